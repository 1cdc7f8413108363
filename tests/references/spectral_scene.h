// Scenes at three wavelengths instead of red, green and blue, for comparison with spectral renderers.
#pragma once
#include <array>
#include <vector>

#include "core/rgb.h"
#include "scene/scene.h"

namespace glowworm {

/// A smooth spectrum of reflectance: s(c0 x^2 + c1 x + c2), x the wavelength mapped to [-1, 1], s(t) = 1/2 + t / (2
/// sqrt(1 + t^2)) (Jakob and Hanika, "A Low-Dimensional Function Space for Efficient Spectral Upsampling", 2019), as
/// pbrt-v4 makes of every RGB colour.
struct SmoothSpectrum {
  std::array<double, 3> c{};
  double at(double wavelength) const;
};

/// The smooth spectrum that has a colour under D65, by Gauss-Newton steps. @param color linear Rec. 709, in [0, 1]
SmoothSpectrum smooth_spectrum(RGB color);

/// Wavelengths at which a picture is rendered, and what a radiance at each, relative to D65, adds to the picture's RGB:
/// the CIE 1931 matching functions under D65, for radiance that is linear between the wavelengths. The weights add up
/// to white.
struct SpectralNodes {
  std::vector<double> wavelengths;  ///< nm, a multiple of three of them
  std::vector<RGB> weights;
};
SpectralNodes spectral_nodes(int triples);

/// The scene with every colour replaced by its smooth spectrum at three wavelengths: reflectances, textures and
/// images; lights by their spectra relative to D65, scaled as pbrt-v4 scales them (twice the largest component).
SceneDescription at_wavelengths(SceneDescription scene, const std::array<double, 3>& wavelengths);

}  // namespace glowworm
