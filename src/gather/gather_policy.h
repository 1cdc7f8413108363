// What final gather rays do where they meet light or a surface.
#pragma once
#include "core/random.h"
#include "gather/final_gather.h"
#include "gather/gather_rays.h"
#include "transport/light_connection.h"

namespace glowworm {

/// The policy of the gather rays of some points, over meet() (transport/step.h).
class GatherPolicy {
 public:
  /// @param maker of the rays @param lights of the same radiance @param queries, caustic_queries as in GatherQueries
  GatherPolicy(const Tracer& tracer, const GatherPoints& points, const FinalGatherSettings& settings,
               const GatherRayMaker& maker, SlotRadiance& radiance, LightAdder& lights, QueryPoints& queries,
               QueryPoints* caustic_queries);

  /// Takes a ray to what it has met. Returns whether it goes on. @param step number of the rays before on its path
  bool advance(GatherPath& path, const Hit& hit, std::uint32_t step);
  /// Random numbers of a ray for a purpose.
  Sampler sampler_of(const GatherPath& path, std::uint32_t stream) const;

 private:
  bool meets_patch(const GatherPath& path, const Hit& hit) const;
  bool ends_on_diffuse(const GatherPath& path, const Hit& hit);
  bool is_short(const GatherPath& path, float distance, Vec3 position) const;
  bool counts_light(const GatherPath& path) const;
  template <typename Density>
  void add_light(const GatherPath& path, RGB emitted, std::uint32_t source, const Density& density);
  bool scatter(GatherPath& path, Vertex& vertex, float distance);
  bool arrive(GatherPath& path, Vertex& vertex, float distance);
  bool gather_again(GatherPath& path, Vertex& vertex, Lobes lobes);
  float guide(Vertex& vertex, Vec2& u) const;
  bool follow(GatherPath& path, const Vertex& vertex, float before);
  static bool leave_for(GatherPath& path, const Vertex& vertex, const ScatteredRay& s, Segment next);
  float number(const GatherPath& path, std::uint32_t what) const;
  std::uint32_t slot(const GatherPath& path) const { return points_.slot[path.point]; }

  const Scene& scene_;
  const GatherPoints& points_;
  const FinalGatherSettings& settings_;
  const GatherRayMaker& maker_;
  SlotRadiance& radiance_;
  LightAdder& lights_;
  QueryPoints& queries_;
  QueryPoints* const caustic_queries_;  // null: there is no caustic map
  std::uint32_t step_ = 0;
};

}  // namespace glowworm
