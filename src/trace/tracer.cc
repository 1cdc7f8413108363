#include "trace/tracer.h"

#include <embree3/rtcore.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <new>
#include <tuple>
#include <utility>

#include "core/error.h"
#include "scene/surface.h"
#include "trace/instruction_set.h"
#include "trace/lamps_in_planes.h"

namespace glowworm {

namespace {

/// Size of Embree's ray packets: the width of AVX2, which is available wherever this Embree runs.
constexpr std::size_t kPacket = 8;
/// Coherent rays (from the camera) are faster in wider packets.
constexpr std::size_t kCoherentPacket = 16;
/// Share of the scene's diagonal within which the origins of coherent rays lie.
constexpr float kNearOrigins = 1e-3f;

/// The triangles of one Embree geometry, as indices into the scene's geometry.
using TriangleList = std::vector<std::uint32_t>;

/// Numbers of Embree's geometries: opaque triangles, triangles that rays may pass (Scene::has_alpha, is_pane, and
/// LampsInPlanes), and the same for triangles that follow() may move.
constexpr unsigned kTested = 1, kMovable = 2, kGeometries = 4;

[[noreturn]] void fail(RTCError code, const char* doing) {
  const auto message = [&](const char* why) { return fmt::format("Embree could not {}: {}", doing, why); };
  switch (code) {
    case RTC_ERROR_OUT_OF_MEMORY:
      throw Error(message("out of memory"), "Use a smaller scene, or leave the program more memory (ulimit -v).");
    case RTC_ERROR_UNSUPPORTED_CPU:
      throw Error(message("this processor is not supported"), "It needs at least SSE2.");
    case RTC_ERROR_UNKNOWN:
      throw Error(message("an unknown error"), "The machine may be short of memory or threads.");
    default:
      throw Error(message(fmt::format("error {}", static_cast<int>(code)).c_str()));
  }
}

void throw_on_error(RTCDevice device, const char* doing) {
  if (const RTCError code = rtcGetDeviceError(device); code != RTC_ERROR_NONE) fail(code, doing);
}

}  // namespace

struct Tracer::Implementation {
  const Scene* scene;
  std::shared_ptr<const Geometry> geometry;  ///< geometry that `world` is built from
  RTCDevice device = nullptr;
  RTCScene world = nullptr;
  std::vector<std::uint32_t> movable;
  TriangleList lists[kGeometries];
  bool attached[kGeometries] = {};
  bool one_list = false;
  LampsInPlanes lamps;
  bool single_sided;   ///< a material is
  bool panes = false;  ///< a material is one
  bool whole = true;   ///< no build of `world` has failed
  std::atomic<std::int64_t> bytes{0};

  explicit Implementation(const Scene& s) : scene(&s), geometry(s.shared_geometry()) {
    single_sided =
        std::any_of(s.materials().begin(), s.materials().end(), [](const Material& m) { return m.single_sided; });
    for (std::uint32_t i = 0; i < s.materials().size(); ++i) panes |= s.is_pane(i);
  }
  ~Implementation() {
    // Embree 3.13 ends the program when it releases a scene whose build ran out of memory. Such a scene leaks instead.
    if (!whole) return;
    if (world) rtcReleaseScene(world);
    if (device) rtcReleaseDevice(device);
  }

  /// Builds whatever changed; throws Error if that fails.
  void commit() {
    whole = false;
    rtcCommitScene(world);
    throw_on_error(device, "build its acceleration structure");
    whole = true;
  }

  /// If all triangles are in one geometry, the list is the identity and is not read.
  std::uint32_t triangle(unsigned id, unsigned primitive) const { return one_list ? primitive : lists[id][primitive]; }
  void build();
  void find_lamps();
  void sort_triangles();
  void add_geometry(unsigned id);
  void visit_near(Vec3 center, float radius, const std::function<bool(std::uint32_t)>& visit) const;
  void place_vertices(Vec3* vertices, const TriangleList& list) const;
};

namespace {

/// A pane that a ray passes.
struct PassedPane {
  unsigned ray;    ///< its number in its packet
  float distance;  ///< along the ray
  std::uint32_t triangle;
  Vec2 barycentric;
};

/// The context of rays of occlusion.
struct OcclusionContext {
  RTCIntersectContext embree;
  std::vector<PassedPane>* passed = nullptr;  ///< panes do not occlude: they are listed here, some more than once
  bool out_of_memory = false;                 ///< for a pane
};

/// Exceptions may not pass through Embree.
void note_pane(OcclusionContext& context, const PassedPane& pane) noexcept {
  try {
    context.passed->push_back(pane);
  } catch (const std::bad_alloc&) {
    context.out_of_memory = true;
  }
}

/// Embree calls this for a hit on a surface that rays may pass. Rejects the hit where the surface is absent or a lamp
/// lies in its plane, and on panes that the context lists.
template <bool kOcclusion>
void pass_filter(const RTCFilterFunctionNArguments* args) {
  const auto& self = *static_cast<const Tracer::Implementation*>(args->geometryUserPtr);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const Vec2 barycentric{RTCHitN_u(args->hit, args->N, i), RTCHitN_v(args->hit, args->N, i)};
    const Vec3 origin{RTCRayN_org_x(args->ray, args->N, i), RTCRayN_org_y(args->ray, args->N, i),
                      RTCRayN_org_z(args->ray, args->N, i)};
    const Vec3 direction{RTCRayN_dir_x(args->ray, args->N, i), RTCRayN_dir_y(args->ray, args->N, i),
                         RTCRayN_dir_z(args->ray, args->N, i)};
    const std::uint32_t triangle =
        self.triangle(RTCHitN_geomID(args->hit, args->N, i), RTCHitN_primID(args->hit, args->N, i));
    const std::uint32_t material = self.geometry->material[triangle];
    bool passes =
        self.lamps.covers(*self.scene, triangle, barycentric) ||
        (self.scene->has_alpha(material) && !alpha_present(*self.scene, triangle, barycentric, origin, direction));
    if constexpr (kOcclusion) {
      auto& context = *reinterpret_cast<OcclusionContext*>(args->context);
      if (!passes && context.passed && self.scene->is_pane(material)) {
        note_pane(context,
                  {RTCRayN_id(args->ray, args->N, i), RTCRayN_tfar(args->ray, args->N, i), triangle, barycentric});
        passes = true;
      }
    }
    if (passes) args->valid[i] = 0;
  }
}

/// Called for the hits of camera rays; rejects those on the backs of single-sided surfaces.
void side_filter(const RTCFilterFunctionNArguments* args) {
  const auto& self = *static_cast<const Tracer::Implementation*>(args->geometryUserPtr);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const std::uint32_t triangle =
        self.triangle(RTCHitN_geomID(args->hit, args->N, i), RTCHitN_primID(args->hit, args->N, i));
    if (!self.scene->materials()[self.geometry->material[triangle]].single_sided) continue;
    const Vec3 direction{RTCRayN_dir_x(args->ray, args->N, i), RTCRayN_dir_y(args->ray, args->N, i),
                         RTCRayN_dir_z(args->ray, args->N, i)};
    if (dot(direction, self.scene->diffuse_triangle(triangle).normal) > 0) args->valid[i] = 0;
  }
}

/// What Embree's point query calls.
struct TriangleVisit {
  const Tracer::Implementation* self;
  const std::function<bool(std::uint32_t)>* visit;
  bool ended = false;
};

/// Embree calls this for each triangle near a point. After the end the ball is a point, which few boxes contain.
bool visit_triangle(RTCPointQueryFunctionArguments* args) {
  auto& to = *static_cast<TriangleVisit*>(args->userPtr);
  if (to.ended) return false;
  to.ended = !(*to.visit)(to.self->triangle(args->geomID, args->primID));
  if (to.ended) args->query->radius = 0;
  return to.ended;
}

bool count_bytes(void* user, ssize_t bytes, bool) {
  static_cast<Tracer::Implementation*>(user)->bytes += bytes;
  return true;
}

RTCIntersectContext make_context(RayOrder order, bool single_sided) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags =
      order == RayOrder::camera ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  if (order == RayOrder::camera && single_sided) context.filter = side_filter;
  return context;
}

RTCRay embree_ray(const Ray& r) {
  const Vec3 &o = r.origin, &d = r.direction;
  return {o.x, o.y, o.z, r.t_min, d.x, d.y, d.z, 0, r.t_max, ~0u, 0, 0};
}

/// Fills what all rays of a batch have in common.
template <typename RayPacket, std::size_t kWidth>
void set_common(RayPacket& packet, int (&valid)[kWidth]) {
  for (std::size_t i = 0; i < kWidth; ++i) {
    packet.time[i] = 0;
    packet.mask[i] = ~0u;
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
}

void call(const int* valid, RTCScene s, RTCIntersectContext* c, RTCRayHit8* p) { rtcIntersect8(valid, s, c, p); }
void call(const int* valid, RTCScene s, RTCIntersectContext* c, RTCRayHit16* p) { rtcIntersect16(valid, s, c, p); }

/// Traces `count` rays in packets. @param context_of context_of(first, n) is that of rays [first, first + n)
/// @param ray_of ray_of(i) returns ray i @param found found(i, Hit) takes its hit
template <typename Packet, std::size_t kWidth, typename ContextOf, typename RayOf, typename Found>
void intersect_packets(const Tracer::Implementation& self, std::size_t count, ContextOf&& context_of, RayOf&& ray_of,
                       Found&& found) {
  Packet packet;
  alignas(64) int valid[kWidth];
  set_common(packet.ray, valid);
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
      found(first + i, Hit{packet.ray.tfar[i],
                           hits ? self.triangle(packet.hit.geomID[i], packet.hit.primID[i]) : kNone,
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

/// What the panes that ray number `ray` of its packet has passed let through. Embree may list a triangle several times,
/// in any order: its structure splits triangles. Panes that the ray meets in one place count once: it passes the edge
/// between two triangles of a pane.
RGB through_panes(const Tracer::Implementation& self, std::vector<PassedPane>& passed, unsigned ray, Vec3 direction) {
  std::sort(passed.begin(), passed.end(), [](const PassedPane& a, const PassedPane& b) {
    return std::tie(a.ray, a.distance, a.triangle) < std::tie(b.ray, b.distance, b.triangle);
  });
  const auto rounding = [&](const PassedPane& pane) {
    const DiffuseTriangle& t = self.scene->diffuse_triangle(pane.triangle);
    return t.offset() / std::abs(dot(t.normal, direction));
  };
  RGB product(1.0f);
  const PassedPane* last = nullptr;
  for (const PassedPane& pane : passed) {
    if (pane.ray != ray) continue;
    const bool again = last && pane.distance - last->distance <= rounding(pane) + rounding(*last);
    if (!again) product *= straight_transmittance(*self.scene, pane.triangle, pane.barycentric, direction);
    last = &pane;
  }
  return product;
}

}  // namespace

/// Makes all of `world` anew.
void Tracer::Implementation::build() {
  sort_triangles();
  for (unsigned id = 0; id < kGeometries; ++id) {
    if (std::exchange(attached[id], false)) rtcDetachGeometry(world, id);
    add_geometry(id);
  }
  commit();
}

/// Finds the lamps in other surfaces' planes, and builds again if they are not those that `world` was built with.
void Tracer::Implementation::find_lamps() {
  LampsInPlanes found(*scene, [&](Vec3 center, float radius, const auto& visit) { visit_near(center, radius, visit); });
  const bool same = found.covered() == lamps.covered();
  lamps = std::move(found);
  if (!same) build();
}

void Tracer::Implementation::sort_triangles() {
  const Geometry& g = *geometry;
  std::vector<bool> moves(g.triangle_count(), false), tested(g.triangle_count(), false);
  for (const std::uint32_t i : movable) moves[i] = true;
  for (const std::uint32_t i : lamps.covered()) tested[i] = true;
  for (TriangleList& list : lists) list.clear();
  for (std::uint32_t i = 0; i < g.triangle_count(); ++i) {
    if (scene->repeats(i)) continue;
    const bool passed = tested[i] || scene->has_alpha(g.material[i]) || scene->is_pane(g.material[i]);
    lists[(moves[i] ? kMovable : 0) + (passed ? kTested : 0)].push_back(i);
  }
  one_list = false;
  for (const TriangleList& list : lists) one_list |= !list.empty() && list.size() == g.triangle_count();
}

void Tracer::Implementation::add_geometry(unsigned id) {
  const TriangleList& list = lists[id];
  if (list.empty()) return;
  RTCGeometry shape = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  throw_on_error(device, "take the triangles");
  // Movable triangles have vertices of their own here, so that few vertices are written when they move.
  const bool own_vertices = id >= kMovable;
  const std::size_t vertex_count = own_vertices ? 3 * list.size() : geometry->positions.size();
  auto* vertices = static_cast<Vec3*>(
      rtcSetNewGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3), vertex_count));
  auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(shape, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                      3 * sizeof(std::uint32_t), list.size()));
  throw_on_error(device, "take the triangles");
  if (own_vertices) {
    rtcSetGeometryBuildQuality(shape, RTC_BUILD_QUALITY_MEDIUM);
    place_vertices(vertices, list);
    for (std::uint32_t i = 0; i < 3 * list.size(); ++i) indices[i] = i;
  } else {
    std::memcpy(vertices, geometry->positions.data(), vertex_count * sizeof(Vec3));
    for (std::size_t i = 0; i < list.size(); ++i) std::copy_n(geometry->triangles[list[i]].data(), 3, indices + 3 * i);
  }
  rtcSetGeometryUserData(shape, this);
  if (id & kTested) {
    rtcSetGeometryIntersectFilterFunction(shape, pass_filter<false>);
    rtcSetGeometryOccludedFilterFunction(shape, pass_filter<true>);
  }
  rtcCommitGeometry(shape);
  rtcAttachGeometryByID(world, shape, id);
  attached[id] = true;
  rtcReleaseGeometry(shape);
}

void Tracer::Implementation::visit_near(Vec3 center, float radius,
                                        const std::function<bool(std::uint32_t)>& visit) const {
  TriangleVisit to{this, &visit};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  RTCPointQuery query;
  query.x = center.x;
  query.y = center.y;
  query.z = center.z;
  query.time = 0;
  query.radius = radius;
  rtcPointQuery(world, &query, &context, visit_triangle, &to);
}

void Tracer::Implementation::place_vertices(Vec3* vertices, const TriangleList& list) const {
  for (std::size_t i = 0; i < list.size(); ++i)
    for (std::size_t corner = 0; corner < 3; ++corner)
      vertices[3 * i + corner] = geometry->positions[geometry->triangles[list[i]][corner]];
}

Tracer::Tracer(const Scene& scene) : Tracer(scene, {}) {}

Tracer::Tracer(const Scene& scene, std::span<const std::uint32_t> movable)
    : implementation_(std::make_unique<Implementation>(scene)) {
  Implementation& self = *implementation_;
  self.device = rtcNewDevice(ray_device_configuration().c_str());
  // If the device was not made, the error belongs to the calling thread.
  if (!self.device) fail(rtcGetDeviceError(nullptr), "start");
  rtcSetDeviceMemoryMonitorFunction(self.device, count_bytes, &self);
  self.world = rtcNewScene(self.device);
  throw_on_error(self.device, "start");
  // Rays through the edge between two triangles meet one of them: light stays in closed rooms.
  // Only a dynamic scene has separate structures for its geometries, and rebuilds those that changed. Other scenes are
  // built once, so a slower, better build pays off.
  if (movable.empty()) rtcSetSceneBuildQuality(self.world, RTC_BUILD_QUALITY_HIGH);
  rtcSetSceneFlags(self.world,
                   static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | (movable.empty() ? 0 : RTC_SCENE_FLAG_DYNAMIC) |
                                              (self.single_sided ? RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION : 0)));
  self.movable.assign(movable.begin(), movable.end());
  self.build();
  self.find_lamps();
}

void Tracer::follow(const Scene& scene) {
  Implementation& self = *implementation_;
  self.scene = &scene;
  if (self.geometry == scene.shared_geometry()) return;
  self.geometry = scene.shared_geometry();
  for (unsigned id = kMovable; id < kGeometries; ++id) {
    if (self.lists[id].empty()) continue;
    RTCGeometry shape = rtcGetGeometry(self.world, id);
    self.place_vertices(static_cast<Vec3*>(rtcGetGeometryBufferData(shape, RTC_BUFFER_TYPE_VERTEX, 0)), self.lists[id]);
    rtcUpdateGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(shape);
  }
  self.commit();
  self.find_lamps();
}

Tracer::~Tracer() = default;

const Scene& Tracer::scene() const { return *implementation_->scene; }
std::uint64_t Tracer::bytes() const {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, implementation_->bytes));
}

Hit Tracer::intersect(const Ray& ray, RayOrder order) const {
  RTCIntersectContext context = make_context(order, implementation_->single_sided);
  RTCRayHit query;
  query.ray = embree_ray(ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(implementation_->world, &context, &query);
  Hit hit;
  hit.distance = query.ray.tfar;
  if (query.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
    hit.triangle = implementation_->triangle(query.hit.geomID, query.hit.primID);
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
  OcclusionContext context{make_context(RayOrder::incoherent, false), implementation_->panes ? &passed : nullptr};
  if (is_occluded(*implementation_, ray, context)) return RGB(0.0f);
  return passed.empty() ? RGB(1.0f) : through_panes(*implementation_, passed, 0, ray.direction);
}

void Tracer::intersect(std::span<const Ray> rays, std::span<Hit> hits, RayOrder order) const {
  RTCIntersectContext context = make_context(order, implementation_->single_sided);
  const auto context_of = [&](std::size_t, std::size_t) { return &context; };
  const auto ray_of = [&](std::size_t i) -> const Ray& { return rays[i]; };
  const auto found = [&](std::size_t i, const Hit& hit) { hits[i] = hit; };
  if (order == RayOrder::camera)
    intersect_packets<RTCRayHit16, kCoherentPacket>(*implementation_, rays.size(), context_of, ray_of, found);
  else
    intersect_packets<RTCRayHit8, kPacket>(*implementation_, rays.size(), context_of, ray_of, found);
}

void Tracer::intersect(const RayArrays& rays, const HitArrays& hits) const {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  // Camera rays without the filter of sides.
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
  intersect_packets<RTCRayHit8, kPacket>(*implementation_, rays.origin.size(), context_of, ray_of, found);
}

void Tracer::occluded(std::span<const Ray> rays, std::span<std::uint8_t> out) const {
  OcclusionContext context{make_context(RayOrder::incoherent, false)};
  occlude_packets(*implementation_, rays, context, [&](std::size_t i, bool hidden) { out[i] = hidden ? 1 : 0; });
}

void Tracer::transmittance(std::span<const Ray> rays, std::span<RGB> out) const {
  std::vector<PassedPane> passed;
  OcclusionContext context{make_context(RayOrder::incoherent, false), implementation_->panes ? &passed : nullptr};
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
