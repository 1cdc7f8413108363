// Glossy query points made into the numbers that the kernels evaluate in vectors.
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "kernels/glossy.h"
#include "points/query_points.h"

namespace glowworm {

/// The model by which the kernels evaluate the BSDF; none where they cannot, which BatchShader is for.
std::optional<GlossyModel> glossy_model(const Bsdf& bsdf);

/// Makes the numbers of points, and keeps the tables that they point into; belongs to one thread.
class GlossyPreparer {
 public:
  /// The numbers of a point. Black where wo lies in the surface.
  /// @param model glossy_model() of its BSDF
  GlossyNumbers prepare(const QueryBsdf& point, GlossyModel model);
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
