// Photons in groups: each group's light is what an engine over its photons alone finds.
#include "density/grouped_map.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/frame.h"
#include "core/parallel.h"
#include "density/density_scenes.h"

namespace glowworm::density_tests {
namespace {

constexpr std::uint32_t kGroups = 5, kTargets = 7;
constexpr std::size_t kPhotons = 800, kPoints = 300;

struct Grouped {
  PhotonBatch photons = room_photons(kPhotons);
  QueryPoints points = room_queries(kPoints);
  RadiusPolicy policy;
  std::vector<std::uint32_t> group_of;

  Grouped() {
    policy.radii.assign(kPhotons, 0.2f);
    for (std::size_t i = 0; i < kPhotons; ++i) group_of.push_back(static_cast<std::uint32_t>(i * i % kGroups));
    for (std::size_t i = 0; i < kPoints; ++i) {
      points.gather_point[i] = static_cast<std::uint32_t>(i * 3 % kTargets);
      points.weight[i] = RGB(0.5f, 1.0f, 2.0f);
    }
  }

  std::vector<std::vector<RGB>> sums(float factor = 1) const {
    std::vector<std::vector<RGB>> light(kGroups, std::vector<RGB>(kTargets));
    Statistics statistics;
    GroupedMap(photons, photons.flux, policy, group_of).add(points, light, statistics, factor);
    return light;
  }
};

TEST(GroupedMap, AgreesWithAnEngineForEachGroup) {
  Grouped room;
  // Some points reflect in lobes.
  for (std::size_t i = 0; i < kPoints; i += 4) {
    QueryBsdf glossy;
    glossy.bsdf.kind = BsdfKind::lambertian;
    glossy.bsdf.diffuse = RGB(0.3f, 0.6f, 0.9f);
    const Frame frame = Frame::from_normal(room.points.normal[i]);
    glossy.s = frame.s, glossy.t = frame.t, glossy.n = frame.n;
    glossy.wo = room.points.normal[i];
    room.points.bsdf[i] = static_cast<std::uint32_t>(room.points.bsdfs.size());
    room.points.bsdfs.push_back(glossy);
  }
  const std::vector<std::vector<RGB>> light = room.sums();
  for (std::uint32_t group = 0; group < kGroups; ++group) {
    PhotonBatch alone = room.photons;
    for (std::size_t i = 0; i < kPhotons; ++i)
      if (room.group_of[i] != group) alone.flux[i] = RGB(0.0f);
    const std::vector<RGB> found = run("brute", alone, room.policy, room.points);
    std::vector<RGB> expected(kTargets);
    for (std::size_t i = 0; i < kPoints; ++i) expected[room.points.gather_point[i]] += room.points.weight[i] * found[i];
    EXPECT_LT(largest_difference(light[group], expected), 1e-4) << group;
  }
}

TEST(GroupedMap, AddsLightTimesAFactor) {
  const Grouped room;
  const std::vector<std::vector<RGB>> light = room.sums(), opposite = room.sums(-1);
  for (std::uint32_t group = 0; group < kGroups; ++group)
    for (std::size_t i = 0; i < kTargets; ++i) EXPECT_EQ(opposite[group][i], light[group][i] * -1.0f);
}

TEST(GroupedMap, HasTheSameBitsForAnyNumberOfThreads) {
  const Grouped room;
  const int threads = thread_count();
  set_thread_count(1);
  const std::vector<std::vector<RGB>> one = room.sums();
  set_thread_count(4);
  EXPECT_EQ(room.sums(), one);
  set_thread_count(threads);
}

TEST(GroupedMap, OfNoPhotonsAddsNothing) {
  Grouped room;
  room.photons = PhotonBatch();
  room.policy.radii.clear();
  room.group_of.clear();
  for (const std::vector<RGB>& group : room.sums())
    for (const RGB& light : group) EXPECT_EQ(light, RGB(0.0f));
}

}  // namespace
}  // namespace glowworm::density_tests
