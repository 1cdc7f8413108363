#include "maps/boundary.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <mutex>
#include <optional>
#include <utility>

#include "core/archive.h"
#include "core/frame.h"
#include "core/parallel.h"
#include "core/random.h"
#include "kernels/kernel_shape.h"
#include "maps/boundary_clusters.h"
#include "maps/kernel_cuts.h"
#include "maps/nearby_surface.h"

namespace glowworm {

template <>
inline constexpr bool kPlain<PhotonCuts> = sizeof(PhotonCuts) == 36;

namespace {

/// Lines per area of a photon's disc: first lines to detect a deviation, and all lines where there is one. A query
/// point has more, because the error of its mass is an error of its estimate, where the errors of many photons average
/// out.
constexpr float kFirstLines = 8, kAllLines = 32, kLinesOfQuery = 64;
/// Photons of a piece of shared work, about a tenth of a second of a core, and most pieces.
constexpr std::size_t kPhotonsPerPiece = 1 << 16, kMostPieces = 64;
/// Share of a line that is skipped behind a surface, in addition to rounding, so that the surface is not hit again.
/// A line goes on through all slats of a blind, without which the mass would be too small.
constexpr float kStep = 1e-3f;
/// Surfaces nearly parallel to a line are ignored; they have no photon's normal.
constexpr float kMinCosine = 0.25f;
/// Most mass: so many surfaces are rarely all visible.
constexpr float kMaxMass = 4;
/// Lines that must find surface, in lines of the kernel on an infinite plane. On thin parts, such as legs of chairs,
/// few do. One over the mass has the right mean if lines are added until enough have found surface, whatever their
/// number: Haldane, "On a method of estimating frequencies", Biometrika 33, 1945.
constexpr float kEnoughLines = 4;

/// Lines of a cluster, at most.
constexpr auto kMostLines = static_cast<std::size_t>(kAllLines * kWidestCluster) + 1;
static_assert(kMostLines <= kMostSegments);

/// Points of the unit square, stratified however many of them are used. The first coordinate is a turn.
struct LinePoint {
  float cosine, sine, square;
};

std::vector<LinePoint> make_line_points() {
  std::vector<LinePoint> out;
  for (std::uint32_t i = 0; i < kMostLines; ++i) {
    const Vec2 u = Sampler(SamplerKind::sobol, kBoundaryStream, 0, i).next2();
    out.push_back({std::cos(2 * kPi * u.x), std::sin(2 * kPi * u.x), u.y});
  }
  return out;
}

/// A line along the cluster's normal through a point of its disc, from above its photons to below them. All places are
/// in the cluster's frame (NearbySurface::frame()).
struct Line {
  float x, y;                ///< metres
  int depth = 0;             ///< solids entered minus solids left since the photon; places inside a solid are invisible
  std::uint32_t places = 0;  ///< found on it
  bool plain = true;         ///< all its places lie in the cluster's plane

  /// Takes the line through a surface. Nothing is hidden behind a sheet that light reaches on both sides.
  /// @param front whether it meets the front, by the winding
  void cross(bool front, LitSide lit) {
    if (lit != LitSide::both) depth += front == (lit == LitSide::front) ? 1 : -1;
  }
};

/// A place on a line where query points may lie.
struct Place {
  float height;        ///< metres
  Vec3 normal;         ///< unit
  float area;          ///< of surface over area of disc
  std::uint32_t line;  ///< its number
};

/// Arrays with the padding of the kernels.
template <std::size_t kArrays>
class Columns {
 public:
  std::size_t count() const { return count_; }
  const float* operator[](std::size_t array) const { return arrays_[array].data(); }
  void clear() { count_ = 0; }
  void push_back(const std::array<float, kArrays>& values) {
    for (std::size_t i = 0; i < kArrays; ++i) {
      if (arrays_[i].size() <= count_ + kBoundaryPadding) arrays_[i].resize(2 * count_ + 2 * kBoundaryPadding);
      arrays_[i][count_] = values[i];
    }
    ++count_;
  }

 private:
  std::size_t count_ = 0;
  std::array<std::vector<float>, kArrays> arrays_;
};

/// The centers and normals of kernels, their radii in metres, and their shape.
struct Kernels {
  std::span<const Vec3> position, normal;
  std::span<const float> radius;
  KernelShape shape;
  float min_cosine;
};

/// Measures one cluster after the other.
class ClusterMass {
 public:
  ClusterMass(const Tracer& tracer, const Kernels& kernels, const std::vector<LinePoint>& points, bool on_all_surfaces,
              const LitSides& sides)
      : scene_(tracer.scene()), kernels_(kernels), points_(points), surface_(tracer, on_all_surfaces, sides) {}

  /// Sets the factors of the cluster's kernels where they are not 1. Keeps their cuts.
  /// @param key    of the cluster's random numbers
  /// @param number lines to the area of a kernel's disc where the first ones find a deviation
  void measure(const BoundaryCluster& cluster, std::span<const std::uint32_t> members, std::uint32_t key, float number,
               std::span<float> factors) {
    approach(cluster, members, key);
    for (std::size_t i = 0; i < member_cuts_.size(); ++i)
      add_cuts(members_[i], member_cuts_[i], surface_.frame(), cuts_);
    trace(kFirstLines);
    if (!surface_.crowded()) {
      if (is_plain()) return;
      trace(number);
    }
    // So many surfaces have more than the maximum mass, even if every other one is invisible.
    std::vector<std::uint32_t> thin;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const float found = surface_.crowded() ? kMaxMass : std::min(mass(i), kMaxMass);
      if (found * number < kEnoughLines) thin.push_back(members[i]);
      factors[members[i]] = 1 / found;
    }
    for (std::uint32_t i = 0; i < thin.size(); ++i) factors[thin[i]] = thin_factor(thin[i], hash_combine(key, i));
  }

  /// The cuts of the kernels measured so far.
  const std::vector<PhotonCuts>& cuts() const { return cuts_; }

 private:
  /// Prepares a cluster, whose lines are to be traced.
  void approach(const BoundaryCluster& cluster, std::span<const std::uint32_t> members, std::uint32_t key) {
    cluster_ = &cluster;
    members_ = members;
    key_ = key;
    thin_ = false;
    lines_.clear();
    places_.clear();
    surface_.approach(cluster);
    walls_.find(surface_, cluster);
    positions_.clear();
    for (const std::uint32_t p : members_)
      positions_.push_back(surface_.frame().to_local(kernels_.position[p] - cluster.center));
    member_cuts_.clear();
    for (std::size_t i = 0; i < members_.size() && !walls_.empty(); ++i)
      member_cuts_.push_back(walls_.cuts(positions_[i], kernels_.radius[members_[i]]));
    is_cut_ = std::any_of(member_cuts_.begin(), member_cuts_.end(), [](const auto& cuts) {
      return cuts[0].normal != Vec3{0, 0, 0};
    });
  }

  /// The factor of a kernel whose disc holds little surface, from lines of its own.
  float thin_factor(std::uint32_t kernel, std::uint32_t key) {
    const BoundaryCluster alone =
        lone_cluster(kernels_.position[kernel], kernels_.normal[kernel], kernels_.radius[kernel]);
    approach(alone, {&kernel, 1}, key);
    thin_ = true;
    float lines = 0, found = 0;
    while (found < kEnoughLines && lines < kMostLines && !surface_.crowded()) {
      lines = std::min(lines + kAllLines, static_cast<float>(kMostLines));
      trace(lines);
      found = lines * mass(0);
    }
    return surface_.crowded() ? 1 / kMaxMass : lines / std::max(found, 1.0f);
  }

  bool is_as_expected(const Line& line) const {
    return cluster_->flat && !is_cut_ && !thin_ && line.plain && line.places == 1;
  }

  bool is_plain() const {
    // A deviation below 2% is not visible.
    for (std::size_t i = 0; i < members_.size() && lines_off_.count() + places_off_.count() > 0; ++i)
      if (std::abs(mass(i) - 1) > 0.02f) return false;
    return true;
  }

  /// Adds lines, up to `density` of them to the area of a photon's disc.
  void trace(float density) {
    const std::size_t before = lines_.size();
    add_lines(static_cast<std::size_t>(std::ceil(density * cluster_->wideness)));
    find_depths(before);
    segments_.count = 0;
    const float along = cluster_->low - cluster_->high;
    for (std::size_t i = before; i < lines_.size(); ++i)
      segments_.push_back({lines_[i].x, lines_[i].y, cluster_->high}, {0, 0, along});
    for (const Meeting& m : surface_.meetings(segments_, 0, step()))
      meet(static_cast<std::uint32_t>(before) + m.segment, cluster_->high + along * m.distance, m);
    gather_unexpected();
  }

  /// Each cluster turns the same points by an angle of its own, and shifts them.
  void add_lines(std::size_t count) {
    const Vec2 u = Sampler(SamplerKind::independent, kBoundaryStream, key_, 0).next2();
    const float cosine = std::cos(2 * kPi * u.x), sine = std::sin(2 * kPi * u.x);
    for (std::size_t i = lines_.size(); i < count; ++i) {
      const LinePoint& p = points_[i];
      const float shifted = p.square + u.y, distance = cluster_->reach * std::sqrt(shifted - std::floor(shifted));
      Line line;
      line.x = distance * (cosine * p.cosine - sine * p.sine);
      line.y = distance * (sine * p.cosine + cosine * p.sine);
      lines_.push_back(line);
    }
  }

  /// Counts the solids that contain the start of each line, along the path from a photon, which lies in none: a floor
  /// continues beneath objects on it and beyond the walls.
  void find_depths(std::size_t before) {
    const auto way = [&](std::size_t line) {
      return Vec3{lines_[line].x, lines_[line].y, cluster_->high} - positions_[line % positions_.size()];
    };
    segments_.count = 0;
    for (std::size_t i = before; i < lines_.size(); ++i) segments_.push_back(positions_[i % positions_.size()], way(i));
    // What lies behind walls is cut off the kernels.
    for (const Meeting& m : surface_.meetings(segments_, step(), step()))
      if (!walls_.cuts_at(m.triangle))
        lines_[before + m.segment].cross(dot(local_normal(m.triangle), way(before + m.segment)) < 0, m.lit);
  }

  /// By the winding, unit.
  Vec3 local_normal(std::uint32_t triangle) const {
    return surface_.frame().to_local(scene_.diffuse_triangle(triangle).normal);
  }

  /// Takes a line through a hit, which is a place if it takes flux and is not inside a solid.
  void meet(std::uint32_t number, float height, const Meeting& hit) {
    if (walls_.cuts_at(hit.triangle)) return;
    Line& line = lines_[number];
    Vec3 normal = local_normal(hit.triangle);
    const float cosine = normal.z;
    const bool buried = line.depth > 0;
    line.cross(cosine > 0, hit.lit);
    if (buried || !hit.takes_flux || std::abs(cosine) < kMinCosine) return;
    // A single sheet may have either winding.
    if (cosine < 0) normal = -normal;
    ++line.places;
    line.plain &= std::abs(height) <= cluster_->flatness && std::abs(cosine) >= 1 - kFlatness;
    places_.push_back({height, normal, 1 / std::abs(cosine), number});
  }

  /// Lists the lines that are not as on an infinite plane, and their places.
  void gather_unexpected() {
    lines_off_.clear();
    places_off_.clear();
    for (const Line& line : lines_)
      if (!is_as_expected(line)) lines_off_.push_back({line.x, line.y});
    for (const Place& p : places_) {
      const Line& line = lines_[p.line];
      if (!is_as_expected(line))
        places_off_.push_back({line.x, line.y, p.height, p.normal.x, p.normal.y, p.normal.z, p.area});
    }
  }

  /// Share of a line, or of the path to it, which has at least half its length, that is skipped behind a surface.
  float step() const { return kStep + 2 * cluster_->step; }

  /// The integral of a kernel of the cluster. The lines' result is compared with their result on an infinite
  /// plane, whose integral is 1, so noise arises only where there is a difference. Thin parts differ nearly everywhere:
  /// their result is the integral.
  float mass(std::size_t member) const {
    const Vec3 p = positions_[member], n = surface_.frame().to_local(kernels_.normal[members_[member]]);
    if (!(n.z > 0)) return 1;
    const float radius = kernels_.radius[members_[member]];
    const KernelBall ball{{p.x, p.y, p.z}, {n.x, n.y, n.z}, 1 / (radius * radius)};
    const auto& off = kept_places(member);
    const WeightedPlaces places{off.count(), {off[0], off[1], off[2]}, {off[3], off[4], off[5]}, off[6]};
    const float there = sum_at_places(kernels_.shape, places, ball, kernels_.min_cosine);
    const float area = kPi * cluster_->reach * cluster_->reach / static_cast<float>(lines_.size());
    const float weight = area * ball.inverse_squared_radius * static_cast<float>(kernel_norm(kernels_.shape));
    if (thin_) return there * weight;
    const float expected = sum_on_plane(kernels_.shape, lines_off_[0], lines_off_[1], lines_off_.count(), ball) / n.z;
    return 1 + (there - expected) * weight;
  }

  /// The places of places_off_ that walls leave to the kernel.
  const Columns<7>& kept_places(std::size_t member) const {
    if (!is_cut_ || member_cuts_[member][0].normal == Vec3{0, 0, 0}) return places_off_;
    const PhotonCuts cuts{members_[member], member_cuts_[member]};
    const auto& off = places_off_;
    places_kept_.clear();
    for (std::size_t i = 0; i < off.count(); ++i) {
      if (cuts.keep(Vec3{off[0][i], off[1][i], off[2][i]} - positions_[member]))
        places_kept_.push_back({off[0][i], off[1][i], off[2][i], off[3][i], off[4][i], off[5][i], off[6][i]});
    }
    return places_kept_;
  }

  const Scene& scene_;
  const Kernels kernels_;
  const std::vector<LinePoint>& points_;
  NearbySurface surface_;
  const BoundaryCluster* cluster_ = nullptr;
  std::span<const std::uint32_t> members_;
  std::uint32_t key_ = 0;
  std::vector<Vec3> positions_;  ///< of the members
  std::vector<Line> lines_;
  std::vector<Place> places_;
  Columns<2> lines_off_;   ///< x, y
  Columns<7> places_off_;  ///< position, normal, area
  NearbyWalls walls_;
  bool is_cut_ = false;                                ///< whether a member has cuts
  bool thin_ = false;                                  ///< in thin_factor()
  std::vector<std::array<KernelCut, 2>> member_cuts_;  ///< if there are walls, in the cluster's frame
  std::vector<PhotonCuts> cuts_;
  mutable Columns<7> places_kept_;  ///< of places_off_, for one kernel
  Segments segments_;
};

/// The factors of all clusters, or of some.
class Factors {
 public:
  Factors(const Tracer& tracer, const PhotonBatch& photons, const RadiusPolicy& policy, bool on_all_surfaces,
          const LitSides& sides)
      : tracer_(tracer),
        photons_(photons),
        policy_(policy),
        on_all_surfaces_(on_all_surfaces),
        sides_(sides),
        factors_(photons.size(), 1.0f) {
    if (policy.kind == RadiusKind::fixed) same_.assign(photons.size(), policy.radius);
    radii_ = same_.empty() ? std::span(policy.radii) : std::span<const float>(same_);
  }
  Factors(const Factors&) = delete;
  Factors& operator=(const Factors&) = delete;

  /// Measures piece `piece` of `pieces`. Returns its clusters.
  std::span<const BoundaryCluster> measure(std::size_t piece, std::size_t pieces) {
    if (!all_) {
      all_ = make_boundary_clusters(photons_, radii_);
      points_ = make_line_points();
    }
    const std::vector<BoundaryCluster>& clusters = all_->clusters;
    const std::size_t first = clusters.size() * piece / pieces, end = clusters.size() * (piece + 1) / pieces;
    parallel_for(first, end, even_grain(end - first), [&](std::size_t from, std::size_t to) {
      const Kernels kernels{photons_.position, photons_.normal, radii_, policy_.kernel, policy_.min_normal_cosine};
      ClusterMass mass(tracer_, kernels, points_, on_all_surfaces_, sides_);
      for (std::size_t i = from; i < to; ++i) {
        const std::span<const std::uint32_t> photons = members(clusters[i]);
        mass.measure(clusters[i], photons, photons[0], kAllLines, factors_);
      }
      const std::lock_guard lock(mutex_);
      cuts_.insert(cuts_.end(), mass.cuts().begin(), mass.cuts().end());
    });
    return std::span(clusters).subspan(first, end - first);
  }
  /// The photons of a cluster that measure() has returned.
  std::span<const std::uint32_t> members(const BoundaryCluster& cluster) const {
    return std::span(all_->photons).subspan(cluster.first, cluster.count);
  }
  std::vector<float>& values() { return factors_; }
  /// The cuts of the pieces measured since the last call, in any order.
  std::vector<PhotonCuts> take_cuts() { return std::exchange(cuts_, {}); }

 private:
  const Tracer& tracer_;
  const PhotonBatch& photons_;
  const RadiusPolicy& policy_;
  const bool on_all_surfaces_;
  const LitSides& sides_;
  std::vector<float> factors_, same_;
  std::span<const float> radii_;
  std::optional<BoundaryClusters> all_;
  std::vector<LinePoint> points_;
  std::mutex mutex_;
  std::vector<PhotonCuts> cuts_;
};

/// Random numbers of a query point belong to its place: they do not depend on the other points of a call. Exponents do
/// not count, so that a scene may have any scale.
std::uint32_t key_of(Vec3 p) {
  constexpr std::uint32_t kSignAndMantissa = 0x807fffff;
  std::uint32_t key = 0;
  for (int axis = 0; axis < 3; ++axis)
    key = hash_combine(key, std::bit_cast<std::uint32_t>(p[axis]) & kSignAndMantissa);
  return key;
}

/// A factor that is not 1.
struct FactorOf {
  std::uint32_t photon;
  float factor;
};

template <typename Archive>
void transfer(Archive& archive, FactorOf& of) {
  transfer_all(archive, of.photon, of.factor);
}

/// A piece of shared work: the factors that are not 1, and cuts.
std::vector<std::byte> make_piece(Factors& factors, std::size_t piece, std::size_t pieces) {
  std::vector<FactorOf> made;
  for (const BoundaryCluster& cluster : factors.measure(piece, pieces))
    for (const std::uint32_t photon : factors.members(cluster))
      if (factors.values()[photon] != 1) made.push_back({photon, factors.values()[photon]});
  return archived(made, factors.take_cuts());
}

void take_piece(std::span<const std::byte> bytes, std::vector<float>& values, std::vector<PhotonCuts>& cuts) {
  std::vector<FactorOf> factors;
  std::vector<PhotonCuts> more;
  unarchive(bytes, factors, more);
  for (const auto& [photon, factor] : factors) require(photon < values.size() && std::isfinite(factor) && factor > 0);
  for (const PhotonCuts& c : more) {
    require(c.photon < values.size());
    for (const KernelCut& cut : c.cuts) require(is_finite(cut.normal) && std::isfinite(cut.distance));
  }
  for (const auto& [photon, factor] : factors) values[photon] = factor;
  cuts.insert(cuts.end(), more.begin(), more.end());
}

/// Measures all factors and cuts, or takes those that other processes measure.
void measure_all(Factors& factors, std::size_t photons, SharedWork* shared, const std::string& name,
                 std::vector<PhotonCuts>* cuts) {
  std::vector<PhotonCuts> found;
  if (shared) {
    const std::size_t pieces = std::min((photons + kPhotonsPerPiece - 1) / kPhotonsPerPiece, kMostPieces);
    shared->divide(
        name, pieces, [&](std::size_t piece) { return make_piece(factors, piece, pieces); },
        [&](std::size_t, std::span<const std::byte> bytes) { take_piece(bytes, factors.values(), found); });
  } else {
    factors.measure(0, 1);
    found = factors.take_cuts();
  }
  sort_cuts(found);
  if (cuts) *cuts = std::move(found);
}

}  // namespace

std::vector<float> boundary_factors(const Tracer& tracer, const PhotonBatch& photons, const RadiusPolicy& policy,
                                    const LitSides& sides, std::vector<PhotonCuts>* cuts, SharedWork* shared,
                                    const std::string& name, bool on_all_surfaces) {
  Factors factors(tracer, photons, policy, on_all_surfaces, sides);
  if (photons.size() > 0) measure_all(factors, photons.size(), shared, name, cuts);
  return std::move(factors.values());
}

void correct_estimates(const Tracer& tracer, const QueryPoints& points, std::span<const float> radii,
                       KernelShape kernel, const LitSides& sides, std::span<RGB> radiance, bool on_all_surfaces) {
  const std::vector<LinePoint> lines = make_line_points();
  const std::span<const Vec3> positions = points.position, normals = points.normal;
  parallel_for(0, points.size(), even_grain(points.size()), [&](std::size_t first, std::size_t last) {
    const std::size_t count = last - first;
    ClusterMass mass(tracer,
                     {positions.subspan(first, count), normals.subspan(first, count), radii.subspan(first, count),
                      kernel, kMinNormalCosine},
                     lines, on_all_surfaces, sides);
    std::vector<float> factors(count, 1.0f);
    for (std::uint32_t i = 0; i < count; ++i) {
      RGB& estimate = radiance[first + i];
      if (!(radii[first + i] > 0) || is_black(estimate)) continue;
      const Vec3 p = positions[first + i];
      mass.measure(lone_cluster(p, normals[first + i], radii[first + i]), {&i, 1}, key_of(p), kLinesOfQuery, factors);
      estimate *= factors[i];
    }
  });
}

}  // namespace glowworm
