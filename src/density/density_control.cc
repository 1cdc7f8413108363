#include "density/density_control.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "core/parallel.h"
#include "core/random.h"
#include "density/knn.h"

namespace glowworm {

namespace {

// Number of neighbours that give the density and receive the flux.
constexpr std::uint32_t kNeighbours = 12;
// Photons whose normals have a dot product above this lie on one surface.
constexpr float kSameSurfaceCosine = 0.9f;
// Directions of neighbours must have a dot product above this. If the target cannot be reached, later rounds use lower
// values.
constexpr float kDirectionCosines[] = {0.9f, 0.7f, 0.4f, 0.0f, -1.1f};
// Largest share of photons that a round drops; more would use up the neighbours.
constexpr double kShareOfRound = 0.5;
constexpr std::size_t kControlGrain = 512;

/// The neighbours of a photon, by their places in the map.
struct Neighbourhood {
  std::array<std::uint32_t, kNeighbours> places;
  std::uint32_t count = 0;
  float area = 0;  ///< of the disc that holds them, m^2
};

/// Flux during redistribution, in double precision, because a photon may receive the flux of many.
struct Flux {
  double r = 0, g = 0, b = 0;
};

/// One round: the photons and their fates.
class Round {
 public:
  Round(const PhotonBatch& photons, std::vector<Flux>& flux) : photons_(photons), flux_(flux) {
    map_.build(photons.position, photons.normal, {});
    around_.resize(photons.size());
    parallel_for(0, photons.size(), kControlGrain, [&](std::size_t first, std::size_t last) {
      std::array<std::uint64_t, kNeighbours + 1> found;
      for (std::size_t i = first; i < last; ++i) find(static_cast<std::uint32_t>(i), found);
    });
  }

  /// The density threshold that leaves `target` photons: photon i stays with probability threshold / density.
  double threshold(std::size_t target) const {
    std::vector<double> areas;
    for (const Neighbourhood& n : around_) areas.push_back(n.count > 0 ? n.area / (n.count + 1) : 0);
    std::sort(areas.begin(), areas.end());
    // Photons with a larger area than the threshold's stay for certain; the others with probability area / threshold
    // area.
    double sum = 0;
    for (std::size_t i = 0; i < areas.size(); ++i) {
      sum += areas[i];
      const double certain = static_cast<double>(areas.size() - 1 - i), rest = static_cast<double>(target) - certain;
      if (rest <= 0 || sum <= 0) continue;
      const double next = i + 1 < areas.size() ? areas[i + 1] : std::numeric_limits<double>::infinity();
      if (sum / rest <= next) return rest / sum;
    }
    return 0;
  }

  /// Drops photons until `target` are left or no more may be dropped. Returns for each photon whether it stays.
  std::vector<bool> thin(std::size_t target, double threshold, float direction_cosine, std::uint32_t seed) {
    alive_.assign(photons_.size(), true);
    std::vector<std::uint32_t> order(photons_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [seed](std::uint32_t a, std::uint32_t b) {
      const std::uint32_t key_a = hash_combine(seed, a), key_b = hash_combine(seed, b);
      return key_a != key_b ? key_a < key_b : a < b;
    });
    std::size_t left = photons_.size();
    for (const std::uint32_t place : order) {
      if (left <= target) break;
      if (density(place) > threshold && hand_on(place, direction_cosine)) --left;
    }
    std::vector<bool> stays(photons_.size());
    for (std::uint32_t place = 0; place < alive_.size(); ++place) stays[map_.index(place)] = alive_[place];
    return stays;
  }

 private:
  Vec3 direction_at(std::uint32_t place) const { return photons_.direction[map_.index(place)]; }

  void find(std::uint32_t place, std::span<std::uint64_t> scratch) {
    const Vec3 x = map_.tree().points[place].position;
    std::uint64_t tested = 0;
    const std::size_t count = map_.nearest(x, map_.normal(place), kSameSurfaceCosine, scratch.size(),
                                           std::numeric_limits<float>::infinity(), scratch, tested);
    Neighbourhood& n = around_[place];
    float farthest = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const FoundPhoton photon = PhotonPlaces::unpack(scratch[i]);
      if (photon.place == place || n.count == kNeighbours) continue;
      n.places[n.count++] = photon.place;
      farthest = std::max(farthest, photon.distance_squared);
    }
    n.area = kPi * farthest;
  }

  /// Photons per square metre around a photon, of those that remain.
  double density(std::uint32_t place) const {
    const Neighbourhood& n = around_[place];
    if (n.count == 0) return 0;
    std::uint32_t left = 1;
    for (std::uint32_t i = 0; i < n.count; ++i) left += alive_[n.places[i]];
    return n.area > 0 ? left / double(n.area) : std::numeric_limits<double>::infinity();
  }

  /// Gives a photon's flux to its neighbours in equal parts and drops it; returns false if no neighbour is similar.
  bool hand_on(std::uint32_t place, float direction_cosine) {
    const Neighbourhood& n = around_[place];
    const Vec3 direction = direction_at(place);
    std::array<std::uint32_t, kNeighbours> heirs;
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < n.count; ++i) {
      const std::uint32_t other = n.places[i];
      if (alive_[other] && dot(direction_at(other), direction) > direction_cosine) heirs[count++] = map_.index(other);
    }
    if (count == 0) return false;
    const Flux own = flux_[map_.index(place)];
    const double share = 1 / static_cast<double>(count);
    for (std::size_t i = 0; i < count; ++i) {
      Flux& heir = flux_[heirs[i]];
      heir = {heir.r + own.r * share, heir.g + own.g * share, heir.b + own.b * share};
    }
    alive_[place] = false;
    return true;
  }

  const PhotonBatch& photons_;
  std::vector<Flux>& flux_;
  PhotonPlaces map_;
  std::vector<Neighbourhood> around_;  // by place
  std::vector<bool> alive_;            // by place
};

/// Keeps the photons that stay, and their flux.
void keep(PhotonBatch& photons, std::vector<Flux>& flux, const std::vector<bool>& stays) {
  std::size_t to = 0;
  for (std::size_t i = 0; i < stays.size(); ++i) {
    if (!stays[i]) continue;
    photons.position[to] = photons.position[i];
    photons.direction[to] = photons.direction[i];
    photons.normal[to] = photons.normal[i];
    flux[to++] = flux[i];
  }
  photons.resize(to);
  flux.resize(to);
}

}  // namespace

PhotonBatch control_density(const PhotonBatch& photons, const DensityControlSettings& settings) {
  PhotonBatch left = photons;
  std::vector<Flux> flux(photons.size());
  for (std::size_t i = 0; i < photons.size(); ++i) flux[i] = {photons.flux[i].r, photons.flux[i].g, photons.flux[i].b};
  std::size_t likeness = 0;
  for (std::uint32_t round = 0; left.size() > settings.wanted && likeness < std::size(kDirectionCosines); ++round) {
    const auto share = static_cast<std::size_t>(static_cast<double>(left.size()) * kShareOfRound);
    const std::size_t target = std::max({settings.wanted, share, std::size_t{1}});
    if (target >= left.size()) break;
    Round work(left, flux);
    const std::vector<bool> stays =
        work.thin(target, work.threshold(target), kDirectionCosines[likeness], hash_combine(settings.seed, round));
    const std::size_t before = left.size();
    keep(left, flux, stays);
    // Most of the target was missed: the remaining photons have no similar neighbours.
    if (before - left.size() < (before - target + 1) / 2) ++likeness;
  }
  for (std::size_t i = 0; i < left.size(); ++i)
    left.flux[i] = RGB(static_cast<float>(flux[i].r), static_cast<float>(flux[i].g), static_cast<float>(flux[i].b));
  return left;
}

}  // namespace glowworm
