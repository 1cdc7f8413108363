#include "session/pace.h"

#include <algorithm>
#include <cmath>

namespace glowworm {

namespace {

/// Share of the requested frame time that is planned. An input waits for the current frame and for its own; at 15
/// frames a second both end within 100 ms, even if a frame sometimes takes twice the planned time.
constexpr double kMargin = 0.5;
/// Of that, the share for photons if they must be traced.
constexpr double kPhotonShare = 0.5;
/// Weight of a new measurement against the running value.
constexpr double kLearning = 0.5;

void learn_rate(double& known, double seconds, std::uint64_t count) {
  // With few items, fixed costs of a frame dominate.
  constexpr std::uint64_t kEnough = 1000;
  if (count < kEnough || !(seconds > 0)) return;
  const double measured = seconds / static_cast<double>(count);
  // Slower measurements count at once: a frame that is too long is worse than one that is too short.
  known = measured > known ? measured : known + kLearning * (measured - known);
}

}  // namespace

void Pace::learn(const FrameWork& work) {
  learn_rate(cost_.pixel_s, work.camera_seconds, work.pixels);
  learn_rate(cost_.ray_s, work.gather_seconds, work.gather_rays);
  learn_rate(cost_.photon_s, work.photon_seconds, work.photons);
}

FrameEffort Pace::plan(std::uint64_t pixels, std::uint32_t gather, std::uint64_t photons, bool new_photons,
                       double seconds) const {
  FrameEffort effort{1, gather, photons};
  double left = seconds * kMargin;
  if (new_photons) {
    const auto affordable = static_cast<std::uint64_t>(left * kPhotonShare / cost_.photon_s);
    effort.photons = std::min(photons, std::max(affordable, std::min(kMinPhotons, photons)));
    left -= static_cast<double>(effort.photons) * cost_.photon_s;
  }
  const auto whole = static_cast<double>(pixels);
  const double room = std::max(left, 0.0);
  const auto rays_for = [&](double count) { return (room / std::max(count, 1.0) - cost_.pixel_s) / cost_.ray_s; };
  // Rays down to a quarter, ...
  const auto quarter = std::max<std::uint32_t>(gather / 4, std::min<std::uint32_t>(gather, 1));
  double rays = std::clamp(rays_for(whole), static_cast<double>(quarter), static_cast<double>(gather));
  // ... then pixels, down to half of each side, then rays to one, then pixels again.
  double share = room / (whole * cost_.sample_s(rays));
  if (share < 0.25) {
    rays = std::clamp(rays_for(whole * 0.25), std::min(1.0, static_cast<double>(gather)), rays);
    share = room / (whole * cost_.sample_s(std::floor(rays)));
  }
  effort.gather = static_cast<std::uint32_t>(rays);
  effort.scale = std::clamp(static_cast<float>(std::sqrt(share)), kMinScale, 1.0f);
  return effort;
}

std::uint32_t Pace::resting_gather(std::uint64_t pixels, std::uint32_t gather, double seconds) const {
  const double rays = (seconds / static_cast<double>(std::max<std::uint64_t>(pixels, 1)) - cost_.pixel_s) / cost_.ray_s;
  return static_cast<std::uint32_t>(std::clamp(rays, 1.0, std::max(1.0, static_cast<double>(gather))));
}

}  // namespace glowworm
