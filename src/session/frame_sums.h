// Sums over all passes of a view at rest.
#pragma once
#include <cstdint>
#include <vector>

#include "render/pass.h"
#include "session/view_image.h"
#include "session/view_state.h"

namespace glowworm {

/// Adds passes, pixel by pixel.
class FrameSums {
 public:
  void clear() { count_ = 0; }
  void add(PassResult&& pass);
  std::uint32_t count() const { return count_; }

  /// Means as a picture: light of the given part times `factor`, and the surfaces. Does not set positions.
  ViewImage image(const Camera& camera, int width, int height, LightPart part, float factor) const;
  /// Means of the diagnosis; empty if there was none.
  std::vector<RGB> diagnosis() const;

 private:
  std::uint32_t count_ = 0;
  PassResult sum_;  // depth: the sum of those that hit something
  std::vector<std::uint32_t> hits_;
};

}  // namespace glowworm
