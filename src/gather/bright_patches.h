// Small bright areas that final gathering samples directly.
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

/// Points on surfaces with the light that arrives there; BrightPatches finds bright ones among them. Arrays of equal
/// length.
struct LitPlaces {
  std::vector<Vec3> position;     ///< metres
  std::vector<Vec3> normal;       ///< unit, on the lit side
  std::vector<float> flux;        ///< luminance, W: of the photons that the point represents
  std::vector<float> irradiance;  ///< luminance, W m^-2, by density estimation
};

/// Patches of triangles that are much brighter than their surroundings, such as the inside of a lampshade or a spot lit
/// by a lamp. Rays sampled by the BSDF rarely hit them, but contribute so much when they do that single pixels stand
/// out. Patches are therefore also sampled like lights, chosen by a LightTree, and the balance heuristic weights both
/// kinds of rays, which leaves the mean unchanged. After Jensen, "Importance Driven Path Tracing Using the Photon Map",
/// EGWR 1995, which chooses directions by the photons near the gather point; for patches, the density at a ray's end is
/// known.
class BrightPatches {
 public:
  BrightPatches() = default;  ///< none
  /// Finds the patches. There are none unless sampling them at least halves the variance of gather rays.
  /// @param radii blur radii of photons, which determine the size of patches
  BrightPatches(const Tracer& tracer, const LitPlaces& places, const RadiusGrid& radii);

  bool empty() const { return patches_.empty(); }
  std::size_t size() const { return patches_.size(); }

  /// The patch that contains a point of a triangle, or kNone.
  std::uint32_t find(std::uint32_t triangle, Vec2 barycentric) const {
    return level(triangle) == kNoLevel ? kNone : find_cell(triangle, barycentric);
  }
  std::uint32_t triangle(std::uint32_t patch) const { return patches_[patch].triangle; }
  /// Density per m^2 of the points that sample() chooses on a patch.
  float density(Vec3 from, std::uint32_t patch) const;

  struct Sample {
    std::uint32_t patch = kNone;  ///< kNone: no patch emits towards the point
    Vec3 position;                ///< metres
    float density = 0;            ///< per m^2
  };
  /// Samples a point on a patch, for the gather point `from`. @param u, v in [0, 1)
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
  /// The number of times the sides of a triangle are halved, or kNoLevel: there is no patch on it.
  std::uint8_t level(std::uint32_t triangle) const {
    if (triangle < level_.size()) return level_[triangle];
    const auto found = instance_level_.find(triangle);
    return found == instance_level_.end() ? kNoLevel : found->second;
  }

  std::vector<std::uint8_t> level_;                                 // empty, or of each triangle of no instance
  std::unordered_map<std::uint32_t, std::uint8_t> instance_level_;  // of the other triangles with patches
  std::unordered_map<std::uint64_t, std::uint32_t> of_cell_;
  std::vector<Patch> patches_;
  LightTree tree_;
};

/// Numbers of rays of a gather point: sampled by the BSDF (`rays_each`), and towards bright patches (`samples_each`).
struct PatchRaySettings {
  std::uint32_t rays_each, samples_each, seed;
};

/// Appends rays to bright patches, `samples_each` for every gather point listed, weighted against `rays_each` rays
/// sampled by the BSDF.
void create_patch_rays(const Scene& scene, const BrightPatches& patches, const GatherPoints& points,
                       std::span<const std::uint32_t> order, const PatchRaySettings& settings, GatherPaths& out);

/// Balance-heuristic weight of a BSDF-sampled ray by its hit: 1 unless it ends on a patch.
float patch_weight(const Scene& scene, const BrightPatches& patches, const GatherPath& path, const Hit& hit,
                   std::uint32_t rays_each, std::uint32_t samples_each);

/// The default number of rays to bright patches for a number of rays sampled by the BSDF.
std::uint32_t default_patch_samples(std::uint32_t gather_rays);

}  // namespace glowworm
