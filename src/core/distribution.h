// Piecewise-constant distributions: choose an index, or a point of an image, in proportion to weights.
#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/vec.h"

namespace glowworm {

/// A discrete distribution over n weights. It is sampled by inversion, so strata of u remain strata.
class Distribution1D {
 public:
  Distribution1D() = default;
  /// @param weights not negative; if all are zero, every index has the same probability
  explicit Distribution1D(std::span<const float> weights);

  std::size_t size() const { return cdf_.empty() ? 0 : cdf_.size() - 1; }
  double total() const { return total_; }

  struct Sample {
    std::uint32_t index;
    float probability;  ///< of the index
    float remapped;     ///< position of u in the chosen interval: uniform in [0, 1) again
  };
  /// @param u in [0, 1)
  Sample sample(float u) const {
    const std::uint32_t index = this->index(u);
    const double width = cdf_[index + 1] - cdf_[index];
    const double inside = width > 0 ? (u - cdf_[index]) / width : 0.0;
    return {index, static_cast<float>(width), std::min(static_cast<float>(inside), kBelowOne)};
  }
  /// The index for u: the last one whose interval begins at or below u.
  std::uint32_t index(float u) const {
    // The index table gives the first and last index possible for the step that contains u. Most steps have one index;
    // in others a binary search follows, because one step may hold nearly all weights. (Indexed search of Chen and
    // Asau, "On Generating Random Variates from an Empirical Distribution", AIIE Transactions 6(2), 1974.)
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

/// A distribution over the unit square, proportional to the texels of an image.
class Distribution2D {
 public:
  Distribution2D() = default;
  /// @param weights width * height values, row-major
  Distribution2D(std::span<const float> weights, int width, int height);

  bool empty() const { return rows_.empty(); }
  /// A point of the unit square and its density per unit area.
  struct Sample {
    Vec2 point;  ///< within texel (x, y), up to rounding
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
