#include "scene/repeated_triangles.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>

#include "core/content_hash.h"
#include "core/parallel.h"
#include "core/radix_sort.h"

namespace glowworm {

namespace {

/// Bits of hashes that are sorted: enough to separate nearly all triangles, and four digits of the sort.
constexpr int kSortedBits = 44;

/// All that equal triangles have in common.
struct Content {
  std::array<Vec3, 3> corner;  ///< in their order, from the least one on
  std::uint32_t material, emission;
  friend bool operator==(const Content&, const Content&) = default;
};

Content content_of(const Geometry& g, std::uint32_t triangle) {
  Content out{{}, g.material[triangle], g.emission[triangle]};
  // Adding zero makes negative zeros positive, so that equal corners have equal bits.
  for (std::size_t i = 0; i < 3; ++i) out.corner[i] = g.positions[g.triangles[triangle][i]] + Vec3{0, 0, 0};
  const auto before = [](Vec3 a, Vec3 b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); };
  std::rotate(out.corner.begin(), std::min_element(out.corner.begin(), out.corner.end(), before), out.corner.end());
  return out;
}

/// All that instances in the same place have in common.
struct PlacedMesh {
  std::uint32_t mesh;
  Transform to_world;
  friend bool operator==(const PlacedMesh& a, const PlacedMesh& b) {
    const Transform &m = a.to_world, &n = b.to_world;
    return a.mesh == b.mesh && m.x == n.x && m.y == n.y && m.z == n.z && m.translation == n.translation;
  }
};

PlacedMesh placed_mesh(const Geometry& g, std::uint32_t instance) {
  const Transform& at = g.instances[instance].to_world;
  const Vec3 zero{0, 0, 0};
  return {g.instances[instance].mesh, {at.x + zero, at.y + zero, at.z + zero, at.translation + zero}};
}

/// For each of some things, whether an earlier one has equal content; empty if none has.
/// @param content_of(i) @param may_repeat(i)
template <typename ContentOf, typename MayRepeat>
std::vector<bool> find_repeated(std::size_t count, const ContentOf& content_of, const MayRepeat& may_repeat) {
  std::vector<KeyedIndex<std::uint64_t>> order(count);
  parallel_for_each(count, 4096, [&](std::size_t i) {
    ContentHash hash;
    hash.add(content_of(static_cast<std::uint32_t>(i)));
    order[i] = {hash.value(), static_cast<std::uint32_t>(i)};
  });
  radix_sort(order, kSortedBits);
  std::vector<bool> repeated;
  for (std::size_t i = 1, first = 0; i < count; ++i) {
    // Hashes agree by chance so rarely that an unequal thing between two equal ones may hide the second.
    if (order[i].key != order[first].key || !(content_of(order[i].index) == content_of(order[first].index))) {
      first = i;
    } else if (may_repeat(order[i].index)) {
      repeated.resize(count);
      repeated[order[i].index] = true;
    }
  }
  return repeated;
}

}  // namespace

std::vector<bool> repeated_triangles(const Geometry& geometry, const std::vector<bool>& ignored) {
  return find_repeated(
      geometry.triangles.size(), [&](std::uint32_t i) { return content_of(geometry, i); },
      [&](std::uint32_t i) { return !ignored[geometry.material[i]]; });
}

std::vector<bool> repeated_instances(const Geometry& geometry, const std::vector<bool>& ignored) {
  return find_repeated(
      geometry.instances.size(), [&](std::uint32_t i) { return placed_mesh(geometry, i); },
      [&](std::uint32_t i) {
        const std::vector<std::uint32_t>& materials = geometry.meshes[geometry.instances[i].mesh]->material;
        return std::none_of(materials.begin(), materials.end(), [&](std::uint32_t m) { return ignored[m]; });
      });
}

}  // namespace glowworm
