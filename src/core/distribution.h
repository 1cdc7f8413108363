// Piecewise-constant distributions: choosing an index, or a point of an image, in proportion to weights.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/vec.h"

namespace glowworm {

/// A discrete distribution over n weights, sampled by inversion, so that strata of u stay strata.
class Distribution1D {
 public:
  Distribution1D() = default;
  /// @param weights none negative; where all are zero every index is as likely
  explicit Distribution1D(std::span<const float> weights);

  std::size_t size() const { return cdf_.empty() ? 0 : cdf_.size() - 1; }
  double total() const { return total_; }

  struct Sample {
    std::uint32_t index;
    float probability;  ///< of the index
    float remapped;     ///< u stretched over the chosen interval: uniform in [0, 1) again
  };
  /// @param u in [0, 1)
  Sample sample(float u) const;
  float probability(std::uint32_t index) const { return static_cast<float>(cdf_[index + 1] - cdf_[index]); }

 private:
  std::vector<double> cdf_;                   // size n + 1, from 0 to 1
  std::vector<std::uint32_t> first_of_step_;  // size n + 1: the index that belongs to u = i / n; the last is n - 1
  double total_ = 0;
};

/// A distribution over the unit square by the texels of an image.
class Distribution2D {
 public:
  Distribution2D() = default;
  /// @param weights row-major, width * height of them
  Distribution2D(std::span<const float> weights, int width, int height);

  bool empty() const { return rows_.empty(); }
  /// A point of the unit square and its density per unit area.
  struct Sample {
    Vec2 point;  ///< within texel (x, y) but for rounding
    float pdf;
    std::uint32_t x, y;
  };
  Sample sample(Vec2 u) const;
  float pdf(Vec2 point) const;

 private:
  int width_ = 0, height_ = 0;
  std::vector<Distribution1D> rows_;
  Distribution1D marginal_;
};

}  // namespace glowworm
