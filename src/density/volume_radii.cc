#include "density/volume_radii.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/box.h"
#include "core/parallel.h"
#include "core/random.h"
#include "density/knn.h"

namespace glowworm {

namespace {

// Fewer neighbours would give noisy radii.
constexpr std::size_t kLeastNeighbours = 16;
// Pieces of a beam of mean length. More pieces have tighter boxes and radii, and take more memory.
constexpr std::size_t kMeanPieces = 8;
constexpr std::size_t kRadiusGrain = 64;
// Lone photons blur over no more than this multiple of the median radius, or this share of their box's diagonal,
// whichever is larger.
constexpr float kMostMedians = 8, kMostOfDiagonal = 1.0f / 16;

/// The mean number of items in a cubic metre around a place, by the distance to the nearest ones.
struct LocalDensity {
  double per_volume = 0;
  bool known = false;
};

/// Calls set(item, density) for the items of each medium. Neighbours in leaves of a kd-tree share a density, which
/// changes slowly from leaf to leaf: the distance to the n-th neighbour changes no faster than the place.
template <class Set>
void find_densities(std::span<const Vec3> place, std::span<const std::uint32_t> item, std::size_t neighbours,
                    const Set& set) {
  PhotonPlaces places;
  // Normals play no part.
  places.build(place, place, {});
  std::vector<KdNode> leaves;
  for (const KdNode& node : places.tree().nodes)
    if (node.is_leaf()) leaves.push_back(node);
  parallel_for(0, leaves.size(), kRadiusGrain, [&](std::size_t first, std::size_t last) {
    std::vector<std::uint64_t> found(neighbours);
    std::uint64_t tested = 0;
    for (std::size_t i = first; i < last; ++i) {
      const std::uint32_t begin = leaves[i].first(), end = begin + leaves[i].count;
      Vec3 mean{0, 0, 0};
      for (std::uint32_t p = begin; p < end; ++p)
        mean += (places.tree().points[p].position - mean) / static_cast<float>(p - begin + 1);
      const std::size_t count = places.nearest(mean, mean, -std::numeric_limits<float>::infinity(), neighbours,
                                               std::numeric_limits<float>::infinity(), found, tested);
      double squared = 0;
      for (std::size_t n = 0; n < count; ++n)
        squared = std::max(squared, double{PhotonPlaces::unpack(found[n]).distance_squared});
      const double volume = 4 * std::numbers::pi / 3 * squared * std::sqrt(squared);
      const LocalDensity density{static_cast<double>(count) / volume, volume > 0};
      for (std::uint32_t p = begin; p < end; ++p) set(item[places.index(p)], density);
    }
  });
}

/// Calls work(places, items) for the items of each medium that have a finite place.
template <class Medium, class Place, class Work>
void for_media(std::size_t count, const Medium& medium, const Place& place, const Work& work) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < count; ++i)
    if (is_finite(place(i))) order.push_back(i);
  const auto before = [&](std::uint32_t a, std::uint32_t b) { return medium(a) < medium(b); };
  if (!std::is_sorted(order.begin(), order.end(), before)) std::stable_sort(order.begin(), order.end(), before);
  for (std::size_t first = 0; first < order.size();) {
    std::size_t last = first;
    while (last < order.size() && medium(order[last]) == medium(order[first])) ++last;
    const std::span<const std::uint32_t> items(order.data() + first, last - first);
    std::vector<Vec3> places(items.size());
    parallel_for_each(items.size(), 1024, [&](std::size_t i) { places[i] = place(items[i]); });
    work(places, items);
    first = last;
  }
}

/// Makes the radii of a medium's items positive and finite, and bounds them. Unknown ones are 0.
void bound_medium_radii(std::vector<float>& radii, std::span<const std::uint32_t> items, std::span<const Vec3> places) {
  Box3 box;
  for (const Vec3& p : places) box.grow(p);
  const float diagonal = length(box.diagonal());
  std::vector<float> known;
  for (const std::uint32_t i : items)
    if (radii[i] > 0 && std::isfinite(radii[i])) known.push_back(radii[i]);
  float median = 0;
  if (!known.empty()) {
    const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
    std::nth_element(known.begin(), middle, known.end());
    median = *middle;
  }
  // All coincide: their density is unknown, and the size of their box is the best estimate.
  if (!(median > 0)) median = diagonal > 0 ? diagonal / 100 : 1e-3f;
  const float low = median * 1e-3f, high = std::max(median * kMostMedians, diagonal * kMostOfDiagonal);
  for (const std::uint32_t i : items) radii[i] = std::isfinite(radii[i]) ? std::clamp(radii[i], low, high) : median;
}

}  // namespace

std::vector<float> volume_photon_radii(const VolumePhotons& photons, std::uint32_t k) {
  // The radii of photons that are nowhere are never read.
  std::vector<float> radii(photons.size(), 1.0f);
  const double held = std::max(k, 1u);
  const auto place = [&](std::uint32_t i) { return photons.position[i]; };
  const auto medium = [&](std::uint32_t i) { return photons.medium[i]; };
  for_media(photons.size(), medium, place, [&](const auto& places, std::span<const std::uint32_t> items) {
    const std::size_t neighbours = std::max<std::size_t>(k, kLeastNeighbours);
    find_densities(places, items, neighbours, [&](std::uint32_t i, const LocalDensity& density) {
      radii[i] =
          density.known ? static_cast<float>(std::cbrt(held * 3 / (4 * std::numbers::pi * density.per_volume))) : 0.0f;
    });
    bound_medium_radii(radii, items, places);
  });
  return radii;
}

std::size_t BeamPieces::most(std::size_t beams) { return beams * (kMeanPieces + 1); }

BeamPieces volume_beam_pieces(const VolumeBeams& beams, std::uint32_t k) {
  const auto length_of = [&](std::size_t i) {
    return std::isfinite(beams.length[i]) && beams.length[i] > 0 ? double{beams.length[i]} : 0.0;
  };
  double all = 0;
  for (std::size_t i = 0; i < beams.size(); ++i) all += length_of(i);
  const double mean_piece = all / (static_cast<double>(kMeanPieces) * static_cast<double>(beams.size()));
  BeamPieces pieces;
  pieces.first.resize(beams.size() + 1);
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < beams.size(); ++i) {
    pieces.first[i] = count;
    count += mean_piece > 0 ? std::max(1u, static_cast<std::uint32_t>(std::ceil(length_of(i) / mean_piece))) : 1;
  }
  pieces.first[beams.size()] = count;
  pieces.radii.assign(count, 1.0f);

  // A place at random on each piece. The density of these places times the length of a piece is the length of beams in
  // a volume; the radius is that of a sphere which k of such beams cross.
  LargeArray<std::uint32_t> beam(count);
  LargeArray<Vec3> at(count);
  parallel_for_each(beams.size(), 1024, [&](std::size_t i) {
    const std::uint32_t first = pieces.first[i], last = pieces.first[i + 1];
    for (std::uint32_t piece = first; piece < last; ++piece) {
      const float share = static_cast<float>(piece - first) + to_unit_float(hash_combine(0x6265616du, piece));
      beam[piece] = static_cast<std::uint32_t>(i);
      at[piece] = beams.origin[i] +
                  beams.direction[i] * (static_cast<float>(length_of(i)) * (share / static_cast<float>(last - first)));
    }
  });
  const double crossing = std::max(k, 1u);
  const auto place = [&](std::uint32_t piece) { return at[piece]; };
  const auto medium = [&](std::uint32_t piece) { return beams.medium[beam[piece]]; };
  for_media(count, medium, place, [&](const auto& places, std::span<const std::uint32_t> items) {
    double length = 0;
    for (const std::uint32_t piece : items) {
      const std::uint32_t i = beam[piece];
      length += length_of(i) / (pieces.first[i + 1] - pieces.first[i]);
    }
    length /= static_cast<double>(items.size());
    find_densities(places, items, kLeastNeighbours, [&](std::uint32_t piece, const LocalDensity& density) {
      pieces.radii[piece] =
          density.known ? static_cast<float>(std::sqrt(crossing / (std::numbers::pi * density.per_volume * length)))
                        : 0.0f;
    });
    bound_medium_radii(pieces.radii, items, places);
  });
  return pieces;
}

}  // namespace glowworm
