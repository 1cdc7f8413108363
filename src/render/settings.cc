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

void check_names(const RenderSettings& settings) {
  const std::vector<std::string> aovs = aov_names(), engines = engine_names();
  for (const std::string& aov : settings.aovs)
    if (std::find(aovs.begin(), aovs.end(), aov) == aovs.end())
      throw Error(fmt::format("there is no AOV '{}'", aov), fmt::format("Choose from: {}.", fmt::join(aovs, ", ")));
  if (settings.engine != "auto" && std::find(engines.begin(), engines.end(), settings.engine) == engines.end())
    throw Error(fmt::format("there is no engine '{}'", settings.engine),
                fmt::format("Choose from: auto, {}.", fmt::join(engines, ", ")));
}

RenderSettings resolve(const RenderSettings& asked, const Scene& scene) {
  RenderSettings s = asked;
  resolve_size(s, scene);
  check_names(s);
  const bool open_ended = s.time_limit_s > 0 || s.noise_target > 0;
  if (s.integrator == Integrator::path) {
    if (s.samples == 0) s.samples = open_ended ? kOpenEndedSamples : 256;
  } else {
    if (s.engine == "auto") s.engine = "blocked";
    if (s.samples == 0) s.samples = open_ended ? kOpenEndedSamples : 16;
    if (s.gather == 0) s.gather = 25;
    if (s.photons == 0) s.photons = 500'000;
    // What knn costs grows with k, and final gathering averages over many of its estimates; [SF07] and [HHS05] went no
    // lower than 30.
    if (s.nearest == 0) s.nearest = s.engine == "knn" ? 30 : 50;
    if (s.light_samples == 0) s.light_samples = std::clamp<std::uint32_t>(s.gather / 8, 1, 16);
  }
  s.camera = scene.camera(s.camera).name;
  s.threads = thread_count();
  if (s.memory_bytes == 0) s.memory_bytes = physical_memory_bytes() / 2;
  return s;
}

}  // namespace glowworm
