#include "trace/tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <tuple>

#include "scene/surface.h"
#include "trace/ray_structure.h"

namespace glowworm {

namespace {

/// Size of Embree's ray packets: the width of AVX2, which is available wherever this Embree runs.
constexpr std::size_t kPacket = 8;
/// Coherent rays (from the camera) are faster in wider packets.
constexpr std::size_t kCoherentPacket = 16;
/// Share of the scene's diagonal within which the origins of coherent rays lie.
constexpr float kNearOrigins = 1e-3f;

/// The context of a packet of rays with TieRule::number: the nearest candidate of each so far.
struct TieContext {
  RTCIntersectContext embree;
  float distance[kPacket];
  std::uint32_t triangle[kPacket];

  explicit TieContext(const RTCIntersectContext& context) : embree(context) {}
  /// Makes it the context of another packet. No distance equals one that is not a number.
  void clear() { std::fill_n(distance, kPacket, std::numeric_limits<float>::quiet_NaN()); }
};

/// Embree calls this for candidates no farther than the nearest one so far; rejects those at the same distance with a
/// higher number.
void tie_filter(const RTCFilterFunctionNArguments* args) {
  const auto& self = *static_cast<const Tracer::Implementation*>(args->geometryUserPtr);
  auto& nearest = *reinterpret_cast<TieContext*>(args->context);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const unsigned ray = RTCRayN_id(args->ray, args->N, i);
    const float distance = RTCRayN_tfar(args->ray, args->N, i);
    const std::uint32_t triangle =
        self.triangle(RTCHitN_geomID(args->hit, args->N, i), RTCHitN_primID(args->hit, args->N, i),
                      RTCHitN_instID(args->hit, args->N, i, 0));
    if (distance == nearest.distance[ray] && triangle > nearest.triangle[ray]) {
      args->valid[i] = 0;
      continue;
    }
    nearest.distance[ray] = distance;
    nearest.triangle[ray] = triangle;
  }
}

RTCIntersectContext make_context(RayOrder order, bool hidden) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags =
      order == RayOrder::camera ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  if (order == RayOrder::camera && hidden) context.filter = camera_filter;
  return context;
}

unsigned mask_of(RayOrder order) {
  return order == RayOrder::surface ? ~kHitsInterfaces : order == RayOrder::partly ? ~kPassesByChance : ~0u;
}

RTCRay embree_ray(const Ray& r) {
  const Vec3 &o = r.origin, &d = r.direction;
  return {o.x, o.y, o.z, r.t_min, d.x, d.y, d.z, r.time, r.t_max, ~0u, 0, 0};
}

/// Fills what all rays of a batch have in common.
template <typename RayPacket, std::size_t kWidth>
void set_common(RayPacket& packet, int (&valid)[kWidth], RayOrder order = RayOrder::incoherent) {
  for (std::size_t i = 0; i < kWidth; ++i) {
    packet.mask[i] = mask_of(order);
    packet.id[i] = static_cast<unsigned>(i);
    packet.flags[i] = 0;
    valid[i] = -1;
  }
}

/// Leaves the lanes from n on out of a packet.
template <std::size_t kWidth>
void shorten(int (&valid)[kWidth], std::size_t n) {
  for (std::size_t i = n; i < kWidth; ++i) valid[i] = 0;
}

/// Fills lane i of a packet's rays.
template <typename RayPacket>
void set_ray(RayPacket& packet, std::size_t i, const Ray& ray) {
  packet.org_x[i] = ray.origin.x;
  packet.org_y[i] = ray.origin.y;
  packet.org_z[i] = ray.origin.z;
  packet.tnear[i] = ray.t_min;
  packet.dir_x[i] = ray.direction.x;
  packet.dir_y[i] = ray.direction.y;
  packet.dir_z[i] = ray.direction.z;
  packet.tfar[i] = ray.t_max;
  packet.time[i] = ray.time;
}

void call(const int* valid, RTCScene s, RTCIntersectContext* c, RTCRayHit8* p) { rtcIntersect8(valid, s, c, p); }
void call(const int* valid, RTCScene s, RTCIntersectContext* c, RTCRayHit16* p) { rtcIntersect16(valid, s, c, p); }

/// Traces `count` rays in packets. @param order the kind of all @param context_of(first, n) returns the context of rays
/// [first, first + n)
/// @param ray_of ray_of(i) returns ray i @param found found(i, Hit) takes its hit
template <typename Packet, std::size_t kWidth, typename ContextOf, typename RayOf, typename Found>
void intersect_packets(const Tracer::Implementation& self, std::size_t count, RayOrder order, ContextOf&& context_of,
                       RayOf&& ray_of, Found&& found) {
  Packet packet;
  alignas(64) int valid[kWidth];
  set_common(packet.ray, valid, order);
  for (std::size_t first = 0; first < count; first += kWidth) {
    const std::size_t n = std::min(kWidth, count - first);
    if (n < kWidth) shorten(valid, n);
    for (std::size_t i = 0; i < kWidth; ++i) {
      set_ray(packet.ray, i, ray_of(first + std::min(i, n - 1)));
      packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    call(valid, self.world, context_of(first, n), &packet);
    for (std::size_t i = 0; i < n; ++i) {
      const bool hits = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
      found(first + i,
            Hit{packet.ray.tfar[i],
                hits ? self.triangle(packet.hit.geomID[i], packet.hit.primID[i], packet.hit.instID[0][i]) : kNone,
                {packet.hit.u[i], packet.hit.v[i]}});
    }
  }
}

/// Whether rays are so close to each other that Embree's way for coherent rays pays off: in the atrium it gains a fifth
/// where directions of a packet differ by 0.02 of their length, nothing at 0.04, and loses two fifths at 0.2.
/// @param near square of the distance of origins (m) that is allowed
bool is_coherent(const RayArrays& rays, std::size_t first, std::size_t n, float near) {
  constexpr float kSpread = 0.03f;
  const Vec3 o = rays.origin[first], d = rays.direction[first];
  const float similar = kSpread * kSpread * length_squared(d);
  const auto fits = [&](std::size_t i) {
    return length_squared(rays.direction[i] - d) <= similar && length_squared(rays.origin[i] - o) <= near;
  };
  // The last ray tells most incoherent batches.
  if (!fits(first + n - 1)) return false;
  bool all = true;
  for (std::size_t i = first + 1; i + 1 < first + n; ++i) all &= fits(i);
  return all;
}

/// Traces one ray of occlusion.
bool is_occluded(const Tracer::Implementation& self, const Ray& ray, OcclusionContext& context) {
  RTCRay query = embree_ray(ray);
  rtcOccluded1(self.world, &context.embree, &query);
  if (context.out_of_memory) throw std::bad_alloc();
  return query.tfar < 0;
}

/// Calls found(i, whether ray i is occluded) for each ray, after each packet.
template <typename Found>
void occlude_packets(const Tracer::Implementation& self, std::span<const Ray> rays, OcclusionContext& context,
                     Found&& found) {
  RTCRay8 packet;
  alignas(64) int valid[kPacket];
  set_common(packet, valid);
  for (std::size_t first = 0; first < rays.size(); first += kPacket) {
    const std::size_t n = std::min(kPacket, rays.size() - first);
    if (n < kPacket) shorten(valid, n);
    for (std::size_t i = 0; i < kPacket; ++i) set_ray(packet, i, rays[first + std::min(i, n - 1)]);
    rtcOccluded8(valid, self.world, &context.embree, &packet);
    if (context.out_of_memory) throw std::bad_alloc();
    // Embree sets tfar to minus infinity where the ray is occluded.
    for (std::size_t i = 0; i < n; ++i) found(first + i, packet.tfar[i] < 0);
    if (context.passed) context.passed->clear();
  }
}

/// Sorts the panes that the rays of a packet have passed, nearest first for each ray.
void sort_panes(std::vector<PassedPane>& passed) {
  std::sort(passed.begin(), passed.end(), [](const PassedPane& a, const PassedPane& b) {
    return std::tie(a.ray, a.distance, a.triangle) < std::tie(b.ray, b.distance, b.triangle);
  });
}

/// Calls visit(pane) for each pane that ray number `ray` of its packet has passed, nearest first. Embree may list a
/// triangle several times: its structure splits triangles. Panes that the ray meets in one place count once: it passes
/// the edge between two triangles of a pane. Interfaces and surfaces with alpha do only if they are of one material and
/// face one way: two media may touch, and a leaf may lie on a pane.
template <typename Visit>
void for_panes(const Scene& scene, const std::vector<PassedPane>& sorted, unsigned ray, Vec3 direction, Visit&& visit) {
  const auto facing = [&](const PassedPane& pane) {
    return dot(scene.diffuse_triangle(pane.triangle).normal, direction);
  };
  const auto rounding = [&](const PassedPane& pane) {
    return scene.diffuse_triangle(pane.triangle).offset() / std::abs(facing(pane));
  };
  const auto material = [&](const PassedPane& pane) { return scene.geometry().material_of(pane.triangle); };
  const auto lies_on_others = [&](const PassedPane& pane) {
    return scene.materials()[material(pane)].kind == MaterialKind::interface || scene.has_alpha(material(pane));
  };
  const auto are_one = [&](const PassedPane& a, const PassedPane& b) {
    if (!lies_on_others(a) && !lies_on_others(b)) return true;
    return material(a) == material(b) && facing(a) * facing(b) > 0;
  };
  const PassedPane* last = nullptr;
  for (const PassedPane& pane : sorted) {
    if (pane.ray != ray) continue;
    const bool again =
        last && pane.distance - last->distance <= rounding(pane) + rounding(*last) && are_one(pane, *last);
    if (!again) visit(pane);
    last = &pane;
  }
}

/// What the panes that ray number `ray` of its packet has passed let through.
RGB through_panes(const Tracer::Implementation& self, std::vector<PassedPane>& passed, unsigned ray, Vec3 direction) {
  sort_panes(passed);
  RGB product(1.0f);
  for_panes(*self.scene, passed, ray, direction, [&](const PassedPane& pane) {
    product *= straight_transmittance(*self.scene, pane.triangle, pane.barycentric, direction);
  });
  return product;
}

}  // namespace

void camera_filter(const RTCFilterFunctionNArguments* args) {
  const auto& self = *static_cast<const Tracer::Implementation*>(args->geometryUserPtr);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const unsigned instance = RTCHitN_instID(args->hit, args->N, i, 0);
    const std::uint32_t triangle =
        self.triangle(RTCHitN_geomID(args->hit, args->N, i), RTCHitN_primID(args->hit, args->N, i), instance);
    const Material& material = self.scene->materials()[self.geometry->material_of(triangle)];
    if (material.unseen) args->valid[i] = 0;
    if (!material.single_sided) continue;
    Vec3 direction{RTCRayN_dir_x(args->ray, args->N, i), RTCRayN_dir_y(args->ray, args->N, i),
                   RTCRayN_dir_z(args->ray, args->N, i)};
    // The ray is in the space of the mesh.
    if (instance != RTC_INVALID_GEOMETRY_ID) direction = self.geometry->instances[instance].to_world.vector(direction);
    if (dot(direction, self.scene->diffuse_triangle(triangle).normal) > 0) args->valid[i] = 0;
  }
}

Tracer::Tracer(const Scene& scene, TieRule ties)
    : implementation_(std::make_unique<Implementation>(scene, std::span<const std::uint32_t>(), ties)) {}
Tracer::Tracer(const Scene& scene, std::span<const std::uint32_t> movable)
    : implementation_(std::make_unique<Implementation>(scene, movable, TieRule::structure)) {}

Tracer::~Tracer() = default;

void Tracer::follow(const Scene& scene) { implementation_->follow(scene); }

const Scene& Tracer::scene() const { return *implementation_->scene; }
std::uint64_t Tracer::bytes() const {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, implementation_->bytes));
}

Hit Tracer::intersect(const Ray& ray, RayOrder order) const {
  RTCIntersectContext context = make_context(order, implementation_->hidden);
  RTCRayHit query;
  query.ray = embree_ray(ray);
  query.ray.mask = mask_of(order);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(implementation_->world, &context, &query);
  Hit hit;
  hit.distance = query.ray.tfar;
  if (query.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
    hit.triangle = implementation_->triangle(query.hit.geomID, query.hit.primID, query.hit.instID[0]);
    hit.barycentric = {query.hit.u, query.hit.v};
  }
  return hit;
}

bool Tracer::occluded(const Ray& ray) const {
  OcclusionContext context{make_context(RayOrder::incoherent, false)};
  return is_occluded(*implementation_, ray, context);
}

RGB Tracer::transmittance(const Ray& ray) const {
  std::vector<PassedPane> passed;
  OcclusionContext context{make_context(RayOrder::incoherent, false), implementation_->passable ? &passed : nullptr};
  if (is_occluded(*implementation_, ray, context)) return RGB(0.0f);
  return passed.empty() ? RGB(1.0f) : through_panes(*implementation_, passed, 0, ray.direction);
}

bool Tracer::passes(const Ray& ray, std::vector<PassedSurface>& passed) const {
  passed.clear();
  std::vector<PassedPane> panes;
  OcclusionContext context{make_context(RayOrder::incoherent, false), implementation_->passable ? &panes : nullptr};
  if (is_occluded(*implementation_, ray, context)) return false;
  sort_panes(panes);
  for_panes(scene(), panes, 0, ray.direction, [&](const PassedPane& pane) { passed.push_back(pane); });
  return true;
}

void Tracer::intersect(std::span<const Ray> rays, std::span<Hit> hits, RayOrder order) const {
  RTCIntersectContext context = make_context(order, implementation_->hidden);
  const auto context_of = [&](std::size_t, std::size_t) { return &context; };
  const auto ray_of = [&](std::size_t i) -> const Ray& { return rays[i]; };
  const auto found = [&](std::size_t i, const Hit& hit) { hits[i] = hit; };
  if (order == RayOrder::camera) {
    intersect_packets<RTCRayHit16, kCoherentPacket>(*implementation_, rays.size(), order, context_of, ray_of, found);
  } else if (implementation_->ties == TieRule::structure) {
    intersect_packets<RTCRayHit8, kPacket>(*implementation_, rays.size(), order, context_of, ray_of, found);
  } else {
    TieContext nearest(context);
    nearest.embree.filter = tie_filter;
    const auto next_packet = [&](std::size_t, std::size_t) {
      nearest.clear();
      return &nearest.embree;
    };
    intersect_packets<RTCRayHit8, kPacket>(*implementation_, rays.size(), order, next_packet, ray_of, found);
  }
}

void Tracer::intersect(const RayArrays& rays, const HitArrays& hits) const {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  // Camera rays without their filter.
  RTCIntersectContext coherent = make_context(RayOrder::camera, false);
  RTCIntersectContext incoherent = make_context(RayOrder::incoherent, false);
  const float near = kNearOrigins * kNearOrigins * length_squared(scene().bounds().diagonal());
  const float one_t_max = rays.t_max.empty() ? kInfinity : rays.t_max[0];
  const bool each = rays.t_max.size() > 1;
  const auto context_of = [&](std::size_t first, std::size_t n) {
    return is_coherent(rays, first, n, near) ? &coherent : &incoherent;
  };
  const auto ray_of = [&](std::size_t i) {
    return Ray{rays.origin[i], rays.t_min, rays.direction[i], each ? rays.t_max[i] : one_t_max};
  };
  const auto found = [&](std::size_t i, const Hit& hit) {
    const bool none = hit.triangle == kNone;
    hits.distance[i] = none ? kInfinity : hit.distance;
    hits.triangle[i] = hit.triangle;
    hits.barycentric[i] = none ? Vec2() : hit.barycentric;
  };
  intersect_packets<RTCRayHit8, kPacket>(*implementation_, rays.origin.size(), RayOrder::incoherent, context_of, ray_of,
                                         found);
}

void Tracer::occluded(std::span<const Ray> rays, std::span<std::uint8_t> out) const {
  OcclusionContext context{make_context(RayOrder::incoherent, false)};
  occlude_packets(*implementation_, rays, context, [&](std::size_t i, bool hidden) { out[i] = hidden ? 1 : 0; });
}

void Tracer::transmittance(std::span<const Ray> rays, std::span<RGB> out) const {
  std::vector<PassedPane> passed;
  OcclusionContext context{make_context(RayOrder::incoherent, false), implementation_->passable ? &passed : nullptr};
  occlude_packets(*implementation_, rays, context, [&](std::size_t i, bool hidden) {
    out[i] = RGB(hidden ? 0.0f : 1.0f);
    if (!hidden && !passed.empty())
      out[i] = through_panes(*implementation_, passed, static_cast<unsigned>(i % kPacket), rays[i].direction);
  });
}

void Tracer::visit_near(Vec3 center, float radius, const std::function<bool(std::uint32_t)>& visit) const {
  implementation_->visit_near(center, radius, visit);
}

}  // namespace glowworm
