#include "settings/effects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bsdf/bsdf.h"

namespace glowworm {

namespace {

constexpr std::size_t kMaxLines = 8;

/// GGX alpha of the sharpest lobe of a material; above 1 if it has none.
float sharpest_alpha(const Material& m) {
  constexpr float kNoLobe = 2;
  // A texture may contain 0.
  const auto least = [](const FloatInput& input) { return input.texture == kNone ? input.value : 0.0f; };
  const float base = std::sqrt(least(m.roughness_u) * least(m.roughness_v)), coat = least(m.coat_roughness);
  switch (m.kind) {
    case MaterialKind::conductor:
    case MaterialKind::coated_diffuse:
    case MaterialKind::dielectric:
      return base;
    case MaterialKind::thin_dielectric:
      return 0;
    case MaterialKind::coated_conductor:
      return std::min(base, coat);
    case MaterialKind::metallic_roughness:
      return m.clearcoat.value > 0 ? std::min(base, coat) : base;
    default:
      return kNoLobe;
  }
}

bool makes_caustics(const Material& m) {
  const bool lets_through =
      m.kind == MaterialKind::dielectric || (m.kind == MaterialKind::metallic_roughness && m.transmission.value > 0);
  return lets_through || sharpest_alpha(m) < kSpecularAlpha;
}

std::vector<bool> find_used(const Scene& scene) {
  std::vector<bool> used(scene.materials().size(), false);
  scene.geometry().for_each_material([&](std::uint32_t material, std::size_t) { used[material] = true; });
  // The parts of a mix may come before or after it, and may be mixes themselves.
  for (std::size_t round = 0; round < used.size(); ++round) {
    bool changed = false;
    for (std::size_t i = 0; i < used.size(); ++i) {
      const Material& m = scene.materials()[i];
      if (!used[i] || m.kind != MaterialKind::mix) continue;
      for (const std::uint32_t part : {m.mix_a, m.mix_b}) {
        changed |= !used[part];
        used[part] = true;
      }
    }
    if (!changed) break;
  }
  return used;
}

}  // namespace

std::vector<std::string> effect_notes(const Scene& scene, const RenderSettings& settings) {
  std::vector<std::string> notes;
  if (settings.integrator != Integrator::gather) return notes;
  const std::size_t first = notes.size();
  const std::vector<bool> used = find_used(scene);
  std::size_t more = 0;
  const char* caustics = settings.indirect_only ? "would make caustics (off: --indirect-only)" : "makes caustics";
  for (std::size_t i = 0; i < used.size(); ++i) {
    const Material& m = scene.materials()[i];
    if (!used[i] || !makes_caustics(m)) continue;
    const bool textured = m.roughness_u.texture != kNone || m.roughness_v.texture != kNone;
    if (notes.size() - first == kMaxLines) {
      ++more;
    } else if (textured && m.kind != MaterialKind::dielectric) {
      notes.push_back(fmt::format("material \"{}\" {} where its texture has a roughness below {}", m.name, caustics,
                                  kSpecularAlpha));
    } else {
      notes.push_back(fmt::format("material \"{}\" (roughness {:.2g}) {}", m.name, sharpest_alpha(m), caustics));
    }
  }
  if (more > 0) notes.push_back(fmt::format("more materials like these: {}", more));
  return notes;
}

}  // namespace glowworm
