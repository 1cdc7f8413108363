#include "measure/glare.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/error.h"

namespace glowworm {

namespace {

constexpr double kDegree = M_PI / 180;
/// Points along a side of a pixel at which its solid angle is taken.
constexpr int kPoints = 4;

Vec2 plane_of(const GlarePicture& p, double x, double y) {
  return {static_cast<float>((2 * x / p.width - 1) * p.half_x), static_cast<float>((1 - 2 * y / p.height) * p.half_y)};
}

PixelView view_of_pixel(const GlarePicture& p, int x, int y) {
  PixelView out;
  const double points = static_cast<double>(p.luminance.size()) * kPoints * kPoints;
  const double area = 4.0 * p.half_x * p.half_y / points;
  for (int i = 0; i < kPoints * kPoints; ++i) {
    const Vec2 plane = plane_of(p, x + (i % kPoints + 0.5) / kPoints, y + (i / kPoints + 0.5) / kPoints);
    const Vec3 d = angular_direction(p.kind, plane);
    const double solid_angle = d.z > 0 ? solid_angle_density(p.kind, plane) * area : 0;
    out.solid_angle += solid_angle;
    out.projected = out.projected + Vec3d(d) * solid_angle;
  }
  return out;
}

/// 0: no source, 1: a source, 2: a peak within one.
int level_of(double luminance, double threshold) { return int{luminance > threshold} + int{luminance > kGlarePeak}; }

/// The part of a pixel that belongs to a source.
struct SourcePart {
  int level = 0;         ///< level_of()
  double share = 1;      ///< of the pixel's solid angle
  double luminance = 0;  ///< cd/m^2
};

/// The places of a pixel at its highest level.
SourcePart brightest_part(const PixelDetail& detail, double threshold) {
  SourcePart out;
  std::size_t count = 0;
  for (const float luminance : detail.luminance) out.level = std::max(out.level, level_of(luminance, threshold));
  for (const float luminance : detail.luminance) {
    if (level_of(luminance, threshold) != out.level) continue;
    out.luminance += luminance;
    ++count;
  }
  out.luminance /= static_cast<double>(count);
  out.share = static_cast<double>(count) / static_cast<double>(detail.luminance.size());
  return out;
}

/// Of each pixel in front of the eye.
std::vector<SourcePart> source_parts(const GlarePicture& p, std::span<const PixelView> views, double threshold) {
  std::vector<SourcePart> parts(p.luminance.size());
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (views[i].solid_angle > 0) parts[i] = {level_of(p.luminance[i], threshold), 1, p.luminance[i]};
  for (const PixelDetail& detail : p.details)
    if (views[detail.pixel].solid_angle > 0) parts[detail.pixel] = brightest_part(detail, threshold);
  return parts;
}

/// Numbers the connected pixels of one level, over sides and corners.
std::uint32_t connect(const GlarePicture& p, const std::vector<SourcePart>& parts,
                      std::vector<std::uint32_t>& source_of) {
  std::uint32_t count = 0;
  std::vector<std::size_t> open;
  const auto width = static_cast<std::size_t>(p.width);
  for (std::size_t first = 0; first < parts.size(); ++first) {
    if (parts[first].level == 0 || source_of[first] != kNoGlareSource) continue;
    open.push_back(first);
    source_of[first] = count;
    while (!open.empty()) {
      const std::size_t at = open.back();
      open.pop_back();
      const int x = static_cast<int>(at % width), y = static_cast<int>(at / width);
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, p.height - 1); ++v)
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, p.width - 1); ++u) {
          const std::size_t next = static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u);
          if (parts[next].level != parts[first].level || source_of[next] != kNoGlareSource) continue;
          source_of[next] = count;
          open.push_back(next);
        }
    }
    ++count;
  }
  return count;
}

}  // namespace

double task_luminance(const GlarePicture& p, const GlareTask& task) {
  const Vec3 middle = angular_direction(p.kind, plane_of(p, task.x, p.height - task.y));
  double sum = 0, solid_angle = 0;
  for (std::size_t i = 0; i < p.luminance.size(); ++i) {
    const int x = static_cast<int>(i) % p.width, y = static_cast<int>(i) / p.width;
    const Vec3 d = angular_direction(p.kind, plane_of(p, x + 0.5, y + 0.5));
    if (!(d.z > 0) || !(dot(d, middle) >= std::cos(task.opening / 2))) continue;
    const double of_pixel = view_of_pixel(p, x, y).solid_angle;
    sum += p.luminance[i] * of_pixel;
    solid_angle += of_pixel;
  }
  if (!(solid_angle > 0))
    throw Error("the task lies outside of the picture", "Give pixels from the lower left corner.");
  return sum / solid_angle;
}

double position_index(Vec3 d) {
  constexpr double kMost = 16, kFarthest = 3, kNear = 0.6;
  if (!(d.z > 0)) return kMost;
  const double side = std::hypot(double{d.x}, double{d.y});
  if (d.y < 0) {
    // The distance from the line of sight over that along it.
    const double r = std::min(side / d.z, kFarthest);
    return std::min(1 + (r > kNear ? 1.2 : 0.8) * r, kMost);
  }
  const double sigma = std::atan2(side, double{d.z}) / kDegree;
  const double tau = std::atan2(std::abs(double{d.x}), double{d.y}) / kDegree;
  const double linear = 35.2 - 0.31889 * tau - 1.22 * std::exp(-2 * tau / 9);
  const double square = 21 + 0.26667 * tau - 0.002963 * tau * tau;
  return std::min(std::exp(linear * 1e-3 * sigma + square * 1e-5 * sigma * sigma), kMost);
}

double daylight_glare_probability(double e, std::span<const GlareSource> sources) {
  double sum = 0;
  for (const GlareSource& s : sources)
    sum += s.luminance * s.luminance * s.solid_angle / (s.position_index * s.position_index);
  const double contrast = e > 0 ? std::log10(1 + sum / std::pow(e, 1.87)) : 0;
  const double low_light_correction = e < 1000 ? 1 / (1 + std::exp(4 - 0.024 * e)) : 1;
  return std::min(5.87e-5 * e + 9.18e-2 * contrast + 0.16, 1.0) * low_light_correction;
}

double daylight_glare_index(double background, std::span<const GlareSource> sources) {
  double sum = 0;
  for (const GlareSource& s : sources)
    sum += std::pow(s.luminance, 1.6) * std::pow(s.solid_angle / (s.position_index * s.position_index), 0.8) /
           (background + 0.07 * std::sqrt(s.solid_angle) * s.luminance);
  return sum > 0 ? 10 * std::log10(0.478 * sum) : 0;
}

double unified_glare_rating(double background, std::span<const GlareSource> sources) {
  double sum = 0;
  for (const GlareSource& s : sources)
    sum += s.luminance * s.luminance * s.solid_angle / (s.position_index * s.position_index);
  return sum > 0 && background > 0 ? 8 * std::log10(0.25 / background * sum) : 0;
}

std::vector<PixelView> pixel_views(const GlarePicture& p) {
  std::vector<PixelView> views;
  views.reserve(p.luminance.size());
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) views.push_back(view_of_pixel(p, x, y));
  return views;
}

Glare rate_glare(const GlarePicture& p, std::span<const PixelView> views, std::span<const GlareSource> lights,
                 double threshold) {
  Glare out;
  const std::vector<SourcePart> parts = source_parts(p, views, threshold);
  for (std::size_t i = 0; i < parts.size(); ++i) out.vertical_illuminance += p.luminance[i] * views[i].projected.z;
  out.source_of.assign(parts.size(), kNoGlareSource);
  out.sources.resize(connect(p, parts, out.source_of));
  std::vector<Vec3d> middle(out.sources.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (out.source_of[i] == kNoGlareSource) continue;
    GlareSource& source = out.sources[out.source_of[i]];
    const double brightness = parts[i].luminance * parts[i].share;
    source.solid_angle += views[i].solid_angle * parts[i].share;
    source.luminance += brightness * views[i].solid_angle;
    source.illuminance += brightness * views[i].projected.z;
    middle[out.source_of[i]] = middle[out.source_of[i]] + views[i].projected * brightness;
  }
  double of_sources = 0;
  for (std::size_t i = 0; i < out.sources.size(); ++i) {
    GlareSource& source = out.sources[i];
    source.luminance /= source.solid_angle;
    const Vec3d& m = middle[i];
    source.direction = narrow(m * (1 / length(m)));
    source.position_index = position_index(source.direction);
    of_sources += source.illuminance;
  }
  for (const GlareSource& light : lights) {
    out.vertical_illuminance += light.illuminance;
    of_sources += light.illuminance;
    out.sources.push_back(light);
  }
  out.background = std::max(out.vertical_illuminance - of_sources, 0.0) / M_PI;
  out.dgp = daylight_glare_probability(out.vertical_illuminance, out.sources);
  out.dgi = daylight_glare_index(out.background, out.sources);
  out.ugr = unified_glare_rating(out.background, out.sources);
  return out;
}

}  // namespace glowworm
