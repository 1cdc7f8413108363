// Glossy query points made into the numbers that the kernels evaluate in vectors.
#pragma once
#include <cstddef>
#include <vector>

#include "gather/query_points.h"
#include "kernels/glossy.h"

namespace glowworm {

/// Whether the kernels can evaluate the BSDF; of which model it is, where they can. (Others are for BatchShader.)
bool is_glossy(const Bsdf& bsdf, GlossyModel& model);

/// Makes the numbers of points, and keeps the tables that they point into; belongs to one thread.
class GlossyPreparer {
 public:
  /// The numbers of a point that is_glossy(). Black where wo lies in the surface.
  GlossyNumbers prepare(const QueryBsdf& point);
  /// The tables of all points since clear(); anew after every prepare().
  const float* tables() const { return tables_.data(); }
  /// Forgets the tables.
  void clear();

 private:
  /// The curves of a surface that stand in the tables already.
  struct Known {
    GlossyModel model;
    float alpha, eta;
    std::size_t place;
  };

  std::vector<float> tables_;
  std::vector<Known> known_;
};

}  // namespace glowworm
