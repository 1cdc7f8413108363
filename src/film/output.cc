#include "film/output.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>

#include "core/json_text.h"
#include "core/version.h"
#include "film/aov.h"
#include "film/filtered.h"
#include "settings/options.h"

namespace glowworm {

std::uint64_t image_bytes(const RenderSettings& settings) {
  // A channel in three forms: as assembled, as the image's, and in the file.
  constexpr std::uint64_t kBytesPerChannel = 3 * sizeof(float);
  std::uint64_t channels = 3;
  for (const std::string& aov : settings.aovs) channels += layer_channels(aov);
  channels += 3 * settings.light_group_count;
  // Renders that end by noise or time filter on their own, beside the readers of the film.
  const bool filters_itself = settings.noise_target > 0 || settings.time_limit_s > 0;
  const std::uint64_t filters_at_once = !filters(settings) ? 0 : filters_itself ? 2 : 1;
  return settings.bounds.pixel_count() * (kBytesPerChannel * channels + filters_at_once * kFilterBytes);
}

Image make_image(const Film& film, const PictureInfo& info) {
  const RenderSettings& settings = info.settings;
  Image image(film.width(), film.height());
  image.place = {film.bounds().x0, film.bounds().y0, settings.width, settings.height};
  FilmPicture seen = shown_picture(film, settings, info.earlier.get());
  std::vector<RGB> beauty = seen.radiance;
  for (RGB& pixel : beauty) pixel *= info.scale;
  image.add_rgb("", beauty);
  for (const std::string& aov : settings.aovs) add_layer(image, {film, info, seen}, aov);
  for (std::size_t group = 0; group < film.light_group_count(); ++group)
    add_light_group(image, {film, info, seen}, group);
  if (film.whole_passes() >= 2)
    image.metadata[kRelativeError] =
        fmt::format("{:.3g}", std::hypot(relative_error(seen), std::sqrt(info.photon_variance)));
  image.matrices = info.matrices;
  image.radiance_scale = info.scale;
  if (!info.view.empty()) image.metadata[kRadianceView] = info.view;
  const std::time_t now = std::time(nullptr);
  image.metadata["capDate"] = fmt::format("{:%Y:%m:%d %H:%M:%S}", fmt::localtime(now));
  image.metadata["Software"] = fmt::format("Glowworm {}", version());
  image.metadata["glowworm:scene"] = info.scene;
  // In floats, positions far from (0, 0, 0) would lose their digits.
  image.metadata["glowworm:origin"] = fmt::format("{} {} {}", info.origin.x, info.origin.y, info.origin.z);
  image.metadata["glowworm:seed"] = std::to_string(settings.seed);
  image.metadata["glowworm:seconds"] = fmt::format("{:.2f}", info.seconds);
  image.metadata["glowworm:passes"] = std::to_string(film.whole_passes());
  image.metadata["glowworm:settings"] = json_text(settings_json(settings));
  return image;
}

}  // namespace glowworm
