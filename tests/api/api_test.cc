// The public interface: scenes of arrays, renders, photons, density estimation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "glowworm/glowworm.h"

namespace gw = glowworm::api;

namespace {

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
  } catch (const glowworm::Error& error) {
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
  for (const bool path_tracing : {false, true}) {
    options.path_tracing = path_tracing;
    const gw::Picture picture = gw::render(lit_square(), options);
    ASSERT_EQ(picture.plane("R").size(), 64u);
    EXPECT_NEAR(picture.plane("R")[27], 0.5f, 0.01f);
    EXPECT_NEAR(picture.plane("G")[27], 0.25f, 0.01f);
    EXPECT_NEAR(picture.plane("albedo.B")[27], 1.0f, 0.01f);
  }
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
  EXPECT_THAT(render.statistics(), HasSubstr("\"cancelled\""));
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
  options.engine = "foward";
  EXPECT_THAT(error_of([&] { gw::render(lit_square(), options); }), HasSubstr("forward"));
  const std::vector<gw::Vec3> positions{{0, 0, 0}};
  EXPECT_THAT(error_of([&] { gw::DensityIndex({positions, {}, {}}, 1.0f); }), HasSubstr("fluxes"));
  const std::vector<gw::Rgb> flux{{1, 1, 1}};
  EXPECT_THAT(error_of([&] { gw::DensityIndex({positions, flux, {}}, 0.0f); }), HasSubstr("radius"));
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
  for (const gw::Kernel shape : {gw::Kernel::box, gw::Kernel::cone, gw::Kernel::epanechnikov, gw::Kernel::gaussian}) {
    const std::vector<gw::Rgb> sums = gw::DensityIndex({photons, flux, {}}, radii, shape).sum(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      double wanted = 0;
      for (std::size_t j = 0; j < photons.size(); ++j) {
        const double x = points[i].x - photons[j].x, y = points[i].y - photons[j].y, z = points[i].z - photons[j].z;
        const double d = std::sqrt(x * x + y * y + z * z) / radii[j];
        if (d < 1) wanted += kernel(shape, d) / (static_cast<double>(radii[j]) * radii[j]) * flux[j].r;
      }
      EXPECT_NEAR(sums[i].r, wanted, 1e-4 * wanted + 1e-3) << i;
    }
  }
}

}  // namespace
