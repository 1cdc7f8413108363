// What every render keeps, in small scenes with media: the same bits, and the same light by all front doors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "bake/bake_stage.h"
#include "control/job_report.h"
#include "film/checkpoint.h"
#include "film/filtered.h"
#include "film/part.h"
#include "media/media_testing.h"
#include "session/camera_control.h"
#include "session/session_testing.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

/// A ball of glass in gas that fills a box, under a lamp: light through the ball comes from photons.
SceneDescription glass_in_gas() {
  SceneDescription d;
  Medium gas = medium_of(0.6f, 0.9f);
  gas.bounds = Box3{{-2, -2, -1}, {2, 2, 1}};
  d.media.push_back(gas);
  d.ambient_medium = 0;
  add_quad(d, {-2, -2, -1}, {4, 0, 0}, {0, 4, 0}, add_material(d, 0.5f));
  Material glass;
  glass.kind = MaterialKind::dielectric;
  glass.ior = 1.5f;
  glass.reflectance.value = glass.transmittance.value = RGB(1.0f);
  glass.inside = kNone;
  glass.outside = 0;
  d.materials.push_back(glass);
  const auto material = static_cast<std::uint32_t>(d.materials.size() - 1);
  add_box(d, {-0.4f, -0.4f, -0.4f}, {0.4f, 0.4f, 0.3f}, material);
  Light lamp;
  lamp.position = {0.2f, 0.1f, 0.9f};
  lamp.intensity = RGB(2.0f);
  d.lights.push_back(lamp);
  d.cameras.push_back(look_at({0, -4, 0.5f}, {0, 0, 0}, {0, 0, 1}, 45));
  return d;
}

struct TinyScene {
  const char* name;
  SceneDescription (*make)();
};
std::ostream& operator<<(std::ostream& out, const TinyScene& scene) { return out << scene.name; }

RenderSettings few_photons(Integrator integrator = Integrator::gather) {
  RenderSettings settings = integrator == Integrator::path ? by_path(12, 4) : by_photons(12, 4, 6, 2000, "blocked");
  settings.filter = Filtering::automatic;
  return settings;
}

class MediaScene : public FolderTest, public testing::WithParamInterface<TinyScene> {
 protected:
  Stage stage{GetParam().make()};
};

TEST_P(MediaScene, HasTheSameBitsForThreadsMemoryAndDisk) {
  const auto bits = [&](RenderSettings settings, int threads, std::uint64_t megabytes, DiskUse disk) {
    set_thread_count(threads);
    settings.memory_bytes = megabytes << 20;
    settings.disk = disk;
    std::vector<std::uint32_t> state = stage.render(settings).save();
    set_thread_count(0);
    return state;
  };
  for (const Integrator integrator : {Integrator::path, Integrator::gather}) {
    const RenderSettings settings = few_photons(integrator);
    const auto expected = bits(settings, 2, 4000, DiskUse::never);
    EXPECT_EQ(bits(settings, 1, 4000, DiskUse::never), expected);
    EXPECT_EQ(bits(settings, 3, 64, DiskUse::always), expected);
  }
}

TEST_P(MediaScene, IsTheSameInPartsAndResumed) {
  const RenderSettings settings = few_photons();
  const Film whole = stage.render(settings);
  std::vector<PartFile> parts;
  for (const std::uint32_t i : {2u, 1u}) {
    RenderSettings share = settings;
    share.part = {i, 2};
    Job job(stage.scene, stage.tracer, share);
    job.wait();
    const std::string name = path(std::to_string(i));
    write_part(name, part_of(job), job.snapshot());
    parts.push_back({name, read_part(name)});
  }
  Film merged = film_for(united(parts, false));
  for (const PartFile& file : parts) add_part(file.path, file.part, merged);
  EXPECT_EQ(merged.save(), whole.save());

  RenderSettings first = settings;
  first.samples = 2;
  Job begun(stage.scene, stage.tracer, first);
  begun.wait();
  const Checkpoint checkpoint = begun.checkpoint();
  Job resumed(stage.scene, stage.tracer, settings, &checkpoint);
  resumed.wait();
  EXPECT_EQ(resumed.snapshot().save(), whole.save());
}

const std::vector<Vec3> kSensors{{0.7f, 0.2f, 0.1f}, {-0.8f, 0.5f, -0.6f}}, kUpwards(2, Vec3{0, 0, 1});

TEST_P(MediaScene, HasTheSameBitsAtSensorsInTheMedium) {
  std::vector<std::vector<double>> light;
  for (const int threads : {1, 3}) {
    set_thread_count(threads);
    light.push_back(irradiance(stage, by_photons(1, 2, 16, 2000, "blocked"), kSensors, kUpwards));
  }
  set_thread_count(0);
  EXPECT_EQ(light[0], light[1]);
  for (const double e : light[0]) EXPECT_GT(e, 0);
}

TEST_P(MediaScene, IsBakedToTheSameBits) {
  std::vector<std::vector<RGB>> light;
  for (const int threads : {1, 3}) {
    set_thread_count(threads);
    const BakeStage bake(GetParam().make(), {16, 0});
    light.push_back(bake.light(by_gathering(2, 4, 2000), TexelLight::irradiance));
  }
  set_thread_count(0);
  EXPECT_TRUE(light[0] == light[1]);
  float most = 0;
  for (const RGB& texel : light[0]) most = std::max(most, luminance(texel));
  EXPECT_GT(most, 0);
}

TEST_P(MediaScene, HasTheSameFramesForAnyNumberOfThreads) {
  std::vector<ViewFrame> frames[2];
  for (int run = 0; run < 2; ++run) {
    set_thread_count(run == 0 ? 1 : 3);
    Session session(stage.scene, {});
    ViewState state = small_state(session);
    state.filter = true;
    for (int i = 0; i < 4; ++i) {
      if (i == 2) state.camera = fly(state.camera, {0.02f, 0, 0.05f});
      frames[run].push_back(session.next_frame(state, i / 30.0));
    }
  }
  set_thread_count(0);
  for (std::size_t i = 0; i < frames[0].size(); ++i)
    EXPECT_TRUE(frames[0][i].image.light == frames[1][i].image.light) << i;
  EXPECT_GT(mean_luminance(frames[0].back()), 0);
}

INSTANTIATE_TEST_SUITE_P(Slow, MediaScene,
                         testing::Values(TinyScene{"beams", [] { return foggy_floor(false); }},
                                         TinyScene{"points of a coloured grid", [] { return foggy_floor(true); }}));
INSTANTIATE_TEST_SUITE_P(Tiny, MediaScene, testing::Values(TinyScene{"glass in gas", glass_in_gas}));

/// The light of paths, within the noise of the few photons. Points near a boundary lose a part of their kernels.
TEST(SlowMediaSensors, AreLitAsByPaths) {
  for (const bool grid : {false, true}) {
    const Stage stage(foggy_floor(grid));
    const std::vector<double> paths = irradiance(stage, by_path(1, 1 << 14), kSensors, kUpwards),
                              photons = irradiance(stage, by_photons(1, 8, 256, 30'000, "blocked"), kSensors, kUpwards);
    for (std::size_t i = 0; i < paths.size(); ++i)
      EXPECT_NEAR(photons[i], paths[i], (grid ? 0.07 : 0.03) * paths[i]) << i;
  }
}

/// Fog over a perfect mirror, or the fog and its image without a mirror, with a lamp without size in it.
SceneDescription fog_over_mirror(bool mirrored) {
  SceneDescription d;
  add_medium_box(d, {-2, -2, mirrored ? -0.5f : -1.0f}, {2, 2, 1}, medium_of(1, 0.8f, 0.3f));
  if (mirrored) {
    Material mirror;
    mirror.kind = MaterialKind::conductor;
    mirror.use_reflectance = true;
    mirror.reflectance.value = RGB(1.0f);
    d.materials.push_back(mirror);
    add_quad(d, {-60, -60, 0}, {120, 0, 0}, {0, 120, 0}, static_cast<std::uint32_t>(d.materials.size() - 1));
  }
  for (const float side : {1.0f, -1.0f}) {
    Light lamp;
    lamp.position = {0.3f, 0.2f, 0.6f * side};
    lamp.intensity = RGB(3.0f);
    if (side > 0 || !mirrored) d.lights.push_back(lamp);
  }
  d.cameras.push_back(look_at({0.3f, -5, 0.6f}, {0.1f, 0, 0.5f}, {0, 0, 1}, 24));
  return d;
}

/// No path meets the image of a lamp without size; photons bring its light to the fog.
TEST(SlowMediaPaths, FindTheLightOfLampsWithoutSizeInMirrors) {
  const auto light = [](bool mirrored) {
    const Film film = Stage(fog_over_mirror(mirrored)).render(by_path(8, 256));
    double sum = 0;
    for (std::size_t i = 0; i < film.pixel_count(); ++i) sum += luminance(film.radiance(i, false));
    return sum;
  };
  const double image = light(false), mirror = light(true);
  EXPECT_NEAR(mirror, image, 0.03 * image);
}

/// Layers show the surface behind fog, for paths that scatter before it, too.
TEST(MediaPaths, SeeTheFirstSurfaceBehindFog) {
  SceneDescription d;
  add_medium_box(d, {-3, -1, -3}, {3, 1, 3}, medium_of(1, 0.5f));
  add_quad(d, {-4, 3, -4}, {0, 0, 8}, {8, 0, 0}, add_material(d, 0.4f));
  d.cameras.push_back(look_at({0, -5, 0}, {0, 0, 0}, {0, 0, 1}, 8));
  d.environment = Environment{};
  RenderSettings settings = by_path(4, 8);
  const Film film = Stage(std::move(d)).render(settings);
  for (std::size_t i = 0; i < film.pixel_count(); ++i) {
    EXPECT_NEAR(film.mean(Film::Layer::albedo, i).r, 0.4f, 1e-4f) << i;
    EXPECT_NEAR(film.mean(Film::Layer::normal, i).g, -1, 1e-4f) << i;
    EXPECT_NEAR(film.depth(i), 8.02f, 0.02f) << i;
    EXPECT_EQ(film.coverage(i), 1) << i;
  }
}

/// The filter averages light of media, too.
TEST(SlowMediaFilter, TakesNoiseOffTheLightOfMedia) {
  const Stage stage(foggy_floor(false));
  RenderSettings settings = by_photons(32, 4, 4, 10'000, "blocked");
  settings.filter = Filtering::automatic;
  RenderSettings many = settings;
  many.samples = 32;
  const Film film = stage.render(settings), truth = stage.render(many);
  const FilmPicture filtered = filtered_picture(film, false), plain = unfiltered_picture(film, false);
  const FilmPicture right = unfiltered_picture(truth, false);
  double with = 0, without = 0, seen = 0, level = 0;
  for (std::size_t i = 0; i < right.radiance.size(); ++i) {
    const auto square = [&](RGB light) {
      const double d = luminance(light) - luminance(right.radiance[i]);
      return d * d;
    };
    with += square(filtered.radiance[i]);
    without += square(plain.radiance[i]);
    level += luminance(right.radiance[i]);
    seen += luminance(filtered.radiance[i]);
  }
  EXPECT_LT(with, 0.2 * without);
  EXPECT_NEAR(seen / level, 1, 0.01);
}

}  // namespace
}  // namespace glowworm
