// The public interface: scenes of arrays and files, instances, media, lights and cameras.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "api/api_testing.h"
#include "support/temporary_folder.h"

namespace {

using glowworm::TemporaryFolder;
using testing::HasSubstr;

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
  EXPECT_GE(gw::Scene::load(folder.path("tiles.glb")).triangle_count(), scene.triangle_count());
  places[3][1][1] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(error_of([&] { builder.add_instances(grid.mesh(builder.add_material({})), places); }),
              HasSubstr("the place of tile 4 is not finite"));
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

/// A glowing grey wall, and a lamp of two sides and 0.5 m square, 0.5 m before its middle. A camera looks at both from
/// above, another from the side, by a mirror if there is one.
gw::Scene lamp_before_wall(bool unseen, bool mirror) {
  gw::SceneBuilder builder;
  gw::Mesh wall = square(builder.add_material({}));
  wall.radiance = {0.75f, 0.75f, 0.75f};
  builder.add_mesh(wall);
  gw::Material black;
  black.color = {0, 0, 0};
  black.unseen = unseen;
  gw::Mesh lamp = square(builder.add_material(black));
  std::vector<gw::Vec3> positions;
  for (const gw::Vec3& p : lamp.positions) positions.push_back({0.25f * p.x, 0.25f * p.y, 0.5f});
  lamp.positions = positions;
  lamp.radiance = {5, 5, 5};
  lamp.two_sided = true;
  builder.add_mesh(lamp);
  gw::Camera camera;
  camera.eye = {0, 0, 4};
  camera.orthographic_size = 0.02f;
  camera.name = "above";
  if (mirror) {
    gw::Material metal;
    metal.kind = gw::Material::Kind::metal;
    metal.color = {1, 1, 1};
    gw::Mesh side = square(builder.add_material(metal));
    const std::vector<gw::Vec3> right{{2, -1, 0}, {2, -1, 4}, {2, 1, 4}, {2, 1, 0}};
    side.positions = right;
    builder.add_mesh(side);
    camera.eye = {0, 0, 1.5f};
    camera.target = {4, 0, 0.5f};  // the lamp's image
  }
  builder.add_camera(camera);
  return builder.build();
}

/// The mean of a small picture.
double mean_of(const gw::Scene& scene, gw::Integrator integrator) {
  gw::RenderOptions options;
  options.width = options.height = 16;
  options.samples = 16;
  options.photons = 20'000;
  options.integrator = integrator;
  double sum = 0;
  const std::vector<float> samples = gw::render(scene, options).layer().samples;
  for (const float value : samples) sum += double{value};
  return sum / static_cast<double>(samples.size());
}

/// Camera rays see the wall behind an unseen lamp, in its light; a mirror shows the lamp.
TEST(Api, LampsMayBeHiddenFromCameras) {
  // The form factor of a parallel square of half side a at distance 1 over its middle, here a = 0.5 (Siegel, Howell).
  const double a = 0.5, root = std::sqrt(1 + a * a), factor = 4 / std::acos(-1.0) * a / root * std::atan(a / root);
  for (const gw::Integrator integrator : {gw::Integrator::gather, gw::Integrator::path}) {
    EXPECT_FLOAT_EQ(static_cast<float>(mean_of(lamp_before_wall(false, false), integrator)), 5);
    EXPECT_NEAR(mean_of(lamp_before_wall(true, false), integrator), 0.75 + 0.5 * 5 * factor, 0.02);
    EXPECT_NEAR(mean_of(lamp_before_wall(true, true), integrator), 5, 1e-3);
  }
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
/// What the layer `position` of a picture is relative to.
gw::Vec3 origin_of(const gw::Picture& picture) {
  gw::Vec3 origin;
  std::istringstream(picture.metadata.at("glowworm:origin")) >> origin.x >> origin.y >> origin.z;
  return origin;
}

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
    const gw::Vec3 origin = origin_of(picture), origin_there = origin_of(picture_there);
    EXPECT_EQ(places_there[3 * 27] + origin_there.x, places[3 * 27] + origin.x + far.x);
    EXPECT_EQ(places_there[3 * 27 + 2] + origin_there.z, places[3 * 27 + 2] + origin.z + far.z);
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

}  // namespace
