// Density estimation alone: a million samples on a unit square, summed at points. Needs no scene and no ray tracer.
#include <glowworm/density.h>

#include <iostream>
#include <random>
#include <vector>

namespace gw = glowworm::api;

int main() {
  constexpr std::size_t kPhotons = 1'000'000;
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<gw::Vec3> positions(kPhotons);
  // One watt in all, so that the irradiance of the square is 1 W m^-2.
  const std::vector<gw::Rgb> flux(kPhotons, {1.0f / kPhotons, 1.0f / kPhotons, 1.0f / kPhotons});
  for (gw::Vec3& p : positions) p = {uniform(random), uniform(random), 0};

  const gw::DensityIndex index({positions, flux, {}}, 0.02f, gw::Kernel::epanechnikov);
  std::vector<gw::Vec3> points;
  for (int i = 1; i < 10; ++i) points.push_back({0.1f * static_cast<float>(i), 0.5f, 0});
  for (const gw::Rgb& sum : index.sum(points)) std::cout << sum.r << ' ';
  std::cout << "W m^-2\n";
}
