// The filtered picture of renders, and its error estimate.
#include "film/filtered.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "builtin/builtin.h"
#include "core/random.h"
#include "film/aov.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

RenderSettings filtered_render(int side, std::uint32_t samples) {
  RenderSettings s = by_photons(side, samples, 8, 20'000, "blocked");
  s.filter = Filtering::automatic;
  return s;
}

/// Root over pixels of the mean of the squared difference of luminance, relative as relative_error() is.
double true_error(const FilmPicture& picture, const FilmPicture& reference) {
  const double mean = mean_luminance(reference);
  double sum = 0;
  for (std::size_t i = 0; i < reference.radiance.size(); ++i) {
    const double m = luminance(reference.radiance[i]), d = luminance(picture.radiance[i]) - m;
    sum += d * d / (m * m + 0.01 * mean * mean);
  }
  return std::sqrt(sum / static_cast<double>(reference.radiance.size()));
}

/// The same over the nine tenths of the pixels with the smallest differences: without edges.
double inner_error(const FilmPicture& picture, const FilmPicture& reference) {
  std::vector<double> squares;
  for (std::size_t i = 0; i < picture.radiance.size(); ++i) {
    const double d = luminance(picture.radiance[i]) - luminance(reference.radiance[i]);
    squares.push_back(d * d);
  }
  std::sort(squares.begin(), squares.end());
  return std::sqrt(std::accumulate(squares.begin(), squares.end() - std::ssize(squares) / 10, 0.0));
}

TEST(Filtered, PicturesHaveLessErrorAndEstimateIt) {
  const Stage stage(builtin_scene("cornell"));
  const FilmPicture reference = unfiltered_picture(stage.render(filtered_render(48, 100)), false);
  const Film film = stage.render(filtered_render(48, 8));
  const FilmPicture filtered = filtered_picture(film, false), unfiltered = unfiltered_picture(film, false);
  EXPECT_LT(inner_error(filtered, reference), 0.8 * inner_error(unfiltered, reference));
  const double error = true_error(filtered, reference);
  EXPECT_LT(error, true_error(unfiltered, reference));
  EXPECT_NEAR(relative_error(filtered), error, 0.3 * error);
}

/// Seen from 2 m: a surface of 2 x 2 m, and before it a lamp of 0.3 m that shines on it from the given distance.
SceneDescription lamp_before_a_wall(float distance) {
  SceneDescription d;
  d.materials.resize(2);
  d.materials[0].reflectance.value = RGB(0.5f);
  d.materials[1].reflectance.value = RGB(0.0f);
  add_quad(d, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  add_quad(d, {-0.15f, -0.15f, distance}, {0.02f, 0.3f, 0}, {0.3f, -0.02f, 0}, 1, add_emission(d, RGB(100.0f)));
  d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 2, 1));
  return d;
}

/// A grey room with a lamp 2 mm below the ceiling, which shines on both sides.
SceneDescription lamp_below_a_ceiling() {
  SceneDescription d;
  d.materials.resize(2);
  d.materials[0].reflectance.value = RGB(0.7f);
  d.materials[1].reflectance.value = RGB(0.0f);
  add_quad(d, {-2, 0, -2}, {0, 0, 5}, {4, 0, 0});
  add_quad(d, {-2, 2.5f, -2}, {4, 0, 0}, {0, 0, 5});
  add_quad(d, {-2, 0, -2}, {4, 0, 0}, {0, 2.5f, 0});
  add_quad(d, {-2, 0, 3}, {0, 2.5f, 0}, {4, 0, 0});
  add_quad(d, {-2, 0, -2}, {0, 2.5f, 0}, {0, 0, 5});
  add_quad(d, {2, 0, -2}, {0, 0, 5}, {0, 2.5f, 0});
  add_quad(d, {-0.3f, 2.498f, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}, 1, add_emission(d, RGB(100.0f), true));
  d.cameras.push_back(look_at({0, 1.2f, 2.8f}, {0, 2.2f, -1}, {0, 1, 0}, 50));
  return d;
}

/// The ceiling two to six pixels beside the lamp is even. The filter makes it less than 3% brighter, and its error is
/// at most that of the samples.
TEST(Filtered, CeilingsBesideLampsHaveNoRing) {
  constexpr int kSide = 96, kReach = 6, kSeeds = 4;
  const Stage stage(lamp_below_a_ceiling());
  const Film film = stage.render(filtered_render(kSide, 64));
  const FilmPicture reference = unfiltered_picture(film, false);
  const auto is_lamp = [&](int x, int y) {
    return !is_black(film.mean(Film::Layer::emitted, static_cast<std::size_t>(y * kSide + x)));
  };
  std::vector<std::size_t> ring;
  for (int y = kReach; y < kSide / 2; ++y)
    for (int x = kReach; x < kSide - kReach; ++x) {
      int nearest = kReach + 1;
      for (int v = y - kReach; v <= y + kReach; ++v)
        for (int u = x - kReach; u <= x + kReach; ++u)
          if (is_lamp(u, v)) nearest = std::min(nearest, std::max(std::abs(u - x), std::abs(v - y)));
      if (nearest >= 2 && nearest <= kReach) ring.push_back(static_cast<std::size_t>(y * kSide + x));
    }
  ASSERT_GT(ring.size(), 200u);
  double right = 0;
  for (const std::size_t i : ring) right += luminance(reference.radiance[i]) / static_cast<double>(ring.size());
  for (const std::uint32_t samples : {2U, 8U}) {
    double mean = 0, error = 0, noise = 0;
    RenderSettings settings = filtered_render(kSide, samples);
    for (settings.seed = 1; settings.seed <= kSeeds; ++settings.seed) {
      const Film sampled = stage.render(settings);
      const FilmPicture filtered = filtered_picture(sampled, false), plain = unfiltered_picture(sampled, false);
      for (const std::size_t i : ring) {
        const double value = luminance(filtered.radiance[i]);
        mean += value / static_cast<double>(kSeeds * ring.size());
        error += std::pow(value - right, 2);
        noise += std::pow(luminance(plain.radiance[i]) - right, 2);
      }
    }
    EXPECT_NEAR(mean, right, 0.03 * right) << samples;
    EXPECT_LT(error, noise) << samples;
  }
}

/// Only a few samples beside the lamp meet bright light. If it spreads, the lamp has a halo, and the error is up to 44
/// times the unfiltered one. Stratified samples err about half as much as their spread says, by which the filter
/// compares pixels, and where light falls steeply it blurs a little.
TEST(Filtered, LampsNearSurfacesHaveNoHalo) {
  for (const float distance : {0.002f, 0.01f}) {
    const Stage stage(lamp_before_a_wall(distance));
    const FilmPicture reference = unfiltered_picture(stage.render(filtered_render(32, 100)), false);
    // Of the pixels that are dark beside those next to the lamp.
    const auto error = [&](const FilmPicture& picture) {
      double sum = 0;
      for (std::size_t i = 0; i < picture.radiance.size(); ++i)
        if (const float right = luminance(reference.radiance[i]); right < 5 * distance)
          sum += std::abs(luminance(picture.radiance[i]) - right);
      return sum;
    };
    for (const std::uint32_t samples : {2U, 8U}) {
      const Film film = stage.render(filtered_render(32, samples));
      EXPECT_LT(error(filtered_picture(film, false)), 4 * error(unfiltered_picture(film, false)))
          << distance << " m, " << samples << " samples";
    }
  }
}

/// Sun through slits in a board, which lights strips of a floor that are narrower than a pixel. They are blurred if
/// they pass for noise.
TEST(Filtered, StripsOfSunAreNotBlurred) {
  SceneDescription d;
  d.materials.resize(1);
  d.materials[0].reflectance.value = RGB(0.6f);
  add_quad(d, {-2, -2, 0}, {4, 0, 0}, {0, 4, 0});
  constexpr float kWidth = 0.4f, kSlit = 0.005f;
  for (int i = 0; i < 10; ++i)
    add_quad(d, {-2 + kWidth * static_cast<float>(i), -2, 0.5f}, {kWidth - kSlit, 0.05f, 0}, {0, 4, 0});
  Light sun;
  sun.kind = LightKind::directional;
  sun.intensity = RGB(60);
  sun.direction = {0.1f, 0, -1};
  d.lights.push_back(sun);
  d.environment = Environment{};
  d.environment->scale = RGB(0.5f);
  d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 0.4f, 1));
  const Stage stage(d);
  const FilmPicture reference = unfiltered_picture(stage.render(filtered_render(32, 100)), false);
  for (const std::uint32_t samples : {2U, 8U}) {
    const Film film = stage.render(filtered_render(32, samples));
    EXPECT_LT(true_error(filtered_picture(film, false), reference),
              1.1 * true_error(unfiltered_picture(film, false), reference))
        << samples;
  }
}

/// Pixels of luminance 0.1, of which every hundredth sample is 10 and all others 0. The few bright pixels must not pass
/// for bright surfaces of little relative noise.
TEST(Filtered, RelativeErrorKnowsFirefliesFromBrightSurfaces) {
  constexpr int kSamples = 20, kSide = 140, kPixels = kSide * kSide;
  constexpr float kBright = 10, kChance = 0.01f, kLevel = kBright * kChance;
  FilmPicture picture{{}, {}, kSide};
  double true_variance = 0;
  for (int i = 0; i < kPixels; ++i) {
    Sampler sampler(SamplerKind::independent, 1, static_cast<std::uint32_t>(i), 0);
    int hits = 0;
    for (int s = 0; s < kSamples; ++s) hits += sampler.next1() < kChance;
    const float share = static_cast<float>(hits) / kSamples, error = kBright * share - kLevel;
    picture.radiance.push_back(RGB(kBright * share));
    picture.variance.push_back(kBright * kBright * share * (1 - share) / (kSamples - 1));
    true_variance += error * error / kPixels;
  }
  const double error = std::sqrt(true_variance / (1.01 * kLevel * kLevel));
  EXPECT_NEAR(relative_error(picture), error, 0.2 * error);
}

TEST(Filtered, RendersStopByTheErrorOfTheFilteredPicture) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = filtered_render(48, 0);
  settings.noise_target = 0.1;
  Job job(stage.scene, stage.tracer, settings);
  job.wait();
  EXPECT_EQ(job.ending(), Ending::noise_reached);
  const Film film = job.snapshot();
  EXPECT_LE(relative_error(filtered_picture(film, false)), settings.noise_target);
  EXPECT_GT(relative_error(unfiltered_picture(film, false)), 1.2 * settings.noise_target);
}

/// A film of one pixel with the same first hit and light in each sample, and other emission and albedo by surface
/// samples.
Film pixel_with_surface_samples(std::uint32_t samples, RGB albedo, RGB surface_albedo, float emitted,
                                float surface_emitted) {
  Film film({0, 0, 1, 1}, false, true, {.surface_samples = true}, true);
  for (std::uint32_t i = 0; i < samples; ++i) {
    SlotRadiance radiance;
    radiance.resize(1);
    radiance.emitted[0] = RGB(emitted);
    radiance.indirect[0] = albedo;
    radiance.surface_emitted = {RGB(surface_emitted)};
    FirstHit hit;
    hit.albedo = {albedo};
    hit.surface_albedo = {surface_albedo};
    hit.normal = {Vec3{0, 0, 1}};
    hit.depth = {1.0f};
    film.add({0, 0, 1, 1, i, 1}, radiance, hit, Geometry());
  }
  return film;
}

TEST(Filtered, NoiseOfLampsIsThatOfSurfaceSamples) {
  constexpr int kSide = 64;
  constexpr std::uint32_t kPixels = kSide * kSide, kSamples = 8;
  // The lamp fills a quarter of a disk in a corner of the pixel.
  constexpr float kLamp = 8, kRadius = 0.6f, kShare = kPi / 4 * kRadius * kRadius;
  Film film({0, 0, kSide, kSide}, false, true, {.surface_samples = true}, true);
  for (std::uint32_t s = 0; s < kSamples; ++s) {
    SlotRadiance radiance;
    radiance.resize(kPixels);
    radiance.surface_emitted.resize(kPixels);
    FirstHit hit;
    hit.albedo = hit.surface_albedo = std::vector<RGB>(kPixels, RGB(0.5f));
    hit.normal.assign(kPixels, Vec3{0, 0, 1});
    hit.depth.assign(kPixels, 1.0f);
    for (std::uint32_t i = 0; i < kPixels; ++i) {
      const auto lamp = [&](std::uint32_t seed, std::uint32_t sample) {
        const Vec2 at = Sampler(SamplerKind::sobol, seed, i, sample).next2();
        return RGB(at.x * at.x + at.y * at.y < kRadius * kRadius ? kLamp : 0.0f);
      };
      radiance.emitted[i] = lamp(3, s);
      for (std::uint32_t k = 0; k < kSurfaceSamples; ++k)
        radiance.surface_emitted[i] += lamp(4, s * kSurfaceSamples + k) * (1.0f / kSurfaceSamples);
    }
    film.add({0, 0, kSide, kSide, s, 1}, radiance, hit, Geometry());
  }
  const FilmPicture picture = filtered_picture(film, false);
  double stated = 0, squares = 0;
  for (std::uint32_t i = 0; i < kPixels; ++i) {
    stated += picture.variance[i];
    squares += std::pow(picture.radiance[i].g - kLamp * kShare, 2);
  }
  // Stated by the strata of the camera samples, which hold for lamps behind glass, too. Those of surface samples make
  // it twice too large for a lamp that is seen directly, and nets err a little less than jittered samples.
  EXPECT_GT(stated / squares, 1);
  EXPECT_LT(stated / squares, 3.5);
}

TEST(Filtered, LightHasTheAlbedoOfSurfaceSamples) {
  const auto shown = [](const Film& film) { return filtered_picture(film, false).radiance[0]; };
  const RGB lit = shown(pixel_with_surface_samples(4, RGB(0.4f), RGB(0.5f), 0, 0));
  EXPECT_NEAR(lit.g, 0.5f, 1e-6f);
  // Light of dark surfaces, or of a channel that is dark beside others, is divided by more than its albedo.
  const RGB dark{0.8f, 0.02f, 0.001f};
  const RGB same = shown(pixel_with_surface_samples(4, dark, dark, 0, 0));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(same[c], dark[c], 1e-6f);
  const RGB black = shown(pixel_with_surface_samples(4, RGB(0.002f), RGB(0.002f), 0, 0));
  EXPECT_NEAR(black.g, 0.002f, 1e-7f);
  const RGB lamp = shown(pixel_with_surface_samples(4, RGB(0.4f), RGB(0.5f), 3, 2));
  EXPECT_NEAR(lamp.g, 2.5f, 1e-5f);
  // A single sample stays as it is.
  const RGB single = shown(pixel_with_surface_samples(1, RGB(0.4f), RGB(0.5f), 3, 2));
  EXPECT_NEAR(single.g, 3.4f, 1e-5f);
}

/// Pseudocolours of illuminance subtract the layer of emission from the image and divide by that of albedo.
TEST(Filtered, LayersOfEmissionAndAlbedoAreThoseOfTheImage) {
  const Film film = pixel_with_surface_samples(4, RGB(0.4f), RGB(0.5f), 3, 2);
  const FilmPicture picture = filtered_picture(film, false);
  Image image(1, 1);
  for (const char* layer : {"emitted", "albedo"}) add_layer(image, {film, PictureInfo(), picture}, layer);
  EXPECT_NEAR(image.rgb("emitted")[0].g, 2, 1e-5f);
  EXPECT_NEAR(image.rgb("albedo")[0].g, 0.5f, 1e-6f);
  EXPECT_NEAR((picture.radiance[0].g - 2) / 0.5f, 1, 1e-5f);  // the light over albedo of each sample
}

TEST(Film, TakesTheSamplesOfATaskFromAnotherFilm) {
  const CameraTask tasks[] = {{0, 0, 16, 10, 0, 1}, {0, 10, 16, 16, 0, 1}};
  Film whole({0, 0, 16, 16}, false, true, {}, true), lower = whole, upper = whole.like({0, 0, 16, 10});
  for (const CameraTask& task : tasks) {
    SlotRadiance radiance;
    radiance.resize(task.slot_count());
    FirstHit hit;
    hit.albedo.assign(task.slot_count(), RGB(0.3f));
    hit.normal.assign(task.slot_count(), Vec3{0, 0, 1});
    hit.depth.assign(task.slot_count(), 2.5f);
    for (std::size_t i = 0; i < task.slot_count(); ++i) {
      radiance.direct[i] = RGB(0.1f * static_cast<float>(i), 0.7f, 1.3f);
      radiance.indirect[i] = RGB(0.3f, 0.01f * static_cast<float>(i), 2.3f);
    }
    whole.add(task, radiance, hit, Geometry());
    (task.y0 == 0 ? upper : lower).add(task, radiance, hit, Geometry());
  }
  lower.add_not_finite(3);
  whole.add_not_finite(3);
  EXPECT_TRUE(lower.awaits(tasks[0]));
  EXPECT_FALSE(lower.awaits(tasks[1]));
  EXPECT_TRUE(upper.is_of(tasks[0]));
  EXPECT_FALSE(lower.is_of(tasks[1]));
  lower.add(tasks[0], upper);
  lower.add(tasks[0], upper);  // it has them already
  EXPECT_EQ(lower.save(), whole.save());
  EXPECT_EQ(lower.not_finite(), 3u);
  Film restored({0, 0, 16, 16}, false, true, {}, true);
  ASSERT_TRUE(restored.restore(lower.save()));
  EXPECT_EQ(restored.moments(Film::Layer::direct, 5).mean, whole.moments(Film::Layer::direct, 5).mean);
}

TEST(Film, MomentsAreThoseOfLightOverAlbedo) {
  Film film({0, 0, 1, 1}, false, true, {}, true);
  const float light[] = {0.2f, 0.4f, 0.9f}, albedo = 0.5f;
  for (std::uint32_t i = 0; i < 3; ++i) {
    SlotRadiance radiance;
    radiance.resize(1);
    radiance.indirect[0] = RGB(light[i]);
    FirstHit hit;
    hit.albedo = {RGB(albedo)};
    hit.normal = {Vec3{0, 0, 1}};
    hit.depth = {1.0f};
    film.add({0, 0, 1, 1, i, 1}, radiance, hit, Geometry());
  }
  const Film::Moments moments = film.moments(Film::Layer::indirect, 0);
  EXPECT_NEAR(moments.mean, 1.0f, 1e-6f);
  // Of 0.4, 0.8 and 1.8: the sum of squared differences over n (n - 1).
  EXPECT_NEAR(moments.variance, (0.36f + 0.04f + 0.64f) / 6, 1e-6f);
  EXPECT_EQ(film.moments(Film::Layer::direct, 0).variance, 0);
}

}  // namespace
}  // namespace glowworm
