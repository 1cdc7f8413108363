// Maps of volume photons against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "density/volume_map.h"
#include "density/volume_reference.h"

namespace glowworm {
namespace {

using namespace density_tests;

VolumeMap map_with_radii(const VolumeBeams& beams, std::uint32_t k) {
  Statistics statistics;
  VolumeMap map;
  BeamPieces pieces = volume_beam_pieces(beams, k);
  pieces.parts.clear();
  map.build(beams, beams.flux, pieces, 1, statistics);
  return map;
}

/// Mean over segments, of each channel.
RGB mean_of(const VolumeMap& map, const VolumeSegments& segments) {
  Statistics statistics;
  std::vector<RGB> found(segments.size(), RGB(0.0f));
  map.estimate(segments, found, statistics);
  RGB sum(0.0f);
  for (const RGB& f : found) sum += f;
  return sum / static_cast<float>(segments.size());
}

void expect_close(RGB found, const double* expected, double relative) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / expected[c], 1, relative) << c;
}

// Photons spread evenly over the unit cube scatter q W m^-3; isotropic light gives q / (4 pi) times the integral of the
// transmittance, for any g. Twenty thousand segments of 0.4 m meet about 20,000 different photons: 0.7% of noise.
TEST(VolumeRadiance, OfEvenPhotonsIsTheIntegralOfTransmittance) {
  constexpr std::uint32_t kPhotons = 100'000;
  VolumePhotons photons;
  const RGB flux(1.0f / kPhotons, 2.0f / kPhotons, 3.0f / kPhotons);
  for (std::uint32_t i = 0; i < kPhotons; ++i)
    photons.push_back({hash_number(i, 1), hash_number(i, 2), hash_number(i, 3)}, hash_direction(i, 4), flux, 0, 0);
  VolumeMap map;
  Statistics statistics;
  map.build(photons, photons.flux, volume_photon_kernels(photons, 10), 1, statistics);
  for (const float g : {0.0f, 0.6f}) {
    const SegmentMedium medium{RGB(0.1f, 1, 10), RGB(0.0f), g, 0};
    VolumeSegments segments;
    for (std::uint32_t i = 0; i < 20'000; ++i) {
      const Vec3 d = hash_direction(i, 9);
      const Vec3 middle{0.3f + 0.4f * hash_number(i, 11), 0.3f + 0.4f * hash_number(i, 12),
                        0.3f + 0.4f * hash_number(i, 13)};
      segments.push_back(middle - d * 0.2f, d, 0.4f, medium, RGB(1.0f), 0);
    }
    double expected[3];
    for (int c = 0; c < 3; ++c) {
      const double sigma = medium.sigma_t[c];
      expected[c] = (c + 1) / (4 * std::numbers::pi) * (1 - std::exp(-0.4 * sigma)) / sigma;
    }
    const RGB found = mean_of(map, segments);
    expect_close(found, expected, 0.015);
  }
}

// A beam of irradiance E along z through [0, D] x [0, H], seen along x. Photons end where they scatter.
TEST(VolumeRadiance, OfAParallelBeamFromTheSide) {
  constexpr std::uint32_t kBeams = 100'000;
  constexpr float kIrradiance = 7, kWidth = 0.5f, kHeight = 0.2f, kSigma = 0.3f, g = 0.4f;
  VolumeBeams beams;
  const RGB flux(kIrradiance * kWidth * kHeight / kBeams);
  for (std::uint32_t i = 0; i < kBeams; ++i) {
    const float length = -std::log(1 - (static_cast<float>(i) + 0.5f) / kBeams) / kSigma;
    beams.push_back({kWidth * hash_number(i, 1), kHeight * hash_number(i, 2), 0}, {0, 0, 1}, length, flux, 2, 0);
  }
  const VolumeMap map = map_with_radii(beams, 5);
  for (const float z : {0.2f, 1.0f, 3.0f}) {
    // The camera sees no medium but that in the beam.
    const SegmentMedium medium{RGB(0.0f), RGB(kSigma, 2 * kSigma, 0.5f * kSigma), g, 2};
    VolumeSegments segments;
    for (std::uint32_t i = 0; i < 2000; ++i)
      segments.push_back({-1, kHeight * (0.25f + 0.5f * hash_number(i, 3)), z + 0.1f * (hash_number(i, 4) - 0.5f)},
                         {1, 0, 0}, 3, medium, RGB(1.0f), 0);
    const double phase = (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g, 1.5));
    double expected[3];
    for (int c = 0; c < 3; ++c) expected[c] = medium.sigma_s[c] * kIrradiance * kWidth * phase * std::exp(-kSigma * z);
    const RGB found = mean_of(map, segments);
    expect_close(found, expected, 0.01);
  }
}

// A camera that looks along a laser: the sum is finite, and its integral over the picture is right.
TEST(VolumeRadiance, OfABeamAlongItselfIsFinite) {
  VolumeBeams beams;
  beams.push_back({0, 0, 0}, {0, 0, 1}, 10, RGB(1.0f), 0, 0);
  const BeamPieces pieces{{0, 4}, {1, 4, 7, 10}, std::vector<float>(4, 0.01f), {}, {}};
  VolumeMap map;
  Statistics statistics;
  map.build(beams, beams.flux, pieces, 1, statistics);
  VolumeSegments segments;
  const float sigma = 0.2f;
  const SegmentMedium medium{RGB(sigma), RGB(sigma), 0, 0};
  constexpr std::uint32_t kSegments = 20'000;
  for (std::uint32_t i = 0; i < kSegments; ++i)
    segments.push_back({0.02f * hash_number(i, 1) - 0.01f, 0.02f * hash_number(i, 2) - 0.01f, -1}, {0, 0, 1}, 20,
                       medium, RGB(1.0f), 0);
  const double expected = (std::exp(-sigma * 1) - std::exp(-sigma * 11)) / (4 * std::numbers::pi) / (0.02 * 0.02);
  EXPECT_NEAR(mean_of(map, segments).r / expected, 1, 0.01);
}

// A lamp of 1 W/sr in a medium without absorption; rays that pass it at distance h, from 5 m before their foot to 5 m
// behind it. The values are integrals of sigma exp(-sigma (t + d)) / (4 pi d^2). Beams that reach 1 m give noise of up
// to 0.5%.
TEST(SlowVolumeRadiance, OfAPointLampIsItsAirlight) {
  constexpr std::uint32_t kBeams = 100'000;
  struct Medium {
    float sigma;
    double at_1, at_quarter;
  };
  for (const Medium& m : {Medium{0.05f, 0.007856, 0.036627}, {0.2f, 0.012126, 0.064269}, {1, 0.000566, 0.004511}}) {
    VolumeBeams beams;
    for (std::uint32_t i = 0; i < kBeams; ++i) {
      const float length = -std::log(1 - hash_number(i, 1)) / m.sigma;
      beams.push_back({0, 0, 0}, hash_direction(i, 2), std::min(length, 8.0f), RGB(4 * kPi / kBeams), 0, 0);
    }
    const VolumeMap map = map_with_radii(beams, 5);
    for (const bool near : {false, true}) {
      VolumeSegments segments;
      for (std::uint32_t i = 0; i < 500; ++i) {
        const Vec3 d = hash_direction(i, 5), foot = normalize(cross(d, hash_direction(i, 7))) * (near ? 0.25f : 1);
        segments.push_back(foot - d * 5, d, 10, {RGB(m.sigma), RGB(m.sigma), 0, 0}, RGB(1.0f), 0);
      }
      EXPECT_NEAR(mean_of(map, segments).r / (near ? m.at_quarter : m.at_1), 1, 0.01) << m.sigma << ' ' << near;
    }
  }
}

}  // namespace
}  // namespace glowworm
