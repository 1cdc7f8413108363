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
/// LampsInPlanes), and the same for triangles that follow() may move.
inline constexpr unsigned kTested = 1, kMovable = 2, kGeometries = 4;

struct Tracer::Implementation {
  const Scene* scene = nullptr;
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

  /// As the constructor of Tracer.
  Implementation(const Scene& s, std::span<const std::uint32_t> movable_triangles);
  ~Implementation();
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  /// If all triangles are in one geometry, the list is the identity and is not read.
  std::uint32_t triangle(unsigned id, unsigned primitive) const { return one_list ? primitive : lists[id][primitive]; }
  void follow(const Scene& s);
  void visit_near(Vec3 center, float radius, const std::function<bool(std::uint32_t)>& visit) const;

 private:
  explicit Implementation(const Scene& s);
  void commit();
  void build();
  void find_lamps();
  void sort_triangles();
  void add_geometry(unsigned id);
  void place_vertices(Vec3* vertices, const TriangleList& list) const;
};

/// A pane that a ray passes.
struct PassedPane : PassedSurface {
  unsigned ray;  ///< its number in its packet
};

/// The context of rays of occlusion.
struct OcclusionContext {
  RTCIntersectContext embree;
  std::vector<PassedPane>* passed = nullptr;  ///< panes do not occlude: they are listed here, some more than once
  bool out_of_memory = false;                 ///< for a pane
};

}  // namespace glowworm
