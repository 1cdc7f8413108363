// An engine's result for a query point does not depend on the other points of the call.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "core/frame.h"
#include "core/random.h"
#include "core/warp.h"
#include "density/density_scenes.h"
#include "density/radius.h"

namespace glowworm::density_tests {
namespace {

/// A place on a bumpy floor, where normals of neighbours match or do not, by up to a right angle.
std::pair<Vec3, Vec3> bumpy(Sampler& sampler) {
  const Vec2 p = sampler.next2(), tilt = sampler.next2();
  const Vec3 normal = normalize(Vec3{2 * tilt.x - 1, 2 * tilt.y - 1, 1});
  return {Vec3{p.x, p.y, 0.02f * std::sin(20 * p.x)}, normal};
}

PhotonBatch bumpy_photons(std::uint32_t count) {
  PhotonBatch photons;
  for (std::uint32_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, 1, 7, i);
    const auto place = bumpy(sampler);
    const Vec3 direction = Frame::from_normal(place.second).to_world(square_to_cosine_hemisphere(sampler.next2()));
    const Vec2 a = sampler.next2(), b = sampler.next2();
    photons.push_back(place.first, direction, RGB(a.x, a.y, b.x), place.second);
  }
  return photons;
}

/// Surfaces of every kind that engines tell apart, one after the other.
Bsdf surface(std::uint32_t i) {
  Bsdf b;
  b.diffuse = {0.8f, 0.4f, 0.05f};
  b.alpha_x = b.alpha_y = 0.3f;
  switch (i % 5) {
    case 0:
      b.kind = BsdfKind::coated_diffuse;
      b.coat_eta = 1.5f;
      break;
    case 1:
      b.kind = BsdfKind::conductor;
      b.eta = {0.155f, 0.117f, 1.4f};
      b.k = {4.83f, 3.12f, 0.2f};
      break;
    case 2:
      b.kind = BsdfKind::conductor;
      b.use_reflectance = true;
      b.specular = {0.9f, 0.6f, 0.3f};
      b.alpha_y = 0.5f;  // anisotropic: shaded photon by photon
      break;
    case 3:
      b.kind = BsdfKind::metallic_roughness;
      b.specular_weight = 0.7f;
      break;
    default:
      b.kind = BsdfKind::lambertian;
      b.transmission = RGB(0.1f);
  }
  return b;
}

QueryPoints bumpy_points(std::uint32_t count) {
  QueryPoints points;
  for (std::uint32_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, 2, 8, i);
    const auto place = bumpy(sampler);
    if (i % 2 == 0) {
      add_query(points, place.first, place.second, RGB(0.3f, 0.6f, 0.9f));
      continue;
    }
    const Frame frame = Frame::from_normal(place.second);
    QueryBsdf query{surface(i / 2), frame.s, frame.t, frame.n, {}};
    query.wo = frame.to_world(normalize(Vec3{0.3f, static_cast<float>(i % 7) * 0.1f, 0.8f}));
    points.push_back(place.first, place.second, query, RGB(1.0f), i);
  }
  return points;
}

QueryPoints chosen(const QueryPoints& points, const std::vector<std::uint32_t>& indices) {
  QueryPoints out;
  for (const std::uint32_t i : indices) {
    if (points.bsdf[i] == kLambertianQuery)
      out.push_back(points.position[i], points.normal[i], points.reflectance[i], points.weight[i], 0);
    else
      out.push_back(points.position[i], points.normal[i], points.bsdfs[points.bsdf[i]], points.weight[i], 0);
  }
  return out;
}

class Grouping : public testing::TestWithParam<std::string> {
 protected:
  /// Asks for the points as groups of them, last points first, and compares with what was said of all at once.
  void expect_same(const PhotonBatch& photons, const RadiusPolicy& policy, const QueryPoints& points) const {
    const auto engine = make_engine(GetParam());
    Statistics statistics;
    engine->build(photons, photons.flux, policy, statistics);
    std::vector<RGB> whole(points.size());
    engine->estimate(points, whole, statistics);
    double sum = 0;
    for (const RGB& value : whole) sum += luminance(value);
    EXPECT_GT(sum, 0);
    for (const std::size_t group : {std::size_t{1}, std::size_t{37}, points.size() / 2 + 1}) {
      std::size_t different = 0;
      // A few hundred points alone are enough.
      const std::size_t least = group == 1 ? points.size() - std::min<std::size_t>(points.size(), 200) : 0;
      for (std::size_t end = points.size(); end > least;) {
        const std::size_t first = end > group ? end - group : 0;
        std::vector<std::uint32_t> indices(end - first);
        std::iota(indices.rbegin(), indices.rend(), static_cast<std::uint32_t>(first));
        std::vector<RGB> some(indices.size());
        engine->estimate(chosen(points, indices), some, statistics);
        for (std::size_t i = 0; i < indices.size(); ++i)
          different += std::memcmp(&some[i], &whole[indices[i]], sizeof(RGB)) != 0;
        end = first;
      }
      EXPECT_EQ(different, 0u) << "groups of " << group;
    }
  }
};

TEST_P(Grouping, DoesNotChangeTheBits) {
  // Few points for many photons, and many for few: engines change how they work on the way.
  const bool brute = GetParam() == "brute";
  const std::pair<std::uint32_t, std::uint32_t> counts[] = {{brute ? 2000u : 20'000u, brute ? 200u : 600u},
                                                            {1000u, brute ? 400u : 3000u}};
  for (const auto& [photon_count, point_count] : counts) {
    const PhotonBatch photons = bumpy_photons(photon_count);
    const QueryPoints points = bumpy_points(point_count);
    RadiusPolicy policy;
    for (const KernelShape shape : kKernelShapes) {
      SCOPED_TRACE(static_cast<int>(shape));
      policy.kernel = shape;
      const bool nearest = engine_traits(GetParam()).takes_nearest;
      policy.kind = nearest ? RadiusKind::nearest : RadiusKind::per_photon;
      policy.radii = per_photon_radii(photons, 40);
      expect_same(photons, policy, points);
      if (!nearest) continue;
      policy.kind = RadiusKind::fixed;
      policy.radius = policy.radii[0];
      expect_same(photons, policy, points);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, Grouping, testing::ValuesIn(engine_names()),
                         [](const testing::TestParamInfo<std::string>& name) { return name.param; });

}  // namespace
}  // namespace glowworm::density_tests
