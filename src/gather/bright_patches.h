// Small bright places that final gathering looks at on purpose.
#pragma once
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "gather/gather_rays.h"
#include "gather/radius_grid.h"
#include "points/gather_points.h"
#include "scene/light_tree.h"
#include "trace/tracer.h"

namespace glowworm {

/// Places on surfaces with what arrives there, by which BrightPatches finds the bright ones. Arrays of one length.
struct LitPlaces {
  std::vector<Vec3> position;     ///< metres
  std::vector<Vec3> normal;       ///< unit, on the lit side
  std::vector<float> flux;        ///< luminance, W: of the photons that a place stands for
  std::vector<float> irradiance;  ///< luminance, W m^-2, by density estimation
};

/// Patches of triangles that are much brighter than what is around: the inside of a lampshade, the spot that a lamp
/// throws. Rays by the BSDF seldom meet them and bring so much when they do that pixels stand out. They are therefore
/// sampled like lights, chosen by a LightTree, and both ways of meeting them are weighted by the balance heuristic, so
/// that the mean stays as it is. After Jensen, "Importance Driven Path Tracing Using the Photon Map", EGWR 1995, who
/// takes directions from photons near the gather point; patches have a density that is known at a ray's end.
class BrightPatches {
 public:
  BrightPatches() = default;  ///< none
  /// Finds the patches, if sampling them would halve the variance of gather rays or better; else there are none.
  /// @param radii over which photons are blurred: the size of patches
  BrightPatches(const Tracer& tracer, const LitPlaces& places, const RadiusGrid& radii);

  bool empty() const { return patches_.empty(); }
  std::size_t size() const { return patches_.size(); }

  /// The patch at a place of a triangle, or kNone.
  std::uint32_t find(std::uint32_t triangle, Vec2 barycentric) const {
    return level_.empty() || level_[triangle] == kNoLevel ? kNone : find_cell(triangle, barycentric);
  }
  std::uint32_t triangle(std::uint32_t patch) const { return patches_[patch].triangle; }
  /// Density per m^2 with which sample() gives the places of a patch.
  float density(Vec3 from, std::uint32_t patch) const;

  struct Sample {
    std::uint32_t patch = kNone;  ///< kNone: no patch shines towards the point
    Vec3 position;                ///< metres
    float density = 0;            ///< per m^2
  };
  /// A place on a patch for the point `from`. @param u, v in [0, 1)
  Sample sample(const Geometry& geometry, Vec3 from, float u, Vec2 v) const;

 private:
  struct Patch {
    std::uint32_t triangle;
    Vec2 corner, side_a, side_b;  // barycentric
    float area;                   // m^2
  };
  std::uint32_t find_cell(std::uint32_t triangle, Vec2 barycentric) const;
  std::uint32_t add(const Geometry& geometry, std::uint32_t triangle, std::uint32_t cell);
  static constexpr std::uint8_t kNoLevel = 255;

  std::vector<std::uint8_t> level_;  // of each triangle: halvings of its sides; kNoLevel: no patch on it
  std::unordered_map<std::uint64_t, std::uint32_t> of_cell_;
  std::vector<Patch> patches_;
  LightTree tree_;
};

/// Rays of a gather point by the BSDF, and to bright patches.
struct PatchRaySettings {
  std::uint32_t rays_each, samples_each, seed;
};

/// Appends rays to bright patches, `samples_each` for every gather point listed, with their weights against `rays_each`
/// rays by the BSDF; and to `targets` the patch that each must meet to count.
void create_patch_rays(const Scene& scene, const BrightPatches& patches, const GatherPoints& points,
                       std::span<const std::uint32_t> order, const PatchRaySettings& settings, GatherRays& out,
                       std::vector<std::uint32_t>& targets);

/// The balance heuristic's weight of a ray by the BSDF that ends on `patch`.
/// @param pdf of the ray's direction per steradian
float patch_weight(const Scene& scene, const BrightPatches& patches, std::uint32_t patch, const Ray& ray,
                   const Hit& hit, float pdf, std::uint32_t rays_each, std::uint32_t samples_each);

/// How many rays to bright patches go with so many by the BSDF.
std::uint32_t default_patch_samples(std::uint32_t gather_rays);

}  // namespace glowworm
