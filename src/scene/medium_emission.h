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
  /// bounds of its own
  MediumEmission(std::uint32_t index, const Medium& medium, const Box3& region);

  std::uint32_t medium() const { return medium_; }
  /// Flux of the box if the medium fills it, W; an estimate for grids.
  RGB power() const { return power_; }

  struct Start {
    Vec3 position;  ///< metres
    RGB flux;       ///< of a photon in any direction, W; divide by the number emitted
  };
  /// A place, in about the proportion of the emission. Where surfaces leave it out of the medium, it emits nothing.
  /// @param medium as in the constructor @param u in [0, 1)
  Start sample(const Medium& medium, Vec3 u) const;

 private:
  /// A block of a grid across the box, from 0 to 1; the whole box in a homogeneous medium.
  Box3 block(const Medium& medium, std::uint32_t index) const;

  std::uint32_t medium_ = 0;
  Box3 box_;               // in the medium's own coordinates if that has bounds, else in the scene's
  Transform to_scene_;     // from these
  float volume_ = 0;       // of the box, m^3
  Distribution1D blocks_;  // in proportion to their flux
  RGB power_;
};

/// The media of a scene that emit. Those without bounds lie in the box of the surfaces that name them. One that no
/// surface holds, as around a scene, emits in a cube about the scene of twice its radius, though rays see it beyond.
/// @param ambient index of the medium around the scene, or kNone
std::vector<MediumEmission> find_emissive_media(const std::vector<Medium>& media,
                                                const std::vector<Material>& materials, const Geometry& geometry,
                                                std::uint32_t ambient);

}  // namespace glowworm
