#include "photon/material_lobes.h"

#include <algorithm>
#include <vector>

namespace glowworm {

namespace {

/// Whether textures decide which of the lobes a surface has.
bool varies(const Material& m, Lobes wanted) {
  const bool is_glass = m.kind == MaterialKind::dielectric || m.kind == MaterialKind::thin_dielectric;
  if (m.kind != MaterialKind::diffuse && (m.roughness_u.texture != kNone || m.roughness_v.texture != kNone))
    return !is_glass || (wanted & kSpecular);
  if (wanted & kBroad) {
    const bool color = m.reflectance.texture != kNone || m.transmittance.texture != kNone;
    if (m.kind == MaterialKind::diffuse || m.kind == MaterialKind::coated_diffuse) return color;
    if (m.kind == MaterialKind::metallic_roughness && color && m.metallic.value < 1) return true;
  }
  return m.kind == MaterialKind::metallic_roughness &&
         (m.metallic.texture != kNone || m.transmission.texture != kNone || m.clearcoat.texture != kNone ||
          m.coat_roughness.texture != kNone);
}

}  // namespace

bool may_have_lobes(const Scene& scene, const SurfacePoint& point, std::uint32_t material, Lobes wanted) {
  const Material& m = scene.materials()[material];
  if (m.kind == MaterialKind::interface) return false;
  if (m.kind == MaterialKind::mix)
    return may_have_lobes(scene, point, m.mix_a, wanted) || may_have_lobes(scene, point, m.mix_b, wanted);
  if (varies(m, wanted)) return true;
  SurfacePoint of_material = point;
  of_material.material = material;
  return (lobes(resolve_bsdf(scene, of_material)) & wanted) != 0;
}

bool may_have_lobes(const Scene& scene, Lobes wanted, bool panes) {
  const Geometry& g = scene.geometry();
  std::vector<bool> seen(scene.materials().size(), false);
  for (std::uint32_t i = 0; i < seen.size(); ++i) seen[i] = !panes && scene.is_pane(i);
  const auto some_have = [&](const std::vector<std::uint32_t>& materials, std::uint32_t first_triangle) {
    for (std::uint32_t i = 0; i < materials.size(); ++i) {
      if (seen[materials[i]]) continue;
      seen[materials[i]] = true;
      const SurfacePoint point = surface_point(scene, first_triangle + i, kMiddle);
      if (may_have_lobes(scene, point, materials[i], wanted)) return true;
    }
    return false;
  };
  if (some_have(g.material, 0)) return true;
  std::vector<bool> looked(g.meshes.size(), false);
  for (const Instance& instance : g.instances) {
    if (looked[instance.mesh]) continue;
    looked[instance.mesh] = true;
    if (some_have(g.meshes[instance.mesh]->material, instance.first)) return true;
  }
  return false;
}

bool bends_delta_lights(const Scene& scene, bool panes) {
  const auto shines = [](const Light& light) { return !is_black(light.intensity); };
  return std::any_of(scene.lights().begin(), scene.lights().end(), shines) && may_have_lobes(scene, kSpecular, panes);
}

}  // namespace glowworm
