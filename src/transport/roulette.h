// Russian roulette: the one rule that ends the paths of cameras, gather rays, photons and the path tracer.
//
// A fixed number of bounces would lose light: a mirror of reflectance 0.95 keeps 0.95^16 = 44% of it after 16 bounces.
// Roulette ends a path at random and divides the light of those that go on by their probability, so that the mean stays
// exact. A path ends for two reasons:
// - It carries little. Below `least`, its probability is its weight over `least`, and it then weighs `least`. So no
//   survivor is brighter than a path that met no roulette, and none shows as a speck.
// - It is long, though nothing absorbs it, as between perfect mirrors. Beyond kEvenBounces it reaches bounce n with
//   probability (kEvenBounces / n)^2, which gives every path a finite mean length. Its weight grows only as n^2, while
//   light that any surface absorbs falls exponentially, so that the variance stays finite.
#pragma once
#include <algorithm>

namespace glowworm {

/// Paths of fewer bounces go on however long they are.
inline constexpr int kEvenBounces = 64;
/// A number of bounces that no path reaches: one in 250 million does.
inline constexpr int kNoBounceLimit = 1 << 20;

/// Least weights before roulette. Photons should carry equal flux, so that every loss of it is one of photons.
inline constexpr float kLeastOfPhotons = 1;
/// The path tracer does the same once a few bounces have made paths cheap.
inline constexpr float kLeastOfPaths = 0.25f;
/// Chains of specular bounces between a pixel and what it shows are few and cheap, so that noise counts more.
inline constexpr float kLeastOfChains = 1.0f / 16;

/// The probability of bounce `bounces` (the first is 1) for a path that has made the one before, by its length alone.
inline float survival_by_length(int bounces) {
  if (bounces <= kEvenBounces) return 1;
  const float ratio = static_cast<float>(bounces - 1) / static_cast<float>(bounces);
  return ratio * ratio;
}

/// The probability with which a path makes its bounce `bounces` (the first is 1). Its light is then divided by it.
/// @param weight largest component of the path's throughput after the bounce, relative to its start, with the
///               divisions so far
/// @param least  one of the constants above
inline float survival(float weight, float least, int bounces) {
  return std::min(std::min(weight / least, 1.0f), survival_by_length(bounces));
}

}  // namespace glowworm
