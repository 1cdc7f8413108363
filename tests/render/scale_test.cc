// Pictures do not depend on the unit of length or the position of the origin.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "builtin/builtin.h"
#include "render/render_testing.h"
#include "scene/scene_checks.h"
#include "scene/scene_parts.h"
#include "support/goodness_of_fit.h"
#include "support/scene_test_name.h"

namespace glowworm {
namespace {

constexpr const char* kScenes[] = {"cornell", "ajar", "glass-sphere", "window-room", "atrium", "ring"};

/// The scene `scale` times as large and moved by `shift` times its own size along a slanted line. Lamps without extent
/// are made so strong that they light it alike.
/// @param back moves it back again, with vertices that have been rounded far away
SceneDescription placed(const char* name, float scale, float shift, bool back = false) {
  SceneDescription d = builtin_scene(name);
  const float size = length(d.geometry.bounds().diagonal());
  const Vec3 by = Vec3{0.48f, -0.6f, 0.64f} * (shift * size * scale);
  const auto move = [&](Vec3& p) {
    p = p * scale + by;
    if (back) p -= by;
  };
  for (Vec3& p : d.geometry.positions) move(p);
  for (Light& light : d.lights) {
    move(light.position);
    if (light.kind != LightKind::directional) light.intensity *= scale * scale;
  }
  for (Camera& camera : d.cameras) {
    move(camera.to_world.translation);
    camera.lens_radius *= scale;
    camera.focal_distance *= scale;
    if (camera.kind == CameraKind::orthographic) camera.half_extent *= scale;
  }
  return d;
}

RenderSettings settings_of(Integrator integrator, int side, std::uint32_t samples) {
  return integrator == Integrator::path ? by_path(side, samples) : by_photons(side, samples, 16, 5000, "blocked");
}

constexpr Integrator kIntegrators[] = {Integrator::path, Integrator::gather, Integrator::photons};

class ScaledScenes : public testing::TestWithParam<const char*> {};

/// Numbers times a power of two are rounded alike, so that any length in the program that is not the scene's shows.
TEST_P(ScaledScenes, LookTheSameToTheBitAtPowersOfTwo) {
  const float size = length(builtin_scene(GetParam()).geometry.bounds().diagonal());
  // Cameras may stand as far outside.
  const float largest = std::ldexp(1.0f, std::ilogb(kMaxCoordinate / size) - 1);
  for (const Integrator integrator : kIntegrators) {
    RenderSettings settings = settings_of(integrator, 16, 1);
    settings.integrator = integrator;
    const std::vector<RGB> original = pixels(Stage(placed(GetParam(), 1, 0)).render(settings));
    EXPECT_GT(mean(original).luminance(), 0);
    for (const float scale : {0x1p-20f, 0x1p+20f, largest})
      EXPECT_EQ(pixels(Stage(placed(GetParam(), scale, 0)).render(settings)), original)
          << "scale " << scale << ", integrator " << static_cast<int>(integrator);
  }
}

class DistantScenes : public testing::TestWithParam<const char*> {};

/// The vertices are rounded there, but nothing else is.
TEST_P(DistantScenes, LookAsIfMovedBackToTheBit) {
  const SceneDescription distant = placed(GetParam(), 1, 1e4f);
  const Stage stage(distant);
  EXPECT_GT(length(stage.scene->origin()), 9e3f * length(distant.geometry.bounds().diagonal()));
  SceneDescription back = distant;
  translate(back, -stage.scene->origin());
  const Stage original(back);
  EXPECT_EQ(original.scene->origin(), (Vec3{0, 0, 0}));
  for (const Integrator integrator : {Integrator::path, Integrator::gather}) {
    const RenderSettings settings = settings_of(integrator, 16, 2);
    const std::vector<RGB> picture = pixels(stage.render(settings));
    EXPECT_GT(mean(picture).luminance(), 0);
    EXPECT_EQ(picture, pixels(original.render(settings)));
  }
}

INSTANTIATE_TEST_SUITE_P(Builtin, DistantScenes, testing::ValuesIn(kScenes), scene_test_name);
INSTANTIATE_TEST_SUITE_P(Builtin, ScaledScenes, testing::Values(kScenes[0]), scene_test_name);
INSTANTIATE_TEST_SUITE_P(Slow, ScaledScenes, testing::ValuesIn(std::begin(kScenes) + 1, std::end(kScenes)),
                         scene_test_name);

constexpr int kScaleSide = 24, kBlock = 4, kAcross = kScaleSide / kBlock;

/// A place for a scene, what its pictures are compared with, and by what share they may differ beside noise.
struct Place {
  float scale, shift;
  bool as_moved_back;  ///< with the same shape at the origin, since rounding of the vertices bends it; else unmoved
  double tolerance;
};
/// A hundred sizes away, coordinates are rounded to a hundred-thousandth of the scene, and the picture's pixels with
/// them.
constexpr Place kPlaces[] = {
    {1e-6f, 0, false, 1e-5}, {1e6f, 0, false, 1e-5}, {1e-3f, 100, true, 1e-4}, {1, 1e4f, true, 1e-4}};

/// bench/tables_scales.py may ask for fewer.
std::uint32_t scale_seeds() {
  const char* asked = std::getenv("GLOWWORM_SCALE_SEEDS");
  return asked ? static_cast<std::uint32_t>(std::atoi(asked)) : 16;
}

std::vector<double> block_means(const Stage& stage, RenderSettings settings, std::uint32_t seed) {
  settings.seed = seed;
  const std::vector<RGB> picture = pixels(stage.render(settings));
  std::vector<double> means(kAcross * kAcross, 0);
  for (int y = 0; y < kScaleSide; ++y)
    for (int x = 0; x < kScaleSide; ++x)
      means[static_cast<std::size_t>(y / kBlock * kAcross + x / kBlock)] +=
          luminance(picture[static_cast<std::size_t>(y * kScaleSide + x)]) / (kBlock * kBlock);
  return means;
}

/// Differences of the blocks between two pictures of the same seeds.
struct Differences {
  std::vector<RunningMean> block = std::vector<RunningMean>(kAcross * kAcross), original = block;
  RunningMean whole, whole_original;

  void add(const std::vector<double>& moved, const std::vector<double>& from) {
    double difference = 0, sum = 0;
    for (std::size_t b = 0; b < block.size(); ++b) {
      block[b].add(moved[b] - from[b]);
      original[b].add(from[b]);
      difference += moved[b] - from[b];
      sum += from[b];
    }
    whole.add(difference / static_cast<double>(block.size()));
    whole_original.add(sum / static_cast<double>(block.size()));
  }
};

class SlowScaledScenes : public testing::TestWithParam<const char*> {};

/// Paired over seeds. 8 standard errors of 16 seeds: by Student's distribution a chance of one in a million for each
/// of the 1,184 means.
TEST_P(SlowScaledScenes, LookTheSameAnywhere) {
  constexpr double kErrors = 8;
  const std::uint32_t seeds = scale_seeds();
  for (const Integrator integrator : {Integrator::path, Integrator::gather}) {
    const RenderSettings settings = settings_of(integrator, kScaleSide, 2);
    const auto means_of = [&](const SceneDescription& d) {
      const Stage stage(d);
      std::vector<std::vector<double>> means;
      for (std::uint32_t seed = 0; seed < seeds; ++seed) means.push_back(block_means(stage, settings, seed));
      return means;
    };
    const auto unmoved = means_of(placed(GetParam(), 1, 0));
    for (const Place& place : kPlaces) {
      const auto from = place.as_moved_back ? means_of(placed(GetParam(), place.scale, place.shift, true)) : unmoved;
      const auto moved = means_of(placed(GetParam(), place.scale, place.shift));
      Differences found;
      for (std::uint32_t seed = 0; seed < seeds; ++seed) found.add(moved[seed], from[seed]);
      const std::string where =
          fmt::format("{}, {}, scale {}, moved by {} of its size", GetParam(),
                      integrator == Integrator::path ? "paths" : "photons and gather rays", place.scale, place.shift);
      const double whole = found.whole_original.mean();
      fmt::print("{}: {:.4f} +- {:.4f} of the original\n", where, 1 + found.whole.mean() / whole,
                 found.whole.standard_error() / whole);
      EXPECT_LE(std::abs(found.whole.mean()), place.tolerance * whole + kErrors * found.whole.standard_error())
          << where;
      for (std::size_t b = 0; b < found.block.size(); ++b)
        EXPECT_LE(std::abs(found.block[b].mean()),
                  place.tolerance * (found.original[b].mean() + whole) + kErrors * found.block[b].standard_error())
            << where << ", block " << b;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Slow, SlowScaledScenes, testing::Values("cornell", "ajar", "glass-sphere", "ring"),
                         scene_test_name);

}  // namespace
}  // namespace glowworm
