#include "density/density_scenes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/frame.h"
#include "core/random.h"
#include "core/warp.h"

namespace glowworm::density_tests {

namespace {

struct Place {
  Vec3 position, normal;
};

/// A point of one of twelve faces: those of the unit cube seen from inside, of a box in it from outside.
Place place(Sampler& sampler) {
  const float u = sampler.next1();
  const Vec2 p = sampler.next2();
  const bool inner = u >= 0.75f;
  const int face = std::min(static_cast<int>((inner ? (u - 0.75f) * 4 : u / 0.75f) * 6), 5);
  const int axis = face % 3;
  const bool high = face >= 3;
  Vec3 position, normal{0, 0, 0};
  position[axis] = high ? 1.0f : 0.0f;
  position[(axis + 1) % 3] = p.x;
  position[(axis + 2) % 3] = p.y;
  normal[axis] = high != inner ? -1.0f : 1.0f;
  if (inner) position = Vec3{0.4f, 0.5f, 0.1f} + position * 0.3f;
  return {position, normal};
}

}  // namespace

PhotonBatch room_photons(std::size_t count, std::uint32_t seed) {
  PhotonBatch photons;
  for (std::size_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, seed, 7, static_cast<std::uint32_t>(i));
    const Place at = place(sampler);
    const Vec3 direction = Frame::from_normal(at.normal).to_world(square_to_cosine_hemisphere(sampler.next2()));
    const Vec2 a = sampler.next2(), b = sampler.next2();
    photons.push_back(at.position, direction, RGB(a.x, a.y, b.x + 0.1f), at.normal);
  }
  return photons;
}

QueryPoints room_queries(std::size_t count, std::uint32_t seed) {
  QueryPoints points;
  for (std::size_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, seed, 8, static_cast<std::uint32_t>(i));
    const Place at = place(sampler);
    const Vec2 a = sampler.next2(), b = sampler.next2();
    points.push_back(at.position, at.normal, RGB(a.x, a.y, b.x), RGB(1.0f), static_cast<std::uint32_t>(i));
  }
  return points;
}

void add_photon(PhotonBatch& photons, Vec3 position, Vec3 normal, RGB flux) {
  photons.push_back(position, normal, flux, normal);
}

void add_query(QueryPoints& points, Vec3 position, Vec3 normal, RGB reflectance) {
  points.push_back(position, normal, reflectance, RGB(1.0f), static_cast<std::uint32_t>(points.size()));
}

std::vector<RGB> run(const std::string& engine, const PhotonBatch& photons, const RadiusPolicy& policy,
                     const QueryPoints& points, Statistics* statistics) {
  Statistics own;
  if (!statistics) statistics = &own;
  const auto made = make_engine(engine);
  made->build(photons, photons.flux, policy, *statistics);
  std::vector<RGB> radiance(points.size(), RGB(0.0f));
  made->estimate(points, radiance, *statistics);
  return radiance;
}

double largest_difference(const std::vector<RGB>& values, const std::vector<RGB>& expected) {
  double difference = 0, largest = 0;
  for (const RGB& value : expected) largest = std::max(largest, double(max_component(value)));
  for (std::size_t i = 0; i < expected.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const double d = std::abs(double(values[i][c]) - double(expected[i][c]));
      if (!std::isfinite(d)) return std::numeric_limits<double>::infinity();
      if (d > 0) difference = std::max(difference, d / std::max(double(expected[i][c]), 0.01 * largest));
    }
  }
  return difference;
}

}  // namespace glowworm::density_tests
