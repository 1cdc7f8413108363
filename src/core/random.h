// Random and low-discrepancy numbers, determined by an index and not by a thread.
#pragma once
#include <cstdint>

#include "core/vec.h"

namespace glowworm {

/// A 32-bit hash in which every input bit affects every output bit (the "lowbias32" finaliser, C. Wellons, "Prospecting
/// for Hash Functions", 2018).
inline std::uint32_t hash32(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x;
}
inline std::uint32_t hash_combine(std::uint32_t seed, std::uint32_t value) {
  return hash32(seed ^ (value + 0x9e3779b9u + (seed << 6) + (seed >> 2)));
}

/// Purposes of random numbers. A purpose is part of a sequence's hash, so that streams are independent of each other.
/// Changing a value changes the picture. (The bytes are four letters of the name.)
enum RandomStream : std::uint32_t {
  kAirStream = 0x61697270,          ///< photons for points in air
  kBoundaryStream = 0x626f756e,     ///< share of a photon's disc that lies on its surface
  kBrightPatchStream = 0x62726967,  ///< gather rays towards bright patches
  kCameraStream = 0x63616d65,       ///< camera rays
  kChosenStream = 0x63686f73,       ///< photons of a PhotonChoice
  kGatherStream = 0x67617468,       ///< gather rays
  kGatherAgainStream = 0x61676169,  ///< secondary gather rays
  kGuideStream = 0x67756964,        ///< gather rays that the guide of gather rays learns from
  kLightStream = 0x6c696768,        ///< light samples at gather points
  kLobeStream = 0x6c6f6265,         ///< the lobe of a gather ray
  kMediumStream = 0x6d656469,       ///< distances and directions in media
  kPathStream = 0x70617468,         ///< the path tracer
  kPhotonStream = 0x70686f74,       ///< photons
  kPhotonEndStream = 0x70656e64,    ///< photons of very long paths, which end at random
  kPhotonNoiseStream = 0x6e6f6973,  ///< samples that measure the noise of photons
  kPhotonSignStream = 0x7369676e,   ///< signs of photons that measure their noise
  kPilotStream = 0x70696c6f,        ///< pilot passes of photons
  kSpecularStream = 0x73686172,     ///< gather rays that continue through specular lobes; one stream for each bounce
  kSplitStream = 0x73706c69,    ///< choice between broad and specular lobes of gather rays; one stream for each bounce
  kSurfaceStream = 0x73757266,  ///< camera samples that only look at surfaces
  kWavelengthStream = 0x77617665,  ///< wavelengths of gather rays; one stream for each bounce
};

/// The upper 24 bits of x as a float in [0, 1).
inline float to_unit_float(std::uint32_t x) { return static_cast<float>(x >> 8) * 0x1p-24f; }

/// The bits of x in reversed order.
constexpr std::uint32_t reverse_bits(std::uint32_t x) {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  return __builtin_bswap32(x);
}

/// Owen-scrambles the bits of x, which are reversed before and after (Burley, "Practical Hash-based Owen Scrambling",
/// JCGT 9(4), 2020, with its improved version of the hash by Laine and Karras).
std::uint32_t nested_uniform_scramble(std::uint32_t x, std::uint32_t seed);

enum class SamplerKind : std::uint8_t {
  sobol,        ///< Owen-scrambled Sobol' pairs, padded and shuffled; the default
  independent,  ///< hashed random numbers, for tests
};

/// The random numbers of sample `index` of the sequence (seed, sequence): for example, camera sample 3 of pixel 1234,
/// or photon 99 of the photon pass. Each next1() or next2() consumes one more pair of dimensions. Samplers made with
/// the same arguments give the same numbers.
class Sampler {
 public:
  Sampler(SamplerKind kind, std::uint32_t seed, std::uint32_t sequence, std::uint32_t index)
      : kind_(kind), key_(hash_combine(seed_key(seed), sequence)), index_(index) {}

  /// The key of pair `dimension` (0 for the first call of next2()), shared by all samples of a sequence. Kernels
  /// combine it with sample numbers to make many numbers at once.
  static std::uint32_t pair_key(std::uint32_t seed, std::uint32_t sequence, std::uint32_t dimension) {
    return hash_combine(hash_combine(seed_key(seed), sequence), dimension);
  }
  /// The part of pair_key() that depends only on the seed: pair_key is hash_combine(hash_combine(seed_key, sequence),
  /// dimension).
  static std::uint32_t seed_key(std::uint32_t seed) { return hash_combine(0x6c6f7721u, seed); }

  /// A number in [0, 1).
  float next1() { return next2().x; }
  /// A point of [0, 1)^2.
  Vec2 next2();

 private:
  SamplerKind kind_;
  std::uint32_t key_;
  std::uint32_t index_;
  std::uint32_t dimension_ = 0;
};

}  // namespace glowworm
