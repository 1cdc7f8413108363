// Chooses the light source to sample at a point: by a tree for sources at finite distance, by power for sources at
// infinity.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/distribution.h"
#include "scene/geometry.h"
#include "scene/light.h"
#include "scene/light_tree.h"

namespace glowworm {

/// Chooses light sources (counted as in Scene::light_power()) for points.
class LightSelector {
 public:
  LightSelector() = default;
  /// @param emissive_triangles of `geometry`; their sources come first
  /// @param lights the sources after them
  /// @param media number of the sources after those, which no point samples
  /// @param powers of all sources, W (luminance); one more than these if there is an environment
  /// @param disc area through which far light reaches the scene, m^2
  LightSelector(const Geometry& geometry, std::span<const std::uint32_t> emissive_triangles,
                std::span<const Emission> emissions, std::span<const Light> lights, std::size_t media,
                std::span<const float> powers, float disc);

  struct Choice {
    std::uint32_t source = 0;
    float probability = 0;  ///< 0: no source can light the point
    float remapped = 0;     ///< position of u in the choice's interval: uniform in [0, 1) again
  };
  /// Chooses sources for one point.
  class AtPoint {
   public:
    /// @param position metres
    AtPoint(const LightSelector& selector, Vec3 position)
        : selector_(selector), position_(position), far_share_(selector.far_share(position)) {}
    /// @param u in [0, 1)
    Choice choose(float u);

   private:
    const LightSelector& selector_;
    Vec3 position_;
    float far_share_;
    LightTree::Descent descent_;
  };
  /// The probability with which AtPoint::choose() returns that source.
  float probability(Vec3 position, std::uint32_t source) const;

  std::size_t directional_count() const { return directional_source_.size(); }
  /// Chooses one of the directional lights by power. @param u in [0, 1)
  Choice choose_directional(float u) const;

 private:
  float far_share(Vec3 position) const;

  LightTree tree_;
  Distribution1D far_, directional_;
  float far_irradiance_ = 0;                                                  // W m^-2
  std::vector<std::uint32_t> near_source_, far_source_, directional_source_;  // sources in the order of these
  std::vector<std::uint32_t> place_;  // index of each source in the tree or, with kFar set, in far_; kNone for media
  static constexpr std::uint32_t kFar = 0x80000000u;
};

}  // namespace glowworm
