// Names of the layers that a picture may have beside the image, and what they need of a render.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "points/slot_value.h"

namespace glowworm {

/// Most ids that a film keeps of a pixel.
inline constexpr std::size_t kMaxIdsOfPixel = 6;

/// What a film keeps of the places that camera rays end at.
struct PlaceLayers {
  bool position = false, uv = false, objects = false, materials = false;
  SlotValues values = {};        ///< of the photons there
  bool surface_samples = false;  ///< emission and albedo by surface samples (gather/camera_pass.h)
  bool medium = false;           ///< light of media, in scenes that have some

  bool any() const { return of_triangles() || !values.empty() || surface_samples || medium; }
  /// Whether FirstHit::triangle and barycentric are needed.
  bool of_triangles() const { return position || uv || objects || materials; }
  bool operator==(const PlaceLayers&) const = default;
};

/// Names for --aov.
std::vector<std::string> aov_names();

/// What layers of these names need. Throws Error where there is no such layer.
PlaceLayers places_for(const std::vector<std::string>& aovs);

/// Channels of a layer of aov_names().
std::size_t layer_channels(const std::string& name);

}  // namespace glowworm
