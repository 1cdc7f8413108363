#include "import/gltf/light_units.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace glowworm {

GltfLightUnits light_units(const nlohmann::json& file) {
  using nlohmann::json;
  const json* bake = &file;
  for (const char* key : {"asset", "extras", "glowworm"}) {
    if (!bake->is_object() || !bake->contains(key)) return {};
    bake = &(*bake)[key];
  }
  const auto number = [&](const char* key, float otherwise) {
    const bool is_given = bake->is_object() && bake->contains(key) && (*bake)[key].is_number();
    return is_given ? (*bake)[key].get<float>() : otherwise;
  };
  const float gain = std::exp2(number(kExposureStops, NAN)), scale = number(kMetresPerUnit, 1);
  if (!std::isnormal(gain) || !std::isnormal(gain / (scale * scale))) return {};
  return {gain, gain, gain / (scale * scale)};
}

}  // namespace glowworm
