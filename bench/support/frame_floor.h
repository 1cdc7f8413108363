// What a frame of a session cannot do without, each part of it done alone, at the rate that this machine does it.
#pragma once
#include <cstdint>
#include <vector>

#include "gather/gather_points.h"
#include "scene/camera.h"
#include "trace/tracer.h"

namespace glowworm::bench {

/// The parts of frames of one scene and camera. All seconds are wall time on all threads, of one run, now.
class FrameFloor {
 public:
  /// @param side pixels of both sides of the picture; @param photons that are traced where all is done anew
  FrameFloor(const Tracer& tracer, const Camera& camera, int side, std::uint64_t photons);

  /// Chooses the final gather rays of a pixel; 0: none, the photon map is shown.
  void choose_gather(std::uint32_t rays_each);

  /// Embree's closest hits of the frame's camera and gather rays, and, anew, of as many rays as there are photons, from
  /// where photons lie by the cosine law.
  double rays(bool anew);
  /// Position, normal and reflectance of the surfaces that those rays met the last time.
  double surfaces(bool anew) const;
  /// Random numbers: the directions of the gather rays; anew, Sobol' pairs: three to emit a path, two a photon.
  double numbers(bool anew) const;
  /// So many shader operations, where every pair that the kernel tests is used, and nothing must be searched.
  double sums(std::uint64_t operations) const { return seconds_an_operation_ * static_cast<double>(operations); }
  /// Query points written once; anew, photons, too, and brought in order once.
  double bytes(std::uint64_t query_points, bool anew) const;

 private:
  const Tracer& tracer_;
  std::uint64_t photons_, emitted_ = 0;
  std::uint32_t rays_each_ = 0;
  std::vector<Ray> photon_rays_, camera_rays_, gather_rays_;
  std::vector<Hit> photon_hits_, camera_hits_, gather_hits_;
  GatherPoints points_;
  std::vector<std::vector<std::uint32_t>> orders_;  // of the portions in which gather rays are made
  double seconds_an_operation_, seconds_a_byte_;
};

}  // namespace glowworm::bench
