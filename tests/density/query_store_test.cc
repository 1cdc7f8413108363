// Query points stored in a file: each comes back once, unchanged, with its neighbours close by.
#include "density/query_store.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/random.h"

namespace glowworm {
namespace {

/// Points all over a cube of side 2, some of them with a BSDF; the target numbers them.
QueryPoints some_points(std::uint32_t first, std::uint32_t count) {
  QueryPoints points;
  for (std::uint32_t i = first; i < first + count; ++i) {
    Sampler sampler(SamplerKind::independent, 1, 2, i);
    const Vec2 u = sampler.next2(), v = sampler.next2();
    const Vec3 p{2 * u.x, 2 * u.y, 2 * v.x};
    const RGB color(u.x, v.x, v.y);
    QueryBsdf bsdf;
    bsdf.wo = {v.y, u.x, u.y};
    if (i % 5 == 0)
      points.push_back(p, {0, 0, 1}, bsdf, color, i);
    else
      points.push_back(p, {0, 1, 0}, color, color * 2, i);
  }
  return points;
}

RGB radiance_of(std::uint32_t number) { return RGB(static_cast<float>(number % 97) * 0.37f); }

TEST(QueryStore, VisitsEveryPointOnceUnchanged) {
  constexpr std::uint32_t kCount = 50'000, kPortion = 3000;
  QueryStore store({{0, 0, 0}, {2, 2, 2}}, kCount);
  for (std::uint32_t first = 0; first < kCount; first += kPortion)
    store.append(some_points(first, std::min(kPortion, kCount - first)));
  EXPECT_EQ(store.size(), kCount);
  const QueryPoints all = some_points(0, kCount);
  std::vector<int> seen(kCount, 0);
  std::size_t runs = 0;
  double volume = 0;
  std::vector<RGB> light(kCount);
  const auto look_up = [&](const QueryPoints& run, std::span<RGB> radiance) {
    EXPECT_LE(run.size(), kPortion);
    ++runs;
    Box3 box;
    for (std::size_t i = 0; i < run.size(); ++i) {
      const std::uint32_t n = run.gather_point[i];
      ++seen[n];
      radiance[i] = radiance_of(n);
      box.grow(run.position[i]);
      EXPECT_TRUE(run.position[i] == all.position[n] && run.normal[i] == all.normal[n] &&
                  run.weight[i] == all.weight[n] && run.reflectance[i] == all.reflectance[n]);
      ASSERT_EQ(run.bsdf[i] == kLambertianQuery, all.bsdf[n] == kLambertianQuery);
      if (run.bsdf[i] != kLambertianQuery) {
        EXPECT_TRUE(run.bsdfs[run.bsdf[i]].wo == all.bsdfs[all.bsdf[n]].wo);
      }
    }
    const Vec3 side = box.diagonal();
    volume += side.x * side.y * side.z;
  };
  store.complete(kPortion, look_up, light);
  for (std::uint32_t n = 0; n < kCount; ++n) ASSERT_EQ(light[n], all.weight[n] * radiance_of(n)) << n;
  EXPECT_TRUE(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
  EXPECT_GE(runs, kCount / kPortion);
  // Boxes of runs in any order would be the whole cube each, of 8 m^3.
  EXPECT_LT(volume, 0.5 * 8 * static_cast<double>(runs));
  EXPECT_EQ(store.size(), 0u);
  EXPECT_GT(store.traffic().written, 0u);
  // Each byte that is written is read once.
  EXPECT_EQ(store.traffic().read, store.traffic().written);
}

TEST(QueryStore, KeepsPointsOutsideAndPointsInOnePlace) {
  QueryStore store({{0, 0, 0}, {1, 1, 1}}, 300);
  QueryPoints points;
  for (std::uint32_t i = 0; i < 100; ++i) points.push_back({5, -7, 1e9f}, {0, 0, 1}, RGB(1.0f), RGB(1.0f), i);
  store.append(points);
  store.append(points);
  std::size_t count = 0;
  std::vector<RGB> light(100);
  const auto look_up = [&](const QueryPoints& run, std::span<RGB>) { count += run.size(); };
  store.complete(100, look_up, light);
  EXPECT_EQ(count, 200u);
  // Forgotten: the file is used anew.
  store.append(points);
  store.complete(100, look_up, light);
  EXPECT_EQ(count, 300u);
  store.append(points);
  store.append(points);
  store.append(points);
  EXPECT_THROW(store.append(points), Error);
}

TEST(QueryStore, EmptyStoreGivesNothing) {
  QueryStore store(Box3(), 0);
  store.append(QueryPoints());
  store.complete(10, [](const QueryPoints&, std::span<RGB>) { FAIL(); }, {});
}

TEST(QueryStore, SumsInTheOrderOfThePoints) {
  // Summands of all sizes: another order would round otherwise.
  constexpr std::uint32_t kCount = 20'000, kTargets = 7;
  QueryPoints points = some_points(0, kCount);
  std::vector<RGB> expected(kTargets), light(kTargets);
  const auto value = [](const QueryPoints& from, std::size_t i) {
    return RGB(std::exp(20 * from.weight[i].r), from.position[i].x, 1);
  };
  for (std::uint32_t i = 0; i < kCount; ++i) {
    points.gather_point[i] = i % kTargets;
    expected[i % kTargets] += points.weight[i] * value(points, i);
  }
  for (const std::size_t run : {std::size_t{100}, std::size_t{3000}, std::size_t{kCount}}) {
    QueryStore store({{0, 0, 0}, {2, 2, 2}}, kCount);
    for (std::uint32_t first = 0; first < kCount;) {
      const auto count = static_cast<std::uint32_t>(std::min<std::size_t>(run, kCount - first));
      QueryPoints portion;
      for (std::uint32_t i = first; i < first + count; ++i)
        if (points.bsdf[i] == kLambertianQuery)
          portion.push_back(points.position[i], points.normal[i], points.reflectance[i], points.weight[i],
                            i % kTargets);
        else
          portion.push_back(points.position[i], points.normal[i], points.bsdfs[points.bsdf[i]], points.weight[i],
                            i % kTargets);
      store.append(portion);
      first += count;
    }
    light.assign(kTargets, RGB());
    store.complete(
        run,
        [&](const QueryPoints& found, std::span<RGB> radiance) {
          for (std::size_t i = 0; i < found.size(); ++i) radiance[i] = value(found, i);
        },
        light);
    EXPECT_EQ(light, expected) << run;
  }
}

}  // namespace
}  // namespace glowworm
