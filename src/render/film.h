// The film: sums of all samples by pixel and layer.
#pragma once
#include <cstdint>
#include <vector>

#include "gather/camera_pass.h"
#include "points/gather_points.h"

namespace glowworm {

/// Sums of radiance and of what was first hit, one entry a pixel, row by row. Tasks must be added in a fixed order for
/// the same bits from any number of threads.
class Film {
 public:
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

  /// The film's whole state, for checkpoints.
  std::vector<float> save() const;
  /// Restores what save() gave; false where it is of another size.
  bool restore(const std::vector<float>& state);

 private:
  int width_, height_;
  bool indirect_only_, layers_;
  std::vector<RGB> sums_[6];  // without layers all light of the image is in the first
  std::vector<float> depth_sum_;
  std::vector<std::uint32_t> depth_count_, count_;
  std::vector<float> square_sum_;  // of the luminance of single samples
};

}  // namespace glowworm
