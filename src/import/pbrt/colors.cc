#include "import/pbrt/colors.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "core/error.h"
#include "import/pbrt/file.h"

namespace glowworm {

namespace {

/// Converts linear RGB of a colour space to linear Rec. 709. Different white points are adapted by Bradford's method
/// (Lindbloom, "Chromatic Adaptation"; ITU-R BT.2407 for Rec. 2020).
RGB to_rec709(PbrtColorSpace space, RGB c) {
  struct Matrix {
    float m[3][3];
  };
  constexpr Matrix kRec2020 = {
      {{1.660491f, -0.587641f, -0.072850f}, {-0.124550f, 1.132900f, -0.008349f}, {-0.018151f, -0.100579f, 1.118730f}}};
  constexpr Matrix kDciP3 = {
      {{1.224940f, -0.224940f, 0.0f}, {-0.042057f, 1.042057f, 0.0f}, {-0.019638f, -0.078636f, 1.098274f}}};
  constexpr Matrix kAces = {
      {{2.521686f, -1.134131f, -0.387555f}, {-0.276480f, 1.372719f, -0.096239f}, {-0.015378f, -0.152975f, 1.168353f}}};
  if (space == PbrtColorSpace::srgb) return c;
  const auto& m = (space == PbrtColorSpace::rec2020 ? kRec2020 : space == PbrtColorSpace::dci_p3 ? kDciP3 : kAces).m;
  RGB out;
  for (int i = 0; i < 3; ++i) out[i] = m[i][0] * c.r + m[i][1] * c.g + m[i][2] * c.b;
  return out;
}

RGB three(const PbrtParameter& parameter) {
  return {static_cast<float>(parameter.numbers[0]), static_cast<float>(parameter.numbers[1]),
          static_cast<float>(parameter.numbers[2])};
}

bool has_count(const PbrtParameters& parameters, const PbrtParameter& parameter, std::size_t count) {
  if (parameter.numbers.size() == count) return true;
  parameters.error(parameter,
                   fmt::format("parameter {} has {} values, expected {}", in_quotes(parameter.name),
                               parameter.numbers.size(), count),
                   "Give as many values as expected.");
  return false;
}

/// The colour of a black body, from its temperature and, in pbrt-v3, its largest radiance per wavelength.
std::optional<RGB> read_blackbody(const PbrtParameters& parameters, const PbrtParameter& parameter) {
  const std::size_t count = parameter.numbers.size();
  if (count != 2 && !has_count(parameters, parameter, 1)) return std::nullopt;
  const double kelvin = parameter.numbers[0];
  if (!(kelvin >= 1 && kelvin <= 1e7)) {
    parameters.error(parameter, fmt::format("a black body of {} K", kelvin), "Give a temperature in kelvin, as 6500.");
    return std::nullopt;
  }
  return count == 2 ? blackbody_rgb_of_peak(kelvin) * static_cast<float>(parameter.numbers[1]) : blackbody_rgb(kelvin);
}

std::optional<RGB> read_spectral_color(PbrtContext& context, const PbrtParameters& parameters,
                                       const PbrtParameter& parameter, PbrtColorUse use) {
  if (!parameter.strings.empty()) {
    if (const auto light = named_illuminant(parameter.strings[0])) return light;
    if (const auto glass = named_glass(parameter.strings[0])) return RGB(*glass);
  }
  const auto spectrum = read_spectrum(context, parameters, parameter);
  if (!spectrum) return std::nullopt;
  switch (use) {
    case PbrtColorUse::illuminant:
      return context.v3 ? emission_rgb(*spectrum) : illuminant_rgb(*spectrum);
    case PbrtColorUse::reflectance:
      return reflectance_rgb(*spectrum);
    case PbrtColorUse::unbounded:
      return RGB(static_cast<float>(photopic_mean(*spectrum)));
  }
  return std::nullopt;
}

RGB clamp_reflectance(const PbrtParameters& parameters, const PbrtParameter& parameter, RGB color) {
  const RGB inside = clamp(color, 0.0f, 1.0f);
  if (!(inside == color)) {
    parameters.diagnostics().note(parameter.place, "clamped to [0, 1]: reflectance " + in_quotes(parameter.name));
  }
  return inside;
}

}  // namespace

std::optional<SampledSpectrum> read_spectrum(PbrtContext& context, const PbrtParameters& parameters,
                                             const PbrtParameter& parameter) {
  if (!parameter.strings.empty()) {
    const std::string& name = parameter.strings[0];
    try {
      const std::string path = context.resolve(name, parameter.place);
      Reservation held(*context.budget, "scene files", 0);
      return parse_spd(read_pbrt_file(path, held), path);
    } catch (const Error& error) {
      parameters.error(
          parameter,
          fmt::format("{} is neither a known spectrum nor a readable file: {}", in_quotes(name), error.what()),
          "Supported: metal-Ag-eta, metal-Ag-k (also Al, Au, Cu, CuZn), glass-BK7 and other glasses, "
          "stdillum-D65 and other illuminants.");
      return std::nullopt;
    }
  }
  SampledSpectrum spectrum;
  for (std::size_t i = 0; i + 1 < parameter.numbers.size(); i += 2) {
    if (i > 0 && parameter.numbers[i] <= spectrum.wavelengths.back()) {
      parameters.error(parameter, fmt::format("the wavelengths of {} do not ascend", in_quotes(parameter.name)),
                       "Sort the pairs by wavelength, each wavelength once.");
      return std::nullopt;
    }
    spectrum.wavelengths.push_back(parameter.numbers[i]);
    spectrum.values.push_back(parameter.numbers[i + 1]);
  }
  return spectrum;
}

std::optional<RGB> read_color(PbrtContext& context, const PbrtParameters& parameters, const PbrtParameter& parameter,
                              PbrtColorUse use) {
  std::optional<RGB> color;
  switch (parameter.type) {
    case PbrtType::rgb:
      if (has_count(parameters, parameter, 3)) color = to_rec709(context.color_space, three(parameter));
      break;
    case PbrtType::xyz:
      if (has_count(parameters, parameter, 3)) {
        color = rgb_from_xyz(parameter.numbers[0], parameter.numbers[1], parameter.numbers[2]);
      }
      break;
    case PbrtType::blackbody:
      color = read_blackbody(parameters, parameter);
      break;
    case PbrtType::real:
    case PbrtType::integer:
      if (has_count(parameters, parameter, 1)) color = RGB(static_cast<float>(parameter.numbers[0]));
      break;
    case PbrtType::spectrum:
      color = read_spectral_color(context, parameters, parameter, use);
      break;
    case PbrtType::texture:
      return std::nullopt;
    default:
      parameters.error(parameter,
                       fmt::format("parameter {} is of type {}, expected a colour or spectrum",
                                   in_quotes(parameter.name), name_of(parameter.type)),
                       "Give it as rgb, blackbody or spectrum.");
      return std::nullopt;
  }
  if (!color) return std::nullopt;
  if (!is_finite(*color)) {
    parameters.error(parameter, fmt::format("the colour {} is too large", in_quotes(parameter.name)),
                     "Give numbers within single precision.");
    return std::nullopt;
  }
  return use == PbrtColorUse::reflectance ? clamp_reflectance(parameters, parameter, *color) : *color;
}

RGB color_or(PbrtContext& context, const PbrtParameters& parameters, std::string_view name, PbrtColorUse use,
             RGB otherwise) {
  const PbrtParameter* parameter = parameters.find(name);
  if (!parameter) return otherwise;
  if (parameter->type == PbrtType::texture) {
    parameters.error(*parameter, fmt::format("{} cannot be a texture here", in_quotes(name)), "Give a colour.");
    return otherwise;
  }
  return read_color(context, parameters, *parameter, use).value_or(otherwise);
}

namespace {

/// The metal in a spectrum name: "Ag" for "metal-Ag-eta". @param ending "-eta" or "-k"; returns "" for names of another
/// form
std::string metal_of(const PbrtParameter& parameter, std::string_view ending) {
  if (parameter.strings.empty()) return {};
  const std::string_view name = parameter.strings[0];
  constexpr std::string_view kPrefix = "metal-";
  if (!name.starts_with(kPrefix) || !name.ends_with(ending) || name.size() <= kPrefix.size() + ending.size()) return {};
  return std::string(name.substr(kPrefix.size(), name.size() - kPrefix.size() - ending.size()));
}

/// The spectrum of one of a conductor's two parameters; copper's if not given; empty if it is a colour.
std::optional<SampledSpectrum> index_spectrum(PbrtContext& context, const PbrtParameters& parameters,
                                              const PbrtParameter* parameter, bool is_k) {
  const auto of = [&](const MetalSpectra& metal) { return is_k ? metal.k : metal.eta; };
  if (!parameter) return of(*named_metal("Cu"));
  if (parameter->type != PbrtType::spectrum) return std::nullopt;
  const std::string metal = metal_of(*parameter, is_k ? "-k" : "-eta");
  if (metal.empty()) return read_spectrum(context, parameters, *parameter);
  if (const auto known = named_metal(metal)) return of(*known);
  parameters.diagnostics().note(parameter->place, "not known, copper is used: metal " + in_quotes(metal));
  return of(*named_metal("Cu"));
}

RGB channel_index(PbrtContext& context, const PbrtParameters& parameters, const PbrtParameter* parameter, bool is_k,
                  RGB otherwise) {
  if (parameter && parameter->type != PbrtType::spectrum) {
    const RGB given = read_color(context, parameters, *parameter, PbrtColorUse::unbounded).value_or(otherwise);
    const float least = std::min({given.r, given.g, given.b});
    if (is_k ? least >= 0 : least > 0) return given;
    parameters.error(
        *parameter,
        fmt::format("{} of a conductor is ({:g}, {:g}, {:g}): expected numbers {}", in_quotes(parameter->name), given.r,
                    given.g, given.b, is_k ? "of at least 0" : "above 0"),
        "Give the complex index of refraction of the metal, or a \"reflectance\".");
    return otherwise;
  }
  if (!parameter) return otherwise;
  const auto spectrum = index_spectrum(context, parameters, parameter, is_k);
  return spectrum ? RGB(static_cast<float>(photopic_mean(*spectrum))) : otherwise;
}

}  // namespace

ConductorIndex read_conductor(PbrtContext& context, const PbrtParameters& parameters, std::string_view prefix) {
  const PbrtParameter* eta = parameters.find(std::string(prefix) + "eta");
  const PbrtParameter* k = parameters.find(std::string(prefix) + "k");
  static const ConductorIndex copper = conductor_rgb(named_metal("Cu")->eta, named_metal("Cu")->k);
  const bool spectral = (!eta || eta->type == PbrtType::spectrum) && (!k || k->type == PbrtType::spectrum);
  if (spectral) {
    const auto eta_spectrum = index_spectrum(context, parameters, eta, false);
    const auto k_spectrum = index_spectrum(context, parameters, k, true);
    return eta_spectrum && k_spectrum ? conductor_rgb(*eta_spectrum, *k_spectrum) : copper;
  }
  return {channel_index(context, parameters, eta, false, copper.eta),
          channel_index(context, parameters, k, true, copper.k)};
}

float read_index_of_refraction(PbrtContext& context, const PbrtParameters& parameters, std::string_view name,
                               float otherwise) {
  const PbrtParameter* parameter = parameters.find(name);
  if (!parameter) return otherwise;
  if (parameter->type == PbrtType::texture) {
    parameters.diagnostics().note(parameter->place, "not supported: a texture as index of refraction");
    return otherwise;
  }
  const auto color = read_color(context, parameters, *parameter, PbrtColorUse::unbounded);
  if (!color) return otherwise;
  const bool differs = color->r != color->g || color->g != color->b;
  if (parameter->type == PbrtType::spectrum || differs) {
    parameters.diagnostics().note(parameter->place, "not supported: dispersion; one index of refraction for all light");
  }
  if (color->r > 0 && color->g > 0 && color->b > 0) return mean(*color);
  parameters.error(*parameter, "an index of refraction must be positive", "Give for example 1.5.");
  return otherwise;
}

}  // namespace glowworm
