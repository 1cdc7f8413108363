// The film: sums of all samples by pixel and layer.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/radiance_range.h"
#include "gather/camera_pass.h"
#include "points/gather_points.h"
#include "scene/geometry.h"
#include "settings/settings.h"

namespace glowworm {

/// Samples of a pixel that take turns in batches which are independent of each other: sample s is of batch
/// s % count.
struct SampleBatches {
  std::uint32_t count = 1;         ///< 1: samples are independent of each other
  std::uint32_t first_sample = 0;  ///< of the film, within the whole render
};

/// Sums of radiance and of first hits, one entry a pixel, row by row. The sums are exact (core/exact_sum.h): they do
/// not depend on the order or the grouping of the samples.
class Film {
 public:
  /// Most samples of a pixel; more could overflow the sums.
  static constexpr std::uint32_t kMaxSamples = 1u << RadianceSum::kTermBits;

  /// @param indirect_only the image is the indirect light only
  /// @param layers        keep the parts of the light, and the first hits, apart; without them mean() and depth() are
  /// not available, and radiance() returns the image for every part
  /// @param places        of first hits to keep, too; they need `layers`
  /// @param moments       keep second moments of direct and indirect light, for moments(); they need `layers`
  /// @param light_groups  number of SlotRadiance::groups to keep, too; they need `layers`
  /// @param batches       that variance() is told by
  explicit Film(const PixelBounds& bounds, bool indirect_only = false, bool layers = true, PlaceLayers places = {},
                bool moments = false, std::size_t light_groups = 0, SampleBatches batches = {});

  /// The part of the picture that the film holds.
  const PixelBounds& bounds() const { return bounds_; }
  int width() const { return bounds_.width(); }
  int height() const { return bounds_.height(); }
  std::size_t pixel_count() const { return count_.size(); }
  /// Index of a pixel of the picture that the film holds.
  std::size_t pixel_at(int x, int y) const {
    return static_cast<std::size_t>(y - bounds_.y0) * static_cast<std::size_t>(width()) +
           static_cast<std::size_t>(x - bounds_.x0);
  }

  /// Adds the samples of a task within bounds(), on all threads. Skips pixels that have their samples already, as after
  /// a checkpoint within a pass.
  /// @param geometry   that the triangles of first_hit are of
  /// @param first_slot of the task in `radiance` and `first_hit`
  void add(const CameraTask& task, const SlotRadiance& radiance, const FirstHit& first_hit, const Geometry& geometry,
           std::size_t first_slot = 0);
  /// The same for samples that a film of the task's pixels holds. Pixels that have some of them, but not all, never get
  /// the rest: awaits() tells. The bits are the same as of samples added one by one, but for a pixel of more than
  /// kMaxIdsOfPixel samples in the task that sees more than kMaxIdsOfPixel objects or materials.
  void add(const CameraTask& task, const Film& samples);
  /// A film of the same kind without samples, for other pixels.
  /// @param first_sample of these, counted from the first of this film
  Film like(const PixelBounds& bounds, std::uint32_t first_sample = 0) const;
  /// A copy of some rows of the picture.
  Film rows(int first, int end) const;
  /// The same, with black samples where a pixel has fewer than two. Its values differ from the picture, but making an
  /// image of it takes as long for each row.
  Film sketch_of_rows(int first, int end) const;
  /// Replaces the pixels of the rows that both films hold. @param other of the same kind, with the same columns
  void take_rows(const Film& other);
  /// The first row of the task with a pixel that lacks samples of it; its y1 where there is none.
  int first_row_to_do(const CameraTask& task) const;
  /// Whether every pixel of the task has its samples.
  bool has(const CameraTask& task) const { return first_row_to_do(task) == task.y1; }
  /// Whether no pixel of the task has samples of it, and all have those before.
  bool awaits(const CameraTask& task) const;
  /// Whether the film holds the samples of the task and no others.
  bool is_of(const CameraTask& task) const;
  /// Number of samples that every pixel has.
  std::uint32_t whole_passes() const;
  /// Number of samples of the pixel that has the most.
  std::uint32_t most_samples() const;
  /// Mean number of samples of a pixel.
  double mean_samples() const;
  /// Whether all pixels have the same number of samples.
  bool is_even() const;

  /// Means over the samples so far; black (or 0) if there are none.
  /// Position (metres) and uv (third component 0) are means over the samples that hit something.
  /// sun is the share of direct that surface samples find of a single sun, and black without them.
  /// medium is black in films without PlaceLayers::medium.
  /// surface_emitted and surface_albedo are means of surface samples (gather/camera_pass.h), or `emitted` and `albedo`
  /// in a film without them and in pixels of a single sample, which the filters leave as it is, too.
  enum class Layer : std::uint8_t {
    emitted,
    direct,
    indirect,
    caustic,
    albedo,
    normal,
    position,
    uv,
    surface_emitted,
    surface_albedo,
    sun,
    medium
  };
  RGB mean(Layer layer, std::size_t pixel) const;
  /// Mean light of a group of light sources over the samples so far. W sr^-1 m^-2.
  RGB light_of_group(std::size_t group, std::size_t pixel) const;
  std::size_t light_group_count() const { return groups_.size(); }
  /// Mean depth over the samples that hit something; infinity if none did.
  float depth(std::size_t pixel) const;
  /// Mean over the samples that have this value; 0 if none has, or if it is not kept.
  float value(SlotValue value, std::size_t pixel) const;
  /// Share of the samples that hit something.
  float coverage(std::size_t pixel) const;

  /// An object or a material, and the samples that hit it.
  struct IdCount {
    std::uint32_t id = kNone, count = 0;
  };
  /// Those of a pixel; samples of further ones are not counted.
  using IdCounts = std::array<IdCount, kMaxIdsOfPixel>;
  /// By Geometry::objects and by the scene's materials, one entry a pixel; empty where they are not kept.
  const std::vector<IdCounts>& objects() const { return objects_; }
  const std::vector<IdCounts>& materials() const { return materials_; }

  /// Radiance of the pixel: all light, or only the indirect light. W sr^-1 m^-2.
  RGB radiance(std::size_t pixel, bool indirect_only) const;
  std::uint32_t sample_count(std::size_t pixel) const { return count_[pixel]; }

  /// Variance of the luminance of radiance(), by the spread of the samples or of the means of batches; 0 for fewer than
  /// two.
  float variance(std::size_t pixel) const;
  bool has_moments() const { return has_moments_; }
  /// Whether these are of light of media, too.
  bool has_moments_of_media() const { return !moments_[2].empty(); }
  /// Whether layers by surface samples are kept.
  bool has_surface_samples() const { return places_.surface_samples; }
  /// Light divided by albedo, which is the irradiance over pi where surfaces are diffuse: luminance of a mean over
  /// samples, weighted by their albedo, and the variance of that mean by the spread of the samples. Albedo counts as
  /// kMinAlbedo at least. Light of media is not divided: it depends on no albedo.
  struct Moments {
    float mean = 0, variance = 0;
  };
  static constexpr float kMinAlbedo = 0.01f;
  /// @param layer direct (without sun), indirect or medium; of a film with moments. The variance is 0 for fewer than
  /// two samples.
  Moments moments(Layer layer, std::size_t pixel) const;

  /// Size in bytes of a film of these dimensions.
  static std::uint64_t bytes(const PixelBounds& bounds, bool layers = true, PlaceLayers places = {},
                             bool moments = false, std::size_t light_groups = 0, std::uint32_t batches = 1);

  /// Counts camera samples that are black because their light was not finite (points/finite_light.h).
  void add_not_finite(std::uint64_t samples) { not_finite_ += samples; }
  std::uint64_t not_finite() const { return not_finite_; }

  /// The complete state of the film, for checkpoints.
  std::vector<std::uint32_t> save() const;
  /// Restores the result of save() in a film of the same size and kind without samples. Returns false, with this film
  /// in no useful state, if the size differs or the state is impossible.
  bool restore(const std::vector<std::uint32_t>& state);

  /// Hands the complete state on, piece by piece, for merge_state().
  void write_state(const std::function<void(std::span<const std::byte>)>& write) const;
  /// Adds the samples of the film of a write_state(), of the same size and kind, in little memory: the same bits as if
  /// all had been added to one film, but for the order of ids. No two films may hold the same samples. Returns false,
  /// with this film in no useful state, if the other's is impossible or has a pixel with more than `most_samples`.
  /// @param read fills the bytes; returns false if there are no more
  bool merge_state(const std::function<bool(std::span<std::byte>)>& read, std::uint32_t most_samples);

 private:
  /// Radiance with resolution 5e-20, up to 3e11 W sr^-1 m^-2.
  using LightSum = RadianceSum;
  /// Squares of luminance with resolution 9e-16, up to 4e15.
  using SquareSum = ExactSum<Int128, 50>;
  /// Albedo and normal, within [-1, 1], with resolution 4e-12.
  using UnitSum = ExactSum<std::int64_t, 37>;

  template <typename Sum>
  static void add(std::array<Sum, 3>& sums, RGB value);
  void add(std::size_t pixel, const SlotRadiance& radiance, const FirstHit& first_hit, std::size_t slot);
  void add_place(std::size_t pixel, const FirstHit& first_hit, std::size_t slot, const Geometry& geometry);
  std::uint64_t state_bytes() const {
    return bytes(bounds_, layers_, places_, has_moments(), groups_.size(), batches_.count);
  }
  /// Calls work(arrays...) for each array of the state, of one film or of several, in the order of save().
  template <typename Work, typename... Films>
  static void for_arrays(Work&& work, Films&... films);
  template <typename Entry>
  bool merge_array(std::vector<Entry>& sums, const std::vector<std::uint32_t>& counts,
                   const std::function<bool(std::span<std::byte>)>& read);

  PixelBounds bounds_;
  bool indirect_only_, layers_, has_moments_;
  PlaceLayers places_;
  SampleBatches batches_;
  std::vector<std::array<LightSum, 3>> light_[4];             // without layers, the first holds all light of the image
  std::vector<std::vector<std::array<LightSum, 3>>> groups_;  // light by group of light sources
  std::vector<std::array<UnitSum, 3>> albedo_, normal_, surface_albedo_;
  std::vector<std::array<LightSum, 3>> surface_emitted_, sun_, medium_;
  std::vector<std::array<LightSum, 3>> position_, uv_;
  std::vector<IdCounts> objects_, materials_;
  std::vector<LightSum> depth_sum_;
  std::array<std::vector<LightSum>, kSlotValues> value_sum_;
  std::array<std::vector<std::uint32_t>, kSlotValues> value_count_;
  std::vector<SquareSum> square_sum_;             // of the luminance of single samples, without batches
  std::vector<std::vector<LightSum>> batch_sum_;  // luminance by batch
  // Squared luminance: of direct and of indirect light, divided by albedo, and of light of media.
  std::vector<SquareSum> moments_[3];
  std::vector<std::uint32_t> depth_count_, count_;
  std::uint64_t not_finite_ = 0;
};

}  // namespace glowworm
