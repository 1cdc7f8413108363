#include "density/density_control.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/parallel.h"
#include "core/random.h"
#include "density/knn.h"

namespace glowworm {

namespace {

// Neighbours whose distance gives the density, and that flux is handed to.
constexpr std::uint32_t kNeighbours = 12;
// Photons of normals with a dot product above this lie on one surface.
constexpr float kSameSurfaceCosine = 0.9f;
// Neighbours must come from directions with a dot product above this. Where the wanted count cannot be reached so,
// rounds that follow ask for less.
constexpr float kDirectionCosines[] = {0.9f, 0.7f, 0.4f, 0.0f, -1.1f};
// A round drops no more than this share of the photons: the neighbours that it works with would be used up.
constexpr double kShareOfRound = 0.5;
constexpr std::size_t kGrain = 512;

/// The neighbours of a photon, by their places in the map.
struct Neighbourhood {
  std::array<std::uint32_t, kNeighbours> places;
  std::uint32_t count = 0;
  float area = 0;  ///< of the disc that holds them, m^2
};

/// Flux while it is handed on: in double precision, since photons may take over that of many.
struct Flux {
  double r = 0, g = 0, b = 0;
};

/// One round: photons and what becomes of them.
class Round {
 public:
  Round(const PhotonBatch& photons, std::vector<Flux>& flux) : photons_(photons), flux_(flux) {
    map_.build(photons, {});
    around_.resize(photons.size());
    parallel_for(0, photons.size(), kGrain, [&](std::size_t first, std::size_t last) {
      std::array<std::uint64_t, kNeighbours + 1> found;
      for (std::size_t i = first; i < last; ++i) find(static_cast<std::uint32_t>(i), found);
    });
  }

  /// The density above which photons must go so that `target` are left: photon i stays with the chance that the
  /// threshold is of its density.
  double threshold(std::size_t target) const {
    std::vector<double> areas;
    for (const Neighbourhood& n : around_) areas.push_back(n.count > 0 ? n.area / (n.count + 1) : 0);
    std::sort(areas.begin(), areas.end());
    // Photons whose share of area is above that of the threshold stay for certain; the others by area over it.
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

  /// Drops photons until `target` are left or no more may go. Returns, by photon, whether it stays.
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
  void find(std::uint32_t place, std::span<std::uint64_t> scratch) {
    const Vec3 x = map_.tree().points[place].position;
    std::uint64_t tested = 0;
    const std::size_t count = map_.nearest(x, map_.normal(place), kSameSurfaceCosine, scratch.size(),
                                           std::numeric_limits<float>::infinity(), scratch, tested);
    Neighbourhood& n = around_[place];
    float farthest = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const FoundPhoton photon = PhotonMap::unpack(scratch[i]);
      if (photon.place == place || n.count == kNeighbours) continue;
      n.places[n.count++] = photon.place;
      farthest = std::max(farthest, photon.distance_squared);
    }
    n.area = kPi * farthest;
  }

  /// Photons per square metre around a photon, of those that are left.
  double density(std::uint32_t place) const {
    const Neighbourhood& n = around_[place];
    if (n.count == 0) return 0;
    std::uint32_t left = 1;
    for (std::uint32_t i = 0; i < n.count; ++i) left += alive_[n.places[i]];
    return n.area > 0 ? left / double(n.area) : std::numeric_limits<double>::infinity();
  }

  /// Gives a photon's flux to its neighbours in equal parts and drops it; false where no neighbour is like it.
  bool hand_on(std::uint32_t place, float direction_cosine) {
    const Neighbourhood& n = around_[place];
    const Vec3 direction = map_.direction(place);
    std::array<std::uint32_t, kNeighbours> heirs;
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < n.count; ++i) {
      const std::uint32_t other = n.places[i];
      if (alive_[other] && dot(map_.direction(other), direction) > direction_cosine) heirs[count++] = map_.index(other);
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
  PhotonMap map_;
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
    const double threshold = std::max(work.threshold(target), double(settings.always_kept));
    const std::vector<bool> stays =
        work.thin(target, threshold, kDirectionCosines[likeness], hash_combine(settings.seed, round));
    const std::size_t before = left.size();
    keep(left, flux, stays);
    // Short of most of what was to go: photons like enough are used up.
    if (before - left.size() < (before - target + 1) / 2) ++likeness;
  }
  for (std::size_t i = 0; i < left.size(); ++i)
    left.flux[i] = RGB(static_cast<float>(flux[i].r), static_cast<float>(flux[i].g), static_cast<float>(flux[i].b));
  return left;
}

}  // namespace glowworm
