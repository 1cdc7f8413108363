#include "maps/lit_sides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/parallel.h"

namespace glowworm {

namespace {

/// Photons that show the lit side.
constexpr std::uint32_t kEnoughPhotons = 8;
/// A side with less than this share of the other's photons is dark: a little light reaches the floor below a rug.
constexpr std::uint32_t kDarkShare = 16;
constexpr std::size_t kGrain = 4096;

/// Photons on the front and on the back.
using Counts = std::array<std::uint32_t, 2>;

std::optional<LitSide> side_of(const Counts& counts) {
  const auto [front, back] = counts;
  if (front + back < kEnoughPhotons) return std::nullopt;
  if (std::uint64_t{kDarkShare} * std::min(front, back) >= std::max(front, back)) return LitSide::both;
  return front > back ? LitSide::front : LitSide::back;
}

/// For each photon twice the number of the triangle that it lies on, plus one on its back; in order.
std::vector<std::uint64_t> places_of(const Tracer& tracer, const PhotonBatch& photons) {
  const Box3 bounds = photons.bounds();
  float largest = 0;
  for (int axis = 0; axis < 3; ++axis)
    largest = std::max({largest, std::abs(bounds.min[axis]), std::abs(bounds.max[axis])});
  const float above = 0x1p-20f * largest;
  std::vector<std::uint64_t> places(photons.size());
  parallel_for(0, photons.size(), kGrain, [&](std::size_t first, std::size_t last) {
    std::vector<Ray> rays;
    for (std::size_t i = first; i < last; ++i)
      rays.push_back({photons.position[i] + photons.normal[i] * above, 0, -photons.normal[i], 2 * above});
    std::vector<Hit> hits(rays.size());
    tracer.intersect(rays, hits, RayOrder::surface);
    for (std::size_t i = first; i < last; ++i) {
      const std::uint32_t triangle = hits[i - first].triangle;
      const bool back = triangle != kNone && dot(tracer.scene().geometry().normal(triangle), photons.normal[i]) < 0;
      places[i] = 2 * std::uint64_t{triangle} + (back ? 1 : 0);
    }
  });
  std::sort(places.begin(), places.end());
  return places;
}

}  // namespace

LitSides::LitSides(const Tracer& tracer, const PhotonBatch& photons) {
  const Geometry& geometry = tracer.scene().geometry();
  const std::vector<std::uint64_t> places = places_of(tracer, photons);
  std::vector<Counts> of_objects(geometry.objects.size());
  for (std::size_t i = 0; i < places.size();) {
    const auto triangle = static_cast<std::uint32_t>(places[i] / 2);
    Counts counts{};
    for (; i < places.size() && places[i] / 2 == triangle; ++i) ++counts[places[i] % 2];
    if (triangle == kNone) break;
    if (const std::optional<LitSide> side = side_of(counts)) triangles_.push_back({triangle, *side});
    const std::uint32_t object = geometry.object_of(triangle);
    if (object == kNone) continue;
    for (int side = 0; side < 2; ++side) of_objects[object][side] += counts[side];
  }
  for (const Counts& counts : of_objects) objects_.push_back(side_of(counts).value_or(LitSide::front));
}

LitSide LitSides::of(const Geometry& geometry, std::uint32_t triangle) const {
  const auto found = std::lower_bound(triangles_.begin(), triangles_.end(), triangle,
                                      [](const Lit& lit, std::uint32_t number) { return lit.triangle < number; });
  if (found != triangles_.end() && found->triangle == triangle) return found->side;
  if (objects_.empty()) return LitSide::front;
  const std::uint32_t object = geometry.object_of(triangle);
  return object == kNone ? LitSide::front : objects_[object];
}

}  // namespace glowworm
