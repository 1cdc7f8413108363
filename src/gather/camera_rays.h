// Camera rays of a block of pixels.
#pragma once
#include <cstdint>
#include <vector>

#include "core/random.h"
#include "gather/camera_pass.h"
#include "gather/light_edges.h"
#include "scene/camera.h"

namespace glowworm {

/// Surface samples of each camera sample in pixels at edges of light (gather/light_edges.h).
inline constexpr std::uint32_t kSurfaceSamplesAtEdges = kSurfaceSamples * kSurfaceSamples;

/// The samples of pixels in the sequences of random numbers: those that make gather points, or surface samples of one
/// number.
class CameraSequence {
 public:
  CameraSequence() = default;
  /// @param count of the surface samples of a camera sample @param number among these
  CameraSequence(std::uint32_t count, std::uint32_t number) : count_(count), number_(number) {}

  bool of_surface() const { return count_ > 0; }
  /// Share of one surface sample in the mean of a camera sample.
  float share() const { return 1 / static_cast<float>(count_); }
  /// The sequence of a pixel.
  std::uint32_t stream_of(std::uint32_t pixel) const {
    const std::uint32_t stream = hash_combine(pixel, of_surface() ? kSurfaceStream : kCameraStream);
    return count_ > kSurfaceSamples ? hash_combine(stream, count_) : stream;
  }
  /// The place of a camera sample in it.
  std::uint32_t place_of(std::uint32_t sample) const { return of_surface() ? sample * count_ + number_ : sample; }

 private:
  std::uint32_t count_ = 0, number_ = 0;
};

/// The ray through a place of the film, in pixels. A ray that ends before it starts meets nothing.
/// @param lens in [0, 1)^2
Ray ray_through(const Camera& camera, const CameraPassSettings& settings, Vec2 film, Vec2 lens);

/// The camera rays of a block, one sample of all its pixels after another. Arrays of one length.
struct CameraRays {
  std::vector<Ray> rays;
  std::vector<std::uint32_t> slot;   ///< kNone of a ray that only fills a packet: its pixel is not of the task
  std::vector<std::uint32_t> pixel;  ///< of the picture, row by row

  /// Makes the rays of the block whose upper left corner is (x0, y0). They use the first two pairs of random numbers.
  /// @param first_slot of the task @param without pixels that get no such samples
  void create(const Camera& camera, const CameraTask& task, std::size_t first_slot, const CameraPassSettings& settings,
              const CameraSequence& sequence, int x0, int y0, const BlockPixels& without);
  /// Makes those of the surface samples of the pixels `at`, one pixel after another: packets hold rays of one pixel.
  /// @param task of one sample
  void create_at(const BlockPixels& at, const Camera& camera, const CameraTask& task, std::size_t first_slot,
                 const CameraPassSettings& settings, int x0, int y0);
  /// The sequence of a ray of create_at().
  static CameraSequence sequence_at(std::size_t ray) {
    return {kSurfaceSamplesAtEdges, static_cast<std::uint32_t>(ray % kSurfaceSamplesAtEdges)};
  }
  /// Number of a ray's camera sample.
  std::uint32_t sample_of(std::size_t ray, const CameraTask& task) const {
    return task.first_sample + static_cast<std::uint32_t>(ray / (rays.size() / task.sample_count));
  }

 private:
  /// Lists the pixels of a square together, so that the rays of a packet are close together.
  void add_square(const CameraTask& task, std::size_t first_slot, int width, int x0, int y0, int x1, int y1,
                  const BlockPixels& without);
  void add_ray(const Camera& camera, const CameraPassSettings& settings, std::uint32_t pixel, Vec2 in_pixel, Vec2 lens);
  /// Makes the rays of a sample through the pixels from index `first` on.
  void create(const Camera& camera, const CameraPassSettings& settings, const CameraSequence& sequence,
              std::size_t first, std::uint32_t sample);

  std::vector<std::uint32_t> stream_;  // streams of random numbers of the pixels
  std::vector<float> film_x_, film_y_, lens_x_, lens_y_;
};

}  // namespace glowworm
