// Scenes at three wavelengths against double-precision sums computed in this file.
#include "references/spectral_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>

#include "import/pbrt/spectrum_tables.h"
#include "pbrt_testing.h"

namespace glowworm {
namespace {

using pbrt_testing::expect_near;

using Triple = std::array<double, 3>;

/// Colours as scenes have them: the walls of the Cornell box, a warm white, a blue and a yellow.
constexpr RGB kColors[] = {
    {0.63f, 0.065f, 0.05f}, {0.14f, 0.45f, 0.091f}, {0.725f, 0.71f, 0.68f}, {0.05f, 0.1f, 0.7f}, {0.9f, 0.8f, 0.1f}};

/// CIE XYZ of a reflectance under D65, Y of white 1.
Triple xyz_under_daylight(const std::function<double(double)>& reflectance) {
  Triple xyz{};
  double white = 0;
  for (std::size_t i = 0; i < kMatching.size(); ++i) {
    const double wavelength = kMatchingFirst + kMatchingStep * static_cast<double>(i);
    white += kDaylight65[i] * kMatching[i][1];
    for (std::size_t c = 0; c < 3; ++c) xyz[c] += kDaylight65[i] * kMatching[i][c] * reflectance(wavelength);
  }
  for (double& value : xyz) value /= white;
  return xyz;
}

/// CIE XYZ of linear Rec. 709 (IEC 61966-2-1).
Triple xyz_of(RGB c) {
  return {0.4124 * c.r + 0.3576 * c.g + 0.1805 * c.b, 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b,
          0.0193 * c.r + 0.1192 * c.g + 0.9505 * c.b};
}

/// Within the rounding of the standard's matrix, and of white by a table in steps of 10 nm.
void expect_same(const Triple& a, const Triple& b) {
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 2e-3) << "XYZ"[c];
}

RGB at(const SmoothSpectrum& spectrum, const std::array<double, 3>& wavelengths) {
  return {static_cast<float>(spectrum.at(wavelengths[0])), static_cast<float>(spectrum.at(wavelengths[1])),
          static_cast<float>(spectrum.at(wavelengths[2]))};
}

TEST(SmoothSpectrum, HasItsColourUnderDaylight) {
  for (const RGB color : kColors) {
    SCOPED_TRACE(testing::Message() << color.r << " " << color.g << " " << color.b);
    const SmoothSpectrum spectrum = smooth_spectrum(color);
    expect_same(xyz_under_daylight([&](double wavelength) { return spectrum.at(wavelength); }), xyz_of(color));
  }
}

TEST(SmoothSpectrum, ReflectsAtMostOne) {
  for (int r = 0; r <= 4; ++r)
    for (int g = 0; g <= 4; ++g)
      for (int b = 0; b <= 4; ++b) {
        const SmoothSpectrum s = smooth_spectrum(
            RGB(0.25f * static_cast<float>(r), 0.25f * static_cast<float>(g), 0.25f * static_cast<float>(b)));
        for (double wavelength = 360; wavelength <= 830; wavelength += 5) {
          EXPECT_GE(s.at(wavelength), 0);
          EXPECT_LE(s.at(wavelength), 1);
        }
      }
}

TEST(SmoothSpectrum, OfGreyIsFlat) {
  for (const float grey : {0.02f, 0.18f, 0.5f, 0.9f})
    for (const double wavelength : {380.0, 450.0, 555.0, 780.0})
      EXPECT_NEAR(smooth_spectrum(RGB(grey)).at(wavelength), grey, 1e-5) << wavelength;
}

TEST(SpectralNodes, WeighWhiteAsWhite) {
  for (int triples = 1; triples <= 6; ++triples) {
    const SpectralNodes nodes = spectral_nodes(triples);
    ASSERT_EQ(nodes.wavelengths.size(), static_cast<std::size_t>(3 * triples));
    ASSERT_EQ(nodes.weights.size(), nodes.wavelengths.size());
    EXPECT_TRUE(std::is_sorted(nodes.wavelengths.begin(), nodes.wavelengths.end()));
    RGB white;
    for (const RGB weight : nodes.weights) white += weight;
    expect_near(white, RGB(1.0f), 1e-5f);
  }
}

TEST(SpectralNodes, AreExactForRadianceLinearBetweenThem) {
  const SpectralNodes nodes = spectral_nodes(5);
  const double first = nodes.wavelengths.front(), last = nodes.wavelengths.back();
  const auto ramp = [&](double wavelength) { return (std::clamp(wavelength, first, last) - 380) / 400; };
  RGB sum;
  for (std::size_t i = 0; i < nodes.weights.size(); ++i)
    sum += nodes.weights[i] * static_cast<float>(ramp(nodes.wavelengths[i]));
  expect_same(xyz_of(sum), xyz_under_daylight(ramp));
}

TEST(SpectralNodes, GiveASmoothSpectrumBackItsColour) {
  const SpectralNodes nodes = spectral_nodes(5);
  for (const RGB color : kColors) {
    SCOPED_TRACE(testing::Message() << color.r << " " << color.g << " " << color.b);
    const SmoothSpectrum spectrum = smooth_spectrum(color);
    RGB sum;
    for (std::size_t i = 0; i < nodes.weights.size(); ++i)
      sum += nodes.weights[i] * static_cast<float>(spectrum.at(nodes.wavelengths[i]));
    expect_near(sum, color, 5e-3f);
  }
}

constexpr std::array<double, 3> kWavelengths = {450, 550, 650};
/// On the grid of the table that at_wavelengths() interpolates in, so that nothing is lost there.
const RGB kRed(14.0f / 23, 2.0f / 23, 1.0f / 23);

class PlainImage final : public TextureImage {
 public:
  RGB color(Vec2) const override { return kRed; }
  float alpha(Vec2) const override { return 0.25f; }
  bool has_alpha() const override { return true; }
  int width() const override { return 3; }
  int height() const override { return 2; }
};

TEST(AtWavelengths, LeavesGreyScenesUnchanged) {
  SceneDescription scene;
  scene.textures.resize(1);
  scene.textures[0].value = RGB(0.3f);
  scene.materials.resize(2);
  scene.materials[0].reflectance.value = RGB(0.7f);
  scene.materials[1].reflectance.texture = 0;
  scene.emissions.resize(1);
  scene.emissions[0].radiance.value = RGB(12.0f);
  const SceneDescription out = at_wavelengths(scene, kWavelengths);
  EXPECT_EQ(out.textures[0].value, RGB(0.3f));
  EXPECT_EQ(out.materials[0].reflectance.value, RGB(0.7f));
  expect_near(out.emissions[0].radiance.value, RGB(12.0f), 1e-5f);
}

TEST(AtWavelengths, TakesReflectancesFromSmoothSpectra) {
  SceneDescription scene;
  scene.materials.resize(1);
  scene.materials[0].reflectance.value = kRed;
  scene.materials[0].transmittance.value = RGB(0.0f);
  const SceneDescription out = at_wavelengths(scene, kWavelengths);
  expect_near(out.materials[0].reflectance.value, at(smooth_spectrum(kRed), kWavelengths), 1e-4f);
  EXPECT_EQ(out.materials[0].transmittance.value, RGB(0.0f));
  // Red reflects long waves, and its table comes back in the order of the wavelengths asked for.
  EXPECT_GT(out.materials[0].reflectance.value.b, 0.4f);
  EXPECT_LT(out.materials[0].reflectance.value.r, 0.2f);
}

TEST(AtWavelengths, ScalesLightsByTwiceTheirLargestComponent) {
  SceneDescription scene;
  scene.emissions.resize(1);
  // Less its strength the colour has a largest component of a half, midway between 11 and 12 of the grid's 23.
  const float scale = 3;
  const RGB light = RGB(11.5f, 2, 1) / 23 * scale;
  scene.emissions[0].radiance.value = light;
  scene.lights.resize(2);
  scene.lights[0].intensity = light * 100;
  scene.lights[1].intensity = RGB(0.0f);
  scene.environment.emplace();
  scene.environment->scale = light;
  const SceneDescription out = at_wavelengths(scene, kWavelengths);
  const RGB below = at(smooth_spectrum(RGB(11, 2, 1) / 23), kWavelengths);
  const RGB above = at(smooth_spectrum(RGB(12, 2, 1) / 23), kWavelengths);
  expect_near(out.emissions[0].radiance.value, (below + above) / 2 * scale, 1e-4f);
  expect_near(out.lights[0].intensity, out.emissions[0].radiance.value * 100, 1e-3f);
  EXPECT_EQ(out.lights[1].intensity, RGB(0.0f));
  expect_near(out.environment->scale, out.emissions[0].radiance.value, 1e-6f);
}

TEST(AtWavelengths, ChangesOnlyColourTextures) {
  SceneDescription scene;
  scene.textures.resize(4);
  scene.textures[0].value = kRed;
  scene.textures[1].kind = TextureKind::image;
  scene.textures[1].image = std::make_shared<PlainImage>();
  scene.textures[2].kind = TextureKind::scale;
  scene.textures[2].child_a = 0;
  scene.textures[2].child_b = 1;
  scene.textures[3].value = kRed;  // of roughness alone
  scene.materials.resize(1);
  scene.materials[0].reflectance.texture = 2;
  scene.materials[0].roughness_u.texture = 3;
  const SceneDescription out = at_wavelengths(scene, kWavelengths);
  const RGB expected = at(smooth_spectrum(kRed), kWavelengths);
  expect_near(out.textures[0].value, expected, 1e-4f);
  expect_near(out.textures[1].image->color({0.5f, 0.5f}), expected, 1e-4f);
  EXPECT_EQ(out.textures[1].image->alpha({0.5f, 0.5f}), 0.25f);
  EXPECT_TRUE(out.textures[1].image->has_alpha());
  EXPECT_EQ(out.textures[1].image->width(), 3);
  EXPECT_EQ(out.textures[1].image->height(), 2);
  EXPECT_EQ(out.textures[3].value, kRed);
}

}  // namespace
}  // namespace glowworm
