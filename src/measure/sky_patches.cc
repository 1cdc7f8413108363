#include "measure/sky_patches.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "core/error.h"

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

std::vector<SkyPatches::Piece> SkyPatches::pieces(int across) const {
  std::vector<Piece> out;
  std::size_t patch = 1;
  for (std::size_t row = 0; row < in_row_.size(); ++row) {
    const bool is_zenith = row + 1 == in_row_.size();
    const double low = static_cast<double>(row) * row_height_, high = is_zenith ? M_PI / 2 : low + row_height_;
    const int around = is_zenith ? 4 * across : across;
    const double width = 2 * M_PI / in_row_[row];
    for (int i = 0; i < in_row_[row]; ++i, ++patch)
      for (int v = 0; v < across; ++v)
        for (int u = 0; u < around; ++u) {
          const double from = low + (high - low) * v / across, to = low + (high - low) * (v + 1) / across;
          const double altitude = (from + to) / 2, azimuth = width * (i - 0.5 + (u + 0.5) / around);
          const double below = std::sin(from), above = std::sin(to), cosine = std::cos(altitude);
          const Vec3 direction{static_cast<float>(cosine * std::sin(azimuth)), static_cast<float>(std::sin(altitude)),
                               static_cast<float>(-cosine * std::cos(azimuth))};
          out.push_back({patch, normalize(direction), width / around * (above - below),
                         width / around * (above * above - below * below) / 2});
        }
  }
  return out;
}

namespace {

/// The scene without its own lights.
SceneEdit dark_edit(const Scene& scene) {
  SceneEdit edit{scene.emissions(), scene.lights(), std::nullopt, nullptr, {}, {}};
  for (Emission& emission : edit.emissions) emission.radiance.value = RGB(0.0f);
  for (Light& light : edit.lights) light.intensity = RGB(0.0f);
  return edit;
}

}  // namespace

Scene scene_under_patches(const Scene& scene, const SkyPatches& patches) {
  SceneEdit edit = dark_edit(scene);
  const auto part_of = [patches](Vec3 d) { return static_cast<std::uint32_t>(patches.patch_of(d)); };
  edit.environment = Environment{};
  edit.environment->name = "sky patch";
  edit.environment->parts =
      std::make_shared<const EnvironmentParts>(EnvironmentParts{static_cast<std::uint32_t>(patches.size()), part_of});
  return Scene(scene, std::move(edit));
}

Scene scene_under_suns(const Scene& scene, std::span<const Vec3> suns) {
  SceneEdit edit = dark_edit(scene);
  for (const Vec3 sun : suns) {
    Light light;
    light.kind = LightKind::directional;
    light.intensity = RGB(1.0f);
    light.direction = -sun;
    edit.lights.push_back(light);
  }
  // Groups of light are unlimited in number beside an environment in parts.
  edit.environment = Environment{};
  edit.environment->scale = RGB(0.0f);
  edit.environment->parts = std::make_shared<const EnvironmentParts>(EnvironmentParts{1, [](Vec3) { return 0u; }});
  return Scene(scene, std::move(edit));
}

RenderSettings patch_settings(RenderSettings settings) {
  settings.light_groups = true;
  // Light comes from everywhere, and bright patches would be looked for in the photons of each sky patch.
  settings.gather_guiding = false;
  // Searches in a GroupedMap take most of the time, and light from all of the sky falls off little.
  settings.extrapolates = false;
  return settings;
}

namespace {

/// The light of `count` light sources from `first` on, counted as in Scene::light_power(), of a Job that keeps groups
/// apart: sensors are rows, sources columns.
ColorMatrix light_of_sources(const Job& job, std::size_t sensors, std::size_t first, std::size_t count) {
  const Film film = job.snapshot();
  const LightGroups& groups = *job.light_groups();
  ColorMatrix out{sensors, count, {}};
  out.value.reserve(sensors * count);
  for (std::size_t i = 0; i < sensors; ++i)
    for (std::size_t source = first; source < first + count; ++source)
      out.value.push_back(film.light_of_group(groups.of_source[source], i));
  return out;
}

}  // namespace

ColorMatrix sun_matrix(const Job& job, std::size_t sensors, std::size_t suns) {
  return light_of_sources(job, sensors, job.scene().first_medium_source() - suns, suns);
}

ColorMatrix daylight_matrix(const Job& job, std::size_t sensors) {
  const std::size_t patches = job.scene().environment()->parts->count;
  return light_of_sources(job, sensors, job.light_groups()->of_source.size() - patches, patches);
}

}  // namespace glowworm
