// Emissive media as light sources: where photons start in their volume.
#pragma once
#include <cstdint>
#include <vector>

#include "core/distribution.h"
#include "scene/geometry.h"
#include "scene/material.h"
#include "scene/medium.h"

namespace glowworm {

/// The light that a medium emits, in a box that holds the medium.
class MediumEmission {
 public:
  /// @param index of the medium @param region a box of the scene's coordinates that holds the medium, if that has no
  /// bounds of its own @param endless whether the medium goes on around the region without end
  MediumEmission(std::uint32_t index, const Medium& medium, const Box3& region, bool endless);

  std::uint32_t medium() const { return medium_; }
  /// Flux of the box if the medium fills it, W; an estimate for grids. If the medium is endless: flux of the ball
  /// around the box, and the flux that enters the ball if nothing but the medium lies beyond.
  RGB power() const { return power_; }

  struct Start {
    Vec3 position;   ///< metres
    Vec3 direction;  ///< unit
    RGB flux;        ///< of a photon, W; divide by the number emitted
  };
  /// A place, in about the proportion of the emission, and a direction. Where surfaces leave the place out of the
  /// medium, it emits nothing.
  /// @param medium as in the constructor @param u, u_direction in [0, 1)
  Start sample(const Medium& medium, Vec3 u, Vec2 u_direction) const;

 private:
  /// A block of a grid across the box, from 0 to 1; the whole box in a homogeneous medium.
  Box3 block(const Medium& medium, std::uint32_t index) const;
  /// Half of the places lie in the ball. The density of the others falls with the distance, as their light does.
  Start sample_endless(const Medium& medium, Vec3 u, Vec2 u_direction) const;
  /// Turns photons that start beyond the ball: half of them towards it, half in any direction.
  /// @param offset of the place from the centre of the ball, metres
  void aim(Start& start, Vec3 offset, Vec2 u) const;

  std::uint32_t medium_ = 0;
  Box3 box_;               // in the medium's own coordinates if that has bounds, else in the scene's
  Transform to_scene_;     // from these
  float volume_ = 0;       // of the box or ball, m^3
  float radius_ = 0;       // of the ball around the box of an endless medium, metres
  float fade_ = 0;         // the mean distance of places beyond the ball, metres
  Distribution1D blocks_;  // in proportion to their flux
  RGB power_;
};

/// The media of a scene that emit. Those without bounds lie in the box of the surfaces that name them. The ambient
/// medium is endless if it has no bounds.
/// @param ambient index of the medium around the scene, or kNone
std::vector<MediumEmission> find_emissive_media(const std::vector<Medium>& media,
                                                const std::vector<Material>& materials, const Geometry& geometry,
                                                std::uint32_t ambient);

}  // namespace glowworm
