// Layers of light by its source: together they are the picture, and each is that of its lights alone.
#include "scene/light_groups.h"

#include <gtest/gtest.h>

#include <cmath>

#include "builtin/builtin.h"
#include "control/job_report.h"
#include "core/error.h"
#include "film/output.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

/// The Cornell box, whose light is named "ceiling", with a lamp beneath the ceiling.
SceneDescription two_lamps(bool left, bool right) {
  SceneDescription d = builtin_scene("cornell");
  for (Emission& emission : d.emissions) emission.name = "ceiling";
  Light lamp;
  lamp.kind = LightKind::point;
  lamp.name = "lamp 2";
  const Box3 room = d.geometry.bounds();
  lamp.position = room.center() + Vec3{0, 0.4f * room.diagonal().y, 0};
  lamp.intensity = RGB(2.0f, 0.5f, 0.1f);
  if (right) d.lights.push_back(lamp);
  if (!left)
    for (Emission& emission : d.emissions) emission.radiance.value = RGB(0.0f);
  return d;
}

RenderSettings in_groups(Integrator integrator) {
  RenderSettings s = by_photons(24, 8, 16, 50'000, "blocked");
  s.integrator = integrator;
  s.light_groups = true;
  return s;
}

TEST(LightGroups, AddUpToThePicture) {
  const Stage stage(two_lamps(true, true));
  for (const Integrator integrator : {Integrator::gather, Integrator::path, Integrator::photons}) {
    const Film film = stage.render(in_groups(integrator));
    ASSERT_EQ(film.light_group_count(), 2u);
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
      const RGB sum = film.light_of_group(0, i) + film.light_of_group(1, i), all = film.radiance(i, false);
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(sum[c], all[c], 1e-4f * (1 + all[c])) << i;
    }
  }
}

TEST(LightGroups, HoldTheLightOfTheirSourcesAlone) {
  const Stage both(two_lamps(true, true)), ceiling(two_lamps(true, false)), lamp(two_lamps(false, true));
  for (const Integrator integrator : {Integrator::gather, Integrator::path}) {
    const Film film = both.render(in_groups(integrator));
    RenderSettings alone = in_groups(integrator);
    alone.light_groups = false;
    double sums[2] = {0, 0};
    for (std::size_t i = 0; i < film.pixel_count(); ++i)
      for (std::size_t group = 0; group < 2; ++group) sums[group] += luminance(film.light_of_group(group, i));
    const auto pixel_count = static_cast<double>(film.pixel_count());
    EXPECT_NEAR(sums[0] / pixel_count / mean(ceiling.render(alone)).luminance(), 1, 0.03);
    EXPECT_NEAR(sums[1] / pixel_count / mean(lamp.render(alone)).luminance(), 1, 0.03);
  }
}

TEST(LightGroups, CostNoRaysAndChangeNoLight) {
  const Stage stage(two_lamps(true, true));
  RenderSettings settings = in_groups(Integrator::gather);
  Job grouped(stage.scene, stage.tracer, settings);
  grouped.wait();
  settings.light_groups = false;
  Job plain(stage.scene, stage.tracer, settings);
  plain.wait();
  for (const Counter counter : {Counter::camera_rays, Counter::gather_rays, Counter::occlusion_rays})
    EXPECT_EQ(grouped.statistics().count(counter), plain.statistics().count(counter));
  const Film a = grouped.snapshot(), b = plain.snapshot();
  for (std::size_t i = 0; i < a.pixel_count(); ++i)
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(a.radiance(i, false)[c], b.radiance(i, false)[c], 1e-4f * (1 + b.radiance(i, false)[c])) << i;
}

TEST(LightGroups, AreTheSameWithQueryPointsOnDisk) {
  const Stage stage(two_lamps(true, true));
  RenderSettings settings = in_groups(Integrator::gather);
  settings.disk = DiskUse::never;
  const Film in_memory = stage.render(settings);
  settings.disk = DiskUse::always;
  const Film on_disk = stage.render(settings);
  EXPECT_EQ(pixels(on_disk), pixels(in_memory));
  for (std::size_t i = 0; i < in_memory.pixel_count(); ++i)
    for (std::size_t group = 0; group < 2; ++group)
      ASSERT_EQ(on_disk.light_of_group(group, i), in_memory.light_of_group(group, i)) << i;
}

TEST(LightGroups, AreLayersOfTheirNamesInTheUnitsOfTheImage) {
  SceneDescription d = two_lamps(true, true);
  d.film.scale = 3;
  const Stage stage(std::move(d));
  Job job(stage.scene, stage.tracer, in_groups(Integrator::gather));
  job.wait();
  const Image image = make_image(job.film(), job);
  const std::vector<RGB> all = image.rgb(), ceiling = image.rgb("light.ceiling"), lamp = image.rgb("light.lamp_2");
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_NEAR(ceiling[i].g + lamp[i].g, all[i].g, 1e-4f * (1 + all[i].g));
}

TEST(LightGroups, OfLightsWithoutNamesAreOneEach) {
  SceneDescription d = two_lamps(true, true);
  for (Emission& emission : d.emissions) emission.name.clear();
  d.lights.front().name.clear();
  d.lights.push_back(d.lights.front());
  const LightGroups groups = light_groups(Scene(d));
  EXPECT_EQ(groups.names, (std::vector<std::string>{"area light", "point light 1", "point light 2"}));
}

TEST(LightGroups, AreRefusedWhereLightCannotBeKeptApart) {
  const Stage stage(two_lamps(true, true));
  RenderSettings settings = in_groups(Integrator::gather);
  settings.engine = "knn";
  EXPECT_THROW(Job(stage.scene, stage.tracer, settings), Error);
  settings = in_groups(Integrator::gather);
  settings.indirect_only = true;
  EXPECT_THROW(Job(stage.scene, stage.tracer, settings), Error);
}

}  // namespace
}  // namespace glowworm
