// The structure that Embree traces rays through, and what decides about its hits. Used by the trace room only.
#pragma once
#include <embree3/rtcore.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "trace/lamps_in_planes.h"
#include "trace/tracer.h"

namespace glowworm {

/// The triangles of one Embree geometry, as indices into the scene's geometry.
using TriangleList = std::vector<std::uint32_t>;

/// Numbers of Embree's geometries: opaque triangles, triangles that rays may pass (Scene::has_alpha, is_pane, and
/// LampsInPlanes), and the same for triangles that follow() may move; then all instances.
inline constexpr unsigned kTested = 1, kMovable = 2, kGeometries = 4, kInstances = 4;

/// Bits of the masks of rays that may hit interfaces, and that chance lets pass partly absent surfaces. Geometries have
/// other bits.
inline constexpr unsigned kHitsInterfaces = 1u << 31, kPassesByChance = 1u << 30;

/// The structure of a mesh that instances place, in its own space. Its geometries have the first two numbers.
struct TracedMesh {
  RTCScene world = nullptr;
  TriangleList lists[2];  ///< as indices into the mesh
  Box3 bounds;
};

struct Tracer::Implementation {
  const Scene* scene = nullptr;
  std::shared_ptr<const Geometry> geometry;  ///< geometry that `world` is built from
  RTCDevice device = nullptr;
  RTCScene world = nullptr;
  std::vector<std::uint32_t> movable;
  TriangleList lists[kGeometries];
  bool attached[kGeometries] = {};
  bool one_list = false;
  std::vector<TracedMesh> meshes;
  std::vector<bool> repeated;  ///< repeated_instances() of the scene, which no ray meets
  LampsInPlanes lamps;
  TieRule ties = TieRule::structure;
  bool hidden = false;    ///< cameras do not see some surfaces (Material::single_sided, unseen)
  bool passable = false;  ///< a material is a pane or has alpha
  bool whole = true;      ///< no build of `world` has failed
  std::atomic<std::int64_t> bytes{0};

  /// As the constructors of Tracer.
  Implementation(const Scene& s, std::span<const std::uint32_t> movable_triangles, TieRule ties_by);
  ~Implementation();
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  /// The triangle of a hit. If all triangles without instances are in one geometry, the list is the identity and is not
  /// read. @param instance RTC_INVALID_GEOMETRY_ID for none
  std::uint32_t triangle(unsigned id, unsigned primitive, unsigned instance) const {
    if (instance != RTC_INVALID_GEOMETRY_ID) return triangle_of_instance(id, primitive, instance);
    return one_list ? primitive : lists[id][primitive];
  }
  void follow(const Scene& s);
  void visit_near(Vec3 center, float radius, const std::function<bool(std::uint32_t)>& visit) const;
  /// The same for the triangles of an instance; false if visit() ended it.
  bool visit_instance(unsigned instance, Vec3 center, float radius,
                      const std::function<bool(std::uint32_t)>& visit) const;

 private:
  Implementation(const Scene& s, TieRule ties_by);
  void commit();
  void build();
  void find_lamps();
  void sort_triangles();
  RTCScene new_scene(bool dynamic) const;
  std::uint32_t triangle_of_instance(unsigned id, unsigned primitive, unsigned instance) const;
  void add_geometry(unsigned id);
  RTCGeometry new_triangles(const Geometry& mesh, const TriangleList& list, bool own_vertices) const;
  void attach(RTCScene to, RTCGeometry shape, unsigned id);
  void build_meshes();
  void add_instances();
  void place_vertices(Vec3* vertices, const TriangleList& list) const;
};

/// The inverse of an instance's map, without its translation.
Transform inverse_of(const Instance& instance);

/// Sets Embree's callbacks for the instances of a scene. @param shape its user data are the Implementation
void set_instance_functions(RTCGeometry shape);

/// Called for the hits of camera rays; rejects those on the backs of single-sided surfaces and on unseen ones.
void camera_filter(const RTCFilterFunctionNArguments* args);

/// A pane, or a partly absent surface, that a ray passes.
struct PassedPane : PassedSurface {
  unsigned ray;  ///< its number in its packet
};

/// The context of rays of occlusion.
struct OcclusionContext {
  RTCIntersectContext embree;
  std::vector<PassedPane>* passed = nullptr;  ///< null: such surfaces occlude; some are listed more than once
  bool out_of_memory = false;                 ///< for a pane
};

}  // namespace glowworm
