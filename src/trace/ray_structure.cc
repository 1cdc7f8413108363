#include "trace/ray_structure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include "core/error.h"
#include "scene/surface.h"
#include "trace/instruction_set.h"

namespace glowworm {

namespace {

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
                  {{RTCRayN_tfar(args->ray, args->N, i), triangle, barycentric}, RTCRayN_id(args->ray, args->N, i)});
        passes = true;
      }
    }
    if (passes) args->valid[i] = 0;
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

}  // namespace

Tracer::Implementation::Implementation(const Scene& s) : scene(&s), geometry(s.shared_geometry()) {
  single_sided =
      std::any_of(s.materials().begin(), s.materials().end(), [](const Material& m) { return m.single_sided; });
  for (std::uint32_t i = 0; i < s.materials().size(); ++i) panes |= s.is_pane(i);
}

// Once the first constructor has returned, an error in this one calls the destructor.
Tracer::Implementation::Implementation(const Scene& s, std::span<const std::uint32_t> movable_triangles)
    : Implementation(s) {
  movable.assign(movable_triangles.begin(), movable_triangles.end());
  device = rtcNewDevice(ray_device_configuration().c_str());
  // If the device was not made, the error belongs to the calling thread.
  if (!device) fail(rtcGetDeviceError(nullptr), "start");
  rtcSetDeviceMemoryMonitorFunction(device, count_bytes, this);
  world = rtcNewScene(device);
  throw_on_error(device, "start");
  // Rays through the edge between two triangles meet one of them: light stays in closed rooms.
  // Only a dynamic scene has separate structures for its geometries, and rebuilds those that changed. Other scenes are
  // built once, so a slower, better build pays off.
  if (movable.empty()) rtcSetSceneBuildQuality(world, RTC_BUILD_QUALITY_HIGH);
  rtcSetSceneFlags(world,
                   static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | (movable.empty() ? 0 : RTC_SCENE_FLAG_DYNAMIC) |
                                              (single_sided ? RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION : 0)));
  build();
  find_lamps();
}

Tracer::Implementation::~Implementation() {
  // Embree 3.13 ends the program when it releases a scene whose build ran out of memory. Such a scene leaks instead.
  if (!whole) return;
  if (world) rtcReleaseScene(world);
  if (device) rtcReleaseDevice(device);
}

/// Builds whatever changed; throws Error if that fails.
void Tracer::Implementation::commit() {
  whole = false;
  rtcCommitScene(world);
  throw_on_error(device, "build its acceleration structure");
  whole = true;
}

void Tracer::Implementation::follow(const Scene& s) {
  scene = &s;
  if (geometry == s.shared_geometry()) return;
  geometry = s.shared_geometry();
  for (unsigned id = kMovable; id < kGeometries; ++id) {
    if (lists[id].empty()) continue;
    RTCGeometry shape = rtcGetGeometry(world, id);
    place_vertices(static_cast<Vec3*>(rtcGetGeometryBufferData(shape, RTC_BUFFER_TYPE_VERTEX, 0)), lists[id]);
    rtcUpdateGeometryBuffer(shape, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(shape);
  }
  commit();
  find_lamps();
}

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

}  // namespace glowworm
