#include "measure/sky_patches.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "core/error.h"
#include "core/version.h"
#include "measure/measurement.h"

namespace glowworm {

namespace {

/// Patches of Tregenza's rows (P. Tregenza, "Subdivision of the sky hemisphere for luminance measurements", Lighting
/// Research and Technology 19(1), 1987).
constexpr int kTregenza[7] = {30, 30, 24, 24, 18, 12, 6};

}  // namespace

SkyPatches::SkyPatches(int patches) {
  if (patches != 145 && patches != 577)
    throw Error(fmt::format("the sky is not divided into {} patches", patches),
                "Give 145 (Tregenza) or 577 (Reinhart).");
  const int factor = patches == 145 ? 1 : 2;
  for (const int row : kTregenza)
    for (int i = 0; i < factor; ++i) in_row_.push_back(factor * row);
  in_row_.push_back(1);
  row_height_ = M_PI / 2 / (7 * factor + 0.5);
  for (const int count : in_row_) size_ += static_cast<std::size_t>(count);
}

std::size_t SkyPatches::patch_of(Vec3 d) const {
  if (!(d.y >= 0)) return 0;
  const double altitude = std::atan2(d.y, std::hypot(d.x, d.z));
  const auto row = std::min(static_cast<std::size_t>(altitude / row_height_), in_row_.size() - 1);
  std::size_t first = 1;
  for (std::size_t i = 0; i < row; ++i) first += static_cast<std::size_t>(in_row_[i]);
  const double share = std::atan2(d.x, -d.z) / (2 * M_PI) + 1;
  const auto place = static_cast<int>(std::floor(share * in_row_[row] + 0.5)) % in_row_[row];
  return first + static_cast<std::size_t>(place);
}

Scene scene_under_patches(const Scene& scene, const SkyPatches& patches) {
  SceneEdit edit{scene.emissions(), scene.lights(), Environment{}, nullptr, {}, {}};
  for (Emission& emission : edit.emissions) emission.radiance.value = RGB(0.0f);
  for (Light& light : edit.lights) light.intensity = RGB(0.0f);
  const auto part_of = [patches](Vec3 d) { return static_cast<std::uint32_t>(patches.patch_of(d)); };
  edit.environment->name = "sky patch";
  edit.environment->parts =
      std::make_shared<const EnvironmentParts>(EnvironmentParts{static_cast<std::uint32_t>(patches.size()), part_of});
  return Scene(scene, std::move(edit));
}

RenderSettings patch_settings(RenderSettings settings) {
  settings.light_groups = true;
  // Light comes from everywhere, and bright patches would be looked for in the photons of each sky patch.
  settings.gather_guiding = false;
  return settings;
}

DaylightMatrix daylight_matrix(const Job& job, std::size_t sensors) {
  const Film film = job.snapshot();
  const LightGroups& groups = *job.light_groups();
  const std::size_t patches = job.scene().environment()->parts->count, first = groups.of_source.size() - patches;
  DaylightMatrix out{sensors, patches, {}};
  out.coefficient.reserve(sensors * patches);
  for (std::size_t i = 0; i < sensors; ++i)
    for (std::size_t patch = 0; patch < patches; ++patch)
      out.coefficient.push_back(film.light_of_group(groups.of_source[first + patch], i));
  return out;
}

std::string daylight_matrix_text(const DaylightMatrix& m, const std::string& about) {
  std::string text = fmt::format("#?RADIANCE\n{}\nSOFTWARE= glowworm {}\nNCOMP=3\nNROWS={}\nNCOLS={}\nFORMAT=ascii\n\n",
                                 one_line(about), version(), m.sensors, m.patches);
  for (std::size_t i = 0; i < m.sensors; ++i) {
    for (std::size_t patch = 0; patch < m.patches; ++patch) {
      const RGB e = m.at(i, patch);
      fmt::format_to(std::back_inserter(text), "{:.6e}\t{:.6e}\t{:.6e}\t", e.r, e.g, e.b);
    }
    text += '\n';
  }
  return text;
}

}  // namespace glowworm
