#include "import/haze.h"

#include <fmt/format.h>

#include <charconv>

#include "core/error.h"

namespace glowworm {

float length_of_text(const char* option, const std::string& text) {
  float length = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), length);
  const std::string unit(end, text.data() + text.size());
  if (unit == "km") length *= 1000;
  const bool known = unit.empty() || unit == "m" || unit == "km";
  if (error == std::errc() && known && length > 0 && std::isfinite(length)) return length;
  throw Error(fmt::format("{} '{}' is not a length above 0", option, text),
              "Give metres, for example 200, 200m or 2km.");
}

void add_haze(SceneDescription& scene, float visibility) {
  // Fine droplets absorb little, and scatter forwards.
  constexpr float kContrast = 3.912f, kAlbedo = 0.98f, kMeanCosine = 0.7f;
  if (scene.geometry.triangle_count() == 0) {
    scene.notes.push_back("--haze has no effect: the scene has no surface");
    return;
  }
  if (scene.ambient_medium != kNone)
    scene.notes.push_back(
        fmt::format("--haze replaces the medium \"{}\" around the scene", scene.media[scene.ambient_medium].name));
  Medium haze;
  haze.name = "haze";
  haze.sigma_s = RGB(kContrast / visibility * kAlbedo);
  haze.sigma_a = RGB(kContrast / visibility * (1 - kAlbedo));
  haze.g = kMeanCosine;
  haze.bounds = box_of_air(scene.geometry.bounds(), scene.cameras, scene.lights);
  scene.ambient_medium = static_cast<std::uint32_t>(scene.media.size());
  scene.media.push_back(std::move(haze));
}

}  // namespace glowworm
