#include "scene/repeated_triangles.h"

#include <algorithm>
#include <array>
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

}  // namespace

std::vector<bool> repeated_triangles(const Geometry& geometry, const std::vector<bool>& ignored) {
  std::vector<KeyedIndex<std::uint64_t>> order(geometry.triangles.size());
  parallel_for_each(order.size(), 4096, [&](std::size_t i) {
    ContentHash hash;
    hash.add(content_of(geometry, static_cast<std::uint32_t>(i)));
    order[i] = {hash.value(), static_cast<std::uint32_t>(i)};
  });
  radix_sort(order, kSortedBits);
  const auto content = [&](std::size_t i) { return content_of(geometry, order[i].index); };
  std::vector<bool> repeated;
  for (std::size_t i = 1, first = 0; i < order.size(); ++i) {
    // Hashes agree by chance so rarely that an unequal triangle between two equal ones may hide the second.
    if (order[i].key != order[first].key || !(content(i) == content(first))) {
      first = i;
    } else if (!ignored[geometry.material[order[i].index]]) {
      repeated.resize(order.size());
      repeated[order[i].index] = true;
    }
  }
  return repeated;
}

}  // namespace glowworm
