// Chooses among many lights in proportion to an estimate of their light at a point.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/box.h"
#include "core/vec.h"

namespace glowworm {

/// Bounds of one or more lights: positions, directions and largest intensity.
struct LightBounds {
  Box3 box;
  Vec3 axis{0, 0, 1};      ///< unit: centre of the cone of normals (or of a spot's directions)
  float cos_normals = 1;   ///< cosine of the angle around `axis` that contains all normals; 1: all are equal, -1: any
  float cos_emission = 0;  ///< cosine of the angle around its normal in which a light emits
  bool two_sided = false;
  float intensity = 0;  ///< luminance of the sum of maximum intensities, W sr^-1
};

/// A binary tree over lights at finite distance. To choose a light, it descends from the root. It takes a child with a
/// probability proportional to a bound of its lights' irradiance at the point, by distance and direction: A. Conty
/// Estevez and C. Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", HPG 2018, section 4.
class LightTree {
 public:
  LightTree() = default;
  /// @param lights bounds of each light; those without intensity are never chosen
  explicit LightTree(std::span<const LightBounds> lights);

  bool empty() const { return nodes_.empty(); }

  struct Choice {
    std::uint32_t light;    ///< index into the lights
    float probability = 0;  ///< 0: no light can light the point
    float remapped = 0;     ///< position of u in the choice's interval: uniform in [0, 1) again
  };
  /// What choose() found out about a point, for its further calls with that point. Its first `known` levels hold
  /// values.
  struct Descent {
    struct Level {
      std::uint32_t child;
      float share;  // probability of the left child
    };
    std::array<Level, 64> level;
    int known = 0;
  };
  /// @param position the point to be lit, metres; @param u in [0, 1); @param descent new for each position
  Choice choose(Vec3 position, float u, Descent& descent) const;
  /// The probability with which choose() returns that light.
  float probability(Vec3 position, std::uint32_t light) const;
  /// An estimate of the unoccluded irradiance (luminance, W m^-2) at a point of a surface that faces all lights.
  float irradiance(Vec3 position) const;

 private:
  struct Node {
    LightBounds bounds;
    std::uint32_t child = 0;  // the left one; the right one follows it; 0: a leaf
    std::uint32_t light = 0;
  };
  class Builder;
  float irradiance(Vec3 position, std::uint32_t node, int levels) const;

  std::vector<Node> nodes_;
  std::vector<std::uint64_t> way_;   // path to each light: bit i tells which child to take at level i
  std::vector<std::uint8_t> depth_;  // of each light's leaf; kNotThere for lights without intensity
};

/// The combined bounds of two sets of lights.
LightBounds merge(const LightBounds& a, const LightBounds& b);

/// An approximate bound of the lights' irradiance (W m^-2) on a surface at `position` that faces them; 0 only if none
/// of them can reach it.
float light_importance(const LightBounds& lights, Vec3 position);

}  // namespace glowworm
