// The public interface: scenes of arrays, renders, photons, density estimation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "glowworm/glowworm.h"
#include "support/temporary_folder.h"

namespace gw = glowworm::api;

namespace {

using glowworm::TemporaryFolder;
using testing::HasSubstr;

/// A white square of side 2 at z = 0, facing +z.
gw::Mesh square(std::uint32_t material) {
  static const std::vector<gw::Vec3> positions{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  static const std::vector<gw::Triangle> triangles{{0, 1, 2}, {0, 2, 3}};
  gw::Mesh mesh;
  mesh.positions = positions;
  mesh.triangles = triangles;
  mesh.material = material;
  return mesh;
}

gw::Scene lit_square() {
  gw::SceneBuilder builder("square");
  gw::Material paint;
  paint.color = {0.5f, 0.25f, 1.0f};
  builder.add_mesh(square(builder.add_material(paint)));
  builder.set_environment({1, 1, 1});
  gw::Camera camera;
  camera.eye = {0, 0, 2};
  camera.field_of_view = 20;
  builder.add_camera(camera);
  return builder.build();
}

std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const gw::Error& error) {
    return error.what();
  }
  return "no error";
}

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

TEST(Api, AnInterruptStopsPhotons) {
  gw::Interrupt interrupt;
  interrupt.request();
  gw::PhotonOptions options;
  options.interrupt = &interrupt;
  EXPECT_THROW(gw::trace_photons(lit_square(), options), gw::Cancelled);
  gw::PhotonMapOptions map_options;
  map_options.interrupt = &interrupt;
  EXPECT_THROW(gw::PhotonMap(lit_square(), map_options), gw::Cancelled);
}

TEST(Api, APhotonMapShowsTheLightOfThePlane) {
  gw::SceneBuilder builder;
  gw::Material paint;
  paint.color = {0.5f, 0.25f, 1};
  builder.add_mesh(square(builder.add_material(paint)));
  builder.add_directional_light({0, 0, -1}, {2, 3, 4});
  gw::PhotonMapOptions options;
  options.photons = 100'000;
  options.nearest = 500;
  const gw::PhotonMap map(builder.build(), options);
  EXPECT_GE(map.size(), options.photons);
  const std::vector<gw::Vec3> at{{0, 0, 0}, {0.3f, -0.2f, 0}}, normal{{0, 0, 1}, {0, 0, 1}},
      back{{0, 0, -1}, {0, 0, -1}};
  const std::vector<gw::Rgb> irradiance = map.irradiance(at, normal), radiance = map.radiance(at, normal);
  for (std::size_t i = 0; i < at.size(); ++i) {
    EXPECT_NEAR(irradiance[i].g, 3, 0.3);
    EXPECT_NEAR(radiance[i].r, irradiance[i].r * 0.5f / 3.14159265f, 1e-5f);
    EXPECT_NEAR(radiance[i].b, irradiance[i].b / 3.14159265f, 1e-5f);
    EXPECT_EQ(map.irradiance(at, back)[i].g, 0);
  }
  const std::vector<gw::Vec3> away{{0, 0, 0.5f}}, up{{0, 0, 1}}, slanted{{0, 1, 1}};
  EXPECT_EQ(map.irradiance(away, up)[0].g, 0);
  EXPECT_THAT(error_of([&] { map.radiance(away, up); }), HasSubstr("point 0 is not on a surface"));
  EXPECT_THAT(error_of([&] { map.irradiance(away, slanted); }), HasSubstr("normal 0 has length 1.41"));
  EXPECT_THAT(error_of([&] { map.irradiance(at, up); }), HasSubstr("1 normals for 2 points"));
}

/// A grid of 2 * 20 * 20 triangles at z = 0, one metre wide around the origin.
struct Grid {
  std::vector<gw::Vec3> positions;
  std::vector<gw::Triangle> triangles;

  Grid() {
    for (int i = 0; i < 21 * 21; ++i)
      positions.push_back({static_cast<float>(i % 21) / 20 - 0.5f, static_cast<float>(i / 21) / 20 - 0.5f, 0});
    for (std::uint32_t i = 0; i < 20 * 21; ++i)
      if (i % 21 < 20) {
        triangles.push_back({i, i + 1, i + 22});
        triangles.push_back({i, i + 22, i + 21});
      }
  }
  gw::Mesh mesh(std::uint32_t material) const {
    gw::Mesh out;
    out.positions = positions;
    out.triangles = triangles;
    out.material = material;
    out.name = "tile";
    return out;
  }
};

TEST(Api, InstancesAreMeshesAtManyPlaces) {
  const Grid grid;
  std::vector<gw::Placement> places;
  for (int i = 0; i < 6; ++i)
    places.push_back({{{i % 2 ? -1.0f : 1.0f, 0, 0, 2.0f * static_cast<float>(i)}, {0, 1, 0.2f, 0}, {0, 0, 1, 0}}});
  gw::SceneBuilder builder;
  gw::Mesh tile = grid.mesh(builder.add_material({}));
  builder.add_instances(tile, places);
  tile.radiance = {1, 1, 1};
  for (gw::Placement& place : places) place[2][3] = 3;
  builder.add_instances(tile, places);
  const gw::Scene scene = builder.build();
  EXPECT_EQ(scene.triangle_count(), 12 * 800u);
  ASSERT_EQ(scene.triangles().size(), scene.triangle_count());
  ASSERT_EQ(scene.triangle_materials().size(), scene.triangle_count());
  std::vector<gw::Vec3> origin, up;
  for (int i = 0; i < 6; ++i) {
    origin.push_back({2.0f * static_cast<float>(i) + 0.13f, 0.21f, 1});
    up.push_back({0, 0, -1});
  }
  const gw::Tracer tracer(scene);
  const gw::Hits hits = tracer.intersect({origin, up, 0, {}});
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(hits.distance[i], 1, 1e-5f);
    // The arrays have the triangle that the ray meets.
    float nearest = 9;
    for (const std::uint32_t corner : scene.triangles()[hits.triangle[i]])
      nearest = std::min(
          nearest, std::hypot(scene.positions()[corner].x - origin[i].x, scene.positions()[corner].y - origin[i].y));
    EXPECT_LT(nearest, 0.08f);
  }
  // Lamps shine from each place, and a bake has texels for each.
  const TemporaryFolder folder;
  gw::BakeOptions options;
  options.render.samples = 1;
  options.render.photons = 2000;
  options.atlas = 256;
  gw::bake(scene, folder.path("tiles.glb"), options);
  EXPECT_GT(std::filesystem::file_size(folder.path("tiles.glb")), 6 * 800u * 3 * 4);
  places[3][1][1] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(error_of([&] { builder.add_instances(grid.mesh(builder.add_material({})), places); }),
              HasSubstr("the place of tile 4 is not finite"));
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

TEST(Api, MediaAreCheckedWhereTheyAreAdded) {
  gw::SceneBuilder builder;
  const float density[] = {1, 2, 3};
  gw::Medium smoke;
  smoke.scattering = {1, 2, 3};
  smoke.name = "smoke";
  smoke.cells = {1, 1, 2};
  EXPECT_THAT(error_of([&] { builder.add_medium(smoke); }), HasSubstr("medium 'smoke' has a grid without a box"));
  smoke.box = {gw::Vec3{0, 0, 0}, gw::Vec3{1, 1, 1}};
  smoke.density_grid = density;
  EXPECT_THAT(error_of([&] { builder.add_medium(smoke); }), HasSubstr("2 cells has 3 values of density"));
  smoke.cells = {1, 1, 3};
  gw::Material surface;
  surface.kind = gw::Material::Kind::interface;
  surface.inside = builder.add_medium(smoke);
  surface.outside = gw::kVacuum;
  builder.add_mesh(square(builder.add_material(surface)));
  EXPECT_EQ(builder.build().triangle_count(), 2u);
  EXPECT_THAT(error_of([&] { builder.add_material(surface); }), HasSubstr("medium 0 of 0"));
}

TEST(Api, OptionsOfLoadingChangeAScene) {
  const std::string path = testing::TempDir() + "square.obj";
  std::ofstream(path) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  gw::LoadOptions options;
  options.z_up = true;
  options.scale = 0.5f;
  options.studio_light = false;
  const gw::Scene scene = gw::Scene::load(path, options);
  EXPECT_EQ(scene.positions()[1].x, 0.5f);
  EXPECT_EQ(scene.positions()[2].z, -0.5f);
  EXPECT_TRUE(scene.lights().empty());
  EXPECT_EQ(gw::Scene::load(path).lights().size(), 1u) << "the studio light";
  gw::RenderOptions dark;
  dark.width = dark.height = 8;
  dark.samples = 1;
  const gw::Picture picture = gw::render(scene, dark);
  for (const float value : picture.layer().samples) EXPECT_EQ(value, 0);
  options.environment = "1,2,3";
  options.more = {{"studio-light", "on"}, {"fov", "30"}};
  EXPECT_EQ(gw::Scene::load(path, options).lights(), std::vector<std::string>{"environment"});
  options.more = {{"studio-ligth", "on"}};
  EXPECT_THAT(error_of([&] { gw::Scene::load(path, options); }), HasSubstr("Did you mean 'studio-light'"));
  options = {};
  options.scale = 0;
  EXPECT_THAT(error_of([&] { gw::Scene::load(path, options); }), HasSubstr("scale"));
}

TEST(Api, LightsAreEdited) {
  const gw::Scene scene = gw::Scene::load("builtin:cornell");
  ASSERT_EQ(scene.lights().size(), 1u);
  gw::LightEdit edit;
  edit.light = scene.lights()[0];
  gw::RenderOptions options;
  options.width = options.height = 8;
  options.samples = 4;
  options.photons = 1000;
  const auto sum = [&] {
    const gw::Picture picture = gw::render(scene.with_lights({&edit, 1}), options);
    double all = 0;
    for (const float value : picture.layer().samples) all += static_cast<double>(value);
    return all;
  };
  const double before = sum();
  EXPECT_GT(before, 0);
  edit.scale = 2;
  EXPECT_NEAR(sum(), 2 * before, 1e-3 * before);
  edit.on = false;
  EXPECT_EQ(sum(), 0);
  edit.scale = -1;
  EXPECT_THAT(error_of([&] { scene.with_lights({&edit, 1}); }), HasSubstr("scale"));
  edit = {"lamp"};
  EXPECT_THAT(error_of([&] { lit_square().with_lights({&edit, 1}); }), HasSubstr("environment"));
}

TEST(Api, MovedLightsAreHitWhereTheyAre) {
  gw::SceneBuilder builder;
  gw::Mesh lamp = square(builder.add_material({}));
  lamp.radiance = {1, 1, 1};
  lamp.name = "lamp";
  builder.add_mesh(lamp);
  gw::LightEdit edit;
  edit.light = "lamp";
  edit.move = {0, 0, 1};
  const std::vector<gw::Vec3> from{{0.5f, 0.25f, 3}}, down{{0, 0, -1}};
  const gw::Tracer tracer(builder.build().with_lights({&edit, 1}));
  EXPECT_FLOAT_EQ(tracer.intersect({from, down, 0, {}}).distance[0], 2);
}

TEST(Api, ASceneWithOneMoreCameraSharesItsTriangles) {
  const gw::Scene scene = lit_square();
  gw::Camera above;
  above.eye = {0, 0, 8};
  above.orthographic_size = 1;
  above.name = "above";
  const gw::Scene more = scene.with_camera(above);
  EXPECT_EQ(more.cameras().size(), 2u);
  EXPECT_EQ(more.positions().data(), scene.positions().data());
  gw::RenderOptions options;
  options.width = options.height = 4;
  options.samples = 4;
  options.photons = 1000;
  options.camera = "above";
  options.aovs = {"depth"};
  EXPECT_FLOAT_EQ(gw::render(more, options).layer("depth").samples[0], 8);
  EXPECT_THAT(error_of([&] { more.with_camera(above); }), HasSubstr("above"));
  EXPECT_THAT(error_of([&] { gw::render(scene, options); }), HasSubstr("above"));
}

gw::Vec3 operator+(gw::Vec3 a, gw::Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }

std::vector<gw::Vec3> moved(std::span<const gw::Vec3> places, gw::Vec3 by) {
  std::vector<gw::Vec3> out;
  for (const gw::Vec3& p : places) out.push_back(p + by);
  return out;
}

std::vector<float> numbers(std::span<const gw::Vec3> places) {
  std::vector<float> out;
  for (const gw::Vec3& p : places) out.insert(out.end(), {p.x, p.y, p.z});
  return out;
}

std::vector<float> numbers(std::span<const gw::Rgb> colors) {
  std::vector<float> out;
  for (const gw::Rgb& c : colors) out.insert(out.end(), {c.r, c.g, c.b});
  return out;
}

/// A square around a place, lit by a lamp above it, with a camera "main" and a further one.
gw::Scene square_at(gw::Vec3 place) {
  gw::SceneBuilder builder;
  gw::Mesh mesh = square(builder.add_material({}));
  const std::vector<gw::Vec3> positions = moved(mesh.positions, place);
  mesh.positions = positions;
  builder.add_mesh(mesh);
  builder.add_point_light(place + gw::Vec3{0.5f, 0.25f, 1}, {3, 4, 5});
  gw::Camera camera;
  camera.eye = place + gw::Vec3{0, 0, 2};
  camera.target = place;
  camera.name = "main";
  builder.add_camera(camera);
  const gw::Scene scene = builder.build();
  camera.eye = place + gw::Vec3{1, 0.5f, 1};
  camera.name = "aside";
  return scene.with_camera(camera);
}

/// Far from the origin the same bits, and places of the caller's coordinates. The distance is such that all places
/// are exact there.
TEST(Api, PlacesAreTheCallersFarFromTheOrigin) {
  const gw::Vec3 far{262'144.5f, -131'072.25f, 524'288};
  const gw::Scene here = square_at({0, 0, 0}), there = square_at(far);
  EXPECT_EQ(numbers(there.positions()), numbers(moved(here.positions(), far)));
  gw::RenderOptions options;
  options.width = options.height = 8;
  options.samples = 2;
  options.photons = 1000;
  options.aovs = {"position"};
  for (const char* camera : {"main", "aside"}) {
    options.camera = camera;
    const gw::Picture picture = gw::render(here, options), picture_there = gw::render(there, options);
    EXPECT_EQ(picture_there.layer().samples, picture.layer().samples);
    const std::vector<float>& places = picture.layer("position").samples;
    const std::vector<float>& places_there = picture_there.layer("position").samples;
    ASSERT_NE(places[3 * 27], 0);
    EXPECT_EQ(places_there[3 * 27], places[3 * 27] + far.x);
    EXPECT_EQ(places_there[3 * 27 + 2], places[3 * 27 + 2] + far.z);
  }
  const std::vector<gw::Vec3> at{{0.25f, 0.5f, 0}, {-0.5f, 0.125f, 0}}, up{{0, 0, 1}, {0, 0, 1}};
  const std::vector<gw::Vec3> at_there = moved(at, far), above = moved(at, {0, 0, 1}), above_there = moved(above, far);
  const std::vector<gw::Vec3> down{{0, 0.25f, -1}, {0.125f, 0, -1}};
  const gw::Tracer tracer(here), tracer_there(there);
  const gw::Hits hits = tracer.intersect({above, down, 0, {}});
  EXPECT_EQ(tracer_there.intersect({above_there, down, 0, {}}).distance, hits.distance);
  EXPECT_EQ(hits.triangle[0], 1u);
  EXPECT_EQ(tracer_there.occluded({above_there, down, 0, {}}), (std::vector<std::uint8_t>{1, 1}));
  gw::MeasureOptions measure;
  measure.render.samples = 2;
  measure.render.photons = 1000;
  EXPECT_EQ(numbers(gw::measure(there, above_there, up, measure).irradiance),
            numbers(gw::measure(here, above, up, measure).irradiance));
  EXPECT_EQ(numbers(gw::measure(there, at_there, up, measure).irradiance),
            numbers(gw::measure(here, at, up, measure).irradiance));
  gw::PhotonOptions photons;
  photons.photons = 1000;
  const gw::Photons map = gw::trace_photons(here, photons), map_there = gw::trace_photons(there, photons);
  EXPECT_EQ(numbers(map_there.positions()), numbers(moved(map.positions(), far)));
  EXPECT_EQ(numbers(map_there.flux()), numbers(map.flux()));
  gw::PhotonMapOptions dense;
  dense.photons = 1000;
  const gw::PhotonMap light(here, dense), light_there(there, dense);
  EXPECT_EQ(numbers(light_there.irradiance(at_there, up)), numbers(light.irradiance(at, up)));
  EXPECT_EQ(numbers(light_there.radiance(at_there, up)), numbers(light.radiance(at, up)));
  EXPECT_GT(light.radiance(at, up)[0].g, 0);
}

TEST(Api, SpotLightsAndImagesOfTheSkyLightTheSquare) {
  gw::RenderOptions options;
  options.width = options.height = 8;
  options.samples = 16;
  options.gather = 16;
  options.photons = 10'000;
  options.integrator = gw::Integrator::path;
  gw::Camera camera;
  camera.eye = {0, 0, 2};
  camera.field_of_view = 5;
  const auto center = [&](gw::SceneBuilder& builder) {
    gw::Material paint;
    paint.color = {1, 1, 1};
    builder.add_mesh(square(builder.add_material(paint)));
    builder.add_camera(camera);
    return gw::render(builder.build(), options).layer().samples[3 * 27];
  };
  gw::SceneBuilder spot, sky;
  gw::SpotLight light;
  light.position = {0, 0, 2};
  light.intensity = {8, 8, 8};
  spot.add_spot_light(light);
  EXPECT_NEAR(center(spot), 8 / 4.0 / 3.14159265, 0.01) << "intensity over squared distance, times 1 / pi";
  std::vector<gw::Rgb> pixels(4 * 2, gw::Rgb{2, 2, 2});
  sky.set_environment(4, 2, pixels);
  options.samples = 1024;
  EXPECT_NEAR(center(sky), 2, 0.02);
  pixels.pop_back();
  EXPECT_THAT(error_of([&] { sky.set_environment(4, 2, pixels); }), HasSubstr("7 pixels, not 4 x 2"));
  light.outer_angle = 120;
  EXPECT_THAT(error_of([&] { spot.add_spot_light(light); }), HasSubstr("angles"));
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

TEST(Api, RefusesDensitiesThatMakeNoSense) {
  const std::vector<gw::Vec3> at{{0, 0, 0}}, up{{0, 0, 1}}, tilted{{0, 0, 2}}, none{{0, 0, 0}};
  const std::vector<gw::Vec3> nan{{std::nanf(""), 0, 1}};
  const std::vector<gw::Rgb> flux{{1, 1, 1}}, infinite{{1, INFINITY, 1}};
  EXPECT_THAT(error_of([&] { gw::DensityIndex({at, infinite, {}}, 1.0f); }), HasSubstr("flux of photon 0"));
  EXPECT_THAT(error_of([&] { gw::DensityIndex({at, flux, tilted}, 1.0f); }), HasSubstr("length 2"));
  EXPECT_THAT(error_of([&] { gw::DensityIndex({at, flux, nan}, 1.0f); }), HasSubstr("normal of photon 0"));
  const auto no_kernel = static_cast<gw::Kernel>(77);
  EXPECT_THAT(error_of([&] { gw::DensityIndex({at, flux, {}}, 1.0f, no_kernel); }), HasSubstr("kernel number 77"));
  gw::PhotonMapOptions options;
  options.kernel = no_kernel;
  EXPECT_THAT(error_of([&] { gw::PhotonMap(lit_square(), options); }), HasSubstr("kernel number 77"));
  const gw::DensityIndex index({at, flux, up}, 1.0f);
  EXPECT_THAT(error_of([&] { index.sum(at, none); }), HasSubstr("normal of point 0"));
  EXPECT_THAT(error_of([&] { index.sum(at, nan); }), HasSubstr("normal of point 0"));
  for (const int threads : {-1, 1'000'000'000})
    EXPECT_THAT(error_of([&] { gw::set_threads(threads); }), HasSubstr(std::to_string(threads)));
}

TEST(Api, PhotonsCountWhereNormalsAreLessThan45DegreesApart) {
  const std::vector<gw::Vec3> at{{0, 0, 0}}, up{{0, 0, 1}};
  const std::vector<gw::Rgb> flux{{1, 1, 1}};
  const gw::DensityIndex index({at, flux, up}, 1.0f);
  for (const double degrees : {44.8, 45.2}) {
    const double angle = degrees * std::acos(-1.0) / 180;
    const std::vector<gw::Vec3> normal{{static_cast<float>(std::sin(angle)), 0, static_cast<float>(std::cos(angle))}};
    EXPECT_EQ(index.sum(at, normal)[0].g > 0, degrees < 45) << degrees;
  }
}

TEST(Api, PhotonsCarryThePowerThatArrives) {
  gw::SceneBuilder builder;
  builder.add_mesh(square(builder.add_material({})));
  builder.add_directional_light({0, 0, -1}, {2, 3, 4});
  const gw::Scene scene = builder.build();
  gw::PhotonOptions options;
  options.photons = 20'000;
  const gw::Photons photons = gw::trace_photons(scene, options);
  ASSERT_GE(photons.size(), options.photons);
  double sum = 0;
  for (const gw::Rgb& flux : photons.flux()) sum += flux.g;
  EXPECT_NEAR(sum, 3.0 * 4.0, 0.25) << "irradiance times area";
  EXPECT_FLOAT_EQ(photons.directions()[0].z, 1);
  EXPECT_FLOAT_EQ(photons.normals()[0].z, 1);
  const gw::DensityIndex index(photons.arrays(), gw::photon_radii(photons.positions()));
  const std::vector<gw::Vec3> at{{0, 0, 0}}, normal{{0, 0, 1}};
  EXPECT_NEAR(index.sum(at, normal)[0].g, 3, 0.6);
}

TEST(Api, NoPhotonsSumToZeroWithAndWithoutNormals) {
  const std::vector<gw::Vec3> at{{0, 0, 0}, {1, 0, 0}}, normal{{0, 0, 1}, {0, 0, 1}};
  const gw::DensityIndex index({}, 0.1f);
  for (const std::vector<gw::Rgb>& sums : {index.sum(at), index.sum(at, normal)}) {
    ASSERT_EQ(sums.size(), 2u);
    EXPECT_EQ(sums[1].g, 0);
  }
  EXPECT_THAT(error_of([&] { index.sum(at, {normal.data(), 1}); }), HasSubstr("normals"));
}

TEST(Api, AsManyCausticPhotonsAreStoredAsAskedFor) {
  gw::PhotonOptions options;
  options.photons = 2000;
  options.caustic = true;
  const gw::Photons caustic = gw::trace_photons(gw::Scene::load("builtin:glass-sphere"), options);
  EXPECT_GE(caustic.size(), options.photons);
  EXPECT_GT(caustic.emitted(), caustic.size());
  const gw::Photons none = gw::trace_photons(lit_square(), options);
  EXPECT_EQ(none.size(), 0u);
  EXPECT_GE(none.emitted(), options.photons);
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

double kernel(gw::Kernel shape, double d) {
  constexpr double pi = 3.14159265358979;
  switch (shape) {
    case gw::Kernel::box:
      return 1 / pi;
    case gw::Kernel::cone:
      return 3 / pi * (1 - d);
    case gw::Kernel::epanechnikov:
      return 2 / pi * (1 - d * d);
    case gw::Kernel::gaussian:
      break;
  }
  const double s = 1.0 / 3;
  return std::exp(-d * d / (2 * s * s)) / (2 * pi * s * s * (1 - std::exp(-1 / (2 * s * s))));
}

TEST(Api, EnginesAgreeAndWriteIntoMemoryOfTheCaller) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<gw::Vec3> photons(2000), points(100);
  for (auto* cloud : {&photons, &points})
    for (gw::Vec3& p : *cloud) p = {uniform(random), uniform(random), 0};
  const std::vector<gw::Rgb> flux(photons.size(), gw::Rgb{1, 2, 3});
  const auto index = [&](gw::Engine engine) {
    return gw::DensityIndex({photons, flux, {}}, 0.1f, gw::Kernel::cone, engine);
  };
  const std::vector<gw::Rgb> wanted = index(gw::Engine::brute).sum(points);
  EXPECT_EQ(gw::engine_names()[static_cast<std::size_t>(gw::Engine::brute)], "brute");
  for (const gw::Engine engine :
       {gw::Engine::automatic, gw::Engine::blocked, gw::Engine::forward, gw::Engine::reverse}) {
    std::vector<gw::Rgb> sums(points.size(), gw::Rgb{7, 7, 7});
    const gw::DensityIndex made = index(engine);
    made.sum(points, {}, sums);
    for (std::size_t i = 0; i < sums.size(); ++i) EXPECT_NEAR(sums[i].g, wanted[i].g, 1e-4f * wanted[i].g);
    EXPECT_THAT(error_of([&] { made.sum(points, {}, {sums.data(), 9}); }), HasSubstr("9 sums for 100"));
  }
  EXPECT_THAT(error_of([&] { index(gw::Engine::knn); }), HasSubstr("knn"));
  EXPECT_THAT(error_of([&] { index(static_cast<gw::Engine>(99)); }), HasSubstr("engine number 99"));
}

TEST(Api, DensitySumsAgreeWithADoubleLoop) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0, 1);
  const auto cloud = [&](std::size_t n) {
    std::vector<gw::Vec3> points(n);
    for (gw::Vec3& p : points) p = {uniform(random), uniform(random), 0.05f * uniform(random)};
    return points;
  };
  const std::vector<gw::Vec3> photons = cloud(3000), points = cloud(200);
  std::vector<gw::Rgb> flux(photons.size());
  for (gw::Rgb& f : flux) f = {uniform(random), 1, 0};
  std::vector<float> radii(photons.size());
  for (float& r : radii) r = 0.02f + 0.05f * uniform(random);
  for (std::size_t name = 0; name < gw::kernel_names().size(); ++name) {
    const auto shape = static_cast<gw::Kernel>(name);
    const std::vector<gw::Rgb> sums = gw::DensityIndex({photons, flux, {}}, radii, shape).sum(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      double wanted = 0;
      for (std::size_t j = 0; j < photons.size(); ++j) {
        const double x = points[i].x - photons[j].x, y = points[i].y - photons[j].y, z = points[i].z - photons[j].z;
        const double d = std::sqrt(x * x + y * y + z * z) / radii[j];
        if (d < 1) wanted += kernel(shape, d) / (static_cast<double>(radii[j]) * radii[j]) * flux[j].r;
      }
      EXPECT_NEAR(sums[i].r, wanted, 1e-4 * wanted + 1e-3) << gw::kernel_names()[name] << ' ' << i;
    }
  }
}

}  // namespace
