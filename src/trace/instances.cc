// Instances for Embree: primitives of a user geometry, which take little memory each, and whose callbacks transform
// rays with few roundings.
#include <cmath>
#include <limits>

#include "core/transform_double.h"
#include "scene/placed_box.h"
#include "trace/ray_structure.h"

namespace glowworm {

namespace {

/// The box of an instance in the world, with room for rounding.
void bound_instance(const RTCBoundsFunctionArguments* args) {
  const auto& self = *static_cast<const Tracer::Implementation*>(args->geometryUserPtr);
  RTCBounds& out = *args->bounds_o;
  if (!self.repeated.empty() && self.repeated[args->primID]) {
    // Embree leaves out what has an empty box.
    out = {HUGE_VALF, HUGE_VALF, HUGE_VALF, 0, -HUGE_VALF, -HUGE_VALF, -HUGE_VALF, 0};
    return;
  }
  const Instance& instance = self.geometry->instances[args->primID];
  const Box3 box = placed_box(instance.to_world, self.meshes[instance.mesh].bounds);
  const auto room = [&](float coordinate) { return instance.rounding + 0x1p-22f * std::abs(coordinate); };
  out.lower_x = box.min.x - room(box.min.x);
  out.lower_y = box.min.y - room(box.min.y);
  out.lower_z = box.min.z - room(box.min.z);
  out.upper_x = box.max.x + room(box.max.x);
  out.upper_y = box.max.y + room(box.max.y);
  out.upper_z = box.max.z + room(box.max.z);
}

/// Rays in the space of an instance's mesh, while this exists. Hits then name the instance.
class WithinInstance {
 public:
  WithinInstance(const void* user, unsigned instance, RTCIntersectContext* context)
      : self_(*static_cast<const Tracer::Implementation*>(user)),
        instance_(self_.geometry->instances[instance]),
        inward_(inverse_of(instance_)),
        context_(*context) {
    context_.instID[0] = instance;
  }
  ~WithinInstance() { context_.instID[0] = RTC_INVALID_GEOMETRY_ID; }
  WithinInstance(const WithinInstance&) = delete;
  WithinInstance& operator=(const WithinInstance&) = delete;

  RTCScene mesh() const { return self_.meshes[instance_.mesh].world; }
  RTCIntersectContext* context() const { return &context_; }
  /// The same ray with the same distances along it. Subtracting the translation first leaves an error in proportion to
  /// the distance from it, not from the origin of the world.
  void move(RTCRay& ray) const {
    const Vec3 at = Vec3{ray.org_x, ray.org_y, ray.org_z} - instance_.to_world.translation;
    const Vec3 origin = inward_.vector(at), direction = inward_.vector({ray.dir_x, ray.dir_y, ray.dir_z});
    ray.org_x = origin.x;
    ray.org_y = origin.y;
    ray.org_z = origin.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
  }

 private:
  const Tracer::Implementation& self_;
  const Instance& instance_;
  Transform inward_;
  RTCIntersectContext& context_;
};

/// Rays of a packet that reach an instance are few; each is traced alone.
void intersect_instance(const RTCIntersectFunctionNArguments* args) {
  const WithinInstance within(args->geometryUserPtr, args->primID, args->context);
  RTCRayN* const rays = RTCRayHitN_RayN(args->rayhit, args->N);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    RTCRayHit query;
    query.ray = rtcGetRayFromRayN(rays, args->N, i);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    within.move(query.ray);
    rtcIntersect1(within.mesh(), within.context(), &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
    RTCRayN_tfar(rays, args->N, i) = query.ray.tfar;
    rtcCopyHitToHitN(RTCRayHitN_HitN(args->rayhit, args->N), &query.hit, args->N, i);
  }
}

void occlude_instance(const RTCOccludedFunctionNArguments* args) {
  const WithinInstance within(args->geometryUserPtr, args->primID, args->context);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    RTCRay query = rtcGetRayFromRayN(args->ray, args->N, i);
    within.move(query);
    rtcOccluded1(within.mesh(), within.context(), &query);
    if (query.tfar < 0) RTCRayN_tfar(args->ray, args->N, i) = -std::numeric_limits<float>::infinity();
  }
}

}  // namespace

// Computed for each use: that is cheap beside the search through the mesh, and a stored one takes memory.
Transform inverse_of(const Instance& instance) {
  const Transform& m = instance.to_world;
  const TransformDouble exact{Vec3d(m.x), Vec3d(m.y), Vec3d(m.z), {}};
  return inverse(exact).relative_to({0, 0, 0});
}

void set_instance_functions(RTCGeometry shape) {
  rtcSetGeometryBoundsFunction(shape, bound_instance, nullptr);
  rtcSetGeometryIntersectFunction(shape, intersect_instance);
  rtcSetGeometryOccludedFunction(shape, occlude_instance);
}

}  // namespace glowworm
