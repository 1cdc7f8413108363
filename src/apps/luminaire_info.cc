#include "apps/luminaire_info.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/commands.h"
#include "apps/output_files.h"
#include "core/log.h"
#include "core/text.h"
#include "import/ies/photometry.h"

namespace glowworm {

namespace {

std::string lamps_text(const LampSet& set) {
  std::string text = set.name;
  const auto add = [&](float value, const char* unit) {
    if (value > 0) text += fmt::format("{}{:g} {}", text.empty() ? "" : ", ", value, unit);
  };
  add(set.flux, "lm");
  add(set.power, "W");
  return text.empty() ? "not told" : text;
}

void print_luminaire_text(const PhotometricFile& file, const Photometry& p) {
  std::string text;
  const auto add = [&](const char* name, const std::string& value) { text += fmt::format("{:<10} {}\n", name, value); };
  if (!file.name.empty()) add("luminaire", printable(file.name));
  for (std::size_t i = 0; i < file.sets.size(); ++i)
    add("lamps", fmt::format("{} {}{}", i + 1, printable(lamps_text(file.sets[i])), i == file.set ? " *" : ""));
  add("flux", fmt::format("{:.5g} lm, {:.3g}% of it down", p.flux, 100 * p.down));
  if (p.efficacy > 0) add("efficacy", fmt::format("{:.4g} lm/W", p.efficacy));
  add("peak", fmt::format("{:.5g} cd at C {:.4g}, gamma {:.4g} degrees", p.candela, p.c, p.gamma));
  add("symmetry", p.symmetry);
  add("opening", p.opening);
  write_output(text);
}

void print_as_json(const PhotometricFile& file, const Photometry& p) {
  nlohmann::json sets = nlohmann::json::array();
  for (const LampSet& set : file.sets)
    sets.push_back({{"name", set.name}, {"flux_lm", set.flux}, {"power_w", set.power}});
  const LuminousOpening& o = file.opening;
  const nlohmann::json out = {
      {"luminaire", file.name}, {"lamps", sets},        {"set", file.set},
      {"flux_lm", p.flux},      {"flux_down", p.down},  {"efficacy_lm_w", p.efficacy},
      {"peak_cd", p.candela},   {"peak_c_deg", p.c},    {"peak_gamma_deg", p.gamma},
      {"symmetry", p.symmetry}, {"opening", p.opening}, {"opening_m", {o.size.x, o.size.y, o.size.z}}};
  write_output(out.dump(2, ' ', true, nlohmann::json::error_handler_t::replace) + "\n");
}

}  // namespace

void print_luminaire(const LuminaireInfoOptions& o) {
  OutputFiles files;
  files.add_input("the luminaire", o.path);
  if (!o.output.empty()) {
    if (lower_ending(o.output) != ".png")
      throw CommandLineError(fmt::format("'{}' does not end in .png", o.output), "Polar curves are PNG files.");
    files.add("-o", o.output);
    files.probe_all();
  }
  const PhotometricFile file = read_photometric_file(o.path, o.lamps);
  const Photometry facts = photometry_of(file);
  o.as_json ? print_as_json(file, facts) : print_luminaire_text(file, facts);
  if (o.output.empty()) return;
  Image curve = polar_curve(file, std::filesystem::path(o.path).filename().string());
  curve.metadata["comments"] = o.command_line;
  files.write(o.output, [&] { write_png(o.output, curve, ToneCurve::srgb); });
  files.throw_if_any_failed();
}

}  // namespace glowworm
