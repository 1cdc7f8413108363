#include "density/volume_map.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "core/hilbert.h"
#include "core/parallel.h"
#include "core/radix_sort.h"
#include "density/compact_sort.h"

namespace glowworm {

namespace {

// Segments that are sorted together, after keys have grouped them.
constexpr std::size_t kSegmentRun = 512;
// Bits of a key for each axis.
constexpr int kSegmentBits = 10;
// Bounds on the rounding of the distance between a segment and a photon, as a share of the coordinates.
constexpr double kDistanceRounding = 4e-6;
// Segments meet a photon together if their bounds are narrower than this multiple of the reach of a block's photons.
// (Measured with bench/volume_bench.cc.)
constexpr float kWidest = 1;
constexpr std::uint32_t kNoMedium = ~std::uint32_t{0};

/// A segment, and the part of its medium (in the index).
using SegmentInPart = KeyedIndex<std::uint32_t>;

/// The part of a segment within a box.
struct Clipped {
  double from = 0, to = -1;  ///< metres from the origin; empty if to < from
};

Clipped clip(const Box3& box, Vec3 origin, Vec3 direction, float length) {
  double from = 0, to = length, farthest = 0;
  for (int axis = 0; axis < 3; ++axis)
    farthest = std::max(
        {farthest, std::abs(double{box.min[axis]}), std::abs(double{box.max[axis]}), std::abs(double{origin[axis]})});
  const double rounding = kDistanceRounding * farthest;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.min[axis] - rounding - origin[axis], high = box.max[axis] + rounding - origin[axis];
    const double d = direction[axis];
    if (d == 0) {
      if (low > 0 || high < 0) return {};
      continue;
    }
    from = std::max(from, std::min(low / d, high / d));
    to = std::min(to, std::max(low / d, high / d));
  }
  return {from, to};
}

bool counts(const VolumeSegments& segments, std::size_t i) {
  const SegmentMedium& medium = segments.medium[i];
  return segments.length[i] > 0 && is_finite(segments.origin[i]) && is_finite(segments.direction[i]) &&
         is_finite(medium.sigma_t) && is_finite(medium.sigma_s) && std::abs(medium.g) < 1;
}

Vec3 along(const VolumeSegments& segments, std::size_t i, double distance) {
  return segments.origin[i] + segments.direction[i] * static_cast<float>(distance);
}

/// Octants of both ends by turns, the largest first: segments with a common beginning of their keys are near along
/// all of their way.
std::uint64_t key_of_ends(const CubeGrid& grid, Vec3 a, Vec3 b) {
  const std::uint64_t first = grid.morton(a), second = grid.morton(b);
  std::uint64_t key = 0;
  for (int level = kSegmentBits - 1; level >= 0; --level)
    key = key << 6 | (first >> 3 * level & 7) << 3 | (second >> 3 * level & 7);
  return key;
}

/// The part of a medium that a segment meets.
VolumeIndex::Key chosen_part(const VolumeIndex& index, const SegmentMedium& medium) {
  const std::uint32_t parts = index.parts(medium.index);
  return {medium.index, static_cast<std::uint32_t>(double{medium.random} * parts)};
}

/// The segments that may see something: by part, and in each by where they enter and leave its box.
std::vector<SegmentInPart> sorted_segments(const VolumeIndex& index, const VolumeSegments& segments) {
  const std::span<const VolumeIndex::Medium> media = index.media();
  std::vector<CubeGrid> grids;
  for (const VolumeIndex::Medium& medium : media) grids.emplace_back(medium.bounds, kSegmentBits);
  std::vector<KeyedIndex<std::uint64_t>> by_ends(segments.size());
  std::vector<std::uint32_t> parts(segments.size(), kNoMedium);
  parallel_for_each(segments.size(), 4096, [&](std::size_t i) {
    by_ends[i] = {0, static_cast<std::uint32_t>(i)};
    if (!counts(segments, i)) return;
    const VolumeIndex::Key wanted = chosen_part(index, segments.medium[i]);
    const auto found = std::lower_bound(media.begin(), media.end(), wanted,
                                        [](const auto& medium, VolumeIndex::Key key) { return medium.key < key; });
    if (found == media.end() || found->key != wanted) return;
    const Clipped part = clip(found->bounds, segments.origin[i], segments.direction[i], segments.length[i]);
    if (!(part.from <= part.to)) return;
    parts[i] = static_cast<std::uint32_t>(found - media.begin());
    by_ends[i].key = key_of_ends(grids[parts[i]], along(segments, i, part.from), along(segments, i, part.to));
  });
  radix_sort(by_ends, 6 * kSegmentBits);
  std::vector<SegmentInPart> sorted;
  sorted.reserve(segments.size());
  for (const auto& [key, segment] : by_ends)
    if (parts[segment] != kNoMedium) sorted.push_back({parts[segment], segment});
  radix_sort(sorted, std::bit_width(media.size()));
  return sorted;
}

/// Grows the bounds of a tile around the ends of its segments.
class TileBounds {
 public:
  void add(const CompactRow& row, Vec3 direction) {
    Ends& e = ends_[count_++];
    for (int axis = 0; axis < 3; ++axis) {
      e.at[0][axis] = row.coordinate[axis];
      e.at[1][axis] = row.coordinate[axis + 3];
      point_[axis] += e.at[0][axis];
      axis_[axis] += direction[axis];
    }
    first_direction_ = count_ == 1 ? direction : first_direction_;
  }

  /// @param rounding metres
  SegmentBounds bounds(double rounding) {
    set_axis();
    double low = std::numeric_limits<double>::infinity(), high = -low, slope = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      Ends& e = ends_[i];
      for (int end = 0; end < 2; ++end) split(e, end);
      low = std::min({low, e.s[0], e.s[1]});
      high = std::max({high, e.s[0], e.s[1]});
      if (e.s[1] > e.s[0]) slope = std::max(slope, (e.away[1] - e.away[0]) / (e.s[1] - e.s[0]));
    }
    SegmentBounds out{};
    double best = std::numeric_limits<double>::infinity();
    // A cylinder, the cone of the steepest segment, or one in between: the narrowest halfway.
    for (const double share : {0.0, 0.5, 1.0}) {
      const double width = width_of(share * slope), halfway = width + share * slope * (low + high) / 2;
      if (halfway >= best) continue;
      best = halfway;
      out.width = static_cast<float>(width);
      out.slope = static_cast<float>(share * slope);
    }
    for (int axis = 0; axis < 3; ++axis) {
      out.point[axis] = static_cast<float>(point_[axis]);
      out.axis[axis] = static_cast<float>(axis_[axis]);
    }
    out.low = static_cast<float>(low);
    out.high = static_cast<float>(high);
    out.rounding = static_cast<float>(rounding);
    return out;
  }

 private:
  struct Ends {
    double at[2][3], s[2], away[2];
  };

  void set_axis() {
    double squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
      point_[axis] = static_cast<float>(point_[axis] / static_cast<double>(count_));
      squared += axis_[axis] * axis_[axis];
    }
    // Opposite directions have no mean.
    const bool known = squared > 1e-6;
    for (int axis = 0; axis < 3; ++axis)
      axis_[axis] = static_cast<float>(known ? axis_[axis] / std::sqrt(squared) : first_direction_[axis]);
  }
  void split(Ends& e, int end) const {
    double squared = 0;
    e.s[end] = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double way = e.at[end][axis] - point_[axis];
      squared += way * way;
      e.s[end] += way * axis_[axis];
    }
    e.away[end] = std::sqrt(std::max(0.0, squared - e.s[end] * e.s[end]));
  }
  double width_of(double slope) const {
    double width = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < count_; ++i)
      for (int end = 0; end < 2; ++end) width = std::max(width, ends_[i].away[end] - slope * ends_[i].s[end]);
    return width;
  }

  std::array<Ends, kSegmentTile> ends_;
  std::size_t count_ = 0;
  double point_[3] = {0, 0, 0}, axis_[3] = {0, 0, 0};
  Vec3 first_direction_;
};

/// Sums runs of segments. Holds the memory of one thread.
class SegmentWorker {
 public:
  SegmentWorker(const VolumeIndex& index, const VolumeSegments& segments, std::span<RGB> found)
      : index_(index), segments_(segments), found_(found) {}

  /// Segments of one medium, at most kSegmentRun.
  void work(std::span<const SegmentInPart> run) {
    const VolumeIndex::Medium& medium = index_.media()[run[0].key];
    const VolumeTree tree = index_.tree(medium);
    for (std::size_t i = 0; i < run.size(); ++i) {
      const std::uint32_t s = run[i].index;
      const Clipped part = clip(medium.bounds, segments_.origin[s], segments_.direction[s], segments_.length[s]);
      const Vec3 a = along(segments_, s, part.from), b = along(segments_, s, part.to);
      // A radius of 1 weighs both ends alike.
      rows_[i] = {{a.x, a.y, a.z, b.x, b.y, b.z, 1, 0}};
      rows_[i].set_index(s);
    }
    compact_sort(std::span(rows_).first(run.size()), scratch_rows_, column_);
    for (std::size_t first = 0; first < run.size(); first += kSegmentTile)
      sum_tiles(tree, medium.reach,
                std::span(rows_).subspan(first, std::min<std::size_t>(kSegmentTile, run.size() - first)));
  }

  VolumeCounts counts;

 private:
  /// Sums segments together if they have most photons in common, or in two parts. @param reach of a block's photons
  void sum_tiles(const VolumeTree& tree, float reach, std::span<const CompactRow> rows) {
    TileBounds ends;
    double farthest = 0;
    for (const CompactRow& row : rows) {
      const std::uint32_t s = row.index();
      ends.add(row, segments_.direction[s]);
      for (int axis = 0; axis < 3; ++axis)
        farthest = std::max({farthest, std::abs(double{segments_.origin[s][axis]}),
                             std::abs(double{row.coordinate[axis]}), std::abs(double{row.coordinate[axis + 3]})});
    }
    // Three coordinates, each at most so far from the origin of the segment.
    const SegmentBounds bounds = ends.bounds(kDistanceRounding * 4 * farthest);
    const std::size_t lanes = rows.size();
    if (lanes == 1 || bounds.width + bounds.slope * (bounds.low + bounds.high) / 2 < kWidest * reach)
      return sum_tile(tree, bounds, rows);
    const std::size_t half = lanes > kSegmentTile / 2 ? lanes / 2 : 1;
    for (std::size_t first = 0; first < lanes; first += half)
      sum_tiles(tree, reach, rows.subspan(first, std::min(half, lanes - first)));
  }

  void sum_tile(const VolumeTree& tree, const SegmentBounds& bounds, std::span<const CompactRow> rows) {
    tile_.count = rows.size();
    tile_.grey = tile_.isotropic = true;
    for (std::size_t lane = 0; lane < kSegmentTile; ++lane) {
      set_lane(lane, rows[std::min(lane, rows.size() - 1)].index());
      if (lane >= rows.size()) tile_.length[lane] = -1;
    }
    tile_.bounds = bounds;
    sum_volume(tree, tile_, scratch_, counts);
    for (std::size_t lane = 0; lane < rows.size(); ++lane) {
      const SegmentMedium& medium = segments_.medium[rows[lane].index()];
      const float phase =
          (1 - medium.g * medium.g) * (0.25f * kInversePi) * static_cast<float>(index_.parts(medium.index));
      const RGB sum = RGB(tile_.sum[0][lane], tile_.sum[1][lane], tile_.sum[2][lane]) * phase;
      found_[rows[lane].index()] += index_.has_beams() ? sum * medium.sigma_s : sum;
    }
  }

  void set_lane(std::size_t lane, std::uint32_t s) {
    const SegmentMedium& medium = segments_.medium[s];
    for (int axis = 0; axis < 3; ++axis) {
      tile_.origin[axis][lane] = segments_.origin[s][axis];
      tile_.direction[axis][lane] = segments_.direction[s][axis];
      tile_.sigma_t[axis][lane] = medium.sigma_t[axis];
    }
    tile_.length[lane] = segments_.length[s];
    tile_.g[lane] = medium.g;
    tile_.grey &= medium.sigma_t.r == medium.sigma_t.g && medium.sigma_t.g == medium.sigma_t.b;
    tile_.isotropic &= medium.g == 0;
  }

  const VolumeIndex& index_;
  const VolumeSegments& segments_;
  const std::span<RGB> found_;
  VolumeScratch scratch_;
  SegmentTile tile_;
  std::array<CompactRow, kSegmentRun> rows_, scratch_rows_;
  alignas(64) std::array<float, kSegmentRun> column_;
};

}  // namespace

void VolumeMap::build(const VolumePhotons& photons, std::span<const RGB> flux, const PhotonKernels& kernels,
                      float scale, Statistics& statistics) {
  PhaseTimer timer(statistics, Phase::build_photon_map);
  index_ = VolumeIndex();
  index_ = VolumeIndex(photons, flux, kernels, scale);
}

void VolumeMap::build(const VolumeBeams& beams, std::span<const RGB> flux, const BeamPieces& pieces, float scale,
                      Statistics& statistics) {
  PhaseTimer timer(statistics, Phase::build_photon_map);
  index_ = VolumeIndex();
  index_ = VolumeIndex(beams, flux, pieces, scale);
}

void VolumeMap::estimate(const VolumeSegments& segments, std::span<RGB> found, Statistics& statistics) const {
  if (empty() || segments.size() == 0) return;
  std::vector<SegmentInPart> sorted;
  std::vector<std::span<const SegmentInPart>> runs;
  {
    PhaseTimer timer(statistics, Phase::reorder);
    sorted = sorted_segments(index_, segments);
    for (std::size_t first = 0; first < sorted.size();) {
      std::size_t last = first;
      while (last < sorted.size() && last < first + kSegmentRun && sorted[last].key == sorted[first].key) ++last;
      runs.emplace_back(sorted.data() + first, last - first);
      first = last;
    }
  }
  PhaseTimer timer(statistics, Phase::density);
  parallel_for(0, runs.size(), 1, [&](std::size_t first, std::size_t last) {
    const auto worker = std::make_unique<SegmentWorker>(index_, segments, found);
    for (std::size_t i = first; i < last; ++i) worker->work(runs[i]);
    statistics.add(Counter::shader_operations, worker->counts.evaluated);
    statistics.add(Counter::pairs_tested, worker->counts.tested);
    statistics.add(Counter::packet_steps, worker->counts.steps);
    statistics.add(Counter::packet_active_lanes, worker->counts.evaluated);
  });
}

std::uint64_t VolumeMap::photon_bytes(std::size_t photons) { return VolumeIndex::photon_bytes(photons); }
std::uint64_t VolumeMap::segment_bytes(std::size_t segments) {
  // Those by their ends, twice while they are sorted, and their parts.
  return segments * (2 * sizeof(KeyedIndex<std::uint64_t>) + sizeof(std::uint32_t));
}
std::uint64_t VolumeMap::beam_bytes(std::size_t beams) { return VolumeIndex::piece_bytes(BeamPieces::most(beams)); }

}  // namespace glowworm
