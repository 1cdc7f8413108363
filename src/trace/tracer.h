// Ray tracing: closest hits and occlusion for batches of rays. Only this room includes Embree.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/vec.h"
#include "scene/scene.h"

namespace glowworm {

/// A ray. Its direction need not be unit; distances are multiples of its length.
struct Ray {
  Vec3 origin;
  float t_min = 0;
  Vec3 direction;
  float t_max = 0;
  float time = 0;  ///< seconds after the shutter opens; scenes stand still, so no hit depends on it
};

/// The closest hit of a ray; triangle is kNone if there is none.
struct Hit {
  float distance = 0;
  std::uint32_t triangle = kNone;
  Vec2 barycentric;  ///< weights of the second and third vertex
};

/// Rays as arrays of one length.
struct RayArrays {
  std::span<const Vec3> origin, direction;
  float t_min = 0;
  std::span<const float> t_max;  ///< one for each ray, one for all, or none: infinite
};

/// Room for closest hits as arrays of one length: members of Hit, but the distance of no hit is infinite.
struct HitArrays {
  std::span<float> distance;
  std::span<std::uint32_t> triangle;
  std::span<Vec2> barycentric;
};

/// A surface that a ray passes in a straight line: a pane, an interface (Scene::is_pane), or one that is partly absent
/// (coverage()).
struct PassedSurface {
  float distance;  ///< along the ray
  std::uint32_t triangle;
  Vec2 barycentric;
};

/// Coherence and kind of rays.
enum class RayOrder : std::uint8_t {
  incoherent,  ///< neighbours in the batch have nothing in common
  camera,   ///< from the camera: neighbours start close together in similar directions. They pass through the backs of
            ///< single-sided surfaces and unseen ones (Material::unseen), which all other rays hit.
  surface,  ///< as incoherent, but they pass through interfaces, as if those were not there
  partly,   ///< as incoherent, but they meet partly absent surfaces (coverage()) always, and not by chance
};

/// Which one of several triangles at exactly the same distance a ray meets.
enum class TieRule : std::uint8_t {
  structure,  ///< any one: the build of the structure decides
  number,     ///< the one with the lowest number, in batches of incoherent rays. Hits then stay as they are where other
              ///< triangles move. Costs time at each candidate for a hit.
};

/// The scene as a structure for ray tracing, without triangles that repeat others (Scene::repeats()).
/// Immutable except for follow(); all other calls are thread-safe.
class Tracer {
 public:
  /// Builds the acceleration structure, on all threads. The scene must outlive the tracer.
  explicit Tracer(const Scene& scene, TieRule ties = TieRule::structure);
  /// As above; triangles that follow() may move have their own structure, and only that is rebuilt.
  Tracer(const Scene& scene, std::span<const std::uint32_t> movable);
  ~Tracer();
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  /// Traces `scene` from now on: the same scene with other lights (Scene's second constructor), in which only the
  /// positions of movable triangles may differ. It must outlive the tracer. No other call may run at the same time.
  void follow(const Scene& scene);

  const Scene& scene() const;
  /// Size of the acceleration structure in bytes.
  std::uint64_t bytes() const;

  Hit intersect(const Ray& ray, RayOrder order = RayOrder::incoherent) const;
  /// Whether something lies between the ends of the ray; panes do, too.
  bool occluded(const Ray& ray) const;
  /// Share of the light that arrives from the ray's end in a straight line: 1 if nothing is in the way, less through
  /// panes (Scene::is_pane) and partly absent surfaces, else black. @param ray of unit direction
  RGB transmittance(const Ray& ray) const;
  /// Lists the surfaces that light passes on its straight way from the ray's end, nearest first. Returns false if
  /// something is in the way. @param ray of unit direction @param passed is replaced
  bool passes(const Ray& ray, std::vector<PassedSurface>& passed) const;

  /// Traces a batch on the calling thread. hits.size() == rays.size().
  void intersect(std::span<const Ray> rays, std::span<Hit> hits, RayOrder order) const;
  /// As above, for arrays. Each eight rays are traced as coherent ones if they start close together in very similar
  /// directions, which the last bits of a hit depend on.
  void intersect(const RayArrays& rays, const HitArrays& hits) const;
  /// Sets out[i] to 1 if something lies between t_min and t_max of ray i, else to 0.
  void occluded(std::span<const Ray> rays, std::span<std::uint8_t> out) const;

  /// Sets out[i] to transmittance() of ray i.
  void transmittance(std::span<const Ray> rays, std::span<RGB> out) const;

  /// Calls visit(triangle) for each triangle whose bounding box meets a ball, and possibly for others near it, in any
  /// order and possibly more than once, until visit() returns false. @param center, radius metres
  void visit_near(Vec3 center, float radius, const std::function<bool(std::uint32_t)>& visit) const;

  struct Implementation;

 private:
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace glowworm
