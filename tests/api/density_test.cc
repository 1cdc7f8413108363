// The public interface: photons, photon maps and density estimation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "api/api_testing.h"

namespace {

using testing::HasSubstr;

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
