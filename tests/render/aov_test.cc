// Layers of surface points: positions, texture coordinates and ids, and the matrices stored with them.
#include "film/aov.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "builtin/builtin.h"
#include "control/job_report.h"
#include "film/output.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

RenderSettings with_layers() {
  RenderSettings s = by_photons(24, 4, 1, 1000);
  s.aovs = {"position", "uv", "cryptomatte"};
  return s;
}

Box3 bounds_of(const Geometry& g, std::uint32_t object) {
  Box3 box;
  for (std::uint32_t t = 0; t < g.triangle_count(); ++t)
    if (g.object_of(t) == object)
      for (const std::uint32_t vertex : g.triangles[t]) box.grow(g.positions[vertex]);
  return box;
}

// Published values of MurmurHash3_x86_32 with seed 0.
TEST(Cryptomatte, HashesAsPublished) {
  EXPECT_EQ(cryptomatte_hash("test"), 0xba6bd213u);
  EXPECT_EQ(cryptomatte_hash("Hello, world!"), 0xc0363e43u);
  EXPECT_EQ(cryptomatte_hash("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
  // A hash of zero is no normal float.
  EXPECT_EQ(cryptomatte_hash(""), 1u << 23);
}

TEST(Layers, OfPlacesAgreeWithTheScene) {
  const Stage stage(builtin_scene("cornell"));
  const Geometry& g = stage.scene->geometry();
  for (const Integrator integrator : {Integrator::gather, Integrator::path, Integrator::photons}) {
    RenderSettings settings = with_layers();
    settings.integrator = integrator;
    const Film film = stage.render(settings);
    std::size_t inner = 0;
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
      const Film::IdCount object = film.objects()[i][0], material = film.materials()[i][0];
      if (object.count < settings.samples) continue;
      ++inner;
      const RGB p = film.mean(Film::Layer::position, i);
      const Box3 box = bounds_of(g, object.id);
      for (int c = 0; c < 3; ++c) {
        EXPECT_GE(p[c], box.min[c] - 1e-4f) << g.objects[object.id].name;
        EXPECT_LE(p[c], box.max[c] + 1e-4f) << g.objects[object.id].name;
      }
      const std::string& name = g.objects[object.id].name;
      EXPECT_EQ(stage.scene->materials()[material.id].name, name == "left wall"    ? "red"
                                                            : name == "right wall" ? "green"
                                                            : name == "lamp"       ? "lamp"
                                                                                   : "white");
    }
    EXPECT_GT(inner, film.pixel_count() / 2);
  }
}

TEST(Layers, OfPlacesComeBackFromACheckpointAndCostNothingWhereNotAsked) {
  const Stage stage(builtin_scene("cornell"));
  Job job(stage.scene, stage.tracer, with_layers());
  job.wait();
  const Checkpoint checkpoint = job.checkpoint();
  RenderSettings more = with_layers();
  more.samples = 6;
  Job resumed(stage.scene, stage.tracer, more, &checkpoint);
  resumed.wait();
  EXPECT_EQ(resumed.snapshot().save(), stage.render(more).save());
  const PixelBounds part{0, 0, 10, 10};
  EXPECT_EQ(Film(part).save().size() * sizeof(std::uint32_t), Film::bytes(part) + 8);
  EXPECT_LT(Film::bytes(part), Film::bytes(part, true, {true, false, false, false}));
}

TEST(Layers, RadiusIsThatOfThePhotonsAndNothingOfPaths) {
  const Stage stage(builtin_scene("cornell"));
  for (const Integrator integrator : {Integrator::gather, Integrator::photons, Integrator::path}) {
    RenderSettings settings = by_photons(24, 4, 1, 4000);
    settings.integrator = integrator;
    settings.fixed_radius = true;
    settings.aovs = {"radius"};
    const auto radii = [&](std::uint32_t nearest) {
      settings.nearest = nearest;
      const Film film = stage.render(settings);
      std::vector<float> out;
      for (std::size_t i = 0; i < film.pixel_count(); ++i)
        if (film.value(SlotValue::radius, i) > 0) out.push_back(film.value(SlotValue::radius, i));
      return out;
    };
    const std::vector<float> few = radii(20), many = radii(80);
    if (integrator == Integrator::path) {
      EXPECT_TRUE(few.empty());
      continue;
    }
    // One radius for all, which grows with the root of the photons that it catches.
    ASSERT_GT(few.size(), 24 * 18 / 2);
    for (const float radius : few) EXPECT_NEAR(radius, few.front(), 1e-5f * few.front());
    EXPECT_NEAR(many.front(), 2 * few.front(), 0.3f * few.front());
    // Radii of their own lie around it.
    settings.fixed_radius = false;
    double sum = 0;
    const std::vector<float> own = radii(20);
    for (const float radius : own) sum += radius;
    EXPECT_NEAR(sum / static_cast<double>(own.size()), few.front(), 0.5 * few.front());
    EXPECT_LT(*std::min_element(own.begin(), own.end()), *std::max_element(own.begin(), own.end()));
  }
}

TEST(SlowLayers, BiasIsWhatWideRadiiAddOrTakeAway) {
  // A point light a metre above a floor: the path tracer has no noise.
  const Stage stage(lit_floor(LightCase::point));
  RenderSettings settings = by_photons(32, 4, 1, 0);
  settings.integrator = Integrator::path;
  const Film truth = stage.render(settings);
  settings.integrator = Integrator::photons;
  settings.photons = 100000;
  settings.nearest = 8000;
  settings.aovs = {"bias"};
  for (const char* engine : {"blocked", "knn"}) {
    settings.engine = engine;
    // Radii that jump between parts of a surface add errors of their own.
    settings.fixed_radius = settings.engine == "blocked";
    const Film film = stage.render(settings);
    double before = 0, after = 0;
    for (std::size_t i = 0; i < film.pixel_count(); ++i) {
      const float error = luminance(film.radiance(i, false)) - luminance(truth.radiance(i, false));
      before += std::pow(error, 2);
      after += std::pow(error - film.value(SlotValue::bias, i), 2);
    }
    // Errors of higher order are left, those at the floor's edge, and the noise of the photons.
    EXPECT_LT(after, 0.5 * before) << engine << " " << before;
  }
}

TEST(Layers, RadiusShrinksFromPassToPass) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = by_photons(24, 1, 1, 4000);
  settings.aovs = {"radius"};
  settings.progressive = true;
  const auto mean = [&](std::uint32_t samples) {
    settings.samples = samples;
    const Film film = stage.render(settings);
    double sum = 0;
    for (std::size_t i = 0; i < film.pixel_count(); ++i) sum += film.value(SlotValue::radius, i);
    return sum;
  };
  EXPECT_LT(mean(8), 0.95 * mean(1));
}

TEST(Metadata, MatricesFarAwayAreRelativeToTheOrigin) {
  constexpr float kEast = 3e5f;
  SceneDescription d;
  d.materials.resize(1);
  add_quad(d, {kEast, 0, 0}, {1, 0, 0}, {0, 1, 0});
  d.cameras.push_back(look_at({kEast, 0, 4}, {kEast, 0, 0}, {0, 1, 0}, 45));
  const Stage stage(std::move(d));
  ASSERT_NE(stage.scene->origin().x, 0);
  Job job(stage.scene, stage.tracer, by_photons(8, 1, 1, 1000));
  job.wait();
  const Image image = make_image(job.snapshot(), job);
  const Vec3 eye = stage.scene->cameras()[0].to_world.translation;
  EXPECT_EQ(image.metadata.at("glowworm:origin"), fmt::format("{} 0 0", stage.scene->origin().x));
  const auto& c = image.matrices.at("worldToCamera");
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(eye.x * c[k] + eye.y * c[4 + k] + eye.z * c[8 + k] + c[12 + k], 0, 1e-4);
}

TEST(Metadata, MatricesTakeAPointToItsPixel) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = with_layers();
  settings.width = 32;
  settings.bounds = {3, 2, 30, 20};
  Job job(stage.scene, stage.tracer, settings);
  job.wait();
  const Film film = job.snapshot();
  const Image image = make_image(film, job);
  const auto& m = image.matrices.at("worldToNDC");
  std::size_t tested = 0;
  for (std::size_t i = 0; i < film.pixel_count(); ++i) {
    // On one flat object the mean of the places lies in the pixel.
    if (film.objects()[i][0].count < settings.samples) continue;
    const RGB p = film.mean(Film::Layer::position, i);
    const auto at = [&](std::size_t c) { return p.r * m[c] + p.g * m[4 + c] + p.b * m[8 + c] + m[12 + c]; };
    const float x = at(0) / at(3) * 32, y = at(1) / at(3) * 24;
    EXPECT_NEAR(x, 3.5f + static_cast<float>(i % 27), 1);
    EXPECT_NEAR(y, 2.5f + static_cast<float>(i / 27), 1);
    ++tested;
  }
  EXPECT_GT(tested, 100u);
  const Vec3 eye = stage.scene->cameras()[0].to_world.translation;
  const auto& c = image.matrices.at("worldToCamera");
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(eye.x * c[k] + eye.y * c[4 + k] + eye.z * c[8 + k] + c[12 + k], 0, 1e-4);
}

}  // namespace
}  // namespace glowworm
