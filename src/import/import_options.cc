#include <algorithm>
#include <cmath>

#include "import/import.h"

namespace glowworm {

std::shared_ptr<MemoryBudget> loading_budget(std::uint64_t bytes) {
  return std::make_shared<MemoryBudget>(bytes > 0 ? bytes : physical_memory_bytes() / 2,
                                        "Give a larger --memory, or use fewer instances, simpler meshes or smaller "
                                        "textures.");
}

void SceneMotion::cover_length() {
  constexpr double kMostFrames = 100'000;
  if (is_still) return;
  const double needed = std::clamp(std::ceil(length * frames_per_second) + 1, 1.0, kMostFrames);
  frames = std::max(frames, static_cast<std::uint32_t>(needed));
}

double SceneMotion::seconds(FrameMoment moment) const {
  const double of_frame = start + moment.frame / frames_per_second;
  return moment.slice > 0 ? of_frame + shutter->moment(moment.slice - 1, slices, seed) : of_frame;
}

std::vector<FrameMoment> SceneMotion::moments() const {
  std::vector<FrameMoment> out;
  for (std::uint32_t frame = 0; frame < frames; ++frame)
    for (std::uint32_t slice = 0; slice <= slice_count(); ++slice) out.push_back({frame, slice});
  return out;
}

}  // namespace glowworm
