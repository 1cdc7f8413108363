#include "measure/year.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "maps/air_light.h"
#include "measure/measurement.h"
#include "transport/light_connection.h"
#include "transport/light_images.h"
#include "transport/medium.h"
#include "transport/vertex.h"

namespace glowworm {

namespace {

/// Least pieces of the sky that mean radiances of patches are taken over.
constexpr double kPieces = 2000;
/// Hours that errors are taken over.
constexpr std::size_t kHoursOfError = 64;

std::vector<SkyPatches::Piece> pieces_of(const SkyPatches& patches) {
  return patches.pieces(static_cast<int>(std::ceil(std::sqrt(kPieces / static_cast<double>(patches.size())))));
}

/// A sky by its patches.
struct PatchedSky {
  std::vector<float> relative;  ///< mean radiance of patches, with a horizontal irradiance of 1; the ground is black
  double horizontal = 0;        ///< irradiance of the sky
};
PatchedSky relative_sky(const SkyModel& sky, std::span<const SkyPatches::Piece> pieces, std::size_t patches) {
  std::vector<double> light(patches), solid_angle(patches), projected(patches);
  for (const SkyPatches::Piece& piece : pieces) {
    light[piece.patch] += sky_radiance(sky, piece.direction) * piece.solid_angle;
    solid_angle[piece.patch] += piece.solid_angle;
    projected[piece.patch] += piece.projected;
  }
  double horizontal = 0;
  for (std::size_t i = 1; i < patches; ++i) horizontal += light[i] / solid_angle[i] * projected[i];
  PatchedSky out{std::vector<float>(patches), horizontal};
  if (!(horizontal > 0)) return out;
  for (std::size_t i = 1; i < patches; ++i)
    out.relative[i] = static_cast<float>(light[i] / solid_angle[i] / horizontal);
  return out;
}

/// The part of the luminance of a product with `v` that one of the channels has, over that channel.
float part_of_channel(RGB v, std::size_t channel, std::size_t channels) {
  if (channels == 1) return luminance(v);
  return luminance({channel == 0 ? v.r : 0, channel == 1 ? v.g : 0, channel == 2 ? v.b : 0});
}

void add_to(ColorMatrix& sum, const ColorMatrix& m) {
  if (sum.value.empty()) {
    sum = m;
    return;
  }
  for (std::size_t i = 0; i < m.value.size(); ++i) sum.value[i] += m.value[i];
}

}  // namespace

YearSky year_sky(const WeatherYear& year, const SkyPatches& patches, double ground) {
  YearSky out;
  out.hours = year.hours;
  std::vector<PerezSky> skies;
  for (std::size_t i = 0; i < year.hours.size(); ++i) {
    const std::optional<PerezSky> sky = perez_sky(year.hours[i].moment, year.hours[i].irradiance);
    if (!sky) continue;
    skies.push_back(*sky);
    out.lit.push_back(static_cast<std::uint32_t>(i));
    out.sun.push_back(sky->shape.sun);
    out.beam.push_back(static_cast<float>(sky->direct));
  }
  out.sky = {patches.size(), skies.size(), std::vector<RGB>(patches.size() * skies.size())};
  out.shape.resize(skies.size());
  const std::vector<SkyPatches::Piece> pieces = pieces_of(patches);
  constexpr std::size_t kHoursAtOnce = 16;
  parallel_for_each(skies.size(), kHoursAtOnce, [&](std::size_t i) {
    const PerezSky& sky = skies[i];
    const PatchedSky patched = relative_sky(sky.shape, pieces, patches.size());
    out.shape[i] = sky.shape;
    out.shape[i].zenith = patched.horizontal > 0 ? static_cast<float>(sky.diffuse / patched.horizontal) : 0.0f;
    out.sky.value[i] = RGB(static_cast<float>(ground * sky.horizontal() / M_PI));
    for (std::size_t patch = 1; patch < patches.size(); ++patch)
      out.sky.value[patch * skies.size() + i] = RGB(patched.relative[patch] * static_cast<float>(sky.diffuse));
  });
  return out;
}

std::vector<float> overcast_sky(const SkyPatches& patches, double ground) {
  constexpr int kOvercast = 16;
  std::vector<float> out =
      relative_sky(cie_sky(kOvercast, {0, 1, 0}, 1, 0), pieces_of(patches), patches.size()).relative;
  out[0] = static_cast<float>(ground / M_PI);
  return out;
}

ColorMatrix matrix_of_sky(const YearSky& sky) {
  ColorMatrix out{sky.sky.rows, sky.hours.size(), std::vector<RGB>(sky.sky.rows * sky.hours.size())};
  for (std::size_t row = 0; row < out.rows; ++row)
    for (std::size_t i = 0; i < sky.lit.size(); ++i) out.value[row * out.columns + sky.lit[i]] = sky.sky.at(row, i);
  return out;
}

void replace_sky(YearSky& sky, const ColorMatrix& matrix, const std::string& path) {
  if (matrix.rows != sky.sky.rows || matrix.columns != sky.hours.size())
    throw Error(
        {path},
        fmt::format("is a matrix of {} patches and {} hours, not of {} and {}", matrix.rows, matrix.columns,
                    sky.sky.rows, sky.hours.size()),
        "Give a matrix of gendaymtx -s -m 1 (or -m 2 with --sky-patches 577), of all hours of the weather file.");
  for (std::size_t row = 0; row < matrix.rows; ++row)
    for (std::size_t i = 0; i < sky.lit.size(); ++i)
      sky.sky.value[row * sky.lit.size() + i] = matrix.at(row, sky.lit[i]);
  sky.shape.clear();
}

std::shared_ptr<const PointGrid> coefficient_grid(const Sensors& sensors, bool on_surfaces) {
  PointGrid grid = sensor_grid(sensors, on_surfaces, 1);
  grid.delta_lights_apart = true;
  return std::make_shared<const PointGrid>(std::move(grid));
}

CoefficientMean::CoefficientMean(const YearSky& sky, const SunGrid& grid) : sky_(sky), grid_(grid) {
  const std::size_t count = std::min(kHoursOfError, sky.lit.size());
  for (std::size_t i = 0; i < count; ++i)
    hours_.push_back(static_cast<std::uint32_t>((2 * i + 1) * sky.lit.size() / (2 * count)));
}

void CoefficientMean::add(const DaylightCoefficients& found) {
  add_to(total_.sky, found.sky);
  add_to(total_.suns, found.suns);
  ++count_;
  sum_.resize(found.sky.rows * hours_.size());
  sum_of_squares_.resize(sum_.size());
  const DiffuseLight light(sky_, grid_, hours_);
  std::vector<float> lux(hours_.size());
  for (std::size_t sensor = 0; sensor < found.sky.rows; ++sensor) {
    light.illuminance(found, sensor, lux);
    for (std::size_t i = 0; i < lux.size(); ++i) {
      sum_[sensor * lux.size() + i] += lux[i];
      sum_of_squares_[sensor * lux.size() + i] += double{lux[i]} * lux[i];
    }
  }
}

DaylightCoefficients CoefficientMean::mean() const {
  DaylightCoefficients out = total_;
  const float each = 1 / static_cast<float>(std::max(count_, 1u));
  for (RGB& v : out.sky.value) v *= each;
  for (RGB& v : out.suns.value) v *= each;
  return out;
}

std::vector<float> CoefficientMean::relative_error() const {
  const std::size_t sensors = total_.sky.rows;
  std::vector<float> out(sensors);
  if (count_ < 2) return out;
  const double n = count_;
  for (std::size_t sensor = 0; sensor < sensors; ++sensor) {
    double variance = 0, level = 0;
    for (std::size_t i = sensor * hours_.size(); i < (sensor + 1) * hours_.size(); ++i) {
      const double mean = sum_[i] / n;
      variance += std::max(sum_of_squares_[i] / n - mean * mean, 0.0) / (n - 1);
      level += mean * mean;
    }
    out[sensor] = level > 0 ? static_cast<float>(student_factor(count_ - 1) * std::sqrt(variance / level))
                            : std::numeric_limits<float>::infinity();
  }
  return out;
}

DiffuseLight::DiffuseLight(const YearSky& sky, const SunGrid& grid, std::vector<std::uint32_t> hours)
    : sky_(sky), grid_(grid), hours_(std::move(hours)) {
  const ColorMatrix& m = sky.sky;
  const bool is_grey = std::all_of(m.value.begin(), m.value.end(), [](RGB v) { return v.r == v.g && v.g == v.b; });
  channel_.resize(is_grey ? 1 : 3);
  for (std::size_t c = 0; c < channel_.size(); ++c)
    for (std::size_t row = 0; row < m.rows; ++row)
      for (const std::uint32_t hour : hours_) channel_[c].push_back(m.at(row, hour)[static_cast<int>(c)]);
}

void DiffuseLight::illuminance(const DaylightCoefficients& of, std::size_t sensor, std::span<float> out) const {
  std::fill(out.begin(), out.end(), 0.0f);
  for (std::size_t c = 0; c < channel_.size(); ++c)
    for (std::size_t patch = 0; patch < of.sky.columns; ++patch) {
      const float factor = part_of_channel(of.sky.at(sensor, patch), c, channel_.size());
      const float* const row = channel_[c].data() + patch * hours_.size();
      for (std::size_t i = 0; i < out.size(); ++i) out[i] += factor * row[i];
    }
  for (std::size_t i = 0; i < out.size(); ++i) {
    const float beam = sky_.beam[hours_[i]];
    float light = 0;
    if (beam > 0)
      for (const SunGrid::Share& share : grid_.shares()[hours_[i]])
        if (share.weight > 0) light += share.weight * luminance(of.suns.at(sensor, share.place));
    out[i] = kLuminousEfficacy * (out[i] + beam * light);
  }
}

namespace {

/// Widens the lobes of a surface to a GGX alpha at least. Smooth lobes stay.
void widen(Bsdf& bsdf, float least_alpha) {
  if (std::max(bsdf.alpha_x, bsdf.alpha_y) >= kSmoothAlpha)
    for (float* alpha : {&bsdf.alpha_x, &bsdf.alpha_y}) *alpha = std::max(*alpha, least_alpha);
  if (bsdf.coat_alpha >= kSmoothAlpha) bsdf.coat_alpha = std::max(bsdf.coat_alpha, least_alpha);
}

/// The first points of all slots, and the end.
std::vector<std::size_t> slots_of(const GatherPoints& points) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (i == 0 || points.slot[i] != points.slot[i - 1]) out.push_back(i);
  out.push_back(points.size());
  return out;
}

}  // namespace

std::vector<float> reflected_sun(const Tracer& tracer, const GatherPoints& points, std::size_t slots,
                                 const YearSky& sky, std::span<const std::uint32_t> hours, const SunReflection& of) {
  constexpr std::size_t kSlotsAtOnce = 16;
  std::vector<float> out(slots * hours.size());
  const auto add_point = [&](std::size_t point) {
    Vertex vertex = vertex_of(points, point);
    widen(vertex.bsdf, of.least_alpha);
    std::vector<UnoccludedLight> lights;
    std::vector<std::size_t> hour;
    for (std::size_t i = 0; i < hours.size(); ++i) {
      if (!(sky.beam[hours[i]] > 0)) continue;
      LightSample sun;
      sun.direction = sky.sun[hours[i]];
      sun.distance = std::numeric_limits<float>::infinity();
      sun.radiance = RGB(1.0f);
      sun.pdf = 1;
      sun.delta = true;
      const RGB scattered = vertex.surface().evaluate(vertex.wo, sun.direction, of.lobes);
      if (is_black(scattered)) continue;
      lights.push_back(reflected_light(sun, vertex, scattered, 1));
      hour.push_back(i);
    }
    const std::vector<RGB> passed = passed_shares(tracer, lights);
    for (std::size_t k = 0; k < passed.size(); ++k)
      out[points.slot[point] * hours.size() + hour[k]] +=
          luminance(points.throughput[point] * lights[k].radiance * passed[k]);
  };
  const std::vector<std::size_t> first = slots_of(points);
  parallel_for_each(first.size() - 1, kSlotsAtOnce, [&](std::size_t i) {
    if (points.slot[first[i]] >= slots) return;
    for (std::size_t point = first[i]; point < first[i + 1]; ++point) add_point(point);
  });
  return out;
}

namespace {

/// Adds the light of the sun's images to sensors in air.
void add_sun_images(const Tracer& tracer, const PointGrid& grid, std::size_t sensors, const YearSky& sky,
                    const std::function<void(double)>& progress, DirectSun& out) {
  const Scene& scene = tracer.scene();
  const LightImages of_scene(scene);
  if (of_scene.empty()) return;
  std::vector<ImagedLight> suns(sky.lit.size());
  for (std::size_t hour = 0; hour < suns.size(); ++hour)
    if (sky.beam[hour] > 0) suns[hour] = of_scene.of(sun_towards(sky.sun[hour]));
  const auto add = [&](std::size_t sensor, std::size_t first, std::size_t end) {
    if (!grid.has(sensor)) return;
    const AirPoint point = air_point(scene, grid, sensor, 0);
    const PathMedium medium =
        scene.media().empty() ? PathMedium{} : medium_at_start(tracer, point.position, point.normal);
    std::uint64_t rays = 0;
    for (std::size_t hour = first; hour < end; ++hour)
      for (const Vec3 image : suns[hour].images) {
        const float cosine = dot(image, point.normal);
        if (!(cosine > 0)) continue;
        std::vector<float>& part = suns[hour].same(image, sky.sun[hour]) ? out.straight : out.mirrored;
        part[sensor * suns.size() + hour] +=
            cosine * luminance(light_of_image(tracer, point.position, medium, suns[hour], image, rays));
      }
  };
  constexpr std::size_t kHoursAtOnce = 64;
  for (std::size_t first = 0; first < suns.size(); first += kHoursAtOnce) {
    if (progress) progress(static_cast<double>(first) / static_cast<double>(suns.size()));
    const std::size_t end = std::min(first + kHoursAtOnce, suns.size());
    parallel_for_each(sensors, 1, [&](std::size_t sensor) { add(sensor, first, end); });
  }
}

}  // namespace

DirectSun direct_sun(const Tracer& tracer, const PointGrid& grid, std::size_t sensors, const YearSky& sky,
                     const std::function<void(double)>& progress) {
  GatherPoints points;
  SlotRadiance unused;
  FirstHit first_hit;
  Statistics statistics;
  point_pass(tracer, grid, CameraTask{0, 0, grid.width, grid.height}, unused, first_hit, points, statistics);
  std::vector<std::uint32_t> all(sky.lit.size());
  std::iota(all.begin(), all.end(), 0u);
  DirectSun out{reflected_sun(tracer, points, sensors, sky, all), {}};
  out.mirrored.resize(out.straight.size());
  if (!grid.on_surfaces) add_sun_images(tracer, grid, sensors, sky, progress, out);
  if (progress) progress(1);
  return out;
}

std::vector<std::uint32_t> hours_of_state(const YearSky& sky, std::span<const std::uint32_t> state_of_hour,
                                          std::size_t state) {
  std::vector<std::uint32_t> out;
  for (std::size_t i = 0; i < sky.lit.size(); ++i)
    if ((state_of_hour.empty() ? 0 : state_of_hour[sky.lit[i]]) == state) out.push_back(static_cast<std::uint32_t>(i));
  return out;
}

Year year_of(const YearSky& sky, const SunGrid& grid, std::span<const YearState> states,
             std::span<const std::uint32_t> state_of_hour) {
  Year out;
  out.sensors = states.front().coefficients.sky.rows;
  out.hours = sky.hours.size();
  out.total.resize(out.sensors * out.hours);
  out.sun.resize(out.sensors * out.hours);
  for (std::size_t state = 0; state < states.size(); ++state) {
    const std::vector<std::uint32_t> hours = hours_of_state(sky, state_of_hour, state);
    const DiffuseLight light(sky, grid, hours);
    parallel_for_each(out.sensors, 1, [&](std::size_t sensor) {
      std::vector<float> lux(hours.size());
      light.illuminance(states[state].coefficients, sensor, lux);
      for (std::size_t i = 0; i < hours.size(); ++i) {
        const std::size_t at = sensor * sky.lit.size() + hours[i];
        const float sun = (states[state].sun.straight[at] + states[state].sun.mirrored[at]) * sky.beam[hours[i]];
        out.total[sensor * out.hours + sky.lit[hours[i]]] = lux[i] + kLuminousEfficacy * sun;
      }
    });
  }
  for (std::size_t sensor = 0; sensor < out.sensors; ++sensor)
    for (std::size_t i = 0; i < sky.lit.size(); ++i)
      out.sun[sensor * out.hours + sky.lit[i]] =
          kLuminousEfficacy * states.front().sun.straight[sensor * sky.lit.size() + i] * sky.beam[i];
  return out;
}

std::vector<float> share_under(const DaylightCoefficients& of, std::span<const float> radiance) {
  std::vector<float> out(of.sky.rows);
  for (std::size_t sensor = 0; sensor < out.size(); ++sensor)
    for (std::size_t patch = 0; patch < of.sky.columns; ++patch)
      out[sensor] += luminance(of.sky.at(sensor, patch)) * radiance[patch];
  return out;
}

}  // namespace glowworm
