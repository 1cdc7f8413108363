// Whether sensors vary from seed to seed as much as their standard errors say.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <vector>

#include "builtin/builtin.h"
#include "control/job.h"
#include "measure/doubts.h"
#include "measure/measurement.h"
#include "measure/plan.h"
#include "measure/sky_patches.h"
#include "scene/scene_parts.h"
#include "support/goodness_of_fit.h"

namespace glowworm {
namespace {

/// Eight sensors in a box, which face along all axes.
Sensors sensors_in(const Box3& box) {
  const Vec3 size = box.diagonal();
  Sensors out;
  for (int i = 0; i < 8; ++i) {
    const Vec3 share{i & 1 ? 0.8f : 0.2f, i >> 2 ? 0.5f : 0.2f, i & 2 ? 0.8f : 0.2f};
    Vec3 direction{0, 0, 0};
    direction[(i / 2) % 3] = i & 1 ? 1.0f : -1.0f;
    out.add(box.min + share * size, direction);
  }
  return out;
}

/// Measures with one seed after another. Tests the mean over seeds and sensors of (value - mean of the sensor)^2 over
/// the variance that is stated, by its spread between seeds, since sensors share photons and vary together: 4 standard
/// errors, a false alarm in 16,000 choices of seeds. The stated variance is the mean over seeds, because the inverse of
/// a single one is biased.
void expect_honest_errors(const std::shared_ptr<const Scene>& scene, const Sensors& sensors, RenderSettings settings,
                          std::uint32_t seeds, std::uint32_t batches = kSensorBatches) {
  const auto tracer = std::make_shared<const Tracer>(*scene);
  const auto grid = std::make_shared<const PointGrid>(sensor_grid(sensors, false, batches));
  std::vector<RunningMean> value(sensors.size()), stated(sensors.size());
  std::vector<std::vector<double>> of_seed;
  settings.guiding = false;
  settings = sensor_settings(settings);
  for (settings.seed = 1; settings.seed <= seeds; ++settings.seed) {
    Job job(scene, tracer, settings, nullptr, end_of_sensors(), grid);
    job.wait();
    const Film film = job.snapshot();
    std::vector<double>& values = of_seed.emplace_back();
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      values.push_back(luminance(film.radiance(i, false)));
      value[i].add(values.back());
      stated[i].add(film.variance(i));
    }
  }
  RunningMean ratio;
  for (const std::vector<double>& values : of_seed) {
    double squares = 0;
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      ASSERT_GT(stated[i].mean(), 0) << i;
      squares += std::pow(values[i] - value[i].mean(), 2) / stated[i].mean();
    }
    ratio.add(squares * seeds / (seeds - 1.0) / static_cast<double>(sensors.size()));
  }
  ASSERT_LT(ratio.standard_error(), 0.15);
  EXPECT_NEAR(ratio.mean(), 1, 4 * ratio.standard_error());
}

RenderSettings effort(std::uint32_t samples) {
  RenderSettings settings;
  settings.samples = samples;
  settings.gather = 16;
  settings.photons = 2000;
  return settings;
}

TEST(SlowStandardErrors, AreThoseOfGatheredLight) {
  const auto scene = std::make_shared<const Scene>(builtin_scene("cornell"));
  expect_honest_errors(scene, sensors_in(scene->bounds()), effort(16), 24);
}

TEST(SlowStandardErrors, AreThoseOfPaths) {
  const auto scene = std::make_shared<const Scene>(builtin_scene("cornell"));
  RenderSettings settings = effort(256);
  settings.integrator = Integrator::path;
  expect_honest_errors(scene, sensors_in(scene->bounds()), settings, 64);
}

TEST(SlowStandardErrors, AreThoseUnderPatchesOfTheSky) {
  SceneDescription d;
  d.materials.resize(1);
  add_quad(d, {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
  add_quad(d, {-2, 0, -2}, {4, 0, 0}, {0, 2, 0});
  const auto scene = std::make_shared<const Scene>(scene_under_patches(Scene(std::move(d)), SkyPatches(145)));
  expect_honest_errors(scene, sensors_in(scene->bounds()), patch_settings(effort(16)), 32, kPatchBatches);
}

/// Errors of sensors over those that are stated: deviations from the mean over seeds.
struct Deviations {
  double rms = 0;
  double beyond_two = 0, beyond_three = 0;  ///< shares of those that are larger
};

Deviations deviations(const std::shared_ptr<const Scene>& scene, const Sensors& sensors, const RenderSettings& effort,
                      std::uint32_t seeds) {
  const auto tracer = std::make_shared<const Tracer>(*scene);
  const auto grid = std::make_shared<const PointGrid>(sensor_grid(sensors, false));
  RenderSettings settings = sensor_settings(effort);
  std::vector<std::vector<double>> level(sensors.size()), stated(sensors.size());
  for (settings.seed = 1; settings.seed <= seeds; ++settings.seed) {
    Job job(scene, tracer, settings, nullptr, end_of_sensors(), grid);
    job.wait();
    const Measurement measured = measurement_of(sensors, job.snapshot(), *scene);
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      level[i].push_back(luminance(measured.irradiance[i]));
      stated[i].push_back(level[i].back() * measured.relative_error[i]);
    }
  }
  Deviations out;
  const double count = static_cast<double>(seeds) * static_cast<double>(sensors.size());
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const double mean = std::accumulate(level[i].begin(), level[i].end(), 0.0) / seeds;
    for (std::size_t k = 0; k < seeds; ++k) {
      // A value takes part in the mean, which lessens its deviation from it.
      const double z = (level[i][k] - mean) / stated[i][k] * std::sqrt(seeds / (seeds - 1.0));
      out.rms += z * z / count;
      out.beyond_two += (std::abs(z) > 2) / count;
      out.beyond_three += (std::abs(z) > 3) / count;
    }
  }
  out.rms = std::sqrt(out.rms);
  return out;
}

/// Eight sensors on two levels of a box, half of them facing up. @param low, high levels as shares of the height
Sensors sensors_on_levels(const Box3& box, int up, float low, float high) {
  const int x = (up + 1) % 3, y = (up + 2) % 3;
  Sensors out;
  for (int i = 0; i < 8; ++i) {
    Vec3 share, direction{0, 0, 0};
    share[x] = i & 1 ? 0.7f : 0.25f;
    share[y] = i & 2 ? 0.6f : 0.3f;
    share[up] = i & 2 ? high : low;
    direction[i < 4 ? up : i & 1 ? x : y] = i < 6 ? 1.0f : -1.0f;
    out.add(box.min + share * box.diagonal(), direction);
  }
  return out;
}

/// Rays and photons that users ask for in a hurry.
RenderSettings hasty() {
  RenderSettings settings;
  settings.gather = 32;
  settings.photons = 5000;
  return settings;
}

/// The errors of eight batches spread, widened by Student's t, by 0.98 of what is stated; 4.7% are beyond twice of it,
/// 1% beyond three times. 160 of them know their spread to a tenth.
void expect_stated(const Deviations& found) {
  EXPECT_GT(found.rms, 0.8);
  EXPECT_LT(found.rms, 1.2);
  EXPECT_LT(found.beyond_two, 0.1);
  EXPECT_LT(found.beyond_three, 0.03);
}

constexpr std::uint32_t kSeeds = 20;

TEST(SlowStandardErrors, AreThoseThatAreStatedInARoom) {
  const auto scene = std::make_shared<const Scene>(builtin_scene("cornell"));
  expect_stated(deviations(scene, sensors_on_levels(scene->bounds(), 1, 0.65f, 0.8f), hasty(), kSeeds));
}

TEST(SlowStandardErrors, AreThoseThatAreStatedOfALampInABox) {
  SceneDescription d = floor_description();
  add_quad(d, {-2, -2, 2}, {0, 4, 0}, {4, 0, 0});
  add_quad(d, {-2, -2, 0}, {0, 4, 0}, {0, 0, 2});
  add_quad(d, {2, -2, 0}, {0, 0, 2}, {0, 4, 0});
  add_quad(d, {-2, -2, 0}, {0, 0, 2}, {4, 0, 0});
  add_quad(d, {-2, 2, 0}, {4, 0, 0}, {0, 0, 2});
  d.lights.push_back(point_light());
  const auto scene = std::make_shared<const Scene>(std::move(d));
  expect_stated(deviations(scene, sensors_on_levels(scene->bounds(), 2, 0.1f, 0.7f), hasty(), kSeeds));
}

TEST(SlowStandardErrors, AreThoseThatAreStatedOfSunThroughGlass) {
  SceneDescription d = lit_floor(LightCase::sun);
  Material& glass = d.materials.emplace_back();
  glass.kind = MaterialKind::dielectric;
  glass.reflectance.value = glass.transmittance.value = RGB(1.0f);
  add_quad(d, {-2, -2, 1.02f}, {4, 0, 0}, {0, 4, 0}, 1);
  add_quad(d, {-2, -2, 1}, {0, 4, 0}, {4, 0, 0}, 1);
  const auto scene = std::make_shared<const Scene>(std::move(d));
  expect_stated(deviations(scene, sensors_on_levels(scene->bounds(), 2, 0.1f, 0.5f), hasty(), kSeeds));
}

/// The spread of two samples of one sensor says little.
TEST(StandardErrors, OfFewSensorsAreKnownBeforeTheyEndAMeasurement) {
  const auto scene = std::make_shared<const Scene>(builtin_scene("cornell"));
  const auto tracer = std::make_shared<const Tracer>(*scene);
  const auto passes = [&](std::size_t count, Integrator integrator) {
    Sensors sensors = plane_sensors("y=0.3,0.2", *scene);
    sensors.position.resize(count);
    sensors.normal.resize(count);
    RenderSettings settings = sensor_settings(effort(0));
    settings.integrator = integrator;
    settings.noise_target = 10;
    Job job(scene, tracer, settings, nullptr, end_of_sensors(),
            std::make_shared<const PointGrid>(sensor_grid(sensors, false)));
    job.wait();
    return job.film().whole_passes();
  };
  EXPECT_EQ(passes(1, Integrator::gather), kSensorBatches);
  EXPECT_EQ(passes(1, Integrator::path), 256u) << "few paths may all miss a light";
  EXPECT_EQ(passes(16, Integrator::path), 256u) << "those of many sensors may miss the same light";
  EXPECT_EQ(passes(16, Integrator::gather), 2u);
}

/// The error of one sensor, known by few batches, swings while paths are added. Rough metal widens the spread of paths.
TEST(StandardErrors, OfOneSensorDoNotEndPathsByChance) {
  SceneDescription d;
  Material& metal = d.materials.emplace_back();
  metal.kind = MaterialKind::conductor;
  metal.use_reflectance = true;
  metal.reflectance.value = RGB(1.0f);
  metal.roughness_u.value = metal.roughness_v.value = 0.3f;
  add_quad(d, {-500, 0, -500}, {0, 0, 1000}, {1000, 0, 0});
  Environment& sky = d.environment.emplace();
  sky.scale = RGB(1.0f);
  const auto scene = std::make_shared<const Scene>(std::move(d));
  const auto tracer = std::make_shared<const Tracer>(*scene);
  Sensors sensor;
  sensor.add({0, 1, 0}, {0, -1, 0});
  const auto grid = std::make_shared<const PointGrid>(sensor_grid(sensor, false));
  constexpr std::uint32_t kRuns = 32;
  double squares = 0;
  for (std::uint32_t seed = 0; seed < kRuns; ++seed) {
    RenderSettings asked;
    asked.integrator = Integrator::path;
    asked.seed = seed;
    asked.noise_target = 0.005;
    Job job(scene, tracer, sensor_settings(asked), nullptr, end_of_sensors(), grid);
    job.wait();
    const Measurement m = measurement_of(sensor, job.film(), *scene);
    squares += std::pow((m.irradiance[0].g / std::numbers::pi - 1) / m.relative_error[0], 2);
  }
  // 2.1 where each path tested the noise.
  EXPECT_LT(std::sqrt(squares / kRuns), 1.5);
}

/// Samples of one pixel of known luminance, sample after sample.
Film film_of(const SampleBatches& batches, const std::vector<float>& samples) {
  Film film({0, 0, 1, 1}, false, false, {}, false, 0, batches);
  SlotRadiance radiance;
  radiance.resize(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) radiance.direct[i] = RGB(samples[i]);
  film.add({0, 0, 1, 1, 0, static_cast<std::uint32_t>(samples.size())}, radiance, {}, {});
  return film;
}

TEST(StandardErrors, OfFewBatchesAreWidenedByStudentsT) {
  // Quantiles of tables.
  for (const auto& [degrees, quantile] : {std::pair(1, 12.706), {2, 4.303}, {3, 3.182}, {7, 2.365}, {15, 2.131}})
    EXPECT_NEAR(student_factor(static_cast<std::uint32_t>(degrees)), quantile / 1.96, 0.002 * quantile) << degrees;
  EXPECT_NEAR(student_factor(100'000), 1, 1e-4);
  // Two batches of one sample of a sensor: the stated error is the spread's by that factor.
  Sensors sensor;
  sensor.add({0, 0, 0}, {0, 0, 1});
  const Scene scene(lit_floor(LightCase::sky));
  const Measurement measured = measurement_of(sensor, film_of({3, 0}, {1, 3}), scene);
  EXPECT_NEAR(measured.relative_error[0], student_factor(1) / 2, 1e-4);
}

TEST(StandardErrors, OfSensorsThatFoundNoLightAreUnknown) {
  Sensors sensor;
  sensor.add({0, 0, 0}, {0, 0, 1});
  const Scene lit(lit_floor(LightCase::sky));
  const Film dark = film_of({3, 0}, {0, 0, 0, 0});
  const Measurement measured = measurement_of(sensor, dark, lit);
  EXPECT_TRUE(std::isinf(measured.relative_error[0]));
  // A chance of 95% that none of 4 finds what 53% find: 0.47^4 = 0.05.
  ASSERT_EQ(doubts_after(measured, lit).size(), 1u);
  EXPECT_THAT(doubts_after(measured, lit)[0],
              testing::HasSubstr("4 samples were too few: with 95% confidence, at most 53% of samples"));
  EXPECT_THAT(measurement_csv(measured, ""), testing::HasSubstr(",0,inf\n"));
  const nlohmann::json json = nlohmann::json::parse(measurement_json(measured, ""));
  EXPECT_TRUE(json.at("points").at(0).at("relative_error").is_null());
  EXPECT_THAT(measurement_vtk(measured, ""), testing::Not(testing::HasSubstr("inf")));
  const std::string page = measurement_page(measured, "", {});
  EXPECT_THAT(page, testing::HasSubstr("relative error</td><td>unknown"));
  EXPECT_THAT(page, testing::HasSubstr(",\"unknown\"]"));
  // In a scene without light, darkness is certain.
  SceneDescription d = lit_floor(LightCase::sky);
  d.environment->scale = RGB(0.0f);
  const Scene unlit(std::move(d));
  EXPECT_EQ(measurement_of(sensor, dark, unlit).relative_error[0], 0);
  EXPECT_TRUE(doubts_after(measurement_of(sensor, dark, unlit), unlit).empty());
}

TEST(FilmBatches, TellTheVarianceByTheirMeans) {
  // The batches 0 and 1 have two samples, the batch 2 one.
  const Film film = film_of({3, 0}, {1, 2, 6, 3, 8});
  const double mean = 4, spread = 2 * std::pow(2 - mean, 2) + 2 * std::pow(5 - mean, 2) + std::pow(6 - mean, 2);
  EXPECT_NEAR(film.variance(0), spread / 2 / 5, 1e-5);
  EXPECT_NEAR(film_of({3, 0}, {1, 3}).variance(0), 1, 1e-6) << "two batches with one sample";
  EXPECT_EQ(film_of({3, 0}, {1}).variance(0), 0);
}

TEST(FilmBatches, OfPartsAreThoseOfTheWhole) {
  const Film whole = film_of({3, 0}, {1, 2, 6, 3, 8});
  Film together = film_of({3, 0}, {1, 2});
  const Film rest = film_of({3, 2}, {6, 3, 8});
  EXPECT_EQ(together.like({0, 0, 1, 1}, 2).save().size(), rest.save().size());
  together.add({0, 0, 1, 1, 2, 3}, rest);
  EXPECT_EQ(together.save(), whole.save());
  EXPECT_EQ(together.variance(0), whole.variance(0));
}

}  // namespace
}  // namespace glowworm
