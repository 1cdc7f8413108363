// Piecewise-constant distributions: choosing an index, or a point of an image, in proportion to weights.
#pragma once
#include <algorithm>
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
  Sample sample(float u) const {
    const std::uint32_t index = this->index(u);
    const double width = cdf_[index + 1] - cdf_[index];
    const double inside = width > 0 ? (u - cdf_[index]) / width : 0.0;
    return {index, static_cast<float>(width), std::min(static_cast<float>(inside), 0x1.fffffep-1f)};
  }
  /// The index alone: the last whose interval begins at or below u.
  std::uint32_t index(float u) const {
    // Between those of the ends of the step that u lies in (the indexed search of Chen and Asau, "On Generating Random
    // Variates from an Empirical Distribution", AIIE Transactions 6(2), 1974; halving the rest, since one step may hold
    // nearly all weights). Most steps have one index.
    const double place = u;
    const std::uint32_t* const step =
        first_of_step_.data() + std::min(static_cast<std::uint32_t>(place * steps_), last_step_);
    if (step[0] == step[1]) return step[0];
    const double* const begin = cdf_.data() + 1;
    return static_cast<std::uint32_t>(std::upper_bound(begin + step[0], begin + step[1], place) - begin);
  }
  float probability(std::uint32_t index) const { return static_cast<float>(cdf_[index + 1] - cdf_[index]); }

 private:
  std::vector<double> cdf_;                   // size n + 1, from 0 to 1
  std::vector<std::uint32_t> first_of_step_;  // size n + 1: the index that belongs to u = i / n; the last is n - 1
  double steps_ = 0;                          // n
  std::uint32_t last_step_ = 0;               // n - 1
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
