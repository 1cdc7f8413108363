#include "scene/material.h"

#include <iterator>

namespace glowworm {

const char* name(MaterialKind kind) {
  static constexpr const char* names[] = {"diffuse",        "conductor",        "dielectric",         "thin_dielectric",
                                          "coated_diffuse", "coated_conductor", "metallic_roughness", "mix",
                                          "interface",      "measured"};
  static_assert(std::size(names) == static_cast<std::size_t>(MaterialKind::measured) + 1);
  return names[static_cast<std::size_t>(kind)];
}

std::array<const ColorInput*, 7> color_inputs(const Material& m) {
  return {&m.reflectance,          &m.transmittance, &m.specular_color, &m.sheen,
          &m.anisotropy_direction, &m.normal_map,    &m.coat_normal_map};
}

std::array<const FloatInput*, 15> float_inputs(const Material& m) {
  return {&m.roughness_u, &m.roughness_v,          &m.coat_roughness,  &m.metallic,   &m.specular,
          &m.clearcoat,   &m.transmission,         &m.sheen_roughness, &m.anisotropy, &m.iridescence,
          &m.film,        &m.diffuse_transmission, &m.mix_amount,      &m.alpha,      &m.bump};
}

}  // namespace glowworm
