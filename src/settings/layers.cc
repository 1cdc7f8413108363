#include "settings/layers.h"

#include "core/names.h"

namespace glowworm {

namespace {

struct LayerNeeds {
  const char* name;
  std::size_t channels;
  PlaceLayers places = {};
};

constexpr LayerNeeds kLayerNeeds[] = {
    {"emitted", 3},
    {"direct", 3},
    {"indirect", 3},
    {"caustic", 3},
    {"medium", 3},
    {"albedo", 3},
    {"normal", 3},
    {"depth", 1},
    {"unfiltered", 3},
    {"noise", 1},
    {"samples", 1},
    {"radius", 1, {.values = SlotValue::radius}},
    {"bias", 1, {.values = SlotValue::bias}},
    {"alpha", 1},
    {"position", 3, {.position = true}},
    {"uv", 2, {.uv = true}},
    {"object-id", 1, {.objects = true}},
    {"material-id", 1, {.materials = true}},
    {"cryptomatte", 4 * kMaxIdsOfPixel, {.objects = true, .materials = true}},
};

const LayerNeeds& needs_of(const std::string& name) { return kLayerNeeds[name_index("AOV", name, aov_names())]; }

}  // namespace

std::vector<std::string> aov_names() {
  std::vector<std::string> names;
  for (const LayerNeeds& layer : kLayerNeeds) names.emplace_back(layer.name);
  return names;
}

PlaceLayers places_for(const std::vector<std::string>& aovs) {
  PlaceLayers out;
  for (const std::string& name : aovs) {
    const PlaceLayers& needs = needs_of(name).places;
    out.position |= needs.position;
    out.uv |= needs.uv;
    out.objects |= needs.objects;
    out.materials |= needs.materials;
    out.values |= needs.values;
  }
  return out;
}

std::size_t layer_channels(const std::string& name) { return needs_of(name).channels; }

}  // namespace glowworm
