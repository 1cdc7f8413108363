// Light as the five receptors of the eye respond to it: CIE S 026:2018.
#pragma once
#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "film/film.h"
#include "measure/spectra.h"
#include "measure/spectra_tables.h"
#include "scene/light_groups.h"

namespace glowworm {

/// Names of the responses, as columns of files have them.
inline constexpr std::array<const char*, kAlphaOpicCount> kAlphaOpicNames = {"S_cone_opic", "M_cone_opic",
                                                                             "L_cone_opic", "rhodopic", "melanopic"};
inline constexpr std::size_t kMelanopic = 4;

/// Irradiances of the five responses.
using AlphaOpic = std::array<double, kAlphaOpicCount>;

/// Efficacies of a spectrum's light, W/lm: irradiance of each response for an illuminance of 1 lx. Throws Error for a
/// spectrum without visible light.
AlphaOpic alpha_opic_efficacy(const SampledSpectrum& spectrum);
/// Equivalent daylight illuminance of an irradiance of one response, lx: the illuminance of D65 that has it, too.
double equivalent_daylight(double irradiance, std::size_t response);

/// A lamp's name, and its spectrum as spectrum_of_text() reads it.
using LampSpectrum = std::pair<std::string, std::string>;
/// Parses LAMP=SPECTRUM. Throws Error.
LampSpectrum parse_lamp_spectrum(const std::string& text);

/// The efficacies of each group of lights: by its spectrum, or by D65 for those that have none; "all" names the others.
/// Throws Error, with the names, where there is no such lamp.
/// @param without gets the names of groups without a spectrum
std::vector<AlphaOpic> efficacies_of_groups(const LightGroups& groups, const std::vector<LampSpectrum>& spectra,
                                            std::vector<std::string>& without);

/// Irradiances of the responses at sensors, W m^-2, of a film with the light of these groups.
std::vector<AlphaOpic> alpha_opic_irradiances(const Film& film, std::size_t sensors,
                                              const std::vector<AlphaOpic>& efficacies);

/// Names of materials that are coloured: light that they reflect has another spectrum than the lamps, which the sums
/// over groups leave out of account.
std::vector<std::string> coloured_materials(const Scene& scene);

}  // namespace glowworm
