#include "render/photon_report.h"

#include <map>

#include "scene/light_sampling.h"

namespace glowworm {

namespace {
constexpr std::size_t kMaxNames = 100;
}  // namespace

std::vector<LightPhotons> photons_by_light(const Scene& scene, const PhotonPass& pass) {
  std::vector<LightPhotons> lights;
  std::map<std::string, std::size_t> places;
  for (std::uint32_t source = 0; source < pass.emitted_by_light.size(); ++source) {
    std::string name = light_source_name(scene, source);
    if (!places.contains(name) && places.size() >= kMaxNames) name = "others";
    const auto [place, added] = places.try_emplace(name, lights.size());
    if (added) lights.push_back({name});
    LightPhotons& light = lights[place->second];
    ++light.sources;
    light.emitted += pass.emitted_by_light[source];
    light.stored += pass.stored_by_light[source];
    light.used += pass.used_by_light[source];
  }
  return lights;
}

void add(std::vector<LightPhotons>& sum, const std::vector<LightPhotons>& pass) {
  if (sum.empty()) {
    sum = pass;
    return;
  }
  for (std::size_t i = 0; i < sum.size(); ++i) {
    sum[i].emitted += pass[i].emitted;
    sum[i].stored += pass[i].stored;
    sum[i].used += pass[i].used;
  }
}

}  // namespace glowworm
