#include "import/pbrt/spectrum.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "core/error.h"
#include "pbrt/pbrt_testing.h"

namespace glowworm {
namespace {

using pbrt_testing::expect_near;

SampledSpectrum constant(double value) { return {{300, 900}, {value, value}}; }

TEST(Spectrum, InterpolatesAndEnds) {
  const SampledSpectrum s{{400, 500, 600}, {1, 3, 2}};
  EXPECT_EQ(s.at(399), 0);
  EXPECT_EQ(s.at(400), 1);
  EXPECT_EQ(s.at(450), 2);
  EXPECT_EQ(s.at(500), 3);
  EXPECT_EQ(s.at(600), 2);
  EXPECT_EQ(s.at(601), 0);
  EXPECT_EQ(SampledSpectrum().at(500), 0);
}

TEST(Spectrum, WhiteIsWhite) {
  expect_near(rgb_from_xyz(0.950456, 1, 1.089058), RGB(1.0f), 1e-3f);
  expect_near(reflectance_rgb(constant(1)), RGB(1.0f), 1e-6f);
  expect_near(reflectance_rgb(constant(0.18)), RGB(0.18f), 1e-6f);
}

TEST(Spectrum, StandardWhitesHaveTheirColours) {
  expect_near(*named_illuminant("stdillum-D65"), RGB(1.0f), 2e-3f);
  // The equal-energy spectrum: chromaticity (1/3, 1/3), linear Rec. 709 from the matrix of IEC 61966-2-1.
  expect_near(illuminant_rgb(constant(7)), {1.2048f, 0.9483f, 0.9089f}, 2e-3f);
  expect_near(emission_rgb(constant(7)), RGB{1.2048f, 0.9483f, 0.9089f} * 7, 2e-2f);
  EXPECT_FALSE(named_illuminant("stdillum-D99"));
}

TEST(Spectrum, LightsHaveLuminanceOne) {
  for (const char* name : {"stdillum-A", "stdillum-D50", "stdillum-F11", "illum-acesD60"}) {
    EXPECT_NEAR(luminance(*named_illuminant(name)), 1, 1e-3) << name;
  }
  for (const double kelvin : {1500.0, 3000.0, 6504.0, 20000.0}) {
    EXPECT_NEAR(luminance(blackbody_rgb(kelvin)), 1, 1e-3) << kelvin;
  }
  EXPECT_TRUE(is_finite(blackbody_rgb(1)));
  EXPECT_TRUE(is_finite(blackbody_rgb(1e7)));
}

TEST(Spectrum, BlackbodyAtIlluminantA) {
  // CIE illuminant A is a Planckian radiator at 2856 K.
  expect_near(blackbody_rgb(2855.5), *named_illuminant("stdillum-A"), 5e-3f);
}

/// The CIE 1931 matching functions by formulas instead of tables: C. Wyman, P.-P. Sloan, P. Shirley, "Simple Analytic
/// Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2), 2013, section 2.2.
std::array<double, 3> fitted_matching(double wavelength) {
  const auto lobe = [&](double height, double mean, double below, double above) {
    const double t = (wavelength - mean) / (wavelength < mean ? below : above);
    return height * std::exp(-0.5 * t * t);
  };
  return {lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
          lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
          lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8)};
}

/// Chromaticity x, y of a light by those formulas, in steps of a nanometre.
std::array<double, 2> fitted_chromaticity(const std::function<double(double)>& power) {
  std::array<double, 3> xyz{};
  for (double wavelength = 380; wavelength <= 780; ++wavelength)
    for (std::size_t c = 0; c < 3; ++c) xyz[c] += power(wavelength) * fitted_matching(wavelength)[c];
  const double sum = xyz[0] + xyz[1] + xyz[2];
  return {xyz[0] / sum, xyz[1] / sum};
}

/// Chromaticity of linear Rec. 709 (IEC 61966-2-1).
std::array<double, 2> chromaticity_of(RGB c) {
  const double x = 0.4124 * c.r + 0.3576 * c.g + 0.1805 * c.b, y = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
  const double sum = x + y + 0.0193 * c.r + 0.1192 * c.g + 0.9505 * c.b;
  return {x / sum, y / sum};
}

TEST(Spectrum, BlackBodiesAgreeWithPlanckUnderFittedMatchingFunctions) {
  for (const double kelvin : {2000.0, 2856.0, 4000.0, 6504.0, 10000.0}) {
    SCOPED_TRACE(kelvin);
    const auto planck = [&](double wavelength) {
      return std::pow(wavelength, -5) / std::expm1(1.438776877e7 / (wavelength * kelvin));
    };
    const std::array<double, 2> expected = fitted_chromaticity(planck), found = chromaticity_of(blackbody_rgb(kelvin));
    EXPECT_NEAR(found[0], expected[0], 5e-3);
    EXPECT_NEAR(found[1], expected[1], 5e-3);
  }
}

TEST(Spectrum, BlackBodiesOfVersion3AreRelativeToTheirPeak) {
  for (const double kelvin : {2000.0, 2700.0, 5221.0, 6500.0, 10000.0}) {
    SCOPED_TRACE(kelvin);
    const auto planck = [&](double wavelength) {
      return std::pow(wavelength, -5) / std::expm1(1.438776877e7 / (wavelength * kelvin));
    };
    double power = 0, white = 0;
    for (double wavelength = 380; wavelength <= 780; ++wavelength) {
      power += planck(wavelength) / planck(2.897771955e6 / kelvin) * fitted_matching(wavelength)[1];
      white += fitted_matching(wavelength)[1];
    }
    EXPECT_NEAR(luminance(blackbody_rgb_of_peak(kelvin)), power / white, 0.02 * power / white);
  }
  EXPECT_TRUE(is_finite(blackbody_rgb_of_peak(1)));
  EXPECT_TRUE(is_finite(blackbody_rgb_of_peak(1e7)));
}

TEST(Spectrum, PairsAgreeWithFittedMatchingFunctions) {
  const SampledSpectrum spectra[] = {
      {{380, 480, 560, 780}, {1, 3, 0.5, 2}}, {{380, 590, 610, 780}, {0.1, 0.2, 3, 3}}, {{380, 500, 780}, {4, 1, 0.5}}};
  for (const SampledSpectrum& spectrum : spectra) {
    const auto expected = fitted_chromaticity([&](double wavelength) {
      std::size_t i = 1;
      while (i + 1 < spectrum.wavelengths.size() && spectrum.wavelengths[i] < wavelength) ++i;
      const double t =
          (wavelength - spectrum.wavelengths[i - 1]) / (spectrum.wavelengths[i] - spectrum.wavelengths[i - 1]);
      return spectrum.values[i - 1] * (1 - t) + spectrum.values[i] * t;
    });
    for (const RGB color : {illuminant_rgb(spectrum), emission_rgb(spectrum)}) {
      EXPECT_NEAR(chromaticity_of(color)[0], expected[0], 5e-3);
      EXPECT_NEAR(chromaticity_of(color)[1], expected[1], 5e-3);
    }
  }
}

TEST(Spectrum, MetalsHaveTheirColours) {
  const auto normal_reflectance = [](const ConductorIndex& index) {
    RGB r;
    for (int c = 0; c < 3; ++c) {
      const float n = index.eta[c], k = index.k[c];
      r[c] = ((n - 1) * (n - 1) + k * k) / ((n + 1) * (n + 1) + k * k);
    }
    return r;
  };
  const auto metal = [&](const char* name) {
    const auto spectra = named_metal(name);
    return normal_reflectance(conductor_rgb(spectra->eta, spectra->k));
  };
  // F0 of polished metals in linear sRGB as tables for artists give them (Hoffman, "Physics and Math of Shading",
  // SIGGRAPH 2015 course notes, table 2).
  expect_near(metal("Ag"), {0.972f, 0.960f, 0.915f}, 0.03f);
  expect_near(metal("Al"), {0.913f, 0.922f, 0.924f}, 0.03f);
  expect_near(metal("Au"), {1.0f, 0.782f, 0.344f}, 0.06f);
  expect_near(metal("Cu"), {0.955f, 0.638f, 0.538f}, 0.06f);
  EXPECT_TRUE(named_metal("CuZn"));
  EXPECT_FALSE(named_metal("Unobtainium"));
}

TEST(Spectrum, ConductorOfConstantSpectraKeepsThem) {
  const ConductorIndex index = conductor_rgb(constant(1.5), constant(4));
  expect_near(index.eta, RGB(1.5f), 1e-5f);
  expect_near(index.k, RGB(4.0f), 1e-4f);
}

TEST(Spectrum, ConductorFromReflectance) {
  const ConductorIndex index = conductor_from_reflectance({0, 0.5f, 2});
  EXPECT_EQ(index.eta.g, 1);
  EXPECT_EQ(index.k.r, 0);
  EXPECT_FLOAT_EQ(index.k.g, 2);
  EXPECT_NEAR(index.k.b, 200, 1);  // clamped below 1
}

TEST(Spectrum, PhotopicMean) {
  EXPECT_NEAR(photopic_mean(constant(1.5)), 1.5, 1e-12);
  EXPECT_NEAR(photopic_mean({{500, 600}, {2, 2}}), 2, 1e-12);
  EXPECT_EQ(photopic_mean({{900, 1000}, {2, 2}}), 0);
  EXPECT_FLOAT_EQ(*named_glass("glass-BK7"), 1.5168f);
  EXPECT_FALSE(named_glass("glass-Window"));
}

TEST(Spectrum, SpdFiles) {
  const SampledSpectrum s = parse_spd("# nm value\n400 1.5\r\n\t500\t2 # end\n600 3e-1", "f.spd");
  EXPECT_EQ(s.wavelengths, (std::vector<double>{400, 500, 600}));
  EXPECT_EQ(s.values, (std::vector<double>{1.5, 2, 0.3}));
  const struct {
    const char *text, *message;
  } kCases[] = {{"", "f.spd:1: a wavelength without a value"},
                {"400 1\n500", "f.spd:2: a wavelength without a value"},
                {"400 1\nfive 2", "f.spd:2: expected a number"},
                {"400 nan", "f.spd:1: expected a number"},
                {"400 1 400 2", "f.spd: the wavelengths do not ascend"}};
  for (const auto& [text, message] : kCases) {
    try {
      parse_spd(text, "f.spd");
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace glowworm
