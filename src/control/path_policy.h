// What paths of the path tracer do where they meet light, media or a surface.
#pragma once
#include "control/path_history.h"
#include "core/random.h"
#include "gather/camera_pass.h"
#include "gather/point_pass.h"
#include "settings/settings.h"
#include "transport/segment_light.h"

namespace glowworm {

/// One path, from the camera or a point to its end: a policy over meet() (transport/step.h).
class PathPolicy {
 public:
  /// @param lights of the same radiance @param lookups null: none
  PathPolicy(const Tracer& tracer, const RenderSettings& settings, Sampler sampler, std::uint32_t slot,
             SlotRadiance& radiance, FirstHit& first_hit, LightAdder& lights, PathLookups* lookups);

  /// Finds the light that arrives at the place of a sample of a cell of the grid.
  void trace_from(const PointGrid& grid, std::size_t cell, std::uint32_t sample);
  /// Finds the light along a camera ray. @param medium around the camera
  void trace_from(const CameraRay& camera, PathMedium medium);

 private:
  /// What a straight part of the path ends at.
  enum class End : std::uint8_t { surface, scattering, nothing };

  void follow(int first_bounce);
  RayOrder order() const { return bounce_ == 0 ? RayOrder::camera : RayOrder::incoherent; }
  End cross(Hit& hit);
  void see_behind(Hit hit);
  bool scatter_in(const Medium& medium, const LitSegment& segment, float distance);
  void add_segment_light(const LitSegment& segment);
  template <typename Density>
  void add_light(RGB light, std::uint32_t source, const Density& density);
  bool scatter(const Vertex& vertex);
  void add_sampled_light(const Vertex& vertex);
  void add_lookup(const Vertex& vertex);
  void add_lookup(const Medium& medium, float length);
  bool go_on(const Vertex& vertex);
  bool survives();

  const Tracer& tracer_;
  const Scene& scene_;
  const RenderSettings& settings_;
  Sampler sampler_;
  std::uint32_t slot_;
  SlotRadiance& radiance_;
  FirstHit& first_hit_;
  LightAdder& lights_;
  PathLookups* lookups_;
  PathState state_;
  float start_ = 1;  // the throughput before the first bounce
  int bounce_ = 0;   // before, at surfaces and in media
  PathHistory history_;
  LitSegment segment_;    // where the path scattered last, if that was in a medium,
  float on_segment_ = 0;  // and the place on it, metres
  Vec3 met_at_{};         // the end of the ray
  Vec3 start_at_{};       // the camera
};

}  // namespace glowworm
