// Where two moments of a scene differ.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/box.h"
#include "scene/scene.h"

namespace glowworm {

/// The margin around places that changed, of the largest coordinate near there: far above its rounding.
inline constexpr float kMarginOfChanges = 1e-5f;

/// What paths depend on in a scene beside the lights, kept to compare another moment of the scene with it.
class SceneMoment {
 public:
  explicit SceneMoment(const Scene& scene);

  /// Boxes around what is elsewhere, or looks different, in another moment, at both moments, with a margin for the
  /// rounding of rays; few, so that they are tested quickly. Empty if all is the same. Nothing if more than places
  /// differ: objects, instances, materials, textures or media are other ones.
  std::optional<std::vector<Box3>> places_changed_in(const Scene& other) const;

  /// Of its geometry, which outlives the scene; meshes of instances count as if no other moment shared them.
  std::uint64_t bytes() const;

 private:
  std::shared_ptr<const Geometry> geometry_;
  std::vector<std::shared_ptr<const TextureImage>> images_;
  std::uint64_t look_;
};

}  // namespace glowworm
