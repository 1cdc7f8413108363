#include "maps/kernel_cuts.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

#include "core/offset_origin.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

std::array<Vec3, 3> corners(const CornerAndEdges& t) {
  const Vec3 a{t.corner[0], t.corner[1], t.corner[2]};
  return {a, a + Vec3{t.edge[0][0], t.edge[0][1], t.edge[0][2]}, a + Vec3{t.edge[1][0], t.edge[1][1], t.edge[1][2]}};
}

/// Where a triangle cuts the plane of points at height z.
std::optional<std::array<Vec3, 2>> slice(const std::array<Vec3, 3>& corner, float z) {
  std::array<Vec3, 2> ends;
  std::size_t found = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 a = corner[i], b = corner[(i + 1) % 3];
    if ((a.z < z) == (b.z < z)) continue;
    ends[found++] = a + (b - a) * ((z - a.z) / (b.z - a.z));
  }
  return found == 2 ? std::optional(ends) : std::nullopt;
}

/// The place of a segment that is nearest to p, seen along z.
Vec3 nearest_of(Vec3 from, Vec3 to, Vec3 p) {
  const Vec3 along{to.x - from.x, to.y - from.y, 0}, way{p.x - from.x, p.y - from.y, 0};
  const float squared = length_squared(along);
  return from + (to - from) * (squared > 0 ? std::clamp(dot(way, along) / squared, 0.0f, 1.0f) : 0.0f);
}

}  // namespace

void NearbyWalls::find(const NearbySurface& surface, const BoundaryCluster& cluster) {
  walls_.clear();
  surface_corners_.clear();
  rounding_ = 4 * position_rounding(cluster.center);
  for (const NearbySurface::Triangle& t : surface.triangles()) {
    const std::array<Vec3, 3> corner = corners(t.place);
    for (const Vec3& place : corner) rounding_ = std::max(rounding_, 4 * position_rounding(place));
    const Vec3 normal = normalize(cross(normalize(corner[1] - corner[0]), normalize(corner[2] - corner[0])));
    // Triangles on which the photons count are surface; the others may be walls.
    if (std::abs(normal.z) > kMinNormalCosine) {
      if (t.takes_flux) surface_corners_.insert(surface_corners_.end(), corner.begin(), corner.end());
    } else if (const auto ends = slice(corner, 0.5f * cluster.high)) {
      walls_.push_back({(*ends)[0], (*ends)[1], normal, dot(normal, corner[0]), false, false, t.index, false});
    }
  }
  for (Wall& wall : walls_)
    for (std::size_t i = 0; i < surface_corners_.size() && !(wall.hides_behind && wall.hides_before); ++i) {
      const float height = dot(wall.normal, surface_corners_[i]) - wall.height;
      wall.hides_behind |= height < -rounding_;
      wall.hides_before |= height > rounding_;
    }
  if (std::none_of(walls_.begin(), walls_.end(),
                   [](const Wall& wall) { return wall.hides_behind || wall.hides_before; }))
    walls_.clear();
}

bool NearbyWalls::cuts_at(std::uint32_t triangle) const {
  return std::any_of(walls_.begin(), walls_.end(),
                     [&](const Wall& wall) { return wall.cuts && wall.triangle == triangle; });
}

bool NearbyWalls::is_coplanar(const Wall& a, const Wall& b) const {
  return std::max(std::abs(a.height_of(b.from)), std::abs(a.height_of(b.to))) <= rounding_;
}

/// Whether a wall and those in its plane leave no gap in the chord along which its plane crosses a kernel. In a corner
/// the chord ends at the next wall, which stands on the kernel's side.
bool NearbyWalls::spans(const Wall& wall, Vec3 position, float radius) {
  const Vec3 way{wall.to.x - wall.from.x, wall.to.y - wall.from.y, 0};
  const float extent = length(way), height = wall.height_of(position);
  if (!(extent > 0)) return false;
  const Vec3 along = way / extent;
  const auto place = [&](Vec3 p) { return dot(along, p - position); };
  float high = std::sqrt(std::max(radius * radius - height * height, 0.0f)), low = -high;
  covered_.clear();
  for (const Wall& other : walls_) {
    if (is_coplanar(wall, other)) {
      covered_.push_back({std::min(place(other.from), place(other.to)), std::max(place(other.from), place(other.to))});
      continue;
    }
    const float side = height < 0 ? -1.0f : 1.0f;
    const float from = side * wall.height_of(other.from), to = side * wall.height_of(other.to);
    if (std::min(from, to) > rounding_ || std::max(from, to) <= rounding_) continue;
    const float end = place(other.from + (other.to - other.from) * std::clamp(from / (from - to), 0.0f, 1.0f));
    (end < 0 ? low : high) = end < 0 ? std::max(low, end) : std::min(high, end);
  }
  std::sort(covered_.begin(), covered_.end());
  for (const std::array<float, 2>& part : covered_)
    if (part[0] <= low + rounding_) low = std::max(low, part[1]);
  return low >= high - rounding_;
}

std::array<KernelCut, 2> NearbyWalls::cuts(Vec3 position, float radius) {
  std::array<KernelCut, 2> out;
  for (std::size_t number = 0; number < out.size(); ++number) {
    float least = radius * radius;
    const Wall* nearest = nullptr;
    for (const Wall& wall : walls_) {
      const Vec3 place = nearest_of(wall.from, wall.to, position);
      const Vec3 way{place.x - position.x, place.y - position.y, 0};
      const float squared = length_squared(way);
      // A wall behind the first one, or one that meets it, hides nothing more.
      if (!(squared < least) || (number == 1 && !(dot(out[0].normal, way) > rounding_ - out[0].distance))) continue;
      const float height = wall.height_of(position);
      if (!(height < 0 ? wall.hides_before : wall.hides_behind) || !(std::abs(height) < radius)) continue;
      if (!spans(wall, position, radius)) continue;
      least = squared;
      nearest = &wall;
      out[number] = {height < 0 ? -wall.normal : wall.normal, std::abs(height)};
    }
    if (!nearest) break;
    for (Wall& wall : walls_) wall.cuts |= is_coplanar(*nearest, wall);
  }
  return out;
}

void add_cuts(std::uint32_t photon, std::array<KernelCut, 2> cuts, const Frame& frame, std::vector<PhotonCuts>& out) {
  if (cuts[0].normal == Vec3{0, 0, 0}) return;
  for (KernelCut& cut : cuts) cut.normal = frame.to_world(cut.normal);
  out.push_back({photon, cuts});
}

void sort_cuts(std::vector<PhotonCuts>& cuts) {
  std::sort(cuts.begin(), cuts.end(), [](const PhotonCuts& a, const PhotonCuts& b) { return a.photon < b.photon; });
}

std::vector<PhotonCuts> kernel_cuts(const Tracer& tracer, const PhotonBatch& photons, std::span<const float> radii,
                                    bool on_all_surfaces) {
  const BoundaryClusters all = make_boundary_clusters(photons, radii);
  const LitSides sides;  // walls do not use them
  std::vector<PhotonCuts> out;
  std::mutex mutex;
  parallel_for(0, all.clusters.size(), even_grain(all.clusters.size()), [&](std::size_t first, std::size_t last) {
    std::vector<PhotonCuts> found;
    NearbySurface surface(tracer, on_all_surfaces, sides);
    NearbyWalls walls;
    for (std::size_t i = first; i < last; ++i) {
      const BoundaryCluster& cluster = all.clusters[i];
      surface.approach(cluster);
      walls.find(surface, cluster);
      if (walls.empty()) continue;
      for (const std::uint32_t p : std::span(all.photons).subspan(cluster.first, cluster.count))
        add_cuts(p, walls.cuts(surface.frame().to_local(photons.position[p] - cluster.center), radii[p]),
                 surface.frame(), found);
    }
    const std::lock_guard lock(mutex);
    out.insert(out.end(), found.begin(), found.end());
  });
  sort_cuts(out);
  return out;
}

}  // namespace glowworm
