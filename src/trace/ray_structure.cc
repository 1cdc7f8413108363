#include "trace/ray_structure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <utility>

#include "core/error.h"
#include "scene/repeated_triangles.h"
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
/// lies in its plane, on interfaces if the ray's mask says so, and on panes and partly absent surfaces that the context
/// lists.
template <bool kOcclusion>
void pass_filter(const RTCFilterFunctionNArguments* args) {
  const auto& self = *static_cast<const Tracer::Implementation*>(args->geometryUserPtr);
  const bool by_camera = args->context->filter == camera_filter;
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const Vec2 barycentric{RTCHitN_u(args->hit, args->N, i), RTCHitN_v(args->hit, args->N, i)};
    const Vec3 origin{RTCRayN_org_x(args->ray, args->N, i), RTCRayN_org_y(args->ray, args->N, i),
                      RTCRayN_org_z(args->ray, args->N, i)};
    const Vec3 direction{RTCRayN_dir_x(args->ray, args->N, i), RTCRayN_dir_y(args->ray, args->N, i),
                         RTCRayN_dir_z(args->ray, args->N, i)};
    const std::uint32_t triangle =
        self.triangle(RTCHitN_geomID(args->hit, args->N, i), RTCHitN_primID(args->hit, args->N, i),
                      RTCHitN_instID(args->hit, args->N, i, 0));
    const std::uint32_t material = self.geometry->material_of(triangle);
    const float present = self.scene->has_alpha(material)
                              ? coverage(*self.scene, triangle, texture_point(*self.geometry, triangle, barycentric))
                              : 1.0f;
    const unsigned mask = RTCRayN_mask(args->ray, args->N, i);
    bool passes = present == 0 ||
                  (!(mask & kHitsInterfaces) && self.scene->materials()[material].kind == MaterialKind::interface) ||
                  self.lamps.covers(*self.scene, triangle, barycentric, by_camera);
    if constexpr (kOcclusion) {
      auto& context = *reinterpret_cast<OcclusionContext*>(args->context);
      if (!passes && context.passed && (present < 1 || self.scene->is_pane(material))) {
        note_pane(context,
                  {{RTCRayN_tfar(args->ray, args->N, i), triangle, barycentric}, RTCRayN_id(args->ray, args->N, i)});
        passes = true;
      }
    }
    passes |= (mask & kPassesByChance) && !is_present(present, triangle, origin, direction);
    if (passes) args->valid[i] = 0;
  }
}

/// What Embree's point query calls.
struct TriangleVisit {
  const Tracer::Implementation* self;
  const std::function<bool(std::uint32_t)>* visit;
  Vec3 center;
  float radius;
  unsigned instance;  ///< whose mesh is visited, or RTC_INVALID_GEOMETRY_ID
  bool ended = false;
};

/// Embree calls this for each triangle near a point. After the end the ball is a point, which few boxes contain.
bool visit_triangle(RTCPointQueryFunctionArguments* args) {
  auto& to = *static_cast<TriangleVisit*>(args->userPtr);
  if (to.ended) return false;
  const bool is_instance = to.instance == RTC_INVALID_GEOMETRY_ID && args->geomID == kInstances;
  to.ended = is_instance ? !to.self->visit_instance(args->primID, to.center, to.radius, *to.visit)
                         : !(*to.visit)(to.self->triangle(args->geomID, args->primID, to.instance));
  if (to.ended) args->query->radius = 0;
  return to.ended;
}

/// Visits the triangles of one of Embree's scenes near to.center; false if visit() ended it.
bool visit_scene(RTCScene scene, TriangleVisit& to) {
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  RTCPointQuery query;
  query.x = to.center.x;
  query.y = to.center.y;
  query.z = to.center.z;
  query.time = 0;
  query.radius = to.radius;
  rtcPointQuery(scene, &query, &context, visit_triangle, &to);
  return !to.ended;
}

bool count_bytes(void* user, ssize_t bytes, bool) {
  static_cast<Tracer::Implementation*>(user)->bytes += bytes;
  return true;
}

}  // namespace

Tracer::Implementation::Implementation(const Scene& s, TieRule ties_by)
    : scene(&s), geometry(s.shared_geometry()), ties(ties_by) {
  hidden = std::any_of(s.materials().begin(), s.materials().end(),
                       [](const Material& m) { return m.single_sided || m.unseen; });
  for (std::uint32_t i = 0; i < s.materials().size(); ++i) passable |= s.is_pane(i) || s.has_alpha(i);
}

// Once the first constructor has returned, an error in this one calls the destructor.
Tracer::Implementation::Implementation(const Scene& s, std::span<const std::uint32_t> movable_triangles,
                                       TieRule ties_by)
    : Implementation(s, ties_by) {
  movable.assign(movable_triangles.begin(), movable_triangles.end());
  device = rtcNewDevice(ray_device_configuration().c_str());
  // If the device was not made, the error belongs to the calling thread.
  if (!device) fail(rtcGetDeviceError(nullptr), "start");
  rtcSetDeviceMemoryMonitorFunction(device, count_bytes, this);
  world = new_scene(!movable.empty());
  build();
  find_lamps();
}

Tracer::Implementation::~Implementation() {
  // Embree 3.13 ends the program when it releases a scene whose build ran out of memory. Such a scene leaks instead.
  if (!whole) return;
  for (const TracedMesh& mesh : meshes)
    if (mesh.world) rtcReleaseScene(mesh.world);
  if (world) rtcReleaseScene(world);
  if (device) rtcReleaseDevice(device);
}

/// An empty scene.
RTCScene Tracer::Implementation::new_scene(bool dynamic) const {
  RTCScene scene_of_embree = rtcNewScene(device);
  throw_on_error(device, "start");
  // Rays through the edge between two triangles meet one of them: light stays in closed rooms.
  // Only a dynamic scene has separate structures for its geometries, and rebuilds those that changed. Other scenes are
  // built once, so a slower, better build pays off.
  if (!dynamic) rtcSetSceneBuildQuality(scene_of_embree, RTC_BUILD_QUALITY_HIGH);
  const bool filters = hidden || ties == TieRule::number;
  rtcSetSceneFlags(scene_of_embree,
                   static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | (dynamic ? RTC_SCENE_FLAG_DYNAMIC : 0) |
                                              (filters ? RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION : 0)));
  return scene_of_embree;
}

/// Builds whatever changed; throws Error if that fails.
void Tracer::Implementation::commit() {
  whole = false;
  for (const TracedMesh& mesh : meshes) rtcCommitScene(mesh.world);
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
  build_meshes();
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
  std::vector<bool> moves(g.triangles.size(), false), tested(g.triangles.size(), false);
  for (const std::uint32_t i : movable) moves[i] = true;
  for (const std::uint32_t i : lamps.covered())
    if (i < tested.size()) tested[i] = true;
  for (TriangleList& list : lists) list.clear();
  for (std::uint32_t i = 0; i < g.triangles.size(); ++i) {
    if (scene->repeats(i)) continue;
    const bool passed = tested[i] || scene->has_alpha(g.material[i]) || scene->is_pane(g.material[i]);
    lists[(moves[i] ? kMovable : 0) + (passed ? kTested : 0)].push_back(i);
  }
  one_list = false;
  for (const TriangleList& list : lists) one_list |= !list.empty() && list.size() == g.triangles.size();
}

/// The geometry of some triangles of a mesh. @param own_vertices no two of them share a vertex
RTCGeometry Tracer::Implementation::new_triangles(const Geometry& mesh, const TriangleList& list,
                                                  bool own_vertices) const {
  RTCGeometry shape = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  throw_on_error(device, "take the triangles");
  const std::size_t vertex_count = own_vertices ? 3 * list.size() : mesh.positions.size();
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
    std::memcpy(vertices, mesh.positions.data(), vertex_count * sizeof(Vec3));
    for (std::size_t i = 0; i < list.size(); ++i) std::copy_n(mesh.triangles[list[i]].data(), 3, indices + 3 * i);
  }
  return shape;
}

/// Adds a geometry of triangles to one of Embree's scenes.
void Tracer::Implementation::attach(RTCScene to, RTCGeometry shape, unsigned id) {
  rtcSetGeometryUserData(shape, this);
  if (id & kTested) {
    rtcSetGeometryIntersectFilterFunction(shape, pass_filter<false>);
    rtcSetGeometryOccludedFilterFunction(shape, pass_filter<true>);
  }
  rtcCommitGeometry(shape);
  rtcAttachGeometryByID(to, shape, id);
  rtcReleaseGeometry(shape);
}

void Tracer::Implementation::add_geometry(unsigned id) {
  if (lists[id].empty()) return;
  // Movable triangles have vertices of their own here, so that few vertices are written when they move.
  attach(world, new_triangles(*geometry, lists[id], id >= kMovable), id);
  attached[id] = true;
}

/// Makes the structures of meshes that do not have the right ones.
void Tracer::Implementation::build_meshes() {
  const Geometry& g = *geometry;
  std::vector<std::vector<bool>> tested;
  for (const auto& mesh : g.meshes) {
    std::vector<bool>& of_mesh = tested.emplace_back();
    for (const std::uint32_t material : mesh->material)
      of_mesh.push_back(scene->has_alpha(material) || scene->is_pane(material));
  }
  for (const std::uint32_t i : lamps.covered()) {
    const StoredTriangle at = g.stored(i);
    if (at.instance) tested[at.instance->mesh][at.index] = true;
  }
  const bool is_new = meshes.empty();
  meshes.resize(g.meshes.size());
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    TracedMesh& mesh = meshes[i];
    TriangleList sorted[2];
    for (std::uint32_t t = 0; t < tested[i].size(); ++t) sorted[tested[i][t] ? kTested : 0].push_back(t);
    if (mesh.world && sorted[kTested] == mesh.lists[kTested]) continue;
    mesh.bounds = g.meshes[i]->bounds();
    if (!mesh.world) mesh.world = new_scene(false);
    for (unsigned id = 0; id < 2; ++id) {
      if (!mesh.lists[id].empty()) rtcDetachGeometry(mesh.world, id);
      if (!sorted[id].empty()) attach(mesh.world, new_triangles(*g.meshes[i], sorted[id], false), id);
      mesh.lists[id] = std::move(sorted[id]);
    }
  }
  if (is_new && !g.instances.empty()) add_instances();
}

void Tracer::Implementation::add_instances() {
  std::vector<bool> ignored(scene->materials().size());
  for (std::uint32_t m = 0; m < ignored.size(); ++m) ignored[m] = scene->has_alpha(m);
  repeated = repeated_instances(*geometry, ignored);
  RTCGeometry shape = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  throw_on_error(device, "take the instances");
  rtcSetGeometryUserPrimitiveCount(shape, static_cast<unsigned>(geometry->instances.size()));
  set_instance_functions(shape);
  attach(world, shape, kInstances);
}

std::uint32_t Tracer::Implementation::triangle_of_instance(unsigned id, unsigned primitive, unsigned instance) const {
  const Instance& at = geometry->instances[instance];
  return at.first + meshes[at.mesh].lists[id][primitive];
}

void Tracer::Implementation::visit_near(Vec3 center, float radius,
                                        const std::function<bool(std::uint32_t)>& visit) const {
  TriangleVisit to{this, &visit, center, radius, RTC_INVALID_GEOMETRY_ID};
  visit_scene(world, to);
}

bool Tracer::Implementation::visit_instance(unsigned instance, Vec3 center, float radius,
                                            const std::function<bool(std::uint32_t)>& visit) const {
  const Instance& at = geometry->instances[instance];
  const Transform inward = inverse_of(at);
  // No length grows by more than the root of the sum of all squares.
  const float growth = std::sqrt(length_squared(inward.x) + length_squared(inward.y) + length_squared(inward.z));
  TriangleVisit to{this, &visit, inward.vector(center - at.to_world.translation), (radius + at.rounding) * growth,
                   instance};
  return visit_scene(meshes[at.mesh].world, to);
}

void Tracer::Implementation::place_vertices(Vec3* vertices, const TriangleList& list) const {
  for (std::size_t i = 0; i < list.size(); ++i)
    for (std::size_t corner = 0; corner < 3; ++corner)
      vertices[3 * i + corner] = geometry->positions[geometry->triangles[list[i]][corner]];
}

}  // namespace glowworm
