#include "measure/alpha_opic.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/error.h"
#include "measure/measurement.h"
#include "scene/scene.h"

namespace glowworm {

namespace {

constexpr double kMaximalEfficacy = 683.002;  // lm/W, of light of 555 nm in air: CIE 018

/// A material counts as coloured from this difference of its channels on.
constexpr float kGrey = 0.02f;

bool is_coloured(RGB c) { return max_component(c) - std::min({c.r, c.g, c.b}) > kGrey; }

bool is_coloured(const Scene& scene, const ColorInput& input) {
  if (is_coloured(input.value)) return true;
  // A texture counts as coloured, unless one colour stands in for it.
  return input.texture != kNone && max_component(input.value) > 0 &&
         scene.textures()[input.texture].kind != TextureKind::constant;
}

}  // namespace

AlphaOpic alpha_opic_efficacy(const SampledSpectrum& spectrum) {
  double luminous = 0;
  AlphaOpic sums{};
  for (std::size_t i = 0; i < kVisibleCount; ++i) {
    const double power = spectrum.at(kVisibleFirst + kVisibleStep * static_cast<double>(i));
    luminous += kLuminousEfficiency[i] * power;
    for (std::size_t k = 0; k < kAlphaOpicCount && i < kActionCount; ++k) sums[k] += kActionSpectra[i][k] * power;
  }
  if (!(luminous > 0)) throw Error("a spectrum has no visible light", "Give powers from 380 to 780 nm.");
  for (double& sum : sums) sum /= kMaximalEfficacy * luminous;
  return sums;
}

double equivalent_daylight(double irradiance, std::size_t response) {
  static const AlphaOpic kDaylight = alpha_opic_efficacy(spectrum_of_text("D65"));
  return irradiance / kDaylight[response];
}

LampSpectrum parse_lamp_spectrum(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    throw Error(fmt::format("--spectrum '{}' is not LAMP=SPECTRUM", text),
                "Write, for example, lamp.ies=4000 or sky=D65; all=F11 means all others.");
  LampSpectrum out{text.substr(0, equals), text.substr(equals + 1)};
  spectrum_of_text(out.second);
  return out;
}

std::vector<AlphaOpic> efficacies_of_groups(const LightGroups& groups, const std::vector<LampSpectrum>& spectra,
                                            std::vector<std::string>& without) {
  const auto find = [&](const std::string& name) {
    return std::find_if(spectra.rbegin(), spectra.rend(), [&](const LampSpectrum& s) { return s.first == name; });
  };
  for (const LampSpectrum& spectrum : spectra)
    if (spectrum.first != "all" &&
        std::find(groups.names.begin(), groups.names.end(), spectrum.first) == groups.names.end())
      throw Error(fmt::format("--spectrum names '{}', which is no light of the scene", spectrum.first),
                  fmt::format("Its lights are: {}; all means the others.", fmt::join(groups.names, ", ")));
  std::vector<AlphaOpic> out;
  for (const std::string& name : groups.names) {
    auto own = find(name);
    if (own == spectra.rend()) own = find("all");
    if (own == spectra.rend()) without.push_back(name);
    out.push_back(alpha_opic_efficacy(spectrum_of_text(own == spectra.rend() ? "D65" : own->second)));
  }
  return out;
}

std::vector<AlphaOpic> alpha_opic_irradiances(const Film& film, std::size_t sensors,
                                              const std::vector<AlphaOpic>& efficacies) {
  std::vector<AlphaOpic> out(sensors);
  for (std::size_t group = 0; group < efficacies.size(); ++group)
    for (std::size_t i = 0; i < sensors; ++i) {
      const double lux = illuminance(film.light_of_group(group, i));
      for (std::size_t k = 0; k < kAlphaOpicCount; ++k) out[i][k] += efficacies[group][k] * lux;
    }
  return out;
}

std::vector<std::string> coloured_materials(const Scene& scene) {
  std::vector<bool> used(scene.materials().size(), false);
  scene.geometry().for_each_material([&](std::uint32_t material, std::size_t) { used[material] = true; });
  std::vector<std::string> out;
  for (std::size_t i = 0; i < used.size(); ++i) {
    const Material& m = scene.materials()[i];
    const auto inputs = color_inputs(m);
    const bool is_metal = m.kind == MaterialKind::conductor && !m.use_reflectance;
    const bool coloured = std::any_of(inputs.begin(), inputs.end(), [&](const ColorInput* input) {
      const bool is_direction =
          input == &m.normal_map || input == &m.coat_normal_map || input == &m.anisotropy_direction;
      return !is_direction && is_coloured(scene, *input);
    });
    if (used[i] && (coloured || (is_metal && (is_coloured(m.eta) || is_coloured(m.k))))) out.push_back(m.name);
  }
  return out;
}

}  // namespace glowworm
