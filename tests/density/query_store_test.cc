// Query points by way of a file: all come back, once, as they were, near one another.
#include "density/query_store.h"

#include <gtest/gtest.h>

#include <map>

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

TEST(QueryStore, GivesEveryPointBackOnceAsItWas) {
  constexpr std::uint32_t kCount = 50'000, kPortion = 3000;
  for (const std::uint64_t cache : {std::uint64_t{1}, std::uint64_t{1} << 18, std::uint64_t{1} << 24}) {
    QueryStore store({{0, 0, 0}, {2, 2, 2}}, kCount, cache);
    for (std::uint32_t first = 0; first < kCount; first += kPortion)
      store.append(some_points(first, std::min(kPortion, kCount - first)));
    EXPECT_EQ(store.size(), kCount);
    const QueryPoints all = some_points(0, kCount);
    std::vector<int> seen(kCount, 0);
    std::size_t runs = 0;
    double volume = 0;
    store.visit(kPortion, [&](const QueryPoints& run) {
      EXPECT_LE(run.size(), kPortion);
      ++runs;
      Box3 box;
      for (std::size_t i = 0; i < run.size(); ++i) {
        const std::uint32_t n = run.gather_point[i];
        ++seen[n];
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
    });
    EXPECT_TRUE(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
    EXPECT_GE(runs, kCount / kPortion);
    // Boxes of runs in any order would be the whole cube each, of 8 m^3.
    EXPECT_LT(volume, 0.5 * 8 * static_cast<double>(runs));
    EXPECT_EQ(store.size(), 0u);
    if (cache < std::uint64_t{1} << 20) {
      EXPECT_GT(store.counts().bytes_written, 0u);
      EXPECT_GT(store.counts().bytes_read, 0u);
      EXPECT_LT(store.counts().hit_rate(), 1);
    }
  }
}

TEST(QueryStore, KeepsPointsOutsideAndPointsInOnePlace) {
  QueryStore store({{0, 0, 0}, {1, 1, 1}}, 300, 1 << 20);
  QueryPoints points;
  for (std::uint32_t i = 0; i < 100; ++i) points.push_back({5, -7, 1e9f}, {0, 0, 1}, RGB(1.0f), RGB(1.0f), i);
  store.append(points);
  store.append(points);
  std::size_t count = 0;
  store.visit(100, [&](const QueryPoints& run) { count += run.size(); });
  EXPECT_EQ(count, 200u);
  // Forgotten: the file is used anew.
  store.append(points);
  store.visit(100, [&](const QueryPoints& run) { count += run.size(); });
  EXPECT_EQ(count, 300u);
  store.append(points);
  store.append(points);
  store.append(points);
  EXPECT_THROW(store.append(points), Error);
}

TEST(QueryStore, OfNothingGivesNothing) {
  QueryStore store(Box3(), 0, 1 << 20);
  store.append(QueryPoints());
  store.visit(10, [](const QueryPoints&) { FAIL(); });
}

}  // namespace
}  // namespace glowworm
