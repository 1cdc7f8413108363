#include "density/blocked_index.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"
#include "density/compact_sort.h"
#include "density/reorder.h"
#include "kernels/kernel_shape.h"

namespace glowworm {

namespace {

// Photons that are sorted together, after a Hilbert curve has grouped them,
constexpr std::size_t kSortedRun = 512;
// or a tree, in which runs of leaves are boxes.
constexpr std::size_t kSortedRunOfTree = 128;
constexpr std::size_t kIndexGrain = 1024;
// Prefetch distance, in photons.
constexpr std::size_t kIndexAhead = 16;
// Margin for rounding in tests against the largest radius, so that no photon is lost.
constexpr float kRadiusMargin = 1 + 1e-5f;
/// Of photons that no block holds.
constexpr std::uint32_t kNoPlace = ~std::uint32_t{0};
/// Distance of a plane that does not exist.
constexpr float kNoPlane = std::numeric_limits<float>::infinity();

float radius_of(const RadiusPolicy& policy, std::size_t i) {
  return policy.kind == RadiusKind::fixed ? policy.radius : policy.radii[i];
}

/// Least radius whose square has an inverse in single precision; every photon has at least this radius.
float inverse_square(float radius) {
  return static_cast<float>(std::max(1e-37, 1 / (static_cast<double>(radius) * radius)));
}

bool counts(Vec3 position, Vec3 normal, float radius) {
  return inverse_square(radius) <= std::numeric_limits<float>::max() && is_finite(position) && is_finite(normal);
}

/// The photons to index, in the order of their blocks.
LargeArray<CompactRow> sorted_photons(const PhotonBatch& photons, const RadiusPolicy& policy, std::size_t& count) {
  std::vector<std::uint32_t> along_curve;
  std::span<const std::uint32_t> order = policy.order;
  if (order.empty()) {
    const ReorderSettings settings{ReorderMethod::radix, 0,
                                   std::min(10, automatic_depth(8 * photons.size(), photons.size()))};
    along_curve = hilbert_order(photons.position, bounds_of(photons.position), photons.size(), settings);
    order = along_curve;
  }
  LargeArray<CompactRow> sorted(order.size());
  std::atomic<bool> all_count{true};
  parallel_for_each(order.size(), kIndexGrain, [&](std::size_t i) {
    // Photons are in memory in the order of tracing, which is random in space.
    const std::uint32_t soon = order[std::min(i + kIndexAhead, order.size() - 1)];
    __builtin_prefetch(&photons.position[soon]);
    __builtin_prefetch(&photons.normal[soon]);
    if (policy.kind == RadiusKind::per_photon) __builtin_prefetch(&policy.radii[soon]);
    const std::uint32_t p = order[i];
    const Vec3 position = photons.position[p], normal = photons.normal[p];
    float radius = radius_of(policy, p);
    if (!counts(position, normal, radius)) {
      radius = 0;
      all_count.store(false, std::memory_order_relaxed);
    }
    sorted[i] = {{position.x, position.y, position.z, normal.x, normal.y, normal.z, radius, 0}};
    sorted[i].set_index(p);
  });
  CompactRow* const end =
      all_count ? sorted.end() : std::remove_if(sorted.begin(), sorted.end(), [](const CompactRow& row) {
        return row.coordinate[CompactRow::kRadius] == 0;
      });
  count = static_cast<std::size_t>(end - sorted.begin());
  const std::size_t run = policy.order.empty() ? kSortedRun : kSortedRunOfTree;
  parallel_for(0, count, kSortedRun, [&](std::size_t begin, std::size_t end_of_piece) {
    std::array<CompactRow, kSortedRun> scratch;
    alignas(64) std::array<float, kSortedRun> column;
    for (std::size_t first = begin; first < end_of_piece; first += run)
      compact_sort(sorted.span().subspan(first, std::min(run, end_of_piece - first)), scratch, column);
  });
  return sorted;
}

/// A lane without a photon.
void clear_lane(PhotonBlock& block, std::size_t lane) {
  block.x[lane] = block.y[lane] = block.z[lane] = block.nx[lane] = block.ny[lane] = block.nz[lane] = 0;
  block.r[lane] = block.g[lane] = block.b[lane] = 0;
  block.inverse_radius_squared[lane] = std::numeric_limits<float>::infinity();
}

/// An empty child.
void clear_child(BlockNode& node, int child) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  node.min_x[child] = node.min_y[child] = node.min_z[child] = kInfinity;
  node.max_x[child] = node.max_y[child] = node.max_z[child] = -kInfinity;
  node.radius_squared[child] = 0;
  node.normal_x[child] = node.normal_y[child] = node.normal_z[child] = node.normal_spread[child] = 0;
}

/// Accumulates the bounds of a child.
struct ChildBounds {
  Box3 box;
  float radius_squared = 0;
  Vec3 normal;  // mean
  float spread = 0;
};

void set_child(BlockNode& node, int child, const ChildBounds& bounds) {
  node.min_x[child] = bounds.box.min.x;
  node.min_y[child] = bounds.box.min.y;
  node.min_z[child] = bounds.box.min.z;
  node.max_x[child] = bounds.box.max.x;
  node.max_y[child] = bounds.box.max.y;
  node.max_z[child] = bounds.box.max.z;
  node.radius_squared[child] = bounds.radius_squared;
  node.normal_x[child] = bounds.normal.x;
  node.normal_y[child] = bounds.normal.y;
  node.normal_z[child] = bounds.normal.z;
  node.normal_spread[child] = bounds.spread;
}

ChildBounds bounds_of_block(const PhotonBlock& block) {
  ChildBounds bounds;
  int count = 0;
  const auto normal = [&](int lane) { return Vec3{block.nx[lane], block.ny[lane], block.nz[lane]}; };
  for (; count < kBlockWidth && std::isfinite(block.inverse_radius_squared[count]); ++count) {
    bounds.box.grow(Vec3{block.x[count], block.y[count], block.z[count]});
    bounds.radius_squared = std::max(bounds.radius_squared, kRadiusMargin / block.inverse_radius_squared[count]);
    bounds.normal += normal(count);
  }
  bounds.normal *= 1.0f / static_cast<float>(count);
  for (int lane = 0; lane < count; ++lane)
    bounds.spread = std::max(bounds.spread, length(normal(lane) - bounds.normal));
  return bounds;
}

ChildBounds bounds_of_node(const BlockNode& node) {
  ChildBounds bounds;
  int count = 0;
  const auto normal = [&](int child) { return Vec3{node.normal_x[child], node.normal_y[child], node.normal_z[child]}; };
  for (; count < kBlockWidth && node.radius_squared[count] > 0; ++count) {
    bounds.box.grow(Vec3{node.min_x[count], node.min_y[count], node.min_z[count]});
    bounds.box.grow(Vec3{node.max_x[count], node.max_y[count], node.max_z[count]});
    bounds.radius_squared = std::max(bounds.radius_squared, node.radius_squared[count]);
    bounds.normal += normal(count);
  }
  bounds.normal *= 1.0f / static_cast<float>(count);
  for (int child = 0; child < count; ++child)
    bounds.spread = std::max(bounds.spread, node.normal_spread[child] + length(normal(child) - bounds.normal));
  return bounds;
}

}  // namespace

BlockedIndex::BlockedIndex(const PhotonBatch& photons, std::span<const RGB> fluxes, const RadiusPolicy& policy,
                           std::vector<std::uint32_t>* photon_of_place)
    : kernel_(policy.kernel), min_normal_cosine_(policy.min_normal_cosine) {
  // Lists hold 32-bit indices of floats in the blocks.
  constexpr std::size_t kMaxPhotons =
      std::numeric_limits<std::uint32_t>::max() / (sizeof(PhotonBlock) / sizeof(float)) * kBlockWidth;
  if (photons.size() > kMaxPhotons)
    throw Error("the blocked density engine holds no more than " + std::to_string(kMaxPhotons) + " photons at once",
                "Trace the photons in several passes.");
  const LargeArray<CompactRow> sorted = sorted_photons(photons, policy, size_);
  // Bits stay in the caches, unlike numbers.
  std::vector<bool> is_cut(policy.cuts.empty() ? 0 : photons.size());
  for (const PhotonCuts& c : policy.cuts) is_cut[c.photon] = true;
  std::vector<std::uint32_t> place_of_cut(policy.cuts.size(), kNoPlace);
  blocks_ = LargeArray<PhotonBlock>((size_ + kBlockWidth - 1) / kBlockWidth);
  directions_ = LargeArray<Vec3>(blocks_.size() * kBlockWidth);
  if (photon_of_place) photon_of_place->resize(size_);
  const double norm = kernel_norm(policy.kernel) / std::numbers::pi;
  parallel_for(0, blocks_.size(), kIndexGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t place = first * kBlockWidth; place < last * kBlockWidth; ++place) {
      PhotonBlock& block = blocks_[place / kBlockWidth];
      const std::size_t lane = place % kBlockWidth;
      if (place >= size_) {
        clear_lane(block, lane);
        continue;
      }
      const std::uint32_t soon = sorted[std::min(place + kIndexAhead, size_ - 1)].index();
      __builtin_prefetch(&fluxes[soon]);
      __builtin_prefetch(&photons.direction[soon]);
      const CompactRow& row = sorted[place];
      const float radius = row.coordinate[CompactRow::kRadius];
      const std::uint32_t p = row.index();
      block.x[lane] = row.coordinate[0];
      block.y[lane] = row.coordinate[1];
      block.z[lane] = row.coordinate[2];
      block.inverse_radius_squared[lane] = inverse_square(radius);
      block.nx[lane] = row.coordinate[3];
      block.ny[lane] = row.coordinate[4];
      block.nz[lane] = row.coordinate[5];
      const float scale = static_cast<float>(norm / (static_cast<double>(radius) * radius));
      const RGB flux = fluxes[p] * scale;
      block.r[lane] = flux.r;
      block.g[lane] = flux.g;
      block.b[lane] = flux.b;
      directions_[place] = photons.direction[p];
      if (photon_of_place) (*photon_of_place)[place] = p;
      if (!is_cut.empty() && is_cut[p])
        place_of_cut[cuts_of(policy.cuts, p) - policy.cuts.data()] = static_cast<std::uint32_t>(place);
    }
  });
  build_nodes();
  if (!policy.cuts.empty()) add_cuts(policy.cuts, place_of_cut);
}

void BlockedIndex::add_cuts(std::span<const PhotonCuts> cuts, std::span<const std::uint32_t> places) {
  cut_of_block_ = LargeArray<std::uint32_t>(blocks_.size());
  std::fill(cut_of_block_.begin(), cut_of_block_.end(), 0);
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    if (places[i] == kNoPlace) continue;
    std::uint32_t& number = cut_of_block_[places[i] / kBlockWidth];
    if (number == 0) {
      cuts_.push_back({});
      for (auto& distances : cuts_.back().distance) std::fill(std::begin(distances), std::end(distances), kNoPlane);
      number = static_cast<std::uint32_t>(cuts_.size());
    }
    const std::size_t lane = places[i] % kBlockWidth;
    for (std::size_t c = 0; c < kCuts; ++c) {
      const KernelCut& cut = cuts[i].cuts[c];
      if (cut.normal == Vec3{0, 0, 0}) continue;
      for (int axis = 0; axis < 3; ++axis) cuts_[number - 1].normal[c][axis][lane] = cut.normal[axis];
      cuts_[number - 1].distance[c][lane] = cut.distance;
    }
  }
}

void BlockedIndex::build_nodes() {
  if (blocks_.size() == 0) return;
  std::size_t children = blocks_.size(), first_child = 0;
  do {
    const std::size_t first = nodes_.size(), count = (children + kBlockWidth - 1) / kBlockWidth;
    const bool lowest = level_first_.empty();
    level_first_.push_back(first);
    nodes_.resize(first + count);
    parallel_for_each(count, kIndexGrain, [&](std::size_t i) {
      for (int c = 0; c < kBlockWidth; ++c) {
        const std::size_t child = i * kBlockWidth + static_cast<std::size_t>(c);
        if (child >= children)
          clear_child(nodes_[first + i], c);
        else
          set_child(nodes_[first + i], c,
                    lowest ? bounds_of_block(blocks_[child]) : bounds_of_node(nodes_[first_child + child]));
      }
    });
    first_child = first;
    children = count;
  } while (children > 1);
}

BlockTree BlockedIndex::tree() const {
  BlockTree tree;
  tree.blocks = blocks_.data();
  tree.levels = static_cast<int>(level_first_.size());
  for (std::size_t level = 0; level < level_first_.size(); ++level)
    tree.level[level] = nodes_.data() + level_first_[level];
  tree.kernel = kernel_;
  tree.min_normal_cosine = min_normal_cosine_;
  static_assert(sizeof(Vec3) == 3 * sizeof(float));
  tree.cut_of_block = cuts_.empty() ? nullptr : cut_of_block_.data();
  tree.cuts = cuts_.data();
  tree.directions = directions_.size() > 0 ? &directions_[0].x : nullptr;
  return tree;
}

std::uint64_t BlockedIndex::bytes(std::size_t photons) {
  const std::uint64_t blocks = (photons + kBlockWidth - 1) / kBlockWidth;
  // All levels together hold less than 1/7 of a node for each block, plus one node for each level.
  return blocks * (sizeof(PhotonBlock) + kBlockWidth * sizeof(Vec3)) + (blocks / 7 + 12) * sizeof(BlockNode);
}

}  // namespace glowworm
