// The way of camera and gather rays through media. Rays do not scatter there: media weaken what they find behind, and
// scatter and emit light along them. Photons bring what is scattered, by segments that are looked up in a map, except
// for light straight from lamps, which is sampled.
#pragma once
#include <cstdint>
#include <vector>

#include "core/random.h"
#include "points/gather_points.h"
#include "points/volume_segments.h"
#include "transport/segment_light.h"

namespace glowworm {

class MediumWalk {
 public:
  /// @param lights of the same radiance @param segments are added to @param photons_alone adds segments, but no light
  MediumWalk(const Tracer& tracer, SlotRadiance& radiance, LightAdder& lights, VolumeSegments& segments,
             bool photons_alone);

  /// What a ray adds to.
  struct Target {
    std::vector<RGB>* part = nullptr;  ///< of the radiance; null: the ray only passes
    std::uint32_t slot = 0;
    /// Whether to look up and sample the light of a piece with a probability of its opacity only, as one of many rays.
    bool by_opacity = false;
  };
  /// Takes a path to the surface that it meets, or out of the scene. Returns false if nothing comes from there.
  bool cross(PathState& path, Hit& hit, RayOrder order, const Target& target, Sampler& sampler);
  /// Adds the light of a piece of a path, metres long. The path stays at its start.
  void add_light(const Medium& medium, const PathState& path, float length, const Target& target, Sampler& sampler);

 private:
  void sample_lamps(const LitSegment& segment, RGB throughput, const Target& target, float places, Sampler& sampler);
  void add_segments(const Medium& medium, const PathState& path, float length, RGB throughput, const Target& target,
                    float random);
  void add_part(const Medium& medium, const PathState& path, float length, RGB throughput, const Target& target,
                float parts, Vec2 random);
  void add(const SegmentLight& light, float weight, RGB throughput, const Target& target);

  const Tracer& tracer_;
  SlotRadiance& radiance_;
  LightAdder& lights_;
  VolumeSegments& segments_;
  const bool photons_alone_;
  const bool has_near_lamps_;
};

}  // namespace glowworm
