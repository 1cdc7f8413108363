// Crops of a picture: the same bits as in the whole picture, at the cost of the crop.
#include <gtest/gtest.h>

#include "builtin/builtin.h"
#include "core/error.h"
#include "render/render_testing.h"

namespace glowworm {
namespace {

constexpr int kWidth = 37, kHeight = 45;

RenderSettings whole_picture(Integrator integrator) {
  RenderSettings s = by_photons(kWidth, 2, 4, 3000, "blocked");
  s.height = kHeight;
  s.integrator = integrator;
  return s;
}

TEST(Crop, HasTheBitsOfTheWholePicture) {
  const Stage stage(builtin_scene("glass-sphere"));
  for (const Integrator integrator : {Integrator::gather, Integrator::path, Integrator::photons}) {
    const Film whole = stage.render(whole_picture(integrator));
    // Across blocks of the camera pass, and of a single pixel at the edge, where a block is cut off.
    for (const PixelBounds part : {PixelBounds{5, 3, 22, 34}, {36, 44, 37, 45}}) {
      RenderSettings settings = whole_picture(integrator);
      settings.bounds = part;
      const Film film = stage.render(settings);
      ASSERT_EQ(film.bounds(), part);
      for (int y = part.y0; y < part.y1; ++y)
        for (int x = part.x0; x < part.x1; ++x) {
          const auto here = static_cast<std::size_t>((y - part.y0) * part.width() + x - part.x0);
          const auto there = static_cast<std::size_t>(y * kWidth + x);
          ASSERT_EQ(film.radiance(here, false), whole.radiance(there, false)) << x << ',' << y;
          ASSERT_EQ(film.mean(Film::Layer::normal, here), whole.mean(Film::Layer::normal, there)) << x << ',' << y;
          ASSERT_EQ(film.depth(here), whole.depth(there)) << x << ',' << y;
        }
    }
  }
}

TEST(Crop, CostsTheRaysOfThePart) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = whole_picture(Integrator::gather);
  settings.secondary_gather = settings.gather_guiding = false;
  settings.bounds = {10, 20, 14, 25};
  Job job(stage.scene, stage.tracer, settings);
  job.wait();
  const std::uint64_t slots = settings.bounds.pixel_count() * settings.samples;
  EXPECT_LE(job.statistics().count(Counter::gather_points), slots);
  EXPECT_GT(job.statistics().count(Counter::gather_rays), 0u);
  EXPECT_LE(job.statistics().count(Counter::gather_rays), slots * settings.gather);
}

TEST(Crop, OfFractionsSharesNoPixelWithItsNeighbour) {
  for (const int side : {1, 7, 30, 640, 1021})
    for (const double cut : {0.0, 0.1, 0.25, 1.0 / 3, 0.5, 0.9, 1.0}) {
      const PixelBounds left = CropWindow{0, 0, cut, 1}.pixels(side, side);
      const PixelBounds right = CropWindow{cut, 0, 1, 1}.pixels(side, side);
      EXPECT_EQ(left.x0, 0);
      EXPECT_EQ(left.x1, right.x0);
      EXPECT_EQ(right.x1, side);
      EXPECT_EQ(left.y1, side);
    }
  // A tenth of thirty is three, though the number is no float.
  EXPECT_EQ((CropWindow{0.1f, 0, 0.5, 1}.pixels(30, 10)), (PixelBounds{3, 0, 15, 10}));
}

TEST(Crop, OfTheFileIsTheDefault) {
  SceneDescription scene = builtin_scene("cornell");
  scene.film.crop[0] = 0.25f;
  scene.film.crop[1] = 0.5f;
  const Stage stage(std::move(scene));
  RenderSettings asked = by_photons(40, 1, 1, 1000);
  EXPECT_EQ(resolve(asked, *stage.scene).bounds, (PixelBounds{10, 0, 20, 40}));
  asked.crop = {0, 0, 0.5, 0.5};
  EXPECT_EQ(resolve(asked, *stage.scene).bounds, (PixelBounds{0, 0, 20, 20}));
  asked.bounds = {30, 30, 90, 90};
  EXPECT_EQ(resolve(asked, *stage.scene).bounds, (PixelBounds{30, 30, 40, 40}));
  asked.bounds = {50, 50, 90, 90};
  EXPECT_THROW(resolve(asked, *stage.scene), Error);
}

TEST(Crop, IsPartOfTheKey) {
  const Stage stage(builtin_scene("cornell"));
  RenderSettings settings = by_photons(20, 1, 1, 1000);
  settings.bounds = {2, 2, 9, 9};
  Job begun(stage.scene, stage.tracer, settings);
  begun.wait();
  const Checkpoint checkpoint = begun.checkpoint();
  settings.bounds = {2, 2, 9, 10};
  try {
    Job other(stage.scene, stage.tracer, settings, &checkpoint);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("--pixel-bounds 2,2,9,9"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace glowworm
