// The public interface: renders, pictures, errors, rays, sensors, bakes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "api/api_testing.h"
#include "support/temporary_folder.h"

namespace {

using glowworm::TemporaryFolder;
using testing::HasSubstr;

TEST(Api, ASquareUnderAWhiteSkyShowsItsColor) {
  gw::RenderOptions options;
  options.width = options.height = 8;
  options.samples = 16;
  options.gather = 16;
  options.photons = 1000;
  options.aovs = {"albedo"};
  for (const gw::Integrator integrator : {gw::Integrator::gather, gw::Integrator::path}) {
    options.integrator = integrator;
    const gw::Picture picture = gw::render(lit_square(), options);
    ASSERT_EQ(picture.layer().samples.size(), 3 * 64u);
    EXPECT_EQ(picture.layer().channels, "RGB");
    EXPECT_NEAR(picture.layer().samples[3 * 27], 0.5f, 0.01f);
    EXPECT_NEAR(picture.layer().samples[3 * 27 + 1], 0.25f, 0.01f);
    EXPECT_NEAR(picture.layer("albedo").samples[3 * 27 + 2], 1.0f, 0.01f);
  }
}

TEST(Api, EveryAovIsALayer) {
  gw::RenderOptions options;
  options.width = options.height = 4;
  options.samples = 2;
  options.photons = 1000;
  options.aovs = gw::aov_names();
  const gw::Picture picture = gw::render(lit_square(), options);
  for (const std::string& name : options.aovs) {
    if (name.starts_with("crypto")) continue;
    EXPECT_EQ(picture.layer(name).samples.size(), 16 * picture.layer(name).channels.size()) << name;
  }
  EXPECT_EQ(picture.layer("CryptoMaterial00").channels, "RGBA");
  EXPECT_EQ(picture.layer("depth").channels, "Z");
  EXPECT_NEAR(picture.layer("depth").samples[5], 2, 0.05) << "the camera looks at the square from 2 m";
  EXPECT_THAT(error_of([&] { picture.layer("depht"); }), HasSubstr("depth"));
}

TEST(Api, OptionsOfTheCommandLineAreOptionsHere) {
  gw::RenderOptions options;
  options.samples = 1;
  options.photons = 1000;
  options.more = {{"size", "6x4"}, {"kernel", "cone"}, {"indirect-only", ""}};
  gw::Render render(lit_square(), options);
  render.wait();
  EXPECT_EQ(render.picture().width, 6);
  const gw::RenderStatistics statistics = render.statistics();
  EXPECT_THAT(statistics.json, HasSubstr("\"kernel\": \"cone\""));
  EXPECT_THAT(statistics.json, HasSubstr("\"indirect_only\": true"));
  for (const std::string& name : gw::render_option_names()) EXPECT_NE(name, "threads");
  options.more = {{"kernle", "cone"}};
  EXPECT_THAT(error_of([&] { gw::render(lit_square(), options); }), HasSubstr("Did you mean 'kernel'"));
  options.more = {{"kernel", "conee"}};
  EXPECT_THAT(error_of([&] { gw::render(lit_square(), options); }), HasSubstr("Did you mean 'cone'"));
}

TEST(Api, StatisticsAreNumbersAndJson) {
  gw::RenderOptions options;
  options.width = options.height = 8;
  options.samples = 2;
  options.photons = 1000;
  options.engine = gw::Engine::forward;
  gw::Render render(lit_square(), options);
  render.wait();
  const gw::RenderStatistics s = render.statistics();
  EXPECT_EQ(s.ending, gw::Ending::samples_done);
  EXPECT_EQ(s.passes, 2u);
  EXPECT_EQ(s.mean_samples, 2);
  EXPECT_GE(s.counts.at("photons_stored"), 1000u);
  EXPECT_GT(s.seconds.at("total"), 0);
  EXPECT_GT(s.memory.at("peak_reserved"), 0u);
  ASSERT_EQ(s.lights.size(), 1u);
  EXPECT_GE(s.lights[0].stored, 1000u);
  EXPECT_THAT(s.json, HasSubstr("\"engine\": \"forward\""));
  EXPECT_THAT(s.json, HasSubstr("\"ending\": \"samples_done\""));
}

/// The code of the error that the work ends with, and its place.
std::pair<gw::ErrorCode, gw::FilePlace> caught(const std::function<void()>& work) {
  try {
    work();
  } catch (const gw::Error& error) {
    return {error.code(), error.place()};
  }
  return {gw::ErrorCode::invalid, {"no error"}};
}

TEST(Api, ErrorsHaveACodeAndAPlace) {
  const std::string path = testing::TempDir() + "broken.obj";
  std::ofstream(path) << "v 0 0 0\nv 1 0 zero\n";
  const auto [broken, place] = caught([&] { gw::Scene::load(path); });
  EXPECT_EQ(broken, gw::ErrorCode::file);
  EXPECT_EQ(place.file, path);
  EXPECT_EQ(place.line, 2);
  const std::string pbrt = testing::TempDir() + "broken.pbrt";
  std::ofstream(pbrt) << "WorldBegin\n\n  Shape \"speer\"\nShape \"box\"\n";
  const auto [unknown, shape] = caught([&] { gw::Scene::load(pbrt); });
  EXPECT_EQ(unknown, gw::ErrorCode::file);
  EXPECT_EQ(shape.file, pbrt);
  EXPECT_EQ(shape.line, 3);
  const auto [missing, nowhere] = caught([] { gw::read_picture("nowhere.exr"); });
  EXPECT_EQ(missing, gw::ErrorCode::file);
  EXPECT_EQ(nowhere.file, "nowhere.exr");
  gw::RenderOptions options;
  options.width = options.height = 4;
  options.samples = 1;
  options.noise_target = -1;
  const auto [senseless, none] = caught([&] { gw::render(lit_square(), options); });
  EXPECT_EQ(senseless, gw::ErrorCode::invalid);
  EXPECT_EQ(none.file, "");
  options.noise_target = 0;
  options.photons = 1'000'000;
  options.memory = 64'000'000;
  EXPECT_EQ(caught([&] { gw::render(lit_square(), options); }).first, gw::ErrorCode::memory);
}

TEST(Api, ACropIsAPartOfTheSamePicture) {
  gw::RenderOptions options;
  options.width = options.height = 8;
  options.samples = 2;
  options.gather = 4;
  options.photons = 1000;
  options.filter = false;
  const gw::Picture whole = gw::render(lit_square(), options);
  options.crop = gw::Crop{0.25, 0.5, 0.75, 1};
  const gw::Picture part = gw::render(lit_square(), options);
  ASSERT_EQ(part.width, 4);
  ASSERT_EQ(part.height, 4);
  EXPECT_EQ(part.x0, 2);
  EXPECT_EQ(part.y0, 4);
  EXPECT_EQ(part.whole_width, 8);
  EXPECT_EQ(whole.whole_width, 0);
  for (std::size_t y = 0; y < 4; ++y)
    for (std::size_t i = 0; i < 12; ++i)
      EXPECT_EQ(part.layer().samples[12 * y + i], whole.layer().samples[24 * (y + 4) + 6 + i]);
  options.crop = gw::Crop{0.5, 0, 0.5, 1};
  EXPECT_THAT(error_of([&] { gw::render(lit_square(), options); }), HasSubstr("crop"));
}

TEST(Api, PicturesKeepTheirLayersInFiles) {
  gw::Picture picture;
  picture.width = 2;
  picture.height = 1;
  picture.layers = {{gw::kImageLayer, "RGB", {1, 70000, 1.0001f, 4, 5, 6}}, {"depth", "Z", {0.1f, 7}}};
  const TemporaryFolder folder;
  const std::string path = folder.path("layers.exr");
  gw::write_picture(path, picture);
  const gw::Picture read = gw::read_picture(path);
  EXPECT_EQ(read.layer().samples, picture.layer().samples);
  EXPECT_EQ(read.layer("depth").samples, picture.layer("depth").samples);
  EXPECT_EQ(gw::compare(picture, read).mse, 0);
  picture.layers[0].samples[5] = 8;
  const gw::Comparison comparison = gw::compare(picture, read);
  EXPECT_DOUBLE_EQ(comparison.mse, 4.0 / 6);
  EXPECT_EQ(comparison.largest_difference, 2);
  EXPECT_NEAR(comparison.rgb_ratio[2], 9.0001 / 7.0001, 1e-6);
  EXPECT_EQ(gw::png_of(picture).substr(1, 3), "PNG");
  EXPECT_EQ(gw::png_of(picture, "depth").substr(1, 3), "PNG");
  picture.layers[0].samples.pop_back();
  EXPECT_THAT(error_of([&] { gw::write_picture(path, picture); }), HasSubstr("5 samples"));
}

TEST(Api, LayersOfOneChannelAreComparedAndShown) {
  gw::Picture picture;
  picture.width = 2;
  picture.height = 1;
  picture.layers = {{gw::kImageLayer, "Y", {1, 2}}, {"alpha", "A", {0.5f, 1}}, {"depth", "Z", {3, 4}}};
  gw::Picture other = picture;
  for (gw::Picture::Layer& layer : other.layers) layer.samples[1] += 0.25f;
  for (const char* layer : {gw::kImageLayer, "alpha", "depth"}) {
    EXPECT_EQ(gw::compare(picture, other, layer).largest_difference, 0.25) << layer;
    EXPECT_EQ(gw::png_of(picture, layer).substr(1, 3), "PNG") << layer;
  }
}

TEST(Api, EveryWaitThrowsTheErrorOfTheRender) {
  gw::RenderOptions options;
  options.width = options.height = 4;
  options.samples = 1;
  options.photons = 1'000'000;
  options.memory = 64'000'000;  // a third of what the photons take
  gw::Render render(lit_square(), options);
  std::vector<std::string> errors(4);
  std::vector<std::thread> threads;
  for (std::string& error : errors)
    threads.emplace_back([&render, &error] { error = error_of([&render] { render.wait(); }); });
  for (std::thread& thread : threads) thread.join();
  for (const std::string& error : errors) EXPECT_THAT(error, HasSubstr("photon map"));
  EXPECT_THAT(error_of([&] { render.wait(); }), HasSubstr("photon map"));
}

TEST(Api, ReportsProgressAndCancelsARender) {
  gw::RenderOptions options;
  options.width = options.height = 64;
  options.samples = 1'000'000;
  options.photons = 1000;
  gw::Render render(lit_square(), options);
  EXPECT_LT(render.progress(), 1);
  EXPECT_EQ(render.picture().width, 64);
  render.cancel();
  render.wait();
  EXPECT_TRUE(render.done());
  EXPECT_TRUE(render.cancelled());
  EXPECT_EQ(render.statistics().ending, gw::Ending::cancelled);
}

TEST(Api, ProgressThatThrowsEndsTheRender) {
  gw::RenderOptions options;
  options.width = options.height = 64;
  options.samples = 1'000'000;
  options.photons = 1000;
  int calls = 0;
  const auto progress = [&](double share) {
    EXPECT_LT(share, 1);
    if (++calls == 2) throw std::domain_error("enough");
  };
  EXPECT_THROW(gw::render(lit_square(), options, progress), std::domain_error);
  EXPECT_EQ(calls, 2);
}

TEST(Api, RaysHitTheSquare) {
  const gw::Tracer tracer(lit_square());
  const std::vector<gw::Vec3> origin{{0.5f, 0.5f, 3}, {0.5f, 0.5f, 3}, {5, 0, 3}};
  const std::vector<gw::Vec3> direction{{0, 0, -2}, {0, 0, 1}, {0, 0, -1}};
  gw::Rays rays{origin, direction, 0, {}};
  const gw::Hits hits = tracer.intersect(rays);
  EXPECT_FLOAT_EQ(hits.distance[0], 1.5f);
  EXPECT_FLOAT_EQ(hits.normal[0].z, 1);
  EXPECT_EQ(hits.triangle[1], gw::kNoTriangle);
  EXPECT_EQ(hits.triangle[2], gw::kNoTriangle);
  EXPECT_TRUE(std::isinf(hits.distance[2]));
  const gw::Triangle triangle = tracer.scene().triangles()[hits.triangle[0]];
  const auto x = [&](int corner) { return tracer.scene().positions()[triangle[static_cast<std::size_t>(corner)]].x; };
  const gw::Vec2 b = hits.barycentric[0];
  EXPECT_NEAR(x(0) * (1 - b.x - b.y) + x(1) * b.x + x(2) * b.y, 0.5f, 1e-6f);
  std::vector<float> distance(3);
  std::vector<std::uint32_t> hit(3);
  std::vector<gw::Vec2> barycentric(3);
  tracer.intersect(rays, {distance, hit, barycentric});
  EXPECT_EQ(distance, hits.distance);
  EXPECT_EQ(hit, hits.triangle);
  EXPECT_THAT(error_of([&] { tracer.intersect(rays, {distance, {}, barycentric}); }), HasSubstr("0 triangles"));
  hit[0] = 99;
  EXPECT_THAT(error_of([&] { tracer.normals(hit); }), HasSubstr("no triangle 99"));
  EXPECT_EQ(tracer.occluded(rays), (std::vector<std::uint8_t>{1, 0, 0}));
  const std::vector<float> near{1.4f};
  rays.t_max = near;
  EXPECT_EQ(tracer.occluded(rays), (std::vector<std::uint8_t>{0, 0, 0}));
  EXPECT_EQ(tracer.intersect(rays).triangle[0], gw::kNoTriangle);
  const std::vector<gw::Vec3> wrong{{0, 0, 0}, {0, NAN, 1}, {0, 0, 1}};
  EXPECT_THAT(error_of([&] { tracer.intersect({origin, wrong, 0, {}}); }), HasSubstr("ray 0"));
  EXPECT_THAT(error_of([&] { tracer.occluded({origin, {}, 0, {}}); }), HasSubstr("0 directions for 3 origins"));
}

TEST(Api, SensorsMeasureTheSun) {
  gw::SceneBuilder builder;
  builder.add_mesh(square(builder.add_material({})));
  builder.add_directional_light({0, 0, -1}, {2, 3, 4});
  const gw::Scene scene = builder.build();
  const std::vector<gw::Vec3> at{{0, 0, 1}, {0.1f, 0, 1}}, normal{{0, 0, 1}, {0, 0.6f, 0.8f}};
  gw::MeasureOptions options;
  options.render.samples = 4;
  options.render.photons = 1000;
  const gw::Measurement measured = gw::measure(scene, at, normal, options);
  EXPECT_NEAR(measured.irradiance[0].g, 3, 1e-3);
  EXPECT_NEAR(measured.direct[1].b, 4 * 0.8, 1e-3);
  EXPECT_NEAR(measured.illuminance[0], 179 * (0.2126 * 2 + 0.7152 * 3 + 0.0722 * 4), 1);
  options.render.samples = 1;
  EXPECT_THAT(error_of([&] { gw::measure(scene, at, normal, options); }), HasSubstr("two samples"));
  EXPECT_THAT(error_of([&] { gw::measure(scene, {}, {}); }), HasSubstr("no sensors"));
}

TEST(SlowApi, FindsTheDaylightOfAYear) {
  gw::SceneBuilder builder, roofed;
  gw::Mesh floor = square(builder.add_material({}));
  const std::vector<gw::Vec3> corners{{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
  floor.positions = corners;
  builder.add_mesh(floor);
  const std::vector<gw::Vec3> above{{-9, 1.1f, -9}, {-9, 1.1f, 9}, {9, 1.1f, 9}, {9, 1.1f, -9}};
  floor.positions = above;
  roofed.add_material({});
  roofed.add_mesh(floor);
  const std::string weather = testing::TempDir() + "glowworm-year.epw";
  std::ofstream epw(weather);
  epw << "LOCATION,Munich,-,DEU,made up,0,48.13,11.70,1,529\n";
  for (int line = 2; line <= 7; ++line) epw << "HEADER\n";
  epw << "DATA PERIODS,1,1,Data,Sunday,6/21,6/21\n";
  for (int hour = 1; hour <= 24; ++hour)
    epw << "1999,6,21," << hour << ",60,?9,20,10,50,95000,0,0,300,0," << (hour == 12 ? 700 : 0) << ','
        << (hour > 8 && hour < 17 ? 100 : 0) << ",0,0\n";
  epw.close();
  const std::vector<gw::Vec3> at{{0, 1, 0}, {0.1f, 1, 0}}, normal{{0, 1, 0}, {0, 0, 1}};
  gw::DaylightOptions o;
  o.render.samples = 4;
  o.hours = "11-13";
  o.shades = {roofed.build()};
  o.shade_of_hour.assign(24, 0);
  o.shade_of_hour[9] = 1;
  const gw::Scene scene = builder.build();
  const gw::Daylight year = gw::daylight(scene, weather, at, normal, o);
  ASSERT_EQ(year.hours.size(), 24u);
  ASSERT_EQ(year.illuminance.size(), 48u);
  EXPECT_EQ(year.hours[11].hour, 12);
  EXPECT_EQ(year.illuminance[3], 0) << "night";
  const float overcast = year.illuminance[12];
  EXPECT_GT(overcast, 5000) << "100 W m^-2 of some 110 lm/W";
  EXPECT_NEAR(year.illuminance[13], overcast, 0.3f * overcast);
  EXPECT_LT(year.illuminance[9], 0.2f * overcast) << "below the roof";
  EXPECT_NEAR(year.illuminance[11] - year.sun[11], overcast, 0.5f * overcast);
  EXPECT_NEAR(year.mean[0], (year.illuminance[11] + overcast) / 2, 1);
  EXPECT_EQ(year.autonomy[0], 1);
  EXPECT_EQ(year.sun_hours[0], 1);
  EXPECT_NEAR(year.daylight_factor[0], 1, 0.03f);
  EXPECT_EQ(year.spatial_autonomy, 1);
  EXPECT_LT(year.relative_error[0], 0.1f);
  gw::Camera eye;
  eye.eye = {0, 1, 0};
  eye.target = {0, 2, 0};
  eye.up = {0, 0, 1};
  eye.field_of_view = 180;
  EXPECT_THAT(error_of([&] { gw::annual_glare(scene, weather, std::vector{eye}, o); }), HasSubstr("half space"));
  eye.projection = gw::Camera::Projection::fisheye;
  gw::DaylightOptions rated = o;
  rated.render.photons = 20'000;
  rated.view_pixels = 16;
  const gw::AnnualGlare glare = gw::annual_glare(scene, weather, std::vector{eye}, rated);
  ASSERT_EQ(glare.views.size(), 1u);
  const gw::ViewGlare& view = glare.views[0];
  ASSERT_EQ(view.dgp.size(), 24u);
  EXPECT_EQ(view.illuminance[3], 0) << "night";
  EXPECT_NEAR(view.illuminance[12], overcast, 0.1f * overcast);
  EXPECT_LT(view.illuminance[9], 0.2f * overcast) << "below the roof";
  EXPECT_GT(view.illuminance_error[12], 0);
  EXPECT_LT(view.illuminance_error[12], 0.1f * overcast);
  EXPECT_NEAR(view.exceeded, std::max(view.dgp[11], view.dgp[12]), 1e-6);
  gw::DaylightOptions wrong = o;
  wrong.sun_step = 0;
  EXPECT_THAT(error_of([&] { gw::daylight(scene, weather, at, normal, wrong); }), HasSubstr("sun_step is 0"));
  wrong = o;
  wrong.render.memory = 1 << 20;
  const std::vector<gw::Vec3> many(100'000, at[0]), up(many.size(), normal[0]);
  EXPECT_THAT(error_of([&] { gw::daylight(scene, weather, many, up, wrong); }),
              HasSubstr("24 hours of 100000 sensors"));
  o.shade_of_hour.assign(3, 0);
  EXPECT_THAT(error_of([&] { gw::daylight(scene, weather, at, normal, o); }), HasSubstr("shade_of_hour has 3 hours"));
  EXPECT_THAT(error_of([&] { gw::daylight(scene, "none.epw", at, normal); }), HasSubstr("none.epw"));
}

TEST(Api, RejectsInvalidInput) {
  gw::SceneBuilder builder;
  gw::Material paint;
  paint.color.r = 1.5f;
  EXPECT_THAT(error_of([&] { builder.add_material(paint); }), HasSubstr("[0, 1]"));
  EXPECT_THAT(error_of([&] { builder.add_mesh(square(7)); }), HasSubstr("material 7"));
  EXPECT_THAT(error_of([&] { builder.add_point_light({0, 0, 1}, {-1, 0, 0}); }), HasSubstr("intensity"));
  gw::Camera camera;
  camera.target = camera.eye;
  EXPECT_THAT(error_of([&] { builder.add_camera(camera); }), HasSubstr("direction"));
  EXPECT_THAT(error_of([&] { builder.build(); }), HasSubstr("triangle"));
  EXPECT_THAT(error_of([] { gw::Scene::load("builtin:nothing"); }), HasSubstr("nothing"));
  gw::RenderOptions options;
  options.width = options.height = 4;
  options.engine = static_cast<gw::Engine>(99);
  EXPECT_THAT(error_of([&] { gw::render(lit_square(), options); }), HasSubstr("engine number 99"));
  options = {};
  options.integrator = static_cast<gw::Integrator>(99);
  EXPECT_THAT(error_of([&] { gw::render(lit_square(), options); }), HasSubstr("integrator"));
  gw::BakeOptions bake;
  bake.format = static_cast<gw::BakeFormat>(99);
  EXPECT_THAT(error_of([&] { gw::bake(lit_square(), "none.glb", bake); }), HasSubstr("format number 99"));
  options = {};
  options.width = options.height = 4;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double value : {-1.0, kNan}) {
    gw::RenderOptions timed = options, noisy = options;
    timed.time_limit = value;
    noisy.noise_target = value;
    EXPECT_THAT(error_of([&] { gw::render(lit_square(), timed); }), HasSubstr("time"));
    EXPECT_THAT(error_of([&] { gw::Render(lit_square(), noisy); }), HasSubstr("noise"));
  }
  options.samples = 1u << 25;
  EXPECT_THAT(error_of([&] { gw::render(lit_square(), options); }), HasSubstr("samples"));
  gw::Material odd;
  odd.kind = static_cast<gw::Material::Kind>(99);
  EXPECT_THAT(error_of([&] { builder.add_material(odd); }), HasSubstr("kind"));
  builder.add_material({});
  gw::Mesh bent = square(0);
  const std::vector<gw::Vec3> normals{{0, 0, 1}, {0, 0, 1}, {0, std::nanf(""), 1}, {0, 0, 1}};
  bent.normals = normals;
  EXPECT_THAT(error_of([&] { builder.add_mesh(bent); }), HasSubstr("normal 2"));
  const std::vector<gw::Vec3> positions{{0, 0, 0}};
  EXPECT_THAT(error_of([&] { gw::DensityIndex({positions, {}, {}}, 1.0f); }), HasSubstr("fluxes"));
  const std::vector<gw::Rgb> flux{{1, 1, 1}};
  EXPECT_THAT(error_of([&] { gw::DensityIndex({positions, flux, {}}, 0.0f); }), HasSubstr("radius"));
}

/// The bytes of a baked scene.
std::string baked(const gw::Scene& scene, const gw::BakeOptions& options) {
  const TemporaryFolder folder;
  const std::string path = folder.path("baked.glb");
  gw::bake(scene, path, options);
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(Api, ABakeOfIndirectLightIsAskedForInTwoWays) {
  const gw::Scene scene = gw::Scene::load("builtin:cornell");
  gw::BakeOptions options;
  options.atlas = 64;
  options.render.samples = 1;
  options.render.gather = 4;
  options.render.photons = 5000;
  const std::string all = baked(scene, options);
  options.render.more = {{"indirect-only", ""}};
  const std::string indirect = baked(scene, options);
  EXPECT_FALSE(indirect == all);
  options.render.more.clear();
  options.indirect_only = true;
  EXPECT_TRUE(indirect == baked(scene, options));
}

}  // namespace
