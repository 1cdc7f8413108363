// The film: sums of all samples by pixel and layer.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/exact_sum.h"
#include "gather/camera_pass.h"
#include "points/gather_points.h"

namespace glowworm {

/// Sums of radiance and of what was first hit, one entry a pixel, row by row. The sums are exact (core/exact_sum.h):
/// they depend on the samples alone, not on their order, nor on which of them were added up together.
class Film {
 public:
  /// Samples of a pixel at most: as many as the sums have room for.
  static constexpr std::uint32_t kMostSamples = 1u << ExactSum<Int128, 64>::kTermBits;

  /// @param indirect_only the image is the indirect light alone
  /// @param layers        keep the parts of the light, and what was first hit, apart; else mean() and depth() have
  ///                      nothing to tell, and radiance() gives the image whatever it is asked
  explicit Film(int width, int height, bool indirect_only = false, bool layers = true);

  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t pixel_count() const { return count_.size(); }

  /// Adds the samples of a task. A pixel that has a sample already, as after a checkpoint within a pass, keeps it.
  void add(const CameraTask& task, const SlotRadiance& radiance, const FirstHit& first_hit);
  /// Whether every pixel of the task has its samples.
  bool has(const CameraTask& task) const;
  /// Samples that every pixel has.
  std::uint32_t whole_passes() const;
  /// Whether no pixel has more samples than another.
  bool is_even() const;

  /// Means over the samples taken so far; black (or 0) where there are none.
  enum class Layer : std::uint8_t { emitted, direct, indirect, caustic, albedo, normal };
  RGB mean(Layer layer, std::size_t pixel) const;
  /// Mean depth over the samples that hit something; infinity for none.
  float depth(std::size_t pixel) const;
  /// Radiance of the pixel: all light, or the indirect alone. W sr^-1 m^-2.
  RGB radiance(std::size_t pixel, bool indirect_only) const;
  std::uint32_t sample_count(std::size_t pixel) const { return count_[pixel]; }

  /// Relative standard error of the image: the root over pixels of the mean of var(mean) / (mean^2 + 0.01 M^2), with M
  /// the mean of the image, from the spread of the samples of each pixel. Infinity under two samples.
  double noise() const;

  /// Bytes that a film of that size holds.
  static std::uint64_t bytes(int width, int height, bool layers = true);

  /// Counts camera samples that were left black because their light was not finite (points/finite_light.h).
  void add_not_finite(std::uint64_t samples) { not_finite_ += samples; }
  std::uint64_t not_finite() const { return not_finite_; }

  /// The film's whole state, for checkpoints.
  std::vector<std::uint32_t> save() const;
  /// Restores what save() gave; false where it is of another size, or where no samples can have given it.
  bool restore(const std::vector<std::uint32_t>& state);

 private:
  /// Radiance to 5e-20, up to 3e11 W sr^-1 m^-2.
  using LightSum = ExactSum<Int128, 64>;
  /// Squares of luminance to 9e-16, up to 4e15.
  using SquareSum = ExactSum<Int128, 50>;
  /// Of albedo and normal, which stay within [-1, 1], to 4e-12.
  using UnitSum = ExactSum<std::int64_t, 37>;

  template <typename Sum>
  void add(std::array<Sum, 3>& sums, RGB value);
  /// Calls work(array) for each array of the state, in the order of save().
  template <typename Self, typename Work>
  static void for_arrays(Self& self, Work&& work);
  bool is_possible() const;

  int width_, height_;
  bool indirect_only_, layers_;
  std::vector<std::array<LightSum, 3>> light_[4];  // without layers all light of the image is in the first
  std::vector<std::array<UnitSum, 3>> albedo_, normal_;
  std::vector<LightSum> depth_sum_;
  std::vector<SquareSum> square_sum_;  // of the luminance of single samples
  std::vector<std::uint32_t> depth_count_, count_;
  std::uint64_t not_finite_ = 0;
};

}  // namespace glowworm
