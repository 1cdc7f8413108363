// The noise of photon maps, which all samples of a picture share.
#pragma once
#include <cstddef>
#include <vector>

#include "core/memory_budget.h"
#include "maps/pass.h"
#include "maps/photon_maps.h"
#include "settings/settings.h"
#include "trace/tracer.h"

namespace glowworm {

/// Tasks of whole squares all over a part of a picture, a sample of each pixel. None if the part has no whole square.
/// @param most squares
std::vector<CameraTask> squares_of(const PixelBounds& part, std::size_t most);

/// Estimates what photons add to the square of a camera picture's relative error (film/filtered.h): the mean of
/// v / (m^2 + 0.01 M^2) over the channels and some squares of pixels all over the picture, with v the variance by
/// photons of a pixel of the square, m the mean of the square, and M that of all. It costs as much for any picture.
///
/// Throws as render_pass().
/// @param maps     up to date, with PhotonMapSettings::sampled
/// @param part     of the picture
/// @param settings of the picture's passes
/// @return 0 if the part has no whole square, or no light
double measure_photon_variance(const Tracer& tracer, const PhotonMaps& maps, const View& view, const PixelBounds& part,
                               const PassSettings& settings, MemoryBudget& budget);

/// Most photons that with_photons_for_noise() chooses.
inline constexpr std::uint64_t kMostPhotonsForNoise = 4'000'000;

/// The settings with so many photons that they have at most half of the square of the relative error
/// RenderSettings::photon_target, which leaves the other half to samples. Estimates average more of them, k in
/// proportion to the square root of their number: where few rays meet one place, as in reflections, the noise is that
/// of k photons, while radii still shrink. Fewer photons where that takes more than kMostPhotonsForNoise; the same
/// where it takes hardly more, or where no target is set.
/// @param variance measure_photon_variance() with the photons of the settings
RenderSettings with_photons_for_noise(RenderSettings settings, double variance);

/// The relative error of samples alone at which a render ends whose error by all is to be `target`: at least half of
/// its square is left to them, also where photons have more than the other half.
double noise_left_to_samples(double target, double photon_variance);

}  // namespace glowworm
