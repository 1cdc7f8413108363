#include "scene/material.h"

#include <iterator>

namespace glowworm {

const char* name(MaterialKind kind) {
  static constexpr const char* names[] = {"diffuse",        "conductor",        "dielectric",         "thin_dielectric",
                                          "coated_diffuse", "coated_conductor", "metallic_roughness", "mix"};
  static_assert(std::size(names) == static_cast<std::size_t>(MaterialKind::mix) + 1);
  return names[static_cast<std::size_t>(kind)];
}

}  // namespace glowworm
