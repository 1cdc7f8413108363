// Whether sensors vary from seed to seed as much as their standard errors say.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "builtin/builtin.h"
#include "measure/measurement.h"
#include "measure/sky_patches.h"
#include "render/job.h"
#include "scene/scene_parts.h"
#include "support/goodness_of_fit.h"

namespace glowworm {
namespace {

/// Chance that the right standard error fails one of these tests, were seeds not fixed.
constexpr double kSignificance = 0.001;

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

/// Measures with one seed after another. Tests the sum over seeds and sensors of (value - mean of the sensor)^2 over
/// the variance that is stated, by both tails of its distribution. The stated variance is the mean over seeds, because
/// the inverse of a single one is biased.
void expect_honest_errors(const std::shared_ptr<const Scene>& scene, const Sensors& sensors, RenderSettings settings,
                          std::uint32_t seeds, std::uint32_t batches = kSensorBatches) {
  const auto tracer = std::make_shared<const Tracer>(*scene);
  const auto grid = std::make_shared<const PointGrid>(sensor_grid(sensors, false, batches));
  std::vector<RunningMean> value(sensors.size()), stated(sensors.size());
  settings.guiding = false;
  settings = sensor_settings(settings);
  for (settings.seed = 1; settings.seed <= seeds; ++settings.seed) {
    Job job(scene, tracer, settings, nullptr, sensor_time(), grid);
    job.wait();
    const Film film = job.snapshot();
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      value[i].add(luminance(film.radiance(i, false)));
      stated[i].add(film.variance(i));
    }
  }
  double statistic = 0;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    ASSERT_GT(stated[i].mean(), 0) << i;
    statistic += (seeds - 1) * seeds * std::pow(value[i].standard_error(), 2) / stated[i].mean();
  }
  const int degrees = static_cast<int>(sensors.size() * (seeds - 1));
  const double tail = chi_squared_tail(statistic, degrees);
  EXPECT_GT(2 * std::min(tail, 1 - tail), kSignificance) << statistic / degrees << " times the stated variance";
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
    Job job(scene, tracer, settings, nullptr, sensor_time(),
            std::make_shared<const PointGrid>(sensor_grid(sensors, false)));
    job.wait();
    return job.film().whole_passes();
  };
  EXPECT_EQ(passes(1, Integrator::gather), kSensorBatches);
  EXPECT_GE(passes(1, Integrator::path), kSensorBatches);
  EXPECT_EQ(passes(16, Integrator::gather), 2u);
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
