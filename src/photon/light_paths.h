// Light paths under way.
#pragma once
#include <cstdint>

#include "core/random.h"
#include "photon/photon_chunk.h"
#include "photon/photon_tracer.h"
#include "transport/path_state.h"

namespace glowworm {

/// What the bounces of a path were, and whether it comes from a light without size: its bits. Passing straight through
/// a pane is not a bounce. Paths from a medium's own light have none of kNoneBroad. Paths with kNotSmooth have met a
/// specular surface that is not is_smooth() (transport/light_images.h); only passes with discs note that.
inline constexpr std::uint8_t kNoneBroad = 1, kAnySpecular = 2, kCaustic = kNoneBroad | kAnySpecular, kRoughFirst = 4,
                              kFromDelta = 8, kNotSmooth = 16;
/// The bits of a path after a bounce with the bits `bounce`.
inline std::uint8_t with_bounce(std::uint8_t path, std::uint8_t bounce) {
  const std::uint8_t first = path & kAnySpecular ? path : bounce;
  return static_cast<std::uint8_t>((path & bounce & kNoneBroad) | ((path | bounce) & (kAnySpecular | kNotSmooth)) |
                                   (first & kRoughFirst) | (path & kFromDelta));
}
/// Whether a path has come straight from a lamp so far.
inline bool is_straight_from_lamp(std::uint8_t path) { return (path & ~(kFromDelta | kNotSmooth)) == kNoneBroad; }
/// Whether a path may still leave photons of a choice.
inline bool may_leave(PhotonChoice choice, std::uint8_t path) {
  if (choice == PhotonChoice::all) return true;
  const bool of_any_light = choice == PhotonChoice::caustic || (path & kFromDelta);
  return (path & kNoneBroad) && of_any_light && !(choice == PhotonChoice::unseen_by_paths && (path & kRoughFirst));
}
/// Whether it leaves one now.
inline bool leaves(PhotonChoice choice, std::uint8_t path) {
  return may_leave(choice, path) && (choice == PhotonChoice::all || (path & kAnySpecular));
}

/// A light path under way. Its throughput is its flux, W.
struct LightPath : PathState {
  Sampler sampler;           ///< emission takes three pairs, each bounce two
  std::uint32_t number = 0;  ///< among all of the pass
  std::uint16_t in_chunk = 0;
  std::uint32_t light = 0;   ///< source, counted as in Scene::light_power()
  std::uint8_t bounces = 0;  ///< the bits of those so far
  int scatterings = 0;       ///< in media
  /// The least share_that_returns() of the places where it has scattered: its flux has grown by at most the inverse.
  float least_share = 1;
  /// Metres. Where a lamp without size seems to be, by the reflections so far: nowhere once light was refracted.
  /// Followed as kNotSmooth is.
  Vec3 image{};
};

}  // namespace glowworm
