// What camera paths do where they meet light or a surface.
#pragma once
#include "core/random.h"
#include "gather/camera_pass.h"
#include "gather/camera_rays.h"
#include "transport/light_connection.h"
#include "transport/path_queue.h"

namespace glowworm {

/// A camera path under way.
struct CameraPath : PathState {
  Sampler sampler;
  std::uint32_t slot, sequence, sample;
  bool smooth = true;  ///< every bounce was at smooth_lobes(); known with CameraPassSettings::glints_apart
};

/// The policy of the camera paths of a block of pixels, over meet() (transport/step.h). Camera samples end at gather
/// points; surface samples go on.
class CameraPolicy {
 public:
  CameraSequence sequence;  ///< of the paths

  /// @param lights of the same radiance @param branches takes surface samples that go on by a second path
  CameraPolicy(const Tracer& tracer, const CameraPassSettings& settings, SlotRadiance& radiance, FirstHit& first_hit,
               LightAdder& lights, GatherPoints& points, std::vector<CameraPath>& branches);

  /// Takes a path to what it has met. Returns whether it goes on. @param bounce surfaces before
  bool advance(CameraPath& path, const Hit& hit, int bounce);
  /// Does the same, and returns true, if a surface sample ends on a surface that only reflects diffusely, as most do.
  bool ends_on_diffuse(std::uint32_t slot, const Hit& hit);

 private:
  bool takes_suns() const { return settings_.suns && sequence.of_surface(); }
  void add_emitted(std::uint32_t slot, RGB light, std::uint32_t source);
  bool scatter(CameraPath& path, const Vertex& vertex, int bounce);
  void find_sun(CameraPath& path, const Vertex& vertex);
  void add_specular_light(CameraPath& path, const Vertex& vertex, RGB factor);
  bool follow(CameraPath& path, const Vertex& vertex, int bounce);
  bool follow_surface_sample(CameraPath& path, const Vertex& vertex, int bounce);

  const Scene& scene_;
  const CameraPassSettings& settings_;
  SlotRadiance& radiance_;
  FirstHit& first_hit_;
  LightAdder& lights_;
  GatherPoints& points_;
  std::vector<CameraPath>& branches_;
  const bool in_media_;
};

}  // namespace glowworm
