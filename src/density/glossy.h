// Numbers of glossy query points for the vector kernels.
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "kernels/glossy.h"
#include "points/query_points.h"

namespace glowworm {

/// The model with which the kernels evaluate the BSDF; none if they cannot, and BatchShader does.
std::optional<GlossyModel> glossy_model(const Bsdf& bsdf);

/// Computes the numbers of points, and owns the tables that they refer to; for one thread only.
class GlossyPreparer {
 public:
  /// The numbers of a point. Black if wo lies in the surface.
  /// @param model glossy_model() of its BSDF
  GlossyNumbers prepare(const QueryBsdf& point, GlossyModel model);
  /// The tables of all points since clear(); call again after every prepare().
  const float* tables() const { return tables_.data(); }
  /// Clears the tables.
  void clear();

 private:
  /// The curves of a surface, if they are in the tables already.
  struct Known {
    GlossyModel model;
    float alpha, eta;
    std::size_t place;
  };

  std::vector<float> tables_;
  std::vector<Known> known_;
};

}  // namespace glowworm
