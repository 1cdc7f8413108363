// Participating media on the way of a path: which medium is where, distances, and transmittance.
//
// Interfaces (MaterialKind::interface) part media and change nothing else: paths pass them without a bounce.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "scene/camera.h"
#include "scene/medium.h"
#include "transport/path_state.h"

namespace glowworm {

/// Whether a triangle parts media; one that emits does not, and is met like a pane.
bool is_interface(const Scene& scene, std::uint32_t triangle);

/// The medium around a path that leaves a surface: that which the surface names on that side. Where it names only the
/// other side, the path has left a body, and is in the ambient medium.
/// @param before around the path where it met the surface @param direction in which it leaves
PathMedium medium_behind(const Scene& scene, PathMedium before, std::uint32_t triangle, Vec3 direction);
/// Both sides of the surface that a path meets. @param arrived around the path @param wo back along it
MediumSides media_at(const Scene& scene, PathMedium arrived, std::uint32_t triangle, Vec3 wo);
/// The medium around the straight piece of a path that ends at a surface. The surface where it starts decides if it
/// names that side, then the one that it meets: so bodies within a medium need no reference to it.
/// @param start at the start of the piece @param triangle where it ends, or kNone
PathMedium medium_until(const Scene& scene, PathMedium start, std::uint32_t triangle, Vec3 direction);
/// The medium where a path starts that has met no surface: that on the near side of the first surface along the ray
/// which names one there, behind others, too; else the ambient medium.
PathMedium medium_at_start(const Tracer& tracer, Vec3 position, Vec3 direction);

PathMedium camera_medium(const Tracer& tracer, const Camera& camera);

/// Takes a path through an interface. @param hit of its ray
void pass_interface(const Scene& scene, PathState& path, const Hit& hit);

/// Length of the ray to its hit, metres; infinite if there is none.
inline float length_to(const Hit& hit) {
  return hit.triangle == kNone ? std::numeric_limits<float>::infinity() : hit.distance;
}

/// Takes a path through media and interfaces to the surface that it meets, or out of the scene. Calls
/// piece(medium, length) for each piece of its way, from the start of path.ray on, with a null pointer in vacuum; if
/// that returns false, the path ends there.
/// @param hit of path.ray; replaced by the one behind interfaces
/// @return whether the path has arrived at `hit`
template <typename Piece>
bool travel(const Tracer& tracer, PathState& path, Hit& hit, RayOrder order, Piece&& piece) {
  const Scene& scene = tracer.scene();
  for (;;) {
    path.medium = medium_until(scene, path.medium, hit.triangle, path.ray.direction);
    const Medium* const medium = path.medium.index == kNone ? nullptr : &scene.media()[path.medium.index];
    if (!piece(medium, length_to(hit))) return false;
    if (hit.triangle == kNone || !is_interface(scene, hit.triangle)) return true;
    pass_interface(scene, path, hit);
    hit = tracer.intersect(path.ray, order);
  }
}

/// What becomes of a path on a piece of its way through a medium.
struct MediumSample {
  bool scatters = false;  ///< before the end of the piece
  float distance = 0;     ///< to where it scatters, metres
  RGB weight{1.0f};       ///< factor on the throughput: to the scattering, with its coefficient, or to the end
  RGB emitted{0.0f};      ///< light that the medium emits along the piece, W sr^-1 m^-2; not weighted
};

/// Samples whether and where a path scatters on a piece of its way.
///
/// Distances in homogeneous media are sampled exactly, in others by delta tracking with local majorants (Woodcock et
/// al. 1965; Novak et al., "Monte Carlo Methods for Volumetric Light Transport Simulation", 2018). Coefficients may
/// differ between channels: one is chosen in proportion to the throughput, and the balance heuristic over channels
/// weighs the sample (Kutz et al., "Spectral and Decomposition Tracking", 2017).
/// @param throughput of the path at the start of the ray @param ray of unit direction @param length may be infinite
/// @param u in [0, 1); media that are not homogeneous take more numbers, which belong to the ray and to these
MediumSample sample_medium(const Medium& medium, const Ray& ray, float length, RGB throughput, Vec2 u);
/// A channel, chosen in proportion to the throughput. @param u in [0, 1); becomes another such number
int choose_channel(RGB throughput, float& u);
/// The mean of values of the channels over that choice.
float mean_over_channels(RGB throughput, RGB values);

/// Share of light that passes a piece of a ray of unit direction, by for_even_pieces().
RGB transmittance(const Medium& medium, const Ray& ray, float length);
/// The same, in a grid an estimate by ratio tracking (Novak et al., "Residual Ratio Tracking", 2014), which is faster
/// in large ones. @param random in [0, 1); further numbers belong to the ray and to these
RGB estimate_transmittance(const Medium& medium, const Ray& ray, float length, Vec2 random);

/// Transmittance of so many metres of a homogeneous medium, and one minus that. @param sigma_t m^-1
RGB transmittance(RGB sigma_t, float distance);
RGB opacity(RGB sigma_t, float distance);

/// Mean coefficients on a piece of a ray, by Gauss's rule of two points: right for cubic functions of the place, as
/// interpolation between eight cells is along a ray.
MediumPoint mean_along(const Medium& medium, const Ray& ray, float first, float length);

/// Calls visit(first, last, coefficients) for pieces of a ray in which these hardly change: one in a homogeneous
/// medium, else one for each plane between cells of the grid that the ray crosses. Leaves out empty ones.
template <typename Visit>
void for_even_pieces(const Medium& medium, const Ray& ray, float length, Visit&& visit) {
  const MediumSpan span = span_in(medium, ray.origin, ray.direction, 0, length);
  if (span.empty()) return;
  if (is_homogeneous(medium)) {
    visit(span.first, span.last, MediumPoint{medium.sigma_a, medium.sigma_s, medium.emission * medium.sigma_a});
    return;
  }
  const Vec3 along = medium.to_medium.vector(ray.direction), size = medium.bounds->diagonal();
  float cells_per_metre = 0;
  for (int axis = 0; axis < 3; ++axis)
    cells_per_metre =
        std::max(cells_per_metre, std::abs(along[axis]) / size[axis] *
                                      static_cast<float>(medium.grid->values().size[static_cast<std::size_t>(axis)]));
  for_majorants(medium, ray.origin, ray.direction, span.first, span.last, [&](float first, float last, float majorant) {
    if (!(majorant > 0)) return true;
    const float count = std::max(std::ceil((last - first) * cells_per_metre), 1.0f), step = (last - first) / count;
    for (float i = 0; i < count; ++i) {
      const float from = first + i * step;
      const MediumPoint mean = mean_along(medium, ray, from, step);
      if (!is_black(mean.sigma_a + mean.sigma_s)) visit(from, from + step, mean);
    }
    return true;
  });
}

}  // namespace glowworm
