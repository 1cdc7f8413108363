// Traces photons in the Cornell box and sums them at points of its floor: irradiance without rendering a picture.
#include <glowworm/glowworm.h>

#include <iostream>
#include <vector>

namespace gw = glowworm::api;

int main() {
  const gw::Scene scene = gw::Scene::load("builtin:cornell");
  gw::PhotonOptions options;
  options.photons = 200'000;
  const gw::Photons photons = gw::trace_photons(scene, options);
  const gw::DensityIndex index(photons.arrays(), gw::photon_radii(photons.positions()));

  std::vector<gw::Vec3> points, normals;
  for (int i = 1; i < 10; ++i) {
    points.push_back({0.055f * static_cast<float>(i), 0, 0.28f});
    normals.push_back({0, 1, 0});
  }
  const std::vector<gw::Rgb> irradiance = index.sum(points, normals);
  std::cout << photons.size() << " photons of " << photons.emitted() << " light paths\n";
  for (std::size_t i = 0; i < points.size(); ++i)
    std::cout << "x = " << points[i].x << " m: " << irradiance[i].r << ' ' << irradiance[i].g << ' ' << irradiance[i].b
              << " W m^-2\n";
}
