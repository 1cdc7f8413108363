// The camera pass: camera rays, followed through sharp bounces to the gather points.
#pragma once
#include <cstdint>
#include <vector>

#include "core/statistics.h"
#include "points/gather_points.h"
#include "points/query_points.h"
#include "trace/tracer.h"

namespace glowworm {

struct CameraPassSettings {
  int width = 0, height = 0;  ///< of the whole picture, pixels
  std::uint32_t seed = 0;
  int max_sharp_bounces = 32;
  bool places = false;  ///< fill FirstHit::triangle and barycentric, too
};

/// What is seen first, through sharp bounces; one entry a slot.
struct FirstHit {
  std::vector<RGB> albedo;   ///< of all lobes of the gather point (white for lights)
  std::vector<Vec3> normal;  ///< shading normal on the viewer's side; (0,0,0) for nothing
  std::vector<float> depth;  ///< metres along the camera ray to the first surface; infinity for none
  // Filled where they are asked for.
  std::vector<std::uint32_t> triangle;  ///< first triangle hit; kNone for none
  std::vector<Vec2> barycentric;        ///< where on it

  /// Makes room for so many slots. @param places with triangles and barycentric coordinates
  void resize(std::size_t slots, bool places);
};

/// Traces the task's camera samples on all threads. Fills `radiance.emitted` and adds to `radiance.direct` what rough
/// sharp surfaces reflect of the lights (both sized by the call); gather points come in an order in which neighbours
/// are near each other. The same for any number of threads.
GatherPoints camera_pass(const Tracer& tracer, const Camera& camera, const CameraTask& task,
                         const CameraPassSettings& settings, SlotRadiance& radiance, FirstHit& first_hit,
                         Statistics& statistics);

/// The same into `points`, whose memory is used again.
void camera_pass(const Tracer& tracer, const Camera& camera, const CameraTask& task, const CameraPassSettings& settings,
                 SlotRadiance& radiance, FirstHit& first_hit, GatherPoints& points, Statistics& statistics);

/// The same, with a photon map shown directly: what gather_points_as_queries() makes of the gather points, without
/// making these, into `queries`, whose memory is used again. Does not count gather points.
void camera_pass_queries(const Tracer& tracer, const Camera& camera, const CameraTask& task,
                         const CameraPassSettings& settings, SlotRadiance& radiance, FirstHit& first_hit,
                         QueryPoints& queries, Statistics& statistics);

}  // namespace glowworm
