#include "maps/nearby_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/offset_origin.h"
#include "photon/material_lobes.h"
#include "scene/surface.h"

namespace glowworm {

namespace {

/// Most triangles that are copied, and looked at. More cost about as much as tracing rays.
constexpr std::size_t kMostCopied = 128, kMostVisited = 8 * kMostCopied;

/// Square of the distance of an edge from the z axis.
float axis_distance_squared(Vec3 a, Vec3 b) {
  const Vec3 e = b - a;
  const float squared = e.x * e.x + e.y * e.y;
  const float t = squared > 0 ? std::clamp(-(a.x * e.x + a.y * e.y) / squared, 0.0f, 1.0f) : 0.0f;
  const float x = a.x + t * e.x, y = a.y + t * e.y;
  return x * x + y * y;
}

/// Twice the area of the triangle of two points and the z axis, as seen along it.
float area_from_axis(Vec3 a, Vec3 b) { return a.x * b.y - a.y * b.x; }

}  // namespace

void NearbySurface::approach(const BoundaryCluster& cluster) {
  cluster_ = &cluster;
  frame_ = Frame::from_normal(cluster.normal);
  triangles_.clear();
  copied_ = true;
  crowded_ = false;
  const float rounding = 4 * position_rounding(cluster.center), reach = cluster.reach + rounding;
  reach_squared_ = reach * reach;
  lowest_ = cluster.low - rounding;
  highest_ = cluster.high + rounding;
  std::size_t visited = 0;
  tracer_.visit_near(cluster.center, std::hypot(reach, std::max(-lowest_, highest_)),
                     [&](std::uint32_t triangle) { return copied_ = ++visited <= kMostVisited && copy(triangle); });
}

/// Whether photons and query points may lie on a triangle of this one's material.
bool NearbySurface::takes_flux(std::uint32_t triangle) {
  const Scene& scene = tracer_.scene();
  const std::uint32_t material = scene.geometry().material_of(triangle);
  if (takes_flux_[material] == kUnknown) {
    const SurfacePoint point = surface_point(scene, triangle, kMiddle);
    takes_flux_[material] = may_have_lobes(scene, point, material, kBroad) ? kYes : kNo;
  }
  return takes_flux_[material] == kYes;
}

/// Copies a triangle if the cylinder may contain a part of it. False if the copies cannot be used.
bool NearbySurface::copy(std::uint32_t triangle) {
  const Scene& scene = tracer_.scene();
  const std::uint32_t material = scene.geometry().material_of(triangle);
  // It only parts media, and hides nothing.
  if (scene.materials()[material].kind == MaterialKind::interface) return true;
  const auto [c, e, f] = local_triangle(triangle);
  const float highest = c.z + std::max({0.0f, e.z, f.z});
  if (highest < lowest_ || c.z + std::min({0.0f, e.z, f.z}) > highest_ || !reaches({c, c + e, c + f})) return true;
  const auto is_it = [&](const Triangle& other) { return other.index == triangle; };
  if (std::any_of(triangles_.begin(), triangles_.end(), is_it)) return true;
  if (triangles_.size() == kMostCopied || scene.has_alpha(material)) return false;
  const CornerAndEdges place{{c.x, c.y, c.z}, {{e.x, e.y, e.z}, {f.x, f.y, f.z}}};
  triangles_.push_back({place, highest, triangle, takes_flux(triangle), lit_side(triangle)});
  return true;
}

/// The corner and edges of a triangle in the cluster's frame.
std::array<Vec3, 3> NearbySurface::local_triangle(std::uint32_t triangle) const {
  const Scene& scene = tracer_.scene();
  if (scene.stores(triangle)) {
    DiffuseTriangleRoom unused;
    const DiffuseTriangle& t = scene.diffuse_triangle(triangle, unused);
    return {frame_.to_local(t.corner - cluster_->center), frame_.to_local(t.edge[0]), frame_.to_local(t.edge[1])};
  }
  // Many are visited near instances, and the rest of a DiffuseTriangle takes longer than its place.
  const auto [a, b, c] = scene.geometry().corners(triangle);
  return {frame_.to_local(a - cluster_->center), frame_.to_local(b - a), frame_.to_local(c - a)};
}

/// Whether a triangle, in the cluster's frame, comes within reach of the axis.
bool NearbySurface::reaches(const std::array<Vec3, 3>& corner) const {
  float least = std::numeric_limits<float>::infinity();
  int left = 0, right = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 a = corner[i], b = corner[(i + 1) % 3];
    least = std::min(least, axis_distance_squared(a, b));
    (area_from_axis(a, b) < 0 ? right : left) += 1;
  }
  return least <= reach_squared_ || left == 3 || right == 3;
}

const std::vector<Meeting>& NearbySurface::meetings(const Segments& segments, float first, float step) {
  found_.clear();
  if (copied_)
    meet_copied(segments, first);
  else
    trace(segments, first, step);
  order(segments.count, step);
  return meetings_;
}

void NearbySurface::meet_copied(const Segments& segments, float first) {
  SegmentArrays arrays{segments.count, {}, {}};
  for (int axis = 0; axis < 3; ++axis) {
    arrays.origin[axis] = segments.origin[axis].data();
    arrays.direction[axis] = segments.direction[axis].data();
  }
  // For surface that takes no flux, and for that which does.
  const float least[2] = {std::min(first, rounding()), first};
  float lowest[2] = {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity()};
  for (std::size_t i = 0; i < segments.count; ++i) {
    const float z = segments.origin[2][i], along = segments.direction[2][i];
    for (const bool takes : {false, true})
      lowest[takes] = std::min(lowest[takes], z + std::min(least[takes] * along, along));
  }
  for (const Triangle& triangle : triangles_) {
    const bool takes = triangle.takes_flux;
    if (triangle.highest < lowest[takes]) continue;
    const std::size_t count = segment_hits(arrays, triangle.place, least[takes], segment_.data(), distance_.data());
    for (std::size_t i = 0; i < count; ++i)
      found_.push_back({segment_[i], distance_[i], triangle.index, takes, triangle.lit});
  }
}

/// Orders what was found by segment, then distance, then triangle: Embree visits triangles in an order of its own.
/// Surface that takes flux comes before what coincides with it, so that this does not hide it. Leaves out hits within a
/// step of the one before.
void NearbySurface::order(std::size_t segments, float step) {
  std::fill_n(begin_.begin(), segments + 1, 0);
  for (const Meeting& m : found_) ++begin_[m.segment + 1];
  for (std::size_t i = 0; i < segments; ++i) begin_[i + 1] += begin_[i];
  meetings_.resize(found_.size());
  for (const Meeting& m : found_) meetings_[begin_[m.segment]++] = m;
  std::size_t kept = 0, first = 0;
  for (std::size_t i = 0; i < segments; ++i) {
    const std::size_t last = begin_[i];
    if (last - first > 1)
      std::sort(&meetings_[first], &meetings_[first] + (last - first), [&](const Meeting& a, const Meeting& b) {
        const auto place = [&](const Meeting& m) { return m.distance - (m.takes_flux ? rounding() : 0); };
        return std::pair(place(a), a.triangle) < std::pair(place(b), b.triangle);
      });
    // From where on hits count, for surface that takes no flux and for that which does.
    float next[2] = {-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
    for (; first < last; ++first) {
      const Meeting m = meetings_[first];
      if (m.distance < next[m.takes_flux]) continue;
      next[m.takes_flux] = m.distance + (m.takes_flux ? step : std::min(step, rounding()));
      meetings_[kept++] = m;
    }
  }
  meetings_.resize(kept);
}

/// Traces each segment from hit to hit. Close behind surface that takes no flux may be some that does.
void NearbySurface::trace(const Segments& segments, float first, float step) {
  std::vector<std::uint32_t> active;
  rays_.clear();
  for (std::uint32_t i = 0; i < segments.count; ++i) {
    const auto at = [&](const auto& of) { return Vec3{of[0][i], of[1][i], of[2][i]}; };
    active.push_back(i);
    rays_.push_back({cluster_->center + frame_.to_world(at(segments.origin)), std::min(first, rounding()),
                     frame_.to_world(at(segments.direction)), 1});
  }
  while (!active.empty()) {
    crowded_ |= found_.size() >= kMostHitsOfSegment * segments.count;
    if (crowded_) break;
    hits_.resize(rays_.size());
    tracer_.intersect(rays_, hits_, RayOrder::surface);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < active.size(); ++i) {
      const auto& [distance, triangle, barycentric] = hits_[i];
      if (triangle == kNone) continue;
      const bool takes = takes_flux(triangle);
      if (!takes || distance >= first) found_.push_back({active[i], distance, triangle, takes, lit_side(triangle)});
      active[kept] = active[i];
      rays_[kept] = rays_[i];
      rays_[kept++].t_min = distance + (takes && distance >= first ? step : std::min(step, rounding()));
    }
    active.resize(kept);
    rays_.resize(kept);
  }
}

}  // namespace glowworm
