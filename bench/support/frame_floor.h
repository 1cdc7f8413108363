// What a frame of a session cannot do without, each part of it done alone, at the rate that this machine does it.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "core/large_array.h"
#include "density/engine.h"
#include "photon/diffuse_hits.h"
#include "points/gather_points.h"
#include "points/photon_batch.h"
#include "points/query_points.h"
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
  /// Position, normal and reflectance of the surfaces that the camera and gather rays met the last time; anew, those
  /// that the photon rays met, too, with the photon left there and the direction in which its path goes on: all by the
  /// vector kernel, in blocks that stay in the first cache.
  double surfaces(bool anew) const;
  /// Light paths emitted by the vector kernels, from the same numbers over and over; anew alone.
  double emission() const;
  /// Random numbers: the directions of the gather rays; anew, Sobol' pairs: three to emit a path, two a photon.
  double numbers(bool anew) const;
  /// So many shader operations, where every pair that the kernel tests is used, and nothing must be searched.
  double sums(std::uint64_t operations) const { return seconds_an_operation_ * static_cast<double>(operations); }
  /// Query points written once; anew, photons, too.
  double bytes(std::uint64_t query_points, bool anew) const;
  /// The least that a map of photons can be: cells counted, and every photon moved to its cell once. No radii, no
  /// index.
  double map();
  /// The frame's query points looked up by `blocked` among the frame's photons with radii of a ten-thousandth, so that
  /// none is found: all that a lookup does but sums. Not a part that nothing can do without.
  double search() const;

 private:
  /// A photon as it is moved.
  struct Row {
    Vec3 position, normal, direction;
    RGB flux;
  };
  void make_gather_rays();
  void make_queries();

  const Tracer& tracer_;
  std::uint64_t photons_, emitted_ = 0;
  PhotonBatch map_;                       // the photons themselves
  std::unique_ptr<DensityEngine> empty_;  // over them, with radii of nearly nothing
  std::vector<QueryPoints> queries_;      // in the portions in which a session looks them up
  LargeArray<Row> moved_;
  std::vector<std::uint32_t> cell_, places_;
  std::vector<float> numbers_;  // in [0, 1), for a block of paths
  std::uint32_t rays_each_ = 0;
  std::vector<Ray> photon_rays_, camera_rays_, gather_rays_;
  std::vector<Hit> photon_hits_, camera_hits_, gather_hits_;
  GatherPoints points_;
  std::vector<std::vector<std::uint32_t>> orders_;  // of the portions in which gather rays are made
  double seconds_an_operation_, seconds_a_byte_;
};

}  // namespace glowworm::bench
