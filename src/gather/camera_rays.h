// Camera rays of a block of pixels.
#pragma once
#include <cstdint>
#include <vector>

#include "core/random.h"
#include "gather/camera_pass.h"
#include "scene/camera.h"

namespace glowworm {

/// The samples of pixels in the sequences of random numbers: those that make gather points, or surface samples of one
/// number.
class CameraSequence {
 public:
  CameraSequence() = default;
  explicit CameraSequence(std::uint32_t surface_sample) : of_surface_(true), surface_sample_(surface_sample) {}

  bool of_surface() const { return of_surface_; }
  /// The sequence of a pixel.
  std::uint32_t stream_of(std::uint32_t pixel) const {
    return hash_combine(pixel, of_surface_ ? kSurfaceStream : kCameraStream);
  }
  /// The place of a camera sample in it.
  std::uint32_t place_of(std::uint32_t sample) const {
    return of_surface_ ? sample * kSurfaceSamples + surface_sample_ : sample;
  }

 private:
  bool of_surface_ = false;
  std::uint32_t surface_sample_ = 0;
};

/// The camera rays of a block, one sample of all its pixels after another. Arrays of one length.
struct CameraRays {
  std::vector<Ray> rays;
  std::vector<std::uint32_t> slot;   ///< kNone of a ray that only fills a packet: its pixel is not of the task
  std::vector<std::uint32_t> pixel;  ///< of the picture, row by row

  /// Makes the rays of the block whose upper left corner is (x0, y0). They use the first two pairs of random numbers.
  /// @param first_slot of the task
  void create(const Camera& camera, const CameraTask& task, std::size_t first_slot, const CameraPassSettings& settings,
              const CameraSequence& sequence, int x0, int y0);
  /// Number of a ray's camera sample.
  std::uint32_t sample_of(std::size_t ray, const CameraTask& task) const {
    return task.first_sample + static_cast<std::uint32_t>(ray / (rays.size() / task.sample_count));
  }

 private:
  /// Lists the pixels of a square together, so that the rays of a packet are close together.
  void add_square(const CameraTask& task, std::size_t first_slot, int width, int x0, int y0, int x1, int y1);
  /// Makes the rays of a sample through the pixels from index `first` on.
  void create(const Camera& camera, const CameraPassSettings& settings, const CameraSequence& sequence,
              std::size_t first, std::uint32_t sample);

  std::vector<std::uint32_t> stream_;  // streams of random numbers of the pixels
  std::vector<float> film_x_, film_y_, lens_x_, lens_y_;
};

}  // namespace glowworm
