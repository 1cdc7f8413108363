#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "builtin/builtin.h"
#include "builtin/spectra.h"
#include "mesh_checks.h"

namespace glowworm {
namespace {

// CIE 1931 matching functions, tabulated every 10 nm from 400 to 700 nm (CIE 015, 2-degree observer).
constexpr double kX[] = {0.01431, 0.04351, 0.13438, 0.2839, 0.34828, 0.3362, 0.2908,  0.19536, 0.09564, 0.03201, 0.0049,
                         0.0093,  0.06327, 0.1655,  0.2904, 0.43345, 0.5945, 0.7621,  0.9163,  1.0263,  1.0622,  1.0026,
                         0.85445, 0.6424,  0.4479,  0.2835, 0.1649,  0.0874, 0.04677, 0.0227,  0.01136};
constexpr double kY[] = {0.000396, 0.00121, 0.004, 0.0116, 0.023,   0.038, 0.06,  0.09098, 0.13902, 0.20802, 0.323,
                         0.503,    0.71,    0.862, 0.954,  0.99495, 0.995, 0.952, 0.87,    0.757,   0.631,   0.503,
                         0.381,    0.265,   0.175, 0.107,  0.061,   0.032, 0.017, 0.00821, 0.004102};
constexpr double kZ[] = {0.06785, 0.2074,  0.6456,  1.3856, 1.74706, 1.77211, 1.6692,  1.28764,
                         0.81295, 0.46518, 0.272,   0.1582, 0.07825, 0.04216, 0.0203,  0.00875,
                         0.0039,  0.0021,  0.00165, 0.0011, 0.0008,  0.00034, 0.00019, 0.00005,
                         0.00002, 0,       0,       0,      0,       0,       0};

double tabulated(const double (&table)[31], double wavelength) {
  const double x = (wavelength - 400) / 10;
  const int i = std::min(static_cast<int>(x), 29);
  return table[i] + (table[i + 1] - table[i]) * (x - i);
}

// The colour by the tables and the matrix of the Rec. 709 primaries and white point to seven digits.
std::array<double, 3> tabulated_color(const CornellSpectrum& spectrum) {
  double x = 0, y = 0, z = 0, white = 0;
  for (std::size_t i = 0; i < spectrum.size(); ++i) {
    const double wavelength = 400 + 4.0 * static_cast<double>(i);
    x += tabulated(kX, wavelength) * spectrum[i];
    y += tabulated(kY, wavelength) * spectrum[i];
    z += tabulated(kZ, wavelength) * spectrum[i];
    white += tabulated(kY, wavelength);
  }
  return {(3.2404542 * x - 1.5371385 * y - 0.4985314 * z) / white,
          (-0.9692660 * x + 1.8760108 * y + 0.0415560 * z) / white,
          (0.0556434 * x - 0.2040259 * y + 1.0572252 * z) / white};
}

TEST(Cornell, LightColorAgreesWithTabulatedMatchingFunctions) {
  const auto expected = tabulated_color(cornell_light());
  const RGB color = cornell_color(cornell_light());
  // The fit's published error is below 1 % of the functions' peaks.
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(color[c], expected[c], 0.02 * expected[c]) << c;
}

TEST(Cornell, ReflectancesAgreeWithTabulatedMatchingFunctions) {
  const CornellSpectrum light = cornell_light();
  const auto lit = tabulated_color(light);
  for (const CornellSpectrum* spectrum : {&kCornellWhite, &kCornellGreen, &kCornellRed}) {
    CornellSpectrum product = light;
    for (std::size_t i = 0; i < product.size(); ++i) product[i] *= (*spectrum)[i];
    const auto expected = tabulated_color(product);
    const RGB reflectance = cornell_reflectance(*spectrum);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(reflectance[c], expected[c] / lit[c], 0.006) << c;
  }
}

TEST(Cornell, MaterialsHaveTheMeasuredReflectances) {
  const SceneDescription scene = builtin_scene("cornell");
  EXPECT_TRUE(scene.materials[0].reflectance.value == cornell_reflectance(kCornellWhite));
  EXPECT_TRUE(scene.materials[1].reflectance.value == cornell_reflectance(kCornellGreen));
  EXPECT_TRUE(scene.materials[2].reflectance.value == cornell_reflectance(kCornellRed));
  EXPECT_TRUE(scene.emissions[0].radiance.value == cornell_color(cornell_light()));
}

TEST(Cornell, LampIsAsLargeAsMeasuredAndLooksDown) {
  const Geometry g = builtin_scene("cornell").geometry;
  double area = 0;
  for (std::uint32_t t = 0; t < g.triangle_count(); ++t) {
    if (g.emission[t] == kNone) continue;
    area += g.area(t);
    EXPECT_FLOAT_EQ(g.normal(t).y, -1);
  }
  EXPECT_NEAR(area, 0.130 * 0.105, 1e-7);
}

TEST(Cornell, ShellIsOpenAtTheFrontAndUnderTheBlocksOnly) {
  const Geometry g = builtin_scene("cornell").geometry;
  EXPECT_EQ(g.triangle_count(), 38u);
  EXPECT_EQ(unmatched_edges(g), 4u + 4u + 4u);
  EXPECT_EQ(slivers(g, 0.01f), 0u);
}

TEST(Cornell, WallsLookIntoTheBox) {
  const Geometry g = builtin_scene("cornell").geometry;
  const Vec3 middle{0.278f, 0.45f, 0.28f};  // above both blocks, below the ceiling
  for (std::uint32_t t = 0; t < 18; ++t)
    EXPECT_GT(dot(g.normal(t), middle - g.positions[g.triangles[t][0]]), 0) << "triangle " << t;
}

TEST(Cornell, BlocksLookOutwards) {
  const Geometry g = builtin_scene("cornell").geometry;
  const Vec3 inside[2] = {{0.186f, 0.08f, 0.169f}, {0.368f, 0.165f, 0.351f}};
  for (std::uint32_t t = 18; t < 38; ++t)
    EXPECT_LT(dot(g.normal(t), inside[t < 28 ? 0 : 1] - g.positions[g.triangles[t][0]]), 0) << "triangle " << t;
}

}  // namespace
}  // namespace glowworm
