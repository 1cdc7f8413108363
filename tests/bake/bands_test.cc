// Bakes in bands: the light of a whole bake, and no ray twice.
#include "bake/bands.h"

#include <gtest/gtest.h>

#include "builtin/builtin.h"

namespace glowworm {
namespace {

/// What a bake took.
struct Bill {
  Baked baked;
  std::size_t bands = 0;
  std::uint64_t gather_points = 0;
};

/// Bakes a wall of the Cornell box: a grid of points with gaps.
Bill bake_wall(std::uint64_t memory) {
  const auto scene = std::make_shared<const Scene>(builtin_scene("cornell"));
  const auto tracer = std::make_shared<const Tracer>(*scene);
  auto grid = std::make_shared<PointGrid>();
  grid->width = 64;
  grid->height = 320;
  const Box3 room = scene->bounds();
  const Vec3 size = room.max - room.min;
  for (int y = 0; y < grid->height; ++y)
    for (int x = 0; x < grid->width; ++x) {
      const Vec3 share{(static_cast<float>(x) + 1) / 66, (static_cast<float>(y) + 1) / 322, 0.6f};
      grid->position.push_back(room.min + Vec3{share.x * size.x, share.y * size.y, share.z * size.z});
      grid->normal.push_back(y % 50 == 0 ? Vec3{} : Vec3{0, 0, -1});
    }
  RenderSettings settings;
  settings.samples = 2;
  settings.gather = 4;
  settings.photons = 5000;
  settings.memory_bytes = memory;
  settings.threads = 2;
  Bill bill;
  bill.baked = bake_points(scene, tracer, grid, settings, std::nullopt, [&](const BandRun& run) {
    run.job.wait();
    bill.bands = run.count;
    bill.gather_points += run.job.statistics().count(Counter::gather_points);
    return nullptr;
  });
  return bill;
}

TEST(BakeBands, TraceNoSampleTwice) {
  const Bill whole = bake_wall(std::uint64_t{1} << 30), bands = bake_wall(std::uint64_t{32} << 20);
  EXPECT_EQ(whole.bands, 1u);
  EXPECT_GT(bands.bands, 2u);
  EXPECT_EQ(bands.baked.irradiance.value, whole.baked.irradiance.value);
  EXPECT_EQ(bands.baked.irradiance.known, whole.baked.irradiance.known);
  EXPECT_EQ(bands.gather_points, whole.gather_points);
}

}  // namespace
}  // namespace glowworm
