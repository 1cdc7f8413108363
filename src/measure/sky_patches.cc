#include "measure/sky_patches.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "core/error.h"
#include "render/job.h"
#include "render/output.h"

namespace glowworm {

namespace {

/// Patches of Tregenza's rows (P. Tregenza, "Subdivision of the sky hemisphere for luminance measurements", Lighting
/// Research and Technology 19(1), 1987).
constexpr int kTregenza[7] = {30, 30, 24, 24, 18, 12, 6};
constexpr int kTableHeight = 360;

/// Length that two intervals share.
double overlap(double a0, double a1, double b0, double b1) {
  return std::max(std::min(a1, b1) - std::max(a0, b0), 0.0);
}

/// The same on a circle of 2 pi, for intervals shorter than it.
double overlap_around(double a0, double a1, double b0, double b1) {
  double sum = 0;
  for (const double turn : {-2 * M_PI, 0.0, 2 * M_PI}) sum += overlap(a0 + turn, a1 + turn, b0, b1);
  return sum;
}

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

Environment SkyPatches::light(std::size_t patch) const {
  double low = -M_PI / 2, high = 0, middle = 0, width = 2 * M_PI;
  std::size_t first = 1;
  for (std::size_t row = 0; patch > 0 && row < in_row_.size(); ++row) {
    const auto count = static_cast<std::size_t>(in_row_[row]);
    if (patch < first + count) {
      low = static_cast<double>(row) * row_height_;
      high = row + 1 == in_row_.size() ? M_PI / 2 : low + row_height_;
      width = 2 * M_PI / static_cast<double>(count);
      middle = width * static_cast<double>(patch - first);
      break;
    }
    first += count;
  }
  Environment e;
  e.name = fmt::format("sky patch {}", patch);
  e.height = kTableHeight;
  e.width = 2 * kTableHeight;
  e.pixels.assign(static_cast<std::size_t>(e.width) * static_cast<std::size_t>(e.height), RGB(0.0f));
  const double texel = M_PI / kTableHeight;
  std::vector<float> columns(static_cast<std::size_t>(e.width));
  for (int x = 0; x < e.width; ++x) {
    // u = 0.5 is north (-z), and east (x) lies to its right.
    const double azimuth = (x + 0.5) * texel - M_PI;
    columns[static_cast<std::size_t>(x)] =
        width > 6 ? 1.0f
                  : static_cast<float>(overlap_around(azimuth - texel / 2, azimuth + texel / 2, middle - width / 2,
                                                      middle + width / 2) /
                                       texel);
  }
  for (int y = 0; y < e.height; ++y) {
    const double altitude = M_PI / 2 - (y + 0.5) * texel;
    const auto share = static_cast<float>(overlap(altitude - texel / 2, altitude + texel / 2, low, high) / texel);
    if (!(share > 0)) continue;
    for (int x = 0; x < e.width; ++x)
      e.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(e.width) + static_cast<std::size_t>(x)] =
          RGB(share * columns[static_cast<std::size_t>(x)]);
  }
  return e;
}

DaylightMatrix measure_sky_patches(const Scene& scene, const Sensors& sensors, bool on_surfaces,
                                   const SkyPatches& patches, const RenderSettings& settings,
                                   const std::function<void(std::size_t)>& done) {
  DaylightMatrix out;
  out.sensors = sensors.size();
  out.patches = patches.size();
  out.coefficient.resize(out.sensors * out.patches);
  SceneEdit edit{scene.emissions(), scene.lights(), {}, nullptr, {}, {}};
  for (Emission& emission : edit.emissions) emission.radiance.value = RGB(0.0f);
  for (Light& light : edit.lights) light.intensity = RGB(0.0f);
  const auto grid = std::make_shared<const PointGrid>(sensor_grid(sensors, on_surfaces));
  const auto tracer = std::make_shared<Tracer>(scene, std::span<const std::uint32_t>());
  for (std::size_t patch = 0; patch < out.patches; ++patch) {
    done(patch);
    edit.environment = patches.light(patch);
    const auto lit = std::make_shared<const Scene>(scene, edit);
    tracer->follow(*lit);
    // With a seed of its own for each patch, the errors of a row do not add up.
    RenderSettings own = settings;
    own.seed = settings.seed + static_cast<std::uint32_t>(patch);
    Job job(lit, tracer, own, nullptr, 0, grid);
    job.wait();
    const Film film = job.snapshot();
    for (std::size_t i = 0; i < out.sensors; ++i) out.coefficient[i * out.patches + patch] = film.radiance(i, false);
  }
  tracer->follow(scene);
  done(out.patches);
  return out;
}

std::string daylight_matrix_text(const DaylightMatrix& m, const std::string& about) {
  std::string line = about;
  for (char& c : line)
    if (c == '\n' || c == '\r') c = ' ';
  std::string text = fmt::format("#?RADIANCE\n{}\nSOFTWARE= glowworm {}\nNCOMP=3\nNROWS={}\nNCOLS={}\nFORMAT=ascii\n\n",
                                 line, version(), m.sensors, m.patches);
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
