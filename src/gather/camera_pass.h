// The camera pass: camera rays, followed through specular bounces to the gather points.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "core/statistics.h"
#include "points/gather_points.h"
#include "points/slot_value.h"
#include "points/volume_segments.h"
#include "trace/tracer.h"
#include "transport/vertex.h"

namespace glowworm {

/// Surface samples of each camera sample: camera paths that find emission, albedo and the light that specular lobes
/// reflect of lamps and suns, but no gather points. They cost little, and textures, edges, lamps, glossy details and
/// suns need more samples than other light; pixels at edges of light have four times as many (gather/light_edges.h).
/// They follow specular lobes, and at first both reflection and refraction: reflected lamps have little noise.
inline constexpr std::uint32_t kSurfaceSamples = 4;

class KnownLightEdges;

struct CameraPassSettings {
  int width = 0, height = 0;  ///< size of the whole picture, pixels
  std::uint32_t seed = 0;
  bool places = false;  ///< also fill FirstHit::triangle and barycentric
  /// Also take surface samples: fill SlotRadiance::surface_emitted and FirstHit::surface_albedo. They, in place of
  /// camera samples, find the lights that rough specular lobes reflect.
  bool surface_samples = false;
  /// With `surface_samples`: surface samples find the light of directional lights, in place of camera and light
  /// samples: a sun's spots are often smaller than a pixel, and its glints always. Needs such a light.
  bool suns = false;
  /// Leave out lights without size in rough specular lobes that the eye sees directly or by smooth lobes:
  /// sky_rays() finds these surfaces.
  bool glints_apart = false;
  bool photons_alone = false;  ///< SlotRadiance::medium is without light that media emit or scatter straight from lamps
  KnownLightEdges* edges = nullptr;    ///< of earlier passes of this view, for surface samples; null: none are known
  VolumeSegments* segments = nullptr;  ///< takes the ways of camera rays through media, by slot; null: no media
};

/// The first visible surface of each slot, seen through specular bounces.
struct FirstHit {
  std::vector<RGB> albedo;   ///< of all lobes of the gather point; white for lights
  std::vector<Vec3> normal;  ///< shading normal on the viewer's side; (0,0,0) if nothing is hit
  std::vector<float> depth;  ///< metres along the camera ray to the first surface; infinity if there is none
  // Filled on request.
  std::vector<RGB> surface_albedo;      ///< as `albedo`, by surface samples
  std::vector<std::uint32_t> triangle;  ///< first triangle hit; kNone if there is none
  std::vector<Vec2> barycentric;        ///< position on that triangle
  /// By SlotValue; infinity where a slot has no such value. Empty unless render_pass() is asked for them.
  std::array<std::vector<float>, kSlotValues> values;
  std::vector<float>& of(SlotValue value) { return values[static_cast<std::size_t>(value)]; }

  /// Notes where a camera ray ends. @param depth metres along it
  void see(std::uint32_t slot, const Hit& hit, float depth);
  /// Notes the normal and albedo of the surface there.
  void see(std::uint32_t slot, const Vertex& vertex);
  /// Resizes to so many slots. @param places whether to include triangles and barycentric coordinates; without
  /// `surface_albedo`
  void resize(std::size_t slots, bool places);
};

/// Traces the camera samples of the tasks on all threads. Fills `radiance.emitted`, and adds to `radiance.direct` the
/// lights reflected by rough specular lobes, and directional lights with CameraPassSettings::suns, which are in
/// `radiance.sun`, too, if there is one. All are resized.
/// Neighbours in the order of gather points are close together in space. The result is the same for any number of
/// threads.
GatherPoints camera_pass(const Tracer& tracer, const Camera& camera, CameraTasks tasks,
                         const CameraPassSettings& settings, SlotRadiance& radiance, FirstHit& first_hit,
                         Statistics& statistics);

/// The same, into `points`, which keeps its allocated memory.
void camera_pass(const Tracer& tracer, const Camera& camera, CameraTasks tasks, const CameraPassSettings& settings,
                 SlotRadiance& radiance, FirstHit& first_hit, GatherPoints& points, Statistics& statistics);

}  // namespace glowworm
