// Irradiance at points: against closed forms and the path tracer, with the rules of every render.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "builtin/builtin.h"
#include "core/error.h"
#include "core/parallel.h"
#include "gather/cell_place.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

PointGrid row_of(std::vector<Vec3> positions, Vec3 normal) {
  PointGrid grid;
  grid.width = static_cast<int>(positions.size());
  grid.height = 1;
  grid.normal.assign(positions.size(), normal);
  grid.position = std::move(positions);
  return grid;
}

Film render(const Stage& stage, const RenderSettings& settings, const PointGrid& grid) {
  Job job(stage.scene, stage.tracer, settings, nullptr, 0, std::make_shared<const PointGrid>(grid));
  job.wait();
  return job.snapshot();
}

/// A light of 2 x 2 m and radiance 1 at a height of 1 m over nothing.
SceneDescription lone_light() {
  SceneDescription d;
  d.materials.resize(1);
  d.materials[0].reflectance.value = RGB(0.0f);
  add_quad(d, {-1, -1, 1}, {0, 2, 0}, {2, 0, 0}, 0, add_emission(d, RGB(1.0f)));
  d.cameras.push_back(square_view({0, 0, 0.5f}, {0, 0, -1}, 0.1f, 0.1f));
  return d;
}

/// Form factor to a square of side 2a at distance h from the point below its middle (Howell, B-4), times pi.
double irradiance_below_middle(double distance) {
  const double x = 1 / distance, root = std::sqrt(1 + x * x);
  return 4 * (x / root) * std::atan(x / root);
}

TEST(PointGrid, HoldsTheIrradianceOfTheClosedForm) {
  const Stage stage(lone_light());
  const PointGrid grid = row_of({{0, 0, 0}, {0, 0, 0.5f}, {0, 0, -1}, {0, 0, 1.5f}}, {0, 0, 1});
  RenderSettings paths = by_path(1, 4096);
  for (const RenderSettings& settings : {by_photons(1, 64, 64, 1000), paths}) {
    const Film film = render(stage, settings, grid);
    EXPECT_NEAR(film.radiance(0, false).g, irradiance_below_middle(1), 0.01);
    EXPECT_NEAR(film.radiance(1, false).g, irradiance_below_middle(0.5), 0.015);
    EXPECT_NEAR(film.radiance(2, false).g, irradiance_below_middle(2), 0.01);
    EXPECT_EQ(film.radiance(3, false).g, 0) << "the light is behind this point";
  }
}

TEST(PointGrid, CountsLightFromBehindByItsShare) {
  const Stage stage(lone_light());
  PointGrid grid = row_of({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {0, 0, 1});
  grid.normal[1] = grid.normal[2] = {0, 0, -1};
  grid.from_behind = {{0.25f, 0.25f, 0.25f}, {0.25f, 0.5f, 0}, {1, 1, 1}};
  const double above = irradiance_below_middle(1);
  for (const RenderSettings& settings : {by_photons(1, 512, 64, 1000), by_path(1, 32768)}) {
    SCOPED_TRACE(static_cast<int>(settings.integrator));
    const Film film = render(stage, settings, grid);
    EXPECT_NEAR(film.radiance(0, false).g, 0.75 * above, 0.01);
    EXPECT_NEAR(film.radiance(1, false).r, 0.25 * above, 0.01);
    EXPECT_NEAR(film.radiance(1, false).g, 0.5 * above, 0.01);
    EXPECT_EQ(film.radiance(1, false).b, 0);
    EXPECT_NEAR(film.radiance(2, false).g, above, 0.015);
  }
}

TEST(SlowPointGrid, AgreesWithThePathTracerOnSurfacesAndApart) {
  const Stage stage(builtin_scene("cornell"));
  const Box3 room = stage.scene->bounds();
  const Vec3 size = room.diagonal();
  for (const bool on_surfaces : {true, false}) {
    std::vector<Vec3> places;
    for (int i = 0; i < 64; ++i)
      places.push_back(room.min + Vec3{size.x * (0.1f + 0.1f * static_cast<float>(i % 8)),
                                       on_surfaces ? 0 : size.y * 0.3f,
                                       size.z * (0.1f + 0.1f * static_cast<float>(i / 8))});
    PointGrid grid = row_of(places, {0, 1, 0});
    grid.on_surfaces = on_surfaces;
    const double photons = mean(render(stage, by_photons(1, 16, 64, 200'000, "blocked"), grid)).luminance();
    const double paths = mean(render(stage, by_path(1, 4096), grid)).luminance();
    EXPECT_GT(paths, 0);
    EXPECT_NEAR(photons / paths, 1, 0.01) << on_surfaces;
  }
}

TEST(PointGrid, SpreadsSamplesOverCellsAmidTheirSurface) {
  constexpr int kSide = 4;
  PointGrid grid;
  grid.width = grid.height = kSide;
  for (int i = 0; i < kSide * kSide; ++i) {
    const auto x = static_cast<float>(i % kSide), y = static_cast<float>(i / kSide);
    grid.position.push_back({2 * x, y, x < 3 ? 0.0f : 1.0f});  // The last column bends.
    grid.normal.push_back({0, 0, 1});
    grid.surface.push_back(y < 3 ? 7 : 8);
  }
  const auto extent = [&](std::size_t cell) {
    Box3 box;
    for (std::uint32_t sample = 0; sample < 64; ++sample) box.grow(place_in_cell(grid, cell, sample));
    return box;
  };
  const Box3 amid = extent(kSide + 1);
  EXPECT_NEAR(amid.min.x, 1, 0.1f);
  EXPECT_NEAR(amid.max.x, 3, 0.1f);
  EXPECT_NEAR(amid.min.y, 0.5f, 0.05f);
  EXPECT_NEAR(amid.max.y, 1.5f, 0.05f);
  const auto is_point = [&](std::size_t cell) { return length(extent(cell).diagonal()) == 0; };
  EXPECT_TRUE(is_point(kSide + 2)) << "bent";
  EXPECT_TRUE(is_point(2 * kSide + 1)) << "beside another surface";
  EXPECT_TRUE(is_point(0)) << "at the rim";
  grid.normal[kSide] = {0, 0, 0};
  EXPECT_TRUE(is_point(kSide + 1)) << "beside a cell without a point";
  grid.normal[kSide] = {0, 0, 1};
  grid.surface.clear();
  EXPECT_TRUE(is_point(kSide + 1)) << "a grid of points";
}

TEST(SlowPointGrid, GetsCausticsApartFromSurfaces) {
  const Stage stage(builtin_scene("glass-sphere"));
  const Box3 room = stage.scene->bounds();
  // Below the sphere, above the floor.
  PointGrid grid = row_of(
      std::vector<Vec3>(32, {room.center().x, room.min.y + 0.02f * room.diagonal().y, room.center().z}), {0, 1, 0});
  // The points differ in their random numbers alone: their spread tells the error of their mean.
  struct Estimate {
    double mean = 0, variance = 0;
    explicit Estimate(const Film& film) {
      const auto n = static_cast<double>(film.pixel_count());
      double square = 0;
      for (std::size_t i = 0; i < film.pixel_count(); ++i) {
        const double light = luminance(film.mean(Film::Layer::caustic, i));
        mean += light / n;
        square += light * light / n;
      }
      variance = (square - mean * mean) / (n - 1);
    }
  };
  const Estimate photons(render(stage, by_photons(1, 64, 512, 100'000, "blocked"), grid));
  const Estimate paths(render(stage, by_path(1, 16384), grid));
  const double error = std::sqrt(photons.variance + paths.variance);
  EXPECT_GT(paths.mean, 0);
  EXPECT_NEAR(photons.mean, paths.mean, 4 * error) << "four standard errors";
  EXPECT_LT(error, 0.25 * paths.mean);
}

TEST(PointGrid, LeavesCellsWithoutPointsBlackAndKeepsItsBits) {
  const Stage stage(builtin_scene("cornell"));
  const Box3 room = stage.scene->bounds();
  PointGrid grid;
  grid.width = grid.height = 20;
  for (int i = 0; i < 400; ++i) {
    // Above the boxes.
    grid.position.push_back(room.center() + Vec3{0.0001f * static_cast<float>(i), 0.35f * room.diagonal().y, 0});
    grid.normal.push_back(i % 3 == 0 ? Vec3{0, 0, 0} : Vec3{0, 1, 0});
  }
  const auto bits = [&](int threads) {
    set_thread_count(threads);
    return pixels(render(stage, by_photons(1, 3, 9, 20'000, "blocked"), grid));
  };
  const std::vector<RGB> one = bits(1), three = bits(3);
  set_thread_count(0);
  EXPECT_EQ(one, three);
  for (std::size_t i = 0; i < one.size(); ++i) ASSERT_EQ(is_black(one[i]), i % 3 == 0) << i;
}

TEST(PointGrid, RefusesImpossiblePoints) {
  const Stage stage(lone_light());
  const RenderSettings settings = by_photons(1, 1, 4, 1000);
  EXPECT_THROW(render(stage, settings, row_of({{0, 0, 0}}, {0, 0, 2})), Error);
  EXPECT_THROW(render(stage, settings, row_of({{std::numeric_limits<float>::quiet_NaN(), 0, 0}}, {0, 0, 1})), Error);
  EXPECT_THROW(render(stage, settings, PointGrid()), Error);
  PointGrid grid = row_of({{0, 0, 0}}, {0, 0, 1});
  grid.normal.clear();
  EXPECT_THROW(render(stage, settings, grid), Error);
}

TEST(PointGrid, ResumesOnlyAtItsOwnPoints) {
  const Stage stage(lone_light());
  const RenderSettings settings = by_photons(1, 2, 4, 1000);
  const auto here = std::make_shared<const PointGrid>(row_of({{0, 0, 0}}, {0, 0, 1}));
  const auto there = std::make_shared<const PointGrid>(row_of({{0, 0, 0.1f}}, {0, 0, 1}));
  Job job(stage.scene, stage.tracer, settings, nullptr, 0, here);
  job.wait();
  const Checkpoint checkpoint = job.checkpoint();
  EXPECT_NO_THROW(Job(stage.scene, stage.tracer, settings, &checkpoint, 0, here).wait());
  EXPECT_THROW(Job(stage.scene, stage.tracer, settings, &checkpoint, 0, there).wait(), Error);
}

/// Most gather rays end near their point there, where photons are blurred over the edges.
TEST(PointGrid, CornersHaveTheIrradianceOfTheRoom) {
  constexpr float kNear = 0.498f;
  const Stage stage(builtin_scene("furnace-box"));
  const PointGrid grid =
      row_of({{kNear, -0.5f, kNear}, {-kNear, -0.5f, kNear}, {kNear, -0.5f, -kNear}, {0, -0.5f, kNear}}, {0, 1, 0});
  RenderSettings settings = by_photons(1, 32, 64, 20'000, "blocked");
  settings.progressive = true;
  const Film film = render(stage, settings, grid);
  for (std::size_t i = 0; i < grid.position.size(); ++i)
    EXPECT_NEAR(film.radiance(i, false).g / (2 * kPi), 1, 0.015) << i;
}

}  // namespace
}  // namespace glowworm
