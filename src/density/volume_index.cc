#include "density/volume_index.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

#include "core/error.h"
#include "core/parallel.h"
#include "density/compact_sort.h"
#include "density/reorder.h"

namespace glowworm {

namespace {

static_assert(kVolumeBlock == kCompactWidth);
// Photons that are sorted together, after a Hilbert curve has grouped them.
constexpr std::size_t kVolumeRun = 512;
constexpr std::size_t kVolumeGrain = 1024;
// Bounds of boxes are wider than their photons by this share of the coordinates.
constexpr float kBoxRounding = 1e-6f;
// The same of radii.
constexpr float kRadiusRounding = 1 + 1e-6f;

/// Whether a photon of this radius adds anything, and the inverse of its square is a number.
bool has_weight(RGB flux, float radius) {
  return is_finite(flux) && !is_black(flux) && radius > 0 && std::isfinite(radius) &&
         std::isfinite(1 / (radius * radius));
}

/// Flux times the norm of the kernel.
RGB scaled_flux(RGB flux, float radius) {
  return flux * static_cast<float>(2 / std::numbers::pi / (static_cast<double>(radius) * radius));
}

template <class Block>
void set_place(Block& block, std::size_t lane, Vec3 place, Vec3 direction, RGB flux) {
  block.x[lane] = place.x;
  block.y[lane] = place.y;
  block.z[lane] = place.z;
  block.dx[lane] = direction.x;
  block.dy[lane] = direction.y;
  block.dz[lane] = direction.z;
  block.r[lane] = flux.r;
  block.g[lane] = flux.g;
  block.b[lane] = flux.b;
}

/// Photons, as the index sees them.
struct PhotonItems {
  const VolumePhotons& photons;
  std::span<const RGB> flux;
  const PhotonKernels& kernels;
  float scale;

  std::size_t size() const { return photons.size(); }
  VolumeIndex::Key key(std::size_t i) const { return {photons.medium[i], 0}; }
  bool counts(std::size_t i) const {
    return has_weight(flux[i], radius(i)) && is_finite(photons.position[i]) && is_finite(photons.direction[i]);
  }
  Vec3 middle(std::size_t i) const { return photons.position[i]; }
  CompactRow row(std::size_t i) const {
    const Vec3 p = photons.position[i];
    return {{p.x, p.y, p.z, 0, 0, 0, radius(i), 0}};
  }
  void fill(VolumePhotonBlock& block, std::size_t lane, std::size_t i) const {
    const float r = radius(i);
    set_place(block, lane, photons.position[i], photons.direction[i], scaled_flux(flux[i], r));
    block.inverse_radius_squared[lane] = 1 / (r * r);
    static_assert(std::extent_v<decltype(VolumePhotonBlock::wall)> == kWallsOfKernel);
    for (std::size_t wall = 0; wall < kWallsOfKernel; ++wall)
      for (int axis = 0; axis < 3; ++axis) block.wall[wall][axis][lane] = kernels.walls[i][wall][axis];
  }
  float radius(std::size_t i) const { return kernels.radii[i] * scale; }
};

/// Pieces of beams, as the index sees them: once for each part of their medium that holds their beam.
class PieceItems {
 public:
  PieceItems(const VolumeBeams& beams, std::span<const RGB> flux, const BeamPieces& pieces, float scale)
      : beams_(beams), flux_(flux), pieces_(pieces), scale_(scale), share_(beams.size()) {
    const std::vector<std::uint32_t> copies = copies_of_beams();
    std::vector<std::uint32_t> next(pieces.parts.size(), 0);
    for (std::uint32_t i = 0; i < beams.size(); ++i) {
      share_[i] = 1 / static_cast<float>(copies[i]);
      for (std::uint32_t copy = 0; copy < copies[i]; ++copy) {
        // Neighbours, as the beams of one path are, lie in different parts.
        const std::uint32_t m = beams.medium[i], part = m < next.size() ? next[m]++ % pieces.parts[m] : 0;
        for (std::uint32_t piece = pieces.first[i]; piece < pieces.first[i + 1]; ++piece)
          items_.push_back({i, piece, part});
      }
    }
  }

  std::size_t size() const { return items_.size(); }
  VolumeIndex::Key key(std::size_t i) const { return {beams_.medium[items_[i].beam], items_[i].part}; }
  bool counts(std::size_t i) const {
    const std::uint32_t beam = items_[i].beam;
    return has_weight(flux_[beam], radius(i)) && is_finite(beams_.origin[beam]) && is_finite(beams_.direction[beam]) &&
           beams_.length[beam] > 0 && std::isfinite(beams_.length[beam]);
  }
  Vec3 middle(std::size_t i) const { return place(i, 0.5f * (begin(i) + end(i))); }
  CompactRow row(std::size_t i) const {
    const Vec3 p = place(i, begin(i)), q = place(i, end(i));
    // A radius of 1 weighs both ends alike.
    return {{p.x, p.y, p.z, q.x, q.y, q.z, 1, 0}};
  }
  void fill(BeamBlock& block, std::size_t lane, std::size_t i) const {
    const auto [beam, piece, part] = items_[i];
    const float r = radius(i), factor = pieces_.factor.empty() ? 1.0f : pieces_.factor[piece];
    set_place(block, lane, place(i, begin(i)), beams_.direction[beam],
              scaled_flux(flux_[beam] * (factor * share_[beam]), r));
    block.radius_squared[lane] = r * r;
    block.length[lane] = end(i) - begin(i);
  }

 private:
  struct Item {
    std::uint32_t beam, piece, part;
  };

  float radius(std::size_t i) const { return pieces_.radii[items_[i].piece] * scale_; }
  float begin(std::size_t i) const { return pieces_.begin(items_[i].beam, items_[i].piece); }
  float end(std::size_t i) const { return pieces_.end[items_[i].piece]; }
  Vec3 place(std::size_t i, float distance) const {
    return beams_.origin[items_[i].beam] + beams_.direction[items_[i].beam] * distance;
  }

  /// How many parts hold a beam: more of them if its flux is above the mean, so that parts are alike.
  std::vector<std::uint32_t> copies_of_beams() const {
    std::vector<std::uint32_t> copies(beams_.size(), 1);
    std::vector<double> total(pieces_.parts.size()), count(total), owed(total);
    const auto size_of = [&](std::size_t i) {
      const double size = luminance(beams_.flux[i]);
      return std::isfinite(size) ? size : 0;
    };
    for (std::size_t i = 0; i < beams_.size(); ++i) {
      if (beams_.medium[i] >= total.size()) continue;
      total[beams_.medium[i]] += size_of(i);
      ++count[beams_.medium[i]];
    }
    for (std::size_t i = 0; i < beams_.size(); ++i) {
      const std::uint32_t m = beams_.medium[i];
      if (m >= total.size() || !(total[m] > 0)) continue;
      const double wanted = std::clamp(size_of(i) * count[m] / total[m], 1.0, static_cast<double>(pieces_.parts[m]));
      // What rounding leaves over goes to later beams.
      copies[i] = std::max(1u, static_cast<std::uint32_t>(wanted + owed[m]));
      owed[m] += wanted - copies[i];
    }
    return copies;
  }

  const VolumeBeams& beams_;
  const std::span<const RGB> flux_;
  const BeamPieces& pieces_;
  const float scale_;
  std::vector<float> share_;  // of a beam's flux that each part has
  LargeVector<Item> items_;
};

/// The items to index, by medium, and along a Hilbert curve in each.
template <class Items>
std::vector<std::uint32_t> order_of(const Items& items) {
  std::vector<std::uint32_t> kept;
  std::vector<bool> counts(items.size());
  // Bits of one word are of one piece of work.
  parallel_for_each(items.size(), 64 * kVolumeGrain, [&](std::size_t i) { counts[i] = items.counts(i); });
  for (std::uint32_t i = 0; i < items.size(); ++i)
    if (counts[i]) kept.push_back(i);
  std::vector<Vec3> middle(kept.size());
  parallel_for_each(kept.size(), kVolumeGrain, [&](std::size_t i) { middle[i] = items.middle(kept[i]); });
  const ReorderSettings settings{ReorderMethod::radix, 0, std::min(10, automatic_depth(8 * kept.size(), kept.size()))};
  std::vector<std::uint32_t> order = hilbert_order(middle, bounds_of(middle), kept.size(), settings);
  for (std::uint32_t& i : order) i = kept[i];
  const auto before = [&](std::uint32_t a, std::uint32_t b) { return items.key(a) < items.key(b); };
  if (!std::is_sorted(order.begin(), order.end(), before)) std::stable_sort(order.begin(), order.end(), before);
  return order;
}

/// A box and the largest radius in it.
struct ReachBox {
  Box3 box;
  float radius = kNoRadius;
};

ReachBox bounds_of_block(const VolumePhotonBlock& block) {
  ReachBox bounds;
  for (std::size_t lane = 0; lane < kVolumeBlock; ++lane) {
    bounds.box.grow(Vec3{block.x[lane], block.y[lane], block.z[lane]});
    bounds.radius = std::max(bounds.radius, kRadiusRounding / std::sqrt(block.inverse_radius_squared[lane]));
  }
  return bounds;
}

ReachBox bounds_of_block(const BeamBlock& block) {
  ReachBox bounds;
  for (std::size_t lane = 0; lane < kVolumeBlock; ++lane) {
    const Vec3 begin{block.x[lane], block.y[lane], block.z[lane]};
    bounds.box.grow(begin);
    bounds.box.grow(begin + Vec3{block.dx[lane], block.dy[lane], block.dz[lane]} * block.length[lane]);
    bounds.radius = std::max(
        bounds.radius, kRadiusRounding * std::sqrt(block.radius_squared[lane]) + kBeamRounding * block.length[lane]);
  }
  return bounds;
}

ReachBox bounds_of_node(const VolumeNode& node) {
  ReachBox bounds;
  for (std::size_t c = 0; c < kVolumeBlock && node.radius[c] > 0; ++c) {
    const Vec3 center{node.center_x[c], node.center_y[c], node.center_z[c]};
    const Vec3 half{node.half_x[c], node.half_y[c], node.half_z[c]};
    bounds.box.grow(center - half);
    bounds.box.grow(center + half);
    bounds.radius = std::max(bounds.radius, node.radius[c]);
  }
  return bounds;
}

void set_child(VolumeNode& node, std::size_t child, const ReachBox& bounds) {
  const bool there = bounds.radius > 0;
  const Vec3 center = there ? bounds.box.center() : Vec3{0, 0, 0};
  Vec3 half{0, 0, 0};
  for (int axis = 0; there && axis < 3; ++axis) {
    const float low = bounds.box.min[axis], high = bounds.box.max[axis];
    half[axis] = (high - low) / 2 + kBoxRounding * std::max(std::abs(low), std::abs(high));
  }
  node.center_x[child] = center.x;
  node.center_y[child] = center.y;
  node.center_z[child] = center.z;
  node.half_x[child] = half.x;
  node.half_y[child] = half.y;
  node.half_z[child] = half.z;
  node.radius[child] = bounds.radius;
}

}  // namespace

VolumeIndex::VolumeIndex(const VolumePhotons& photons, std::span<const RGB> flux, const PhotonKernels& kernels,
                         float scale) {
  build(PhotonItems{photons, flux, kernels, scale}, photons_);
}

VolumeIndex::VolumeIndex(const VolumeBeams& beams, std::span<const RGB> flux, const BeamPieces& pieces, float scale) {
  parts_ = pieces.parts;
  build(PieceItems(beams, flux, pieces, scale), beams_);
}

template <class Items, class Block>
void VolumeIndex::build(const Items& items, LargeArray<Block>& blocks) {
  // Lists hold 32-bit places.
  constexpr std::size_t kMost = std::numeric_limits<std::uint32_t>::max() / 2;
  if (items.size() > kMost)
    throw Error("a volume map holds no more than " + std::to_string(kMost) + " photons or pieces of beams at once",
                "Trace the photons in several passes.");
  const std::vector<std::uint32_t> order = order_of(items);
  std::vector<std::size_t> first;  // of each medium in the order
  std::size_t block_count = 0;
  const auto blocks_of = [](std::size_t count) { return (count + kVolumeBlock - 1) / kVolumeBlock; };
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Key key = items.key(order[i]);
    if (i > 0 && key == media_.back().key) continue;
    if (i > 0) block_count += blocks_of(i - first.back());
    media_.push_back({key, {}, 0, block_count, {}});
    first.push_back(i);
  }
  if (order.empty()) return;
  block_count += blocks_of(order.size() - first.back());
  first.push_back(order.size());
  blocks = LargeArray<Block>(block_count);
  for (std::size_t m = 0; m < media_.size(); ++m) {
    const std::span<const std::uint32_t> mine(order.data() + first[m], first[m + 1] - first[m]);
    const std::span<Block> own = blocks.span().subspan(media_[m].first_block, blocks_of(mine.size()));
    parallel_for(0, mine.size(), kVolumeRun, [&](std::size_t begin, std::size_t end) {
      std::array<CompactRow, kVolumeRun> rows, scratch;
      alignas(64) std::array<float, kVolumeRun> column;
      for (std::size_t i = begin; i < end; ++i) {
        rows[i - begin] = items.row(mine[i]);
        rows[i - begin].set_index(mine[i]);
      }
      compact_sort(std::span(rows).first(end - begin), scratch, column);
      for (std::size_t i = begin; i < blocks_of(end) * kVolumeBlock; ++i) {
        Block& block = own[i / kVolumeBlock];
        const std::size_t lane = i % kVolumeBlock;
        items.fill(block, lane, rows[std::min(i, end - 1) - begin].index());
        if (i >= end) block.r[lane] = block.g[lane] = block.b[lane] = 0;
      }
    });
    build_nodes<Block>(media_[m], own);
  }
}

template <class Block>
void VolumeIndex::build_nodes(Medium& medium, std::span<const Block> blocks) {
  std::size_t children = blocks.size(), first_child = 0;
  do {
    const std::size_t first = nodes_.size(), count = (children + kVolumeBlock - 1) / kVolumeBlock;
    const bool lowest = medium.level_first.empty();
    medium.level_first.push_back(first);
    nodes_.resize(first + count);
    parallel_for_each(count, kVolumeGrain, [&](std::size_t i) {
      for (std::size_t c = 0; c < kVolumeBlock; ++c) {
        const std::size_t child = i * kVolumeBlock + c;
        set_child(nodes_[first + i], c,
                  child >= children ? ReachBox{}
                  : lowest          ? bounds_of_block(blocks[child])
                                    : bounds_of_node(nodes_[first_child + child]));
      }
    });
    first_child = first;
    children = count;
  } while (children > 1);
  double mean_reach = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const VolumeNode& node = nodes_[medium.level_first[0] + i / kVolumeBlock];
    const std::size_t c = i % kVolumeBlock;
    mean_reach += node.radius[c] + std::max({node.half_x[c], node.half_y[c], node.half_z[c]});
  }
  medium.reach = static_cast<float>(mean_reach / static_cast<double>(blocks.size()));
  const ReachBox all = bounds_of_node(nodes_[medium.level_first.back()]);
  const Vec3 reach{all.radius, all.radius, all.radius};
  medium.bounds = {all.box.min - reach, all.box.max + reach};
}

VolumeTree VolumeIndex::tree(const Medium& medium) const {
  VolumeTree tree;
  if (has_beams())
    tree.beams = beams_.data() + medium.first_block;
  else
    tree.photons = photons_.data() + medium.first_block;
  tree.levels = static_cast<int>(medium.level_first.size());
  for (std::size_t level = 0; level < medium.level_first.size(); ++level)
    tree.level[level] = nodes_.data() + medium.level_first[level];
  return tree;
}

namespace {

/// All levels together hold less than 1/7 of a node for each block, plus one node for each level.
std::uint64_t bytes_of_blocks(std::size_t items, std::size_t block_bytes) {
  const std::uint64_t blocks = (items + kVolumeBlock - 1) / kVolumeBlock;
  return blocks * block_bytes + (blocks / 7 + 12) * sizeof(VolumeNode);
}

}  // namespace

std::uint64_t VolumeIndex::photon_bytes(std::size_t photons) {
  return bytes_of_blocks(photons, sizeof(VolumePhotonBlock));
}
// Copies of beams in other parts are no more than the beams.
std::uint64_t VolumeIndex::piece_bytes(std::size_t pieces) { return bytes_of_blocks(2 * pieces, sizeof(BeamBlock)); }

}  // namespace glowworm
