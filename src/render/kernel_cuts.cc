#include "render/kernel_cuts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/offset_origin.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

/// Triangles whose normal is within this cosine of the photons' are surface; the others may be walls.
constexpr float kSurfaceCosine = 0.70710678f;
constexpr std::size_t kClustersPerChunk = 64;

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
    const Vec3 scaled = cross(corner[1] - corner[0], corner[2] - corner[0]);
    if (scaled.z * scaled.z > kSurfaceCosine * kSurfaceCosine * length_squared(scaled)) {
      surface_corners_.insert(surface_corners_.end(), corner.begin(), corner.end());
    } else if (const auto ends = slice(corner, 0.5f * cluster.high)) {
      const Vec3 normal = scaled / length(scaled);
      walls_.push_back({(*ends)[0], (*ends)[1], normal, dot(normal, corner[0]), false, false, t.index});
    }
  }
  for (Wall& wall : walls_)
    for (std::size_t i = 0; i < surface_corners_.size() && !(wall.hides_behind && wall.hides_before); ++i) {
      const float height = dot(wall.normal, surface_corners_[i]) - wall.height;
      wall.hides_behind |= height < -rounding_;
      wall.hides_before |= height > rounding_;
    }
  std::erase_if(walls_, [](const Wall& wall) { return !wall.hides_behind && !wall.hides_before; });
}

bool NearbyWalls::has(std::uint32_t triangle) const {
  return std::any_of(walls_.begin(), walls_.end(), [&](const Wall& wall) { return wall.triangle == triangle; });
}

std::array<KernelCut, 2> NearbyWalls::cuts(Vec3 position, float radius) const {
  std::array<KernelCut, 2> out;
  for (std::size_t number = 0; number < out.size(); ++number) {
    float least = radius * radius;
    for (const Wall& wall : walls_) {
      const Vec3 place = nearest_of(wall.from, wall.to, position);
      const Vec3 way{place.x - position.x, place.y - position.y, 0};
      const float squared = length_squared(way);
      // A wall behind the first one, or one that meets it, hides nothing more.
      if (!(squared < least) || (number == 1 && !(dot(out[0].normal, way) > rounding_ - out[0].distance))) continue;
      const float height = dot(wall.normal, position) - wall.height;
      if (!(height < 0 ? wall.hides_before : wall.hides_behind) || !(std::abs(height) < radius)) continue;
      least = squared;
      out[number] = {height < 0 ? -wall.normal : wall.normal, std::abs(height)};
    }
    if (!(least < radius * radius)) break;
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

std::vector<PhotonCuts> kernel_cuts(const Tracer& tracer, const PhotonBatch& photons, std::span<const float> radii) {
  const BoundaryClusters all = make_boundary_clusters(photons, radii);
  const std::size_t chunks = (all.clusters.size() + kClustersPerChunk - 1) / kClustersPerChunk;
  std::vector<std::vector<PhotonCuts>> found(chunks);
  parallel_for(0, chunks, 1, [&](std::size_t chunk, std::size_t) {
    NearbySurface surface(tracer);
    NearbyWalls walls;
    const std::size_t end = std::min((chunk + 1) * kClustersPerChunk, all.clusters.size());
    for (std::size_t i = chunk * kClustersPerChunk; i < end; ++i) {
      const BoundaryCluster& cluster = all.clusters[i];
      surface.approach(cluster);
      walls.find(surface, cluster);
      if (walls.empty()) continue;
      for (const std::uint32_t p : std::span(all.photons).subspan(cluster.first, cluster.count))
        add_cuts(p, walls.cuts(surface.frame().to_local(photons.position[p] - cluster.center), radii[p]),
                 surface.frame(), found[chunk]);
    }
  });
  std::vector<PhotonCuts> out;
  for (const auto& some : found) out.insert(out.end(), some.begin(), some.end());
  sort_cuts(out);
  return out;
}

}  // namespace glowworm
