#include "render/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/error.h"
#include "core/memory_budget.h"
#include "core/parallel.h"
#include "scene/scene.h"

namespace glowworm {

namespace {

constexpr int kLargestSide = 65536;
/// Camera samples of a render that ends by time or noise, at most.
constexpr std::uint32_t kOpenEndedSamples = 1u << 20;

void resolve_size(RenderSettings& s, const Scene& scene) {
  if (s.width == 0 && s.height == 0) {
    s.width = scene.film().width > 0 ? scene.film().width : 512;
    s.height = scene.film().height > 0 ? scene.film().height : 512;
  }
  if (s.width < 1 || s.height < 1 || s.width > kLargestSide || s.height > kLargestSide)
    throw Error(fmt::format("a picture of {}x{} pixels cannot be rendered", s.width, s.height),
                fmt::format("Give --size WxH with both from 1 to {}.", kLargestSide));
}

}  // namespace

std::vector<std::string> aov_names() {
  return {"emitted", "direct", "indirect", "caustic", "albedo", "normal", "depth"};
}

RenderSettings resolve(const RenderSettings& asked, const Scene& scene) {
  RenderSettings s = asked;
  resolve_size(s, scene);
  const std::vector<std::string> known = aov_names();
  for (const std::string& aov : s.aovs)
    if (std::find(known.begin(), known.end(), aov) == known.end())
      throw Error(fmt::format("there is no AOV '{}'", aov), fmt::format("Choose from: {}.", fmt::join(known, ", ")));
  const bool open_ended = s.time_limit_s > 0 || s.noise_target > 0;
  if (s.integrator == Integrator::path) {
    if (s.samples == 0) s.samples = open_ended ? kOpenEndedSamples : 256;
  } else {
    if (s.engine == "auto") s.engine = "blocked";
    const std::vector<std::string> engines = engine_names();
    if (std::find(engines.begin(), engines.end(), s.engine) == engines.end())
      throw Error(fmt::format("there is no engine '{}'", s.engine),
                  fmt::format("Choose from: auto, {}.", fmt::join(engines, ", ")));
    if (s.samples == 0) s.samples = open_ended ? kOpenEndedSamples : 16;
    if (s.gather == 0) s.gather = 25;
    if (s.photons == 0) s.photons = 500'000;
    if (s.nearest == 0) s.nearest = 50;
    if (s.light_samples == 0) s.light_samples = std::clamp<std::uint32_t>(s.gather / 8, 1, 16);
  }
  s.camera = scene.camera(s.camera).name;
  s.threads = thread_count();
  if (s.memory_bytes == 0) s.memory_bytes = physical_memory_bytes() / 2;
  return s;
}

}  // namespace glowworm
