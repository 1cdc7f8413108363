#include "density/volume_radii.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include "core/parallel.h"
#include "core/random.h"
#include "core/rgb.h"
#include "density/knn.h"

namespace glowworm {

namespace {

// Fewer neighbours would give noisy radii.
constexpr std::size_t kLeastNeighbours = 16;
// Beams that cross a sphere, as a share of those that a segment crosses. With as many, blur brightens a hazy room with
// one window by 0.6%.
constexpr double kOfSphere = 0.25;
// Pieces of a beam of mean length. More pieces have tighter boxes and radii, and take more memory.
constexpr std::size_t kMeanPieces = 4;
// Shorter pieces would have no tighter boxes.
constexpr double kLeastRadii = 4;
constexpr std::size_t kRadiusGrain = 64, kItemGrain = 1024;
// Lone photons blur over no more than this multiple of the median radius, or this share of their box's diagonal,
// whichever is larger.
constexpr float kMostMedians = 8, kMostOfDiagonal = 1.0f / 16;
// Beams of more flux than the median are wider, as the root of their flux, by at most this.
constexpr float kMostWider = 8;
// Where photons are densest, in a focus or at a lamp, radii are no smaller than this share of the median.
constexpr float kLeastOfMedian = 1.0f / 32;

/// A radius for every place, from the density of items around it: the same in each leaf of a kd-tree, and similar in
/// neighbouring leaves, as the distance to the n-th neighbour changes no faster than the place.
class RadiusField {
 public:
  /// @param radius_of the radius where so many items are in a cubic metre
  template <class RadiusOf>
  RadiusField(std::span<const Vec3> items, std::size_t neighbours, const RadiusOf& radius_of) {
    // Normals play no part.
    places_.build(items, items, {});
    for (const KdNode& node : places_.tree().nodes)
      if (node.is_leaf()) leaves_.push_back(node);
    radius_.resize(items.size());
    parallel_for(0, leaves_.size(), kRadiusGrain, [&](std::size_t first, std::size_t last) {
      std::vector<std::uint64_t> found(neighbours);
      for (std::size_t i = first; i < last; ++i) {
        const double density = density_of(leaves_[i], found);
        radius_[leaves_[i].first()] = density > 0 ? static_cast<float>(radius_of(density)) : 0.0f;
      }
    });
    bound_radii();
  }

  float at(Vec3 place) const {
    const std::vector<KdNode>& nodes = places_.tree().nodes;
    std::size_t i = 0;
    while (!nodes[i].is_leaf()) i += place[nodes[i].axis()] <= nodes[i].split ? 1 : nodes[i].right_offset();
    return radius_[nodes[i].first()];
  }

  /// Calls set(item, radius) for each item.
  template <class Set>
  void for_items(const Set& set) const {
    parallel_for_each(leaves_.size(), kRadiusGrain, [&](std::size_t i) {
      const std::uint32_t first = leaves_[i].first();
      for (std::uint32_t p = first; p < first + leaves_[i].count; ++p) set(places_.index(p), radius_[first]);
    });
  }
  /// Calls work(number of items, radius) for each leaf.
  template <class Work>
  void for_leaves(const Work& work) const {
    for (const KdNode& leaf : leaves_) work(leaf.count, radius_[leaf.first()]);
  }

 private:
  /// In a sphere around the middle of a leaf, m^-3; 0 if it is unknown.
  double density_of(const KdNode& leaf, std::span<std::uint64_t> found) const {
    Vec3 mean{0, 0, 0};
    for (std::uint32_t n = 0; n < leaf.count; ++n)
      mean += (places_.tree().points[leaf.first() + n].position - mean) / static_cast<float>(n + 1);
    constexpr float kNoLimit = std::numeric_limits<float>::infinity();
    std::uint64_t tested = 0;
    const std::size_t count = places_.nearest(mean, mean, -kNoLimit, found.size(), kNoLimit, found, tested);
    double squared = 0;
    for (const std::uint64_t packed : found.first(count))
      squared = std::max(squared, double{PhotonPlaces::unpack(packed).distance_squared});
    const double volume = 4 * std::numbers::pi / 3 * squared * std::sqrt(squared);
    return volume > 0 ? static_cast<double>(count) / volume : 0;
  }

  /// Makes radii positive and finite, and bounds them.
  void bound_radii() {
    const float diagonal = length(places_.tree().bounds.diagonal());
    std::vector<float> known;
    for (const KdNode& leaf : leaves_)
      if (radius_[leaf.first()] > 0 && std::isfinite(radius_[leaf.first()])) known.push_back(radius_[leaf.first()]);
    float median = 0;
    if (!known.empty()) {
      const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
      std::nth_element(known.begin(), middle, known.end());
      median = *middle;
    }
    // All coincide: their density is unknown, and the size of their box is the best estimate.
    if (!(median > 0)) median = diagonal > 0 ? diagonal / 100 : 1e-3f;
    const float low = median * kLeastOfMedian, high = std::max(median * kMostMedians, diagonal * kMostOfDiagonal);
    for (const KdNode& leaf : leaves_) {
      float& radius = radius_[leaf.first()];
      radius = std::isfinite(radius) ? std::clamp(radius, low, high) : median;
    }
  }

  PhotonPlaces places_;
  std::vector<KdNode> leaves_;
  std::vector<float> radius_;  // of a leaf, at its first item
};

/// The items that have a finite place, by medium.
template <class Place>
std::vector<std::uint32_t> by_medium(std::span<const std::uint32_t> medium, const Place& place) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < medium.size(); ++i)
    if (is_finite(place(i))) order.push_back(i);
  const auto before = [&](std::uint32_t a, std::uint32_t b) { return medium[a] < medium[b]; };
  if (!std::is_sorted(order.begin(), order.end(), before)) std::stable_sort(order.begin(), order.end(), before);
  return order;
}

/// Calls work(items) for the items of each medium. @param order by_medium()
template <class Work>
void for_media(std::span<const std::uint32_t> order, std::span<const std::uint32_t> medium, const Work& work) {
  for (std::size_t first = 0; first < order.size();) {
    std::size_t last = first;
    while (last < order.size() && medium[order[last]] == medium[order[first]]) ++last;
    work(order.subspan(first, last - first));
    first = last;
  }
}

/// The pieces of some beams that follow one another.
struct PiecesOfBeams {
  std::vector<std::uint32_t> count;  // of each beam
  std::vector<float> end, radii;
};

/// Cuts the beams of a medium.
class BeamCutter {
 public:
  /// @param crossing beams that cross a sphere of the radius
  BeamCutter(const VolumeBeams& all, std::span<const std::uint32_t> mine, double crossing)
      : beams_(all), mine_(mine), parts_((mine.size() + kItemGrain - 1) / kItemGrain) {
    set_median_flux();
    double length = 0;
    for (const std::uint32_t i : mine) length += length_of(i);
    const double beams = static_cast<double>(mine.size()), step = length / (kMeanPieces * beams);
    // A place at random on each of equal parts. Their density times their length is the length of beams in a volume.
    std::vector<Vec3> places;
    for (const std::uint32_t i : mine) {
      const std::uint32_t count =
          step > 0 ? std::max(1u, static_cast<std::uint32_t>(std::ceil(length_of(i) / step))) : 1;
      for (std::uint32_t n = 0; n < count; ++n) {
        const float random = to_unit_float(hash_combine(hash_combine(0x6265616du, i), n));
        places.push_back(place(i, length_of(i) * ((static_cast<float>(n) + random) / static_cast<float>(count))));
      }
    }
    const double mean = length / static_cast<double>(places.size());
    field_.emplace(places, kLeastNeighbours,
                   [&](double density) { return std::sqrt(crossing / (std::numbers::pi * density * mean)); });
    // With this length, in radii, a beam has kMeanPieces on average.
    double radii = 0;
    field_->for_leaves([&](std::uint32_t count, float radius) { radii += count * (mean / radius); });
    radii_ = static_cast<float>(std::max(kLeastRadii, radii / (kMeanPieces * beams)));
    // Lines cross a sphere of radius r as often as its section pi r^2, and a tube of length L as often as its mean
    // projection pi r L / 2. The mean beam is as long as radii / beams.
    crossed_ = crossing / 2 * radii / beams;
    for (;;) {
      const std::size_t count = cut_all(), most = BeamPieces::most(mine.size());
      if (count <= most) break;
      radii_ *= 1.1f * static_cast<float>(count) / static_cast<float>(most);
    }
  }

  /// How many beams a segment as long as the mean beam crosses, on average over places along beams.
  double crossed() const { return crossed_; }

  /// Calls add(beam, pieces, place of the first in `pieces`, their number) for each beam.
  template <class Add>
  void for_beams(const Add& add) const {
    parallel_for_each(parts_.size(), 1, [&](std::size_t p) {
      std::size_t at = 0;
      for (std::size_t n = 0; n < parts_[p].count.size(); at += parts_[p].count[n++])
        add(mine_[p * kItemGrain + n], parts_[p], at, parts_[p].count[n]);
    });
  }

 private:
  /// Cuts all beams; returns the number of pieces.
  std::size_t cut_all() {
    parallel_for(0, mine_.size(), kItemGrain, [&](std::size_t first, std::size_t last) {
      PiecesOfBeams& part = parts_[first / kItemGrain];
      part = {};
      for (std::size_t i = first; i < last; ++i) {
        const std::size_t before = part.end.size();
        cut(mine_[i], part);
        part.count.push_back(static_cast<std::uint32_t>(part.end.size() - before));
      }
    });
    std::size_t count = 0;
    for (const PiecesOfBeams& part : parts_) count += part.end.size();
    return count;
  }

  void cut(std::uint32_t i, PiecesOfBeams& part) const {
    const float length = length_of(i);
    const float wider = wider_of(i);
    float begin = 0, radius = field_->at(place(i, 0));
    for (;;) {
      // Halfway beams may be denser, so the piece is shorter.
      const float halfway = field_->at(place(i, (begin + std::min(begin + radii_ * radius, length)) / 2));
      const float end = begin + radii_ * std::min(radius, halfway);
      const bool last = !(end < length) || end == begin;
      part.end.push_back(last ? length : end);
      part.radii.push_back(halfway * wider);
      if (last) return;
      begin = end;
      radius = halfway;
    }
  }

  void set_median_flux() {
    std::vector<float> flux;
    for (const std::uint32_t i : mine_)
      if (is_finite(beams_.flux[i])) flux.push_back(luminance(beams_.flux[i]));
    const auto middle = flux.begin() + static_cast<std::ptrdiff_t>(flux.size() / 2);
    std::nth_element(flux.begin(), middle, flux.end());
    median_flux_ = middle != flux.end() ? *middle : 0.0f;
  }
  /// Guided emission leaves a few beams with most of the flux, which would be seen as streaks.
  float wider_of(std::uint32_t i) const {
    const float flux = luminance(beams_.flux[i]);
    if (!(median_flux_ > 0) || !(flux > median_flux_)) return 1;
    return std::min(std::sqrt(flux / median_flux_), kMostWider);
  }

  float length_of(std::size_t i) const {
    return std::isfinite(beams_.length[i]) && beams_.length[i] > 0 ? beams_.length[i] : 0.0f;
  }
  Vec3 place(std::size_t i, float distance) const { return beams_.origin[i] + beams_.direction[i] * distance; }

  const VolumeBeams& beams_;
  const std::span<const std::uint32_t> mine_;
  std::optional<RadiusField> field_;
  float radii_ = 0;  // length of a piece
  double crossed_ = 0;
  float median_flux_ = 0;
  std::vector<PiecesOfBeams> parts_;
};

}  // namespace

PhotonKernels volume_photon_kernels(const VolumePhotons& photons, std::uint32_t k) {
  PhotonKernels kernels;
  // The radii of photons that are nowhere are never read.
  kernels.radii.assign(photons.size(), 1.0f);
  kernels.walls.assign(photons.size(), {Vec3{0, 0, 0}, Vec3{0, 0, 0}});
  const auto place = [&](std::uint32_t i) { return photons.position[i]; };
  for_media(by_medium(photons.medium, place), photons.medium, [&](std::span<const std::uint32_t> items) {
    std::vector<Vec3> places(items.size());
    parallel_for_each(items.size(), kItemGrain, [&](std::size_t i) { places[i] = place(items[i]); });
    const double held = std::max(k, 1u);
    const RadiusField field(places, std::max<std::size_t>(k, kLeastNeighbours),
                            [&](double density) { return std::cbrt(held * 3 / (4 * std::numbers::pi * density)); });
    field.for_items([&](std::uint32_t i, float radius) { kernels.radii[items[i]] = radius; });
  });
  return kernels;
}

std::size_t BeamPieces::most(std::size_t beams) { return beams * (kMeanPieces + 1); }

BeamPieces volume_beam_pieces(const VolumeBeams& beams, std::uint32_t k) {
  BeamPieces pieces;
  pieces.first.assign(beams.size() + 1, 0);
  std::deque<BeamCutter> cutters;
  const auto place = [&](std::uint32_t i) { return beams.origin[i] + beams.direction[i]; };
  const std::vector<std::uint32_t> order = by_medium(beams.medium, place);
  for_media(order, beams.medium, [&](std::span<const std::uint32_t> items) {
    cutters.emplace_back(beams, items, std::max(kOfSphere * k, 1.0))
        .for_beams([&](std::uint32_t i, const PiecesOfBeams&, std::size_t, std::uint32_t count) {
          pieces.first[i + 1] = count;
        });
    const std::uint32_t medium = beams.medium[items[0]];
    pieces.parts.resize(std::max<std::size_t>(pieces.parts.size(), medium + 1), 1);
    pieces.parts[medium] = static_cast<std::uint32_t>(
        std::clamp(cutters.back().crossed() / std::max(k, 1u), 1.0, static_cast<double>(items.size())));
  });
  std::partial_sum(pieces.first.begin(), pieces.first.end(), pieces.first.begin());
  pieces.end.resize(pieces.first.back());
  pieces.radii.resize(pieces.first.back());
  for (const BeamCutter& cutter : cutters)
    cutter.for_beams([&](std::uint32_t i, const PiecesOfBeams& from, std::size_t at, std::uint32_t count) {
      std::copy_n(from.end.begin() + static_cast<std::ptrdiff_t>(at), count, pieces.end.begin() + pieces.first[i]);
      std::copy_n(from.radii.begin() + static_cast<std::ptrdiff_t>(at), count, pieces.radii.begin() + pieces.first[i]);
    });
  return pieces;
}

}  // namespace glowworm
