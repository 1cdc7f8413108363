#include "bake/bands.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "render/film.h"
#include "render/filtered.h"

namespace glowworm {

namespace {

/// The filter calibrates variances by blocks of so many rows; bands begin with one.
constexpr int kBlock = 32;
/// Rows above and below a band that its filtered light depends on: the window of the filter and the blocks around that,
/// of which the last has differences with one row more.
constexpr int kAbove = 2 * kBlock, kBelow = kBlock + 2;
/// Share of the memory for the film; photons and query points take the rest.
constexpr double kFilmShare = 0.7;

}  // namespace

std::vector<BakeBand> cut_into_bands(const PointGrid& grid, const RenderSettings& settings, std::uint64_t memory) {
  const bool filtered = filters(settings);
  const PixelBounds row{0, 0, grid.width, 1};
  // The Job holds its film twice.
  const std::uint64_t row_bytes = 2 * Film::bytes(row, settings.separate_layers || filtered, {}, filtered) +
                                  row.pixel_count() * ((filtered ? kFilterBytes : 0) + sizeof(RGB) + sizeof(float));
  const double share = kFilmShare * static_cast<double>(memory) / static_cast<double>(row_bytes);
  const int rows = static_cast<int>(std::min(share, 1e9));
  if (rows >= grid.height) return {{0, grid.height, {0, 0, grid.width, grid.height}}};
  const int around = filtered ? kAbove + kBelow : 0;
  const int step = std::max((rows - around) / kBlock * kBlock, kBlock);
  std::vector<BakeBand> out;
  for (int first = 0; first < grid.height; first += step) {
    BakeBand band;
    band.first = first;
    band.end = std::min(first + step, grid.height);
    band.rendered = {0, filtered ? std::max(first - kAbove, 0) : first, grid.width,
                     filtered ? std::min(band.end + kBelow, grid.height) : band.end};
    out.push_back(band);
  }
  return out;
}

Baked bake_points(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Tracer>& tracer,
                  const std::shared_ptr<const PointGrid>& points, RenderSettings settings, const Checkpoint* resume,
                  const AttendBand& attend) {
  const std::uint64_t tables = points->normal.size() * kTexelTableBytes;
  if (tables >= settings.memory_bytes)
    throw Error(fmt::format("{:.0f} MB for the places of texels exceed the memory budget of {:.0f} MB",
                            static_cast<double>(tables) / 1e6, static_cast<double>(settings.memory_bytes) / 1e6),
                "Give a larger --memory, or a smaller --atlas.");
  settings.memory_bytes -= tables;
  settings.separate_layers = filters(settings);
  const double time_limit_s = settings.time_limit_s;
  const std::vector<BakeBand> bands = cut_into_bands(*points, settings, settings.memory_bytes);
  Baked baked;
  baked.irradiance = TexelIrradiance(points->normal.size());
  for (std::size_t i = 0; i < bands.size(); ++i) {
    settings.bounds = bands[i].rendered;
    if (time_limit_s > 0)
      settings.time_limit_s = std::max((time_limit_s - baked.seconds) / static_cast<double>(bands.size() - i), 1e-3);
    Job job(scene, tracer, settings, resume, 0, points);
    baked.failure = attend(job, bands[i], bands.size());
    baked.seconds += job.seconds();
    baked.ending = job.ending();
    baked.passes = i == 0 ? job.passes() : std::min(baked.passes, job.passes());
    if (job.passes() > 0) baked.irradiance.take(job.snapshot(), *points, job.settings(), bands[i].first, bands[i].end);
    const bool stops = baked.failure || baked.ending == Ending::cancelled || job.passes() == 0;
    if (stops && i + 1 < bands.size()) baked.passes = 0;
    if (stops) break;
  }
  return baked;
}

}  // namespace glowworm
