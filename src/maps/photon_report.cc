#include "maps/photon_report.h"

#include "scene/light_groups.h"

namespace glowworm {

std::vector<LightPhotons> photons_by_light(const Scene& scene, const PhotonPass& pass) {
  const LightGroups groups = light_groups(scene);
  std::vector<LightPhotons> lights;
  for (const std::string& name : groups.names) lights.push_back({name});
  for (std::uint32_t source = 0; source < pass.emitted_by_light.size(); ++source) {
    LightPhotons& light = lights[groups.of_source[source]];
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
