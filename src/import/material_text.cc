#include "import/material_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/input_file.h"
#include "core/names.h"
#include "core/text.h"
#include "import/glass_sheets.h"
#include "import/window/bsdf_xml.h"

namespace glowworm {

namespace {

constexpr double kGlassIndex = 1.52;

[[noreturn]] void refuse_material(const std::string& text, const std::string& why) {
  throw Error(
      fmt::format("--material '{}' {}", text, why),
      "Write NAME,tau=T or NAME,tau=T,rho=R with the name of a material, for example glazing,tau=0.7,rho=0.12; or "
      "NAME,bsdf=FILE with a file of BSDF data (XML).");
}

/// A text of --material in its parts.
struct MaterialText {
  std::string name;
  std::optional<double> tau, rho;
  std::string file;  ///< of BSDF data; empty: none
};

double share_of(const std::string& text, std::string_view value) {
  const std::vector<double> number = numbers_of<double>(value);
  if (number.size() != 1 || number[0] < 0 || number[0] > 1)
    refuse_material(text, fmt::format("has '{}', which is no share from 0 to 1", value));
  return number[0];
}

MaterialText read_material(const std::string& text) {
  MaterialText out;
  std::string_view rest = text;
  // The name may hold commas: the values stand behind it.
  if (const std::size_t at = text.find(",bsdf="); at != std::string::npos) {
    out.name = text.substr(0, at);
    out.file = text.substr(at + std::string_view(",bsdf=").size());
    if (out.file.empty()) refuse_material(text, "names no file");
    return out;
  }
  for (std::size_t comma = rest.rfind(','); comma != std::string_view::npos; comma = rest.rfind(',')) {
    const std::string_view part = rest.substr(comma + 1);
    const bool is_tau = part.starts_with("tau=");
    if (!is_tau && !part.starts_with("rho=")) break;
    (is_tau ? out.tau : out.rho) = share_of(text, part.substr(4));
    rest = rest.substr(0, comma);
  }
  out.name = rest;
  if (!out.tau) refuse_material(text, "has no tau");
  if (*out.tau + out.rho.value_or(0) > 1 + 1e-9) refuse_material(text, "transmits and reflects more than all light");
  const double r = std::pow((kGlassIndex - 1) / (kGlassIndex + 1), 2), clear = (1 - r) / (1 + r);
  if (!out.rho && *out.tau > clear)
    refuse_material(text, fmt::format("transmits more than clear glass, {:.3f}: give rho too", clear));
  return out;
}

/// What a pane reflects at normal incidence.
double reflected_by(const PaneOptics& pane, double tau) {
  const double r = std::pow((pane.ior - 1) / (pane.ior + 1), 2);
  return r + r * pane.transmittance * tau;
}

Material pane_material(const PaneOptics& optics, const std::string& name) {
  Material pane;
  pane.name = name;
  pane.kind = MaterialKind::thin_dielectric;
  pane.ior = static_cast<float>(optics.ior);
  pane.reflectance.value = RGB(1.0f);
  pane.transmittance.value = RGB(static_cast<float>(optics.transmittance));
  return pane;
}

/// Makes both faces of slabs of the materials half of a pane each.
void halve_slabs(const std::vector<bool>& changed, const Material& half, SceneDescription& scene) {
  const auto next = static_cast<std::uint32_t>(scene.materials.size());
  std::size_t count = 0;
  const auto change = [&](Geometry& geometry, const std::vector<std::uint32_t>& slabs) {
    for (const std::uint32_t triangle : slabs) geometry.material[triangle] = next;
    count += slabs.size();
  };
  change(scene.geometry, triangles_of_slabs(scene.geometry, changed));
  for (std::shared_ptr<const Geometry>& mesh : scene.geometry.meshes) {
    const std::vector<std::uint32_t> slabs = triangles_of_slabs(*mesh, changed);
    if (slabs.empty()) continue;
    Geometry copy = *mesh;
    change(copy, slabs);
    mesh = std::make_shared<const Geometry>(std::move(copy));
  }
  if (count == 0) return;
  scene.materials.push_back(half);
  scene.notes.push_back(
      fmt::format("material \"{}\": {} triangles of closed panes, each face half of the data sheet", half.name, count));
}

}  // namespace

PaneOptics half_pane_of_data_sheet(double tau, double rho) {
  // With t and r of a half: tau = t^2 / (1 - r^2), rho = r + r t^2 / (1 - r^2).
  const double r = rho / (1 + tau);
  return pane_of_data_sheet(std::sqrt(tau * (1 - r * r)), r);
}

PaneOptics pane_of_data_sheet(double tau, double rho) {
  // With r of a face and t of the inside: tau = (1 - r)^2 t / (1 - r^2 t^2), rho = r + r t tau.
  const double b = tau * tau - rho * rho + 2 * rho + 1;
  const double r = (b - std::sqrt(std::max(b * b - 4 * (2 - rho) * rho, 0.0))) / (2 * (2 - rho));
  PaneOptics out;
  const double face = std::min(std::sqrt(r), 0.9999);  // a perfect mirror has no index
  out.ior = (1 + face) / (1 - face);
  out.transmittance = r * tau > 0 ? std::clamp((rho - r) / (r * tau), 0.0, 1.0) : tau;
  return out;
}

PaneOptics pane_of_transmittance(double tau) {
  const double r = std::pow((kGlassIndex - 1) / (kGlassIndex + 1), 2), passed = (1 - r) * (1 - r);
  // The root of tau r^2 t^2 + passed t - tau = 0.
  const double t = 2 * tau / (passed + std::sqrt(passed * passed + 4 * tau * tau * r * r));
  return {kGlassIndex, std::clamp(t, 0.0, 1.0)};
}

void check_material_text(const std::string& text) { read_material(text); }

Material measured_material(std::string_view text, const std::string& path, std::vector<std::string>& notes) {
  std::vector<std::string> own;
  Material out;
  out.kind = MaterialKind::measured;
  out.measured = parse_bsdf_xml(text, path, own);
  for (const std::string& note : own) notes.push_back(fmt::format("{}: {}", path, note));
  return out;
}

void change_material(const std::string& text, SceneDescription& scene, MemoryBudget& budget) {
  const MaterialText given = read_material(text);
  Material made;
  PaneOptics pane;
  if (given.file.empty()) {
    pane = given.rho ? pane_of_data_sheet(*given.tau, *given.rho) : pane_of_transmittance(*given.tau);
    made = pane_material(pane, given.name);
  } else {
    Reservation held(budget, "BSDF data", 0);
    const std::string data = read_input_file(given.file, held);
    held.grow(bsdf_bytes(data));
    made = measured_material(data, given.file, scene.notes);
    made.name = given.name;
  }
  std::vector<bool> changed;
  for (Material& material : scene.materials) {
    changed.push_back(material.name == given.name);
    if (changed.back()) material = made;
  }
  if (std::find(changed.begin(), changed.end(), true) != changed.end()) {
    if (given.tau)
      halve_slabs(changed,
                  pane_material(half_pane_of_data_sheet(*given.tau, given.rho.value_or(reflected_by(pane, *given.tau))),
                                given.name),
                  scene);
    return;
  }
  std::vector<std::string> names;
  for (const Material& material : scene.materials)
    if (!material.name.empty()) names.push_back(material.name);
  throw Error(fmt::format("--material '{}': the scene has no material '{}'", text, given.name),
              did_you_mean(given.name, names) + "`glowworm info` lists the names.");
}

}  // namespace glowworm
