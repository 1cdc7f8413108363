// Sums over all passes of a view at rest.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/memory_budget.h"
#include "film/film.h"
#include "maps/pass.h"
#include "session/view_image.h"
#include "session/view_state.h"

namespace glowworm {

/// The picture of one pass: light of the given part times `factor`, and the surfaces. Does not set positions.
ViewImage pass_image(const PassResult& pass, const Camera& camera, int width, int height, LightPart part, float factor);

/// Adds passes into a film, as a render does.
class FrameSums {
 public:
  explicit FrameSums(MemoryBudget& budget) : budget_(budget) {}

  void clear();
  /// Adds the next pass of a view: one sample of every pixel, which shows the given part of the light. The first one
  /// after clear() makes the film. Throws Error if that does not fit into the budget. Passes beyond Film::kMaxSamples
  /// are left out.
  void add(PassResult&& pass, int width, int height, LightPart part);
  std::uint32_t count() const { return count_; }

  /// Means as a picture: light times `factor`, and the surfaces. Does not set positions.
  /// @param filtered as a render filters its picture (film/filtered.h). Throws Error if the budget is too small for
  /// it
  ViewImage image(const Camera& camera, LightPart part, float factor, bool filtered) const;
  /// Means of the diagnosis; empty if there was none.
  std::vector<RGB> diagnosis() const;

 private:
  MemoryBudget& budget_;
  std::unique_ptr<Reservation> reservation_;
  std::optional<Film> film_;
  std::uint32_t count_ = 0;
  std::vector<RGB> diagnosis_;  // sums
};

}  // namespace glowworm
