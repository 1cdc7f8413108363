#include "density/knn.h"

#include <algorithm>
#include <bit>

#include "core/parallel.h"

namespace glowworm {

namespace {

// Measured with bench/density_bench.cc.
constexpr std::uint32_t kKnnLeafSize = 8;
/// A subtree still to be searched, and the distance to its cell: squared, and by axis. Differences, squares and sums
/// round monotonically and are taken in the order of length_squared(), so that no photon of the cell is nearer than the
/// cell.
struct Pending {
  std::uint32_t node;
  float distance_squared;
  Vec3 offset;
};

/// The bits of distances that are not negative order as the distances do; packed with the place, ties are broken by
/// place.
std::uint64_t pack(float distance_squared, std::uint32_t place) {
  return std::uint64_t{std::bit_cast<std::uint32_t>(distance_squared)} << 32 | place;
}

/// Replaces the top of a max-heap by `value` and sifts it down.
void replace_top(std::uint64_t* heap, std::size_t size, std::uint64_t value) {
  std::size_t hole = 0;
  for (;;) {
    std::size_t child = 2 * hole + 1;
    if (child >= size) break;
    if (child + 1 < size) child += heap[child + 1] > heap[child];
    if (heap[child] <= value) break;
    heap[hole] = heap[child];
    hole = child;
  }
  heap[hole] = value;
}

/// Descends from a subtree to its leaf whose cell is nearest to x; pushes the siblings on the way.
template <class Wait>
const KdNode& descend(const KdTree& tree, Vec3 x, Pending& at, const Wait& wait) {
  const KdNode* node = &tree.nodes[at.node];
  while (!node->is_leaf()) {
    const int axis = node->axis();
    const float distance = x[axis] - node->split;
    const std::uint32_t left = at.node + 1, right = at.node + node->right_offset();
    const bool on_left = distance <= 0;
    Pending far{on_left ? right : left, 0, at.offset};
    far.offset[axis] = std::abs(distance);
    far.distance_squared = length_squared(far.offset);
    wait(far);
    at.node = on_left ? left : right;
    node = &tree.nodes[at.node];
  }
  return *node;
}

/// Distance of x from the box, by axis.
Vec3 outside(const Box3& box, Vec3 x) {
  Vec3 offset;
  for (int axis = 0; axis < 3; ++axis) {
    offset[axis] = std::max({box.min[axis] - x[axis], x[axis] - box.max[axis], 0.0f});
  }
  return offset;
}

}  // namespace

void PhotonPlaces::build(std::span<const Vec3> position, std::span<const Vec3> normal,
                         std::span<const PhotonCuts> cuts) {
  tree_ = build_kd_tree(position, kKnnLeafSize);
  normal_ = LargeArray<Vec3>(position.size());
  parallel_for_each(size(), 4096, [&](std::size_t i) { normal_[i] = normal[tree_.points[i].index]; });
  cuts_.assign(cuts.begin(), cuts.end());
  cut_of_.assign(cuts.empty() ? 0 : size(), 0);
  for (std::uint32_t place = 0; place < cut_of_.size(); ++place)
    if (const PhotonCuts* found = cuts_of(cuts, index(place)))
      cut_of_[place] = 1 + static_cast<std::uint32_t>(found - cuts.data());
}

void PhotonMap::build(const PhotonBatch& photons, std::span<const RGB> flux, std::span<const PhotonCuts> cuts) {
  PhotonPlaces::build(photons.position, photons.normal, cuts);
  direction_ = LargeArray<Vec3>(size());
  flux_ = LargeArray<RGB>(size());
  parallel_for_each(size(), 4096, [&](std::size_t i) {
    const auto place = static_cast<std::uint32_t>(i);
    direction_[i] = photons.direction[index(place)];
    flux_[i] = flux[index(place)];
  });
}

FoundPhoton PhotonPlaces::unpack(std::uint64_t packed) {
  return {std::bit_cast<float>(static_cast<std::uint32_t>(packed >> 32)), static_cast<std::uint32_t>(packed)};
}

std::size_t PhotonPlaces::nearest(Vec3 x, Vec3 normal, float min_cosine, std::size_t k, float limit_squared,
                                  std::span<std::uint64_t> found, std::uint64_t& tested) const {
  if (tree_.nodes.empty() || k == 0) return 0;
  std::uint64_t* const heap = found.data();
  std::size_t size = 0;
  // A photon is taken if its packed distance is below this: first the limit, then the top of the full heap.
  std::uint64_t bound = pack(limit_squared, 0);
  Pending stack[KdTree::kMaxDepth];
  int depth = 0;
  Pending at{0, 0, outside(tree_.bounds, x)};
  at.distance_squared = length_squared(at.offset);
  for (;;) {
    const KdNode& leaf = descend(tree_, x, at, [&](const Pending& far) {
      if (pack(far.distance_squared, 0) <= bound) stack[depth++] = far;
    });
    tested += leaf.count;
    for (std::uint32_t place = leaf.first(); place < leaf.first() + leaf.count; ++place) {
      const std::uint64_t candidate = pack(length_squared(tree_.points[place].position - x), place);
      if (candidate >= bound || !(dot(normal_[place], normal) > min_cosine)) continue;
      if (is_cut_off(place, x)) continue;
      if (size < k) {
        heap[size++] = candidate;
        if (size < k) continue;
        std::make_heap(heap, heap + k);
      } else {
        replace_top(heap, k, candidate);
      }
      bound = heap[0];
    }
    do {
      if (depth == 0) return size;
      at = stack[--depth];
    } while (pack(at.distance_squared, 0) > bound);
  }
}

void PhotonPlaces::within(Vec3 x, Vec3 normal, float min_cosine, float radius, std::vector<FoundPhoton>& found,
                          std::uint64_t& tested) const {
  found.clear();
  if (tree_.nodes.empty()) return;
  const float r2 = radius * radius;
  Pending stack[KdTree::kMaxDepth];
  int depth = 0;
  Pending at{0, 0, outside(tree_.bounds, x)};
  at.distance_squared = length_squared(at.offset);
  for (;;) {
    const KdNode& leaf = descend(tree_, x, at, [&](const Pending& far) {
      if (far.distance_squared <= r2) stack[depth++] = far;
    });
    tested += leaf.count;
    // Every photon is written, and then kept or overwritten: the choice is unpredictable, and a mispredicted branch
    // costs more than the write.
    const std::size_t before = found.size();
    found.resize(before + leaf.count);
    FoundPhoton* next = found.data() + before;
    for (std::uint32_t place = leaf.first(); place < leaf.first() + leaf.count; ++place) {
      const float d2 = length_squared(tree_.points[place].position - x);
      *next = {d2, place};
      next +=
          static_cast<std::ptrdiff_t>(d2 < r2) & static_cast<std::ptrdiff_t>(dot(normal_[place], normal) > min_cosine);
    }
    found.resize(static_cast<std::size_t>(next - found.data()));
    if (depth == 0) break;
    at = stack[--depth];
  }
  if (!cuts_.empty()) std::erase_if(found, [&](const FoundPhoton& photon) { return is_cut_off(photon.place, x); });
}

}  // namespace glowworm
