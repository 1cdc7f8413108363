// Changes of a scene by command-line options: environment, axis, unit and camera.
#include "import/scene_changes.h"

#include "bsdf/bsdf.h"
#include "image/image.h"
#include "import/haze.h"
#include "import/material_text.h"
#include "scene/environment.h"
#include "scene/scene_parts.h"
#include "scene/surface.h"
#include "test_files.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

void expect_close(Vec3 a, Vec3 b) { EXPECT_LT(length(a - b), 1e-4f) << a.x << " " << a.y << " " << a.z; }

/// A triangle in the plane y = 1, under a lamp, seen by a camera from +z.
SceneDescription small_scene() {
  SceneDescription d;
  d.materials.emplace_back().bump.value = 0.25f;  // m
  Geometry mesh;
  mesh.positions = {{0, 1, 0}, {0, 1, 2}, {2, 1, 0}};
  mesh.normals.assign(3, {0, 1, 0});
  mesh.uvs.resize(3);
  mesh.triangles = {{0, 1, 2}};
  append_mesh(d.geometry, mesh, "triangle", 0, kNone);
  Light lamp;
  lamp.position = {0, 3, 1};
  lamp.direction = {0, -1, 0};
  d.lights.push_back(lamp);
  d.cameras.push_back(look_at({0, 1, 5}, {0, 1, 0}, {0, 1, 0}, 40));
  d.cameras[0].lens_radius = 0.1f;
  return d;
}

class SceneChangesTest : public FileTest {
 protected:
  /// The triangle, of a material "glazing".
  static SceneDescription glazed() {
    SceneDescription d = small_scene();
    d.materials[0] = Material();
    d.materials[0].name = "glazing";
    return d;
  }
  /// An image with one bright pixel.
  std::string image_file(int width, int height, int x, int y) const {
    Image image(width, height);
    for (const char* name : {"R", "G", "B"}) {
      const auto plane = image.add_channel(name);
      plane[static_cast<std::size_t>(y * width + x)] = 8;
    }
    write_exr(path("sky.exr"), image, ExrPrecision::single);
    return path("sky.exr");
  }
  static SceneDescription changed(const SceneChanges& changes) {
    SceneDescription d = small_scene();
    change_scene(d, changes, loading_budget());
    return d;
  }
};

/// Places on the command line are those of the file, turned and scaled as the scene is.
TEST_F(SceneChangesTest, PlacesAreInTheFilesCoordinates) {
  SceneDescription d = small_scene();
  d.origin = {512345, -100, 5412345};
  SceneChanges changes;
  changes.look_at = parse_look_at("512345.125,-99,5412350.001,512345.125,-99,5412345.001");
  change_scene(d, changes, loading_budget());
  expect_close(d.cameras[0].to_world.translation, {0.125f, 1, 5.001f});
  SceneDescription turned = small_scene();
  turned.origin = {512345, 5412345, 100};
  const Vec3 before = turned.geometry.positions[2];
  SceneChanges up;
  up.z_up = true;
  up.metres_per_unit = 0.01f;
  change_scene(turned, up, loading_budget());
  // Of (x, y, z) to (x, z, -y), hundredths.
  const Vec3d place = Vec3d(turned.geometry.positions[2]) + Vec3d(turned.origin);
  const double scale = double{0.01f};
  EXPECT_NEAR(place.x, scale * (512345.0 + before.x), 1e-6);
  EXPECT_NEAR(place.y, scale * (100.0 + before.z), 1e-6);
  EXPECT_NEAR(place.z, -scale * (5412345.0 + before.y), 1e-6);
}

TEST_F(SceneChangesTest, LatLongImagesReplaceTheEnvironmentTurnedAndScaled) {
  SceneChanges changes;
  // The brightest direction is along -z, a little above the horizon.
  parse_environment(image_file(9, 4, 4, 1), changes);
  const auto sky = changed(changes).environment;
  ASSERT_TRUE(sky);
  EXPECT_EQ(sky->mapping, EnvironmentMapping::lat_long);
  const float up = std::sin(kPi / 8), ahead = std::cos(kPi / 8);
  EXPECT_NEAR(radiance(*sky, {0, up, -ahead}).g, 8, 1e-3f);
  changes.environment_turn = 90;
  changes.environment_scale = 0.5f;
  const auto turned = changed(changes).environment;
  EXPECT_NEAR(radiance(*turned, {-ahead, up, 0}).g, 4, 1e-3f);
  EXPECT_NEAR(radiance(*turned, {0, up, -ahead}).g, 0, 1e-3f);
}

/// North of a sky, and its sun with it.
TEST_F(SceneChangesTest, SkiesTurnWithTheirSuns) {
  for (const std::string sky : {"perez:700,120,6,21,9,48,0,0", "cie:12,40,120"}) {
    SceneChanges changes;
    changes.sky = sky;
    const SceneDescription plain = changed(changes);
    changes.environment_turn = 90;
    const SceneDescription turned = changed(changes);
    const auto left = [](Vec3 d) { return Vec3{d.z, d.y, -d.x}; };
    for (const Vec3 d : {normalize({1, 1, 0}), normalize({0, 0.5f, -1}), normalize({-1, 0.2f, -1})})
      EXPECT_NEAR(radiance(*turned.environment, left(d)).g / radiance(*plain.environment, d).g, 1, 1e-4) << sky;
    for (std::size_t i = 0; i < plain.lights.size(); ++i)
      if (plain.lights[i].name == "sun") expect_close(turned.lights[i].direction, left(plain.lights[i].direction));
  }
}

TEST_F(SceneChangesTest, SquareImagesAreEqualAreaMapsWithTheirMiddleUp) {
  SceneChanges changes;
  parse_environment(image_file(5, 5, 2, 2), changes);
  const auto sky = changed(changes).environment;
  ASSERT_TRUE(sky);
  EXPECT_EQ(sky->mapping, EnvironmentMapping::equal_area);
  EXPECT_NEAR(radiance(*sky, {0, 1, 0}).g, 8, 1e-3f);
  EXPECT_NEAR(radiance(*sky, {0, -1, 0}).g, 0, 1e-3f);
}

TEST_F(SceneChangesTest, ImagesTakeMemoryOfTheBudgetBeforeTheyAreDecoded) {
  const std::string file = image_file(64, 32, 2, 2);
  // A texel is three floats; its distribution has a double, an index, and a weight while it is made.
  EXPECT_THROW(read_environment(file, loading_budget(64 * 32 * 28 - 1)), MemoryError);
  EXPECT_EQ(read_environment(file, loading_budget(1'000'000)).width, 64);
}

TEST_F(SceneChangesTest, NumbersAreAUniformRadiance) {
  SceneChanges changes;
  parse_environment("1,2,3", changes);
  changes.environment_scale = 2;
  EXPECT_EQ(radiance(*changed(changes).environment, {0, 0, 1}), RGB(2, 4, 6));
  parse_environment("0.5", changes);
  EXPECT_EQ(radiance(*changed(changes).environment, {0, 0, 1}), RGB(1.0f));
  EXPECT_THROW(parse_environment("1,-2,3", changes), Error);
  parse_environment("not-there.exr", changes);
  try {
    changed(changes);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("not-there.exr"));
  }
}

TEST_F(SceneChangesTest, RotatingWithoutAnEnvironmentIsNoted) {
  SceneChanges changes;
  changes.environment_turn = 30;
  EXPECT_THAT(changed(changes).notes, testing::Contains(HasSubstr("--environment-turn")));
}

TEST_F(SceneChangesTest, ZUpAndScaleMoveEverything) {
  SceneChanges changes;
  changes.z_up = true;
  changes.metres_per_unit = 0.5f;
  const SceneDescription d = changed(changes);
  expect_close(d.geometry.positions[1], {0, 1, -0.5f});
  expect_close(d.geometry.normals[1], {0, 0, -1});
  expect_close(d.geometry.normal(0), {0, 0, -1});
  expect_close(d.lights[0].position, {0, 0.5f, -1.5f});
  expect_close(d.lights[0].direction, {0, 0, 1});
  expect_close(d.cameras[0].to_world.translation, {0, 2.5f, -0.5f});
  expect_close(d.cameras[0].to_world.z, {0, -1, 0});
  EXPECT_FLOAT_EQ(d.cameras[0].lens_radius, 0.05f);
  EXPECT_EQ(d.materials[0].bump.value, 0.125f) << "a displacement is a length";
}

TEST_F(SceneChangesTest, ZUpHoldsForPlacesOfOptions) {
  write("lamp.ies", "IESNA91\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0 1 1 1\n0 90\n0\n10 20\n");
  SceneChanges changes;
  changes.z_up = true;
  changes.look_at = parse_look_at("4,1,2;4,3,2");
  changes.luminaires = {path("lamp.ies") + "@1,2,3", path("lamp.ies") + "@1,2,3,0,1,0,90"};
  const SceneDescription d = changed(changes);
  EXPECT_TRUE(d.z_up);
  expect_close(d.cameras[0].to_world.translation, {4, 2, -1});
  expect_close(d.cameras[0].to_world.z, {0, 0, -1});
  expect_close(d.cameras[0].to_world.y, {0, 1, 0});
  ASSERT_EQ(d.lights.size(), 3u);
  for (const std::size_t i : {1, 2}) expect_close(d.lights[i].position, {1, 3, -2});
  expect_close(d.lights[1].direction, {0, -1, 0});
  expect_close(d.lights[2].direction, {0, 0, -1});
  expect_close(d.lights[2].right, {0, 1, 0});
}

TEST_F(SceneChangesTest, CamerasTakeAngleAndPlace) {
  SceneChanges changes;
  changes.field_of_view = 90;
  changes.look_at = parse_look_at("4,1,0;0,1,0");
  const SceneDescription d = changed(changes);
  ASSERT_EQ(d.cameras.size(), 1u);
  EXPECT_FLOAT_EQ(d.cameras[0].half_extent, 1);
  expect_close(d.cameras[0].to_world.translation, {4, 1, 0});
  expect_close(d.cameras[0].to_world.z, {-1, 0, 0});
  EXPECT_FLOAT_EQ(d.cameras[0].lens_radius, 0.1f);
  for (const char* wrong : {"1,2,3", "1,2,3,4,5,x", "1,2,3,1,2,3", "", "1,2,3,4,5,6,7", "1,2,3,nan,5,6"})
    EXPECT_THROW(parse_look_at(wrong), Error) << wrong;
}

TEST_F(SceneChangesTest, ProjectionsShowHalfSpacesUnlessTold) {
  SceneChanges changes;
  changes.projection = CameraKind::fisheye;
  EXPECT_FLOAT_EQ(changed(changes).cameras.at(0).half_extent, kPi / 2);
  changes.field_of_view = 360;
  EXPECT_FLOAT_EQ(changed(changes).cameras.at(0).half_extent, kPi);
  changes.projection = CameraKind::panorama;
  EXPECT_THROW(changed(changes), Error);
  changes.projection.reset();
  EXPECT_THROW(changed(changes), Error) << "perspective";
}

TEST_F(SceneChangesTest, DefaultCamerasFrameTheSceneByTheAngle) {
  SceneDescription d = small_scene();
  d.cameras.clear();
  SceneChanges changes;
  changes.field_of_view = 10;
  change_scene(d, changes, loading_budget());
  ASSERT_EQ(d.cameras.size(), 1u);
  for (const Vec3& p : d.geometry.positions) {
    const Vec3 seen = inverse(d.cameras[0].to_world).point(p);
    EXPECT_LE(std::max(std::abs(seen.x), std::abs(seen.y)) / seen.z, d.cameras[0].half_extent * 1.0001f);
  }
}

TEST(HazeTest, SurroundsSurfacesAndCamerasByItsVisibility) {
  SceneChanges changes;
  for (const SceneOption& option : scene_options())
    if (std::string_view(option.name) == "--haze") option.read(changes, "0.2km");
  SceneDescription d = small_scene();
  Light lamp;
  lamp.position = {0, -20, 0};
  d.lights.push_back(lamp);
  change_scene(d, changes, std::make_shared<MemoryBudget>());
  ASSERT_EQ(d.ambient_medium, 0u);
  const Medium& haze = d.media.at(0);
  EXPECT_NEAR(haze.sigma_a.g + haze.sigma_s.g, 3.912f / 200, 1e-6f);
  for (const Vec3 place : {Vec3{2, 1, 0}, Vec3{0, 1, 5}, lamp.position})
    EXPECT_GT(medium_point(haze, place).sigma_s.r, 0.9f * 3.912f / 200);
  EXPECT_EQ(medium_point(haze, {0, 9, 0}).sigma_s.r, 0);
  for (const char* text : {"", "m", "0", "-3m", "nan", "inf", "5 furlongs"}) {
    EXPECT_THROW(length_of_text("--haze", text), Error) << text;
  }
  SceneDescription bare;
  bare.lights.push_back(lamp);
  change_scene(bare, changes, std::make_shared<MemoryBudget>());
  EXPECT_EQ(bare.ambient_medium, kNone);
  EXPECT_THAT(bare.notes, testing::Contains(testing::HasSubstr("--haze has no effect")));
  EXPECT_EQ(length_of_text("--haze", "12.5m"), 12.5f);
}

TEST(HazeTest, CoefficientsAndGridsKeepTheirPlaceInOtherUnits) {
  SceneDescription d = small_scene();
  Medium medium;
  medium.sigma_s = RGB(3.0f);
  medium.bounds = Box3{{0, 0, 0}, {2, 1, 1}};
  d.media.push_back(medium);
  SceneChanges changes;
  changes.metres_per_unit = 0.1f;
  changes.z_up = true;
  change_scene(d, changes, std::make_shared<MemoryBudget>());
  EXPECT_FLOAT_EQ(medium_point(d.media[0], {0.15f, 0.05f, -0.05f}).sigma_s.r, 30);
  EXPECT_FLOAT_EQ(medium_point(d.media[0], {0.15f, 0.05f, 0.05f}).sigma_s.r, 0);
}

TEST_F(SceneChangesTest, PanesHaveTheTransmittanceAndReflectanceOfTheirDataSheet) {
  struct Case {
    const char* text;
    float tau, rho;
  };
  // Clear glass, a coat for the sun, a mirror that lets some through, a coat against reflections, black glass.
  for (const Case& c : {Case{"glazing,tau=0.88,rho=0.08", 0.88f, 0.08f}, Case{"glazing,tau=0.4,rho=0.3", 0.4f, 0.3f},
                        Case{"glazing,tau=0.1,rho=0.9", 0.1f, 0.9f}, Case{"glazing,rho=0.005,tau=0.95", 0.95f, 0.005f},
                        Case{"glazing,tau=0,rho=0.05", 0, 0.05f}, Case{"glazing,tau=0.5,rho=0", 0.5f, 0}}) {
    SceneDescription d = glazed();
    change_material(c.text, d, *loading_budget());
    const Scene scene(std::move(d));
    SurfacePoint point = surface_point(scene, 0, {0.3f, 0.3f});
    const Bsdf bsdf = resolve_bsdf(scene, point);
    EXPECT_NEAR(straight_transmittance(bsdf, {0, 0, 1}).g, c.tau, 2e-5) << c.text;
    EXPECT_NEAR(albedo(bsdf, {0, 0, 1}, kAllLobes).g, c.tau + c.rho, 4e-5) << c.text;
    for (const float cosine : {0.9f, 0.5f, 0.1f, 0.01f}) {
      const Vec3 wo{std::sqrt(1 - cosine * cosine), 0, cosine};
      EXPECT_LE(albedo(bsdf, wo, kAllLobes).g, 1.00001f) << c.text;
      // Faces of a high index, which a mirror without loss needs, pass more near Brewster's angle.
      if (c.tau + c.rho < 1) {
        EXPECT_LE(straight_transmittance(bsdf, wo).g, c.tau + 1e-5f) << c.text;
      }
    }
  }
  SceneDescription plain = glazed();
  change_material("glazing,tau=0.88", plain, *loading_budget());
  EXPECT_FLOAT_EQ(plain.materials[0].ior, 1.52f);
  EXPECT_NEAR(plain.materials[0].transmittance.value.r, 0.96, 2e-3) << "as Radiance has plain glass";
}

/// A pane of glass modelled as a closed box, and a large box of sheets.
TEST_F(SceneChangesTest, FacesOfClosedPanesAreHalvesOfTheDataSheet) {
  constexpr double kTau = 0.7, kRho = 0.12;
  const auto boxed = [](float thickness) {
    SceneDescription d = glazed();
    d.geometry = {};
    const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, thickness};
    add_quad(d, {0, 0, 0}, y, x);
    add_quad(d, z, x, y);
    add_quad(d, {0, 0, 0}, x, z);
    add_quad(d, y, z, x);
    add_quad(d, {0, 0, 0}, z, y);
    add_quad(d, x, y, z);
    change_material("glazing,tau=0.7,rho=0.12", d, *loading_budget());
    return d;
  };
  const SceneDescription slab = boxed(0.02f);
  EXPECT_THAT(slab.notes, testing::Contains(HasSubstr("12 triangles of closed panes")));
  const Scene scene(slab);
  const auto front_of = [](const Scene& of) {
    SurfacePoint point = surface_point(of, 0, {0.3f, 0.3f});
    return resolve_bsdf(of, point);
  };
  const Bsdf half = front_of(scene);
  const double t = straight_transmittance(half, {0, 0, 1}).g, r = albedo(half, {0, 0, 1}, kAllLobes).g - t;
  // All reflections between the two faces.
  EXPECT_NEAR(t * t / (1 - r * r), kTau, 1e-4);
  EXPECT_NEAR(r + r * t * t / (1 - r * r), kRho, 1e-4);
  const Scene house(boxed(0.8f));
  EXPECT_NEAR(straight_transmittance(front_of(house), {0, 0, 1}).g, kTau, 1e-4);
}

/// An arched skylight, whose borders lie on opaque walls.
TEST_F(SceneChangesTest, BentSheetsAreNoClosedPanes) {
  SceneDescription d = glazed();
  d.geometry = {};
  d.materials.resize(2);
  const auto height = [](int i) { return 0.1f * (1 - 0.25f * static_cast<float>((i - 2) * (i - 2))); };
  for (int i = 0; i < 4; ++i)
    add_quad(d, {static_cast<float>(i), 0, height(i)}, {1, 0, height(i + 1) - height(i)}, {0, 4, 0});
  for (const float side : {0.0f, 4.0f}) {
    add_quad(d, {side, 0, -1}, {0, 4, 0}, {0, 0, 2}, 1);
    add_quad(d, {0, side, -1}, {4, 0, 0}, {0, 0, 2}, 1);
  }
  change_material("glazing,tau=0.7,rho=0.12", d, *loading_budget());
  const Scene scene(std::move(d));
  SurfacePoint point = surface_point(scene, 0, {0.3f, 0.3f});
  EXPECT_NEAR(straight_transmittance(resolve_bsdf(scene, point), {0, 0, 1}).g, 0.7, 1e-4);
}

TEST_F(SceneChangesTest, BadMaterialTextsAreRefused) {
  for (const char* wrong : {"glazing", "glazing,rho=0.1", "glazing,tau=x", "glazing,tau=1.2", "glazing,tau=0.8,rho=0.3",
                            "glazing,tau=0.95", "glazing,tau=-0.1", "glazing,tau=0.5,0.5", ""})
    EXPECT_THROW(check_material_text(wrong), Error) << wrong;
  SceneDescription d = glazed();
  try {
    change_material("glzing,tau=0.5", d, *loading_budget());
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("Did you mean 'glazing'?"));
  }
}

}  // namespace
}  // namespace glowworm
