#include "density/volume_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "core/parallel.h"
#include "density/volume_reference.h"

namespace glowworm {
namespace {

using namespace density_tests;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Photons in the unit cube, in media 3 and 7.
VolumePhotons cube_photons(std::uint32_t count) {
  VolumePhotons photons;
  for (std::uint32_t i = 0; i < count; ++i)
    photons.push_back(hash_place(i, 1), hash_direction(i, 4), hash_colour(i, 6), i % 5 == 0 ? 7 : 3, 0);
  return photons;
}

/// Beams in about the unit cube, in media 3 and 7; many of a length of 0 or in common directions.
VolumeBeams cube_beams(std::uint32_t count) {
  VolumeBeams beams;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 along = i % 4 == 1 ? Vec3{0, 0, 1} : i % 4 == 2 ? hash_direction(i % 8, 4) : hash_direction(i, 4);
    const float length = i % 16 == 3 ? 0.0f : 0.7f * hash_number(i, 9);
    beams.push_back(hash_place(i, 1), along, length, hash_colour(i, 6), i % 5 == 0 ? 7 : 3, 0);
  }
  return beams;
}

/// Segments through the cube: of a camera, of gather rays, along the axes and beams, infinite, and without sense.
VolumeSegments cube_segments(std::uint32_t count) {
  VolumeSegments segments;
  for (std::uint32_t i = 0; i < count; ++i) {
    SegmentMedium medium{hash_colour(i, 20) * 3, hash_colour(i, 24), 1.6f * hash_number(i, 28) - 0.8f,
                         i % 3 == 0 ? 7u : 3u};
    if (i % 5 == 0) medium.g = 0;
    if (i % 7 < 3) medium.sigma_t = RGB(medium.sigma_t.r);
    Vec3 origin = hash_place(i, 30), along = hash_direction(i, 34);
    float length = hash_number(i, 38);
    switch (i % 8) {
      case 0:
        origin = {0.5f, 0.4f, -3};
        along = normalize(hash_place(i, 40) - origin);
        length = 3 + 2 * length;
        break;
      case 1:
        along = {0, 0, i % 16 == 1 ? 1.0f : -1.0f};
        break;
      case 2:
        along = hash_direction(i % 8, 4);
        length = kInfinity;
        break;
      case 3:
        origin = origin - along * 20;
        length = kInfinity;
        break;
      default:
        break;
    }
    if (i % 31 == 30) length = i % 2 == 0 ? 0.0f : -1.0f;
    if (i % 61 == 60) (i % 2 == 0 ? origin.y : along.z) = kNaN;
    if (i % 67 == 66) medium.index = 5;
    segments.push_back(origin, along, length, medium, RGB(1.0f), i);
  }
  return segments;
}

std::vector<RGB> estimate(const VolumeMap& map, const VolumeSegments& segments) {
  Statistics statistics;
  std::vector<RGB> found(segments.size(), RGB(0.0f));
  map.estimate(segments, found, statistics);
  return found;
}

/// The largest difference of a channel, relative to the value or a hundredth of the largest one.
double difference(const std::vector<RGB>& found, const std::vector<Radiance>& expected) {
  double largest = 0, worst = 0;
  for (const Radiance& e : expected)
    for (const double v : e) largest = std::max(largest, v);
  for (std::size_t i = 0; i < found.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double d = std::abs(double{found[i][c]} - expected[i][c]) / std::max(expected[i][c], largest / 100);
      worst = std::isnan(d) ? kInfinity : std::max(worst, d);
    }
  return worst;
}

VolumeMap map_of(const VolumePhotons& photons, const PhotonKernels& kernels, float scale = 1) {
  Statistics statistics;
  VolumeMap map;
  map.build(photons, photons.flux, kernels, scale, statistics);
  return map;
}
VolumeMap map_of(const VolumeBeams& beams, const BeamPieces& pieces, float scale = 1) {
  Statistics statistics;
  VolumeMap map;
  map.build(beams, beams.flux, pieces, scale, statistics);
  return map;
}

TEST(VolumeMap, SumsEveryPhotonAlongEverySegment) {
  const VolumePhotons photons = cube_photons(3000);
  PhotonKernels kernels = volume_photon_kernels(photons, 20);
  const VolumeSegments segments = cube_segments(2000);
  EXPECT_LT(difference(estimate(map_of(photons, kernels), segments), brute_points(photons, kernels, segments)), 1e-4);
  const VolumeMap narrow = map_of(photons, kernels, 0.5f);
  for (float& r : kernels.radii) r *= 0.5f;
  EXPECT_LT(difference(estimate(narrow, segments), brute_points(photons, kernels, segments)), 1e-4);
}

TEST(VolumeMap, FoldsPhotonsBesideWalls) {
  const VolumePhotons photons = cube_photons(3000);
  PhotonKernels kernels = volume_photon_kernels(photons, 20);
  const VolumeSegments segments = cube_segments(2000);
  const std::vector<RGB> without = estimate(map_of(photons, kernels), segments);
  for (std::uint32_t i = 0; i < photons.size(); i += 2) {
    const auto wall = [&](std::uint32_t at) {
      return hash_direction(i, at) * (1 / (kernels.radii[i] * (0.05f + 1.2f * hash_number(i, at + 2))));
    };
    kernels.walls[i] = {wall(30), i % 4 == 0 ? wall(40) : Vec3{0, 0, 0}};
  }
  const std::vector<RGB> found = estimate(map_of(photons, kernels), segments);
  EXPECT_LT(difference(found, brute_points(photons, kernels, segments)), 1e-4);
  EXPECT_NE(found, without);
}

TEST(VolumeMap, SumsEveryBeamAlongEverySegment) {
  const VolumeBeams beams = cube_beams(600);
  BeamPieces pieces = volume_beam_pieces(beams, 5);
  pieces.parts.clear();
  // The map takes transmittance over a crossing to second order: crossings of up to half a metre, sigma_t of up to 3.
  const VolumeSegments segments = cube_segments(1000);
  EXPECT_LT(difference(estimate(map_of(beams, pieces), segments), brute_beams(beams, pieces, segments)), 5e-3);
  const VolumeMap narrow = map_of(beams, pieces, 0.1f);
  for (float& r : pieces.radii) r *= 0.1f;
  EXPECT_LT(difference(estimate(narrow, segments), brute_beams(beams, pieces, segments)), 1e-3);
}

TEST(VolumeMap, DividesBeamsIntoPartsOfWhichEachTellsTheSum) {
  VolumeBeams beams = cube_beams(600);
  // One in fifty has most of the flux.
  for (std::size_t i = 0; i < beams.size(); i += 50) beams.flux[i] *= 1000;
  BeamPieces pieces = volume_beam_pieces(beams, 5);
  VolumeSegments segments = cube_segments(1000);
  std::vector<Radiance> expected(segments.size());
  pieces.parts.clear();
  const std::vector<RGB> all = estimate(map_of(beams, pieces), segments);
  for (std::size_t i = 0; i < all.size(); ++i) expected[i] = {all[i].r, all[i].g, all[i].b};
  constexpr std::uint32_t kParts = 6;
  pieces.parts.assign(8, kParts);
  const VolumeMap map = map_of(beams, pieces);
  std::vector<RGB> sum(segments.size(), RGB(0.0f));
  double unlike = 0, total = 0;
  for (std::uint32_t part = 0; part < kParts; ++part) {
    for (SegmentMedium& medium : segments.medium)
      medium.random = (static_cast<float>(part) + 0.5f) / static_cast<float>(kParts);
    const std::vector<RGB> found = estimate(map, segments);
    for (std::size_t i = 0; i < found.size(); ++i) {
      sum[i] += found[i] / static_cast<float>(kParts);
      unlike += std::abs(double{found[i].g} - all[i].g);
      total += double{all[i].g} * kParts;
    }
  }
  EXPECT_GT(total, 0);
  EXPECT_LT(difference(sum, expected), 1e-4);
  // All parts have the beams of most flux.
  EXPECT_LT(unlike, 0.05 * total);
}

TEST(VolumeBeamPieces, HaveSoManyPartsThatAMeanSegmentCrossesKBeamsOfEach) {
  // Short beams from evenly spread places: their density gives the radius of a sphere that k / 4 of them cross.
  constexpr double kBeams = 40000, kSide = 3, kLength = 0.7;
  VolumeBeams beams;
  for (std::uint32_t i = 0; i < 2 * kBeams; ++i)
    beams.push_back(hash_place(i, 1) * static_cast<float>(kSide), hash_direction(i, 4), static_cast<float>(kLength),
                    RGB(1.0f), i % 2 == 0 ? 3 : 7, 0);
  for (const std::uint32_t k : {4u, 20u}) {
    const double held = k / 4.0;
    const double radius = std::sqrt(held * kSide * kSide * kSide / (kPi * kBeams * kLength));
    const double crossed = held * kLength / (2 * radius);
    const std::vector<std::uint32_t> parts = volume_beam_pieces(beams, k).parts;
    ASSERT_EQ(parts.size(), 8u);
    EXPECT_EQ(parts[0], 1u);
    // Whole parts, and fewer beams beside the cube.
    EXPECT_NEAR(parts[3] + 0.5, crossed / k, 0.25 * crossed / k + 0.5) << k;
    EXPECT_EQ(parts[7], parts[3]);
  }
}

TEST(VolumeBeamPieces, AreWiderAsTheRootOfTheirFlux) {
  VolumeBeams beams = cube_beams(600);
  for (RGB& flux : beams.flux) flux = RGB(0.5f);
  const BeamPieces even = volume_beam_pieces(beams, 5);
  beams.flux[100] *= 16;
  beams.flux[200] *= 0.5f;
  beams.flux[300] *= 1e6f;
  const BeamPieces pieces = volume_beam_pieces(beams, 5);
  ASSERT_EQ(pieces.first, even.first);
  for (std::uint32_t i = 0; i < beams.size(); ++i)
    for (std::uint32_t piece = pieces.first[i]; piece < pieces.first[i + 1]; ++piece)
      EXPECT_NEAR(pieces.radii[piece] / even.radii[piece], i == 100 ? 4 : i == 300 ? 8 : 1, 1e-3) << i;
}

/// Each segment alone, and all of them by one and by three threads.
template <class Map>
void expect_same_bits(const Map& map) {
  const VolumeSegments segments = cube_segments(1500);
  const std::vector<RGB> all = estimate(map, segments);
  set_thread_count(3);
  const std::vector<RGB> by_three = estimate(map, segments);
  set_thread_count(0);
  EXPECT_EQ(std::memcmp(all.data(), by_three.data(), all.size() * sizeof(RGB)), 0);
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    VolumeSegments one;
    one.push_back(segments.origin[i], segments.direction[i], segments.length[i], segments.medium[i], RGB(1.0f), 0);
    const RGB alone = estimate(map, one)[0];
    ASSERT_EQ(std::memcmp(&alone, &all[i], sizeof(RGB)), 0) << i;
  }
}

TEST(VolumeMap, GivesASegmentTheSameBitsWithAnyOthersAndAnyThreads) {
  const VolumePhotons photons = cube_photons(20000);
  expect_same_bits(map_of(photons, volume_photon_kernels(photons, 10)));
  const VolumeBeams beams = cube_beams(3000);
  expect_same_bits(map_of(beams, volume_beam_pieces(beams, 3)));
}

TEST(VolumeMap, LeavesOutWhatIsNotFinite) {
  VolumePhotons photons = cube_photons(500);
  VolumeBeams beams = cube_beams(500);
  const VolumeSegments segments = cube_segments(300);
  const PhotonKernels kernels = volume_photon_kernels(photons, 20);
  const BeamPieces pieces = volume_beam_pieces(beams, 5);
  const auto spoil = [](auto& batch, auto& place, std::uint32_t i) {
    switch (i % 4) {
      case 0:
        place[i].y = kNaN;
        break;
      case 1:
        batch.direction[i].x = kInfinity;
        break;
      case 2:
        batch.flux[i].g = kNaN;
        break;
      default:
        batch.flux[i] = RGB(0.0f);
    }
  };
  for (std::uint32_t i = 0; i < 500; ++i) spoil(photons, photons.position, i);
  for (std::uint32_t i = 0; i < 500; ++i) spoil(beams, beams.origin, i);
  const std::vector<RGB> none(segments.size(), RGB(0.0f));
  EXPECT_TRUE(map_of(photons, kernels).empty());
  EXPECT_EQ(estimate(map_of(photons, kernels), segments), none);
  EXPECT_TRUE(map_of(beams, pieces).empty());
  // The radii of what is left are finite.
  for (const float r : volume_photon_kernels(photons, 20).radii) EXPECT_TRUE(r > 0 && std::isfinite(r));
  for (const float r : volume_beam_pieces(beams, 5).radii) EXPECT_TRUE(r > 0 && std::isfinite(r));
  EXPECT_TRUE(volume_photon_kernels({}, 20).radii.empty());
  EXPECT_TRUE(volume_beam_pieces({}, 5).radii.empty());
}

}  // namespace
}  // namespace glowworm
