// Light paths under way, in structure-of-arrays form.
#pragma once
#include <cstdint>
#include <vector>

#include "photon/photon_chunk.h"
#include "photon/photon_tracer.h"
#include "transport/path_state.h"

namespace glowworm {

/// What the bounces of a path were, and whether it comes from a light without size: its bits. Passing straight through
/// a pane is not a bounce. Paths from a medium's own light have none of kNoneBroad. Paths with kNotSmooth have met a
/// sharp surface that is not is_smooth() (transport/sun_images.h); only passes with discs note that.
inline constexpr std::uint8_t kNoneBroad = 1, kAnySharp = 2, kCaustic = kNoneBroad | kAnySharp, kRoughFirst = 4,
                              kFromDelta = 8, kNotSmooth = 16;
/// The bits of a path after a bounce with the bits `bounce`.
inline std::uint8_t with_bounce(std::uint8_t path, std::uint8_t bounce) {
  const std::uint8_t first = path & kAnySharp ? path : bounce;
  return static_cast<std::uint8_t>((path & bounce & kNoneBroad) | ((path | bounce) & (kAnySharp | kNotSmooth)) |
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
  return may_leave(choice, path) && (choice == PhotonChoice::all || (path & kAnySharp));
}

/// Light paths; finished paths are compacted away after every bounce. The first `count` elements are valid.
struct LightPaths {
  std::size_t count = 0;
  std::vector<Ray> rays = std::vector<Ray>(kPathsPerChunk);
  std::vector<Hit> hits = std::vector<Hit>(kPathsPerChunk);
  std::vector<RGB> flux = std::vector<RGB>(kPathsPerChunk);                        // W
  std::vector<std::uint32_t> number = std::vector<std::uint32_t>(kPathsPerChunk);  // of the path within its chunk
  std::vector<std::uint32_t> light = std::vector<std::uint32_t>(kPathsPerChunk);
  std::vector<PathMedium> medium = std::vector<PathMedium>(kPathsPerChunk);  // that the last bounce led into
  std::vector<int> scatterings = std::vector<int>(kPathsPerChunk);           // in media
  /// The least share_that_returns() of the places where it has scattered: its flux has grown by at most the inverse.
  std::vector<float> least_share = std::vector<float>(kPathsPerChunk);
  std::vector<std::uint8_t> bounces = std::vector<std::uint8_t>(kPathsPerChunk);  // the bits of those so far
};

}  // namespace glowworm
