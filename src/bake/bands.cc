#include "bake/bands.h"

#include <algorithm>

#include "bake/layout.h"
#include "control/scheduler.h"
#include "control/time_fit.h"
#include "core/error.h"
#include "core/memory_budget.h"
#include "core/parallel.h"
#include "film/film.h"
#include "film/filtered.h"
#include "film/part.h"

namespace glowworm {

namespace {

/// The filter calibrates variances by blocks of so many rows; bands begin with one.
constexpr int kBlock = 32;
/// Rows above and below a band that its filtered light depends on: the window of the filter and the blocks around that,
/// of which the last has differences with two rows more, whose variances are shared with one more.
constexpr int kAbove = 2 * kBlock, kBelow = kBlock + 3;
/// Share of the memory for the film, at most; photons and query points take the rest.
constexpr double kFilmShare = 0.7;
/// That rest is at least so many times the room of the smallest task.
constexpr double kTracingRooms = 1.5;

/// A band of these rows.
BakeBand band_of(const PointGrid& grid, bool filtered, int first, int end) {
  const int above = filtered ? kAbove : 0, below = filtered ? kBelow : 0;
  return {first, end, {0, std::max(first - above, 0), grid.width, std::min(end + below, grid.height)}};
}

/// The band that a checkpoint is of. Throws Error if there is none in the grid.
BakeBand band_of(const Checkpoint& checkpoint, const PointGrid& grid, bool filtered) {
  const auto first = static_cast<int>(checkpoint.first_row), end = static_cast<int>(checkpoint.end_row);
  const bool whole = first % kBlock == 0 && (end % kBlock == 0 || end == grid.height);
  if (first < 0 || end <= first || end > grid.height || !whole ||
      checkpoint.above.size() != static_cast<std::size_t>(first) * static_cast<std::size_t>(grid.width))
    throw Error("the checkpoint is not of a bake of as many texels or probes",
                "Give --atlas, --texels-per-metre or --spacing as they were, or remove the file to start again.");
  return band_of(grid, filtered, first, end);
}

}  // namespace

RenderSettings bake_settings(RenderSettings settings, const PointGrid& points) {
  settings.memory_bytes -= texel_table_bytes(points.normal.size(), settings.memory_bytes, !points.on_surfaces);
  settings.separate_layers = filters(settings);
  return settings;
}

Checkpoint BandRun::checkpoint() const {
  Checkpoint out = job.checkpoint();
  out.first_row = static_cast<std::uint32_t>(band.first);
  out.end_row = static_cast<std::uint32_t>(band.end);
  const std::size_t above = out.first_row * static_cast<std::size_t>(job.points()->width);
  out.above.assign(light.begin(), light.begin() + static_cast<std::ptrdiff_t>(above));
  return out;
}

std::vector<BakeBand> cut_into_bands(const PointGrid& grid, const RenderSettings& settings, std::uint64_t memory,
                                     int first) {
  const bool filtered = filters(settings);
  const PixelBounds row{0, 0, grid.width, 1};
  // The Job holds its film twice.
  const std::uint64_t row_bytes = 2 * Film::bytes(row, settings.separate_layers || filtered, {}, filtered) +
                                  row.pixel_count() * ((filtered ? kFilterBytes : 0) + sizeof(RGB) + sizeof(float));
  RenderSettings traced = settings;
  traced.threads = thread_count();
  const auto all = static_cast<double>(memory);
  const double for_film =
      std::max(std::min(kFilmShare * all, all - kTracingRooms * static_cast<double>(smallest_room(traced))), 0.0);
  const int rows = static_cast<int>(std::min(for_film / static_cast<double>(row_bytes), 1e9));
  if (rows >= grid.height - first) return {band_of(grid, filtered, first, grid.height)};
  const int around = filtered ? kAbove + kBelow : 0;
  const int step = std::max((rows - around) / kBlock * kBlock, kBlock);
  std::vector<BakeBand> out;
  for (; first < grid.height; first += step)
    out.push_back(band_of(grid, filtered, first, std::min(first + step, grid.height)));
  return out;
}

Baked bake_points(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Tracer>& tracer,
                  const std::shared_ptr<const PointGrid>& points, RenderSettings settings,
                  std::optional<Checkpoint> resume, const AttendBand& attend) {
  settings = bake_settings(std::move(settings), *points);
  std::vector<BakeBand> bands;
  Baked baked;
  baked.irradiance = TexelIrradiance(points->normal.size());
  if (resume) {
    settings = with_numbers_of(settings, parse_key(resume->key));
    bands.push_back(band_of(*resume, *points, filters(settings)));
    std::copy(resume->above.begin(), resume->above.end(), baked.irradiance.value.begin());
    for (std::size_t i = 0; i < resume->above.size(); ++i) baked.irradiance.known[i] = points->has(i);
  }
  const int first = bands.empty() ? 0 : bands.back().end;
  if (first < points->height)
    for (const BakeBand& band : cut_into_bands(*points, settings, settings.memory_bytes, first)) bands.push_back(band);
  std::shared_ptr<JobMaps> maps;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    settings.bounds = bands[i].rendered;
    // Each band gets its share of the time that is left; the numbers of rays and photons suit the whole time.
    const double left_s = settings.time_limit_s - baked.seconds;
    const double share_s = std::max(left_s / static_cast<double>(bands.size() - i), 1e-3);
    const double spent_s = settings.time_limit_s > 0 ? settings.time_limit_s - share_s : 0;
    Job job(scene, tracer, settings, resume ? &*resume : nullptr, spent_s, points, nullptr, maps);
    resume.reset();
    baked.failure = attend({job, bands[i], i, bands.size(), baked.irradiance.value});
    baked.seconds += job.seconds();
    baked.ending = job.ending();
    baked.passes = i == 0 ? job.passes() : std::min(baked.passes, job.passes());
    if (job.passes() > 0) baked.irradiance.take(job.film(), *points, job.settings(), bands[i].first, bands[i].end);
    const bool stops = baked.failure || baked.ending == Ending::cancelled || job.passes() == 0;
    if (stops && i + 1 < bands.size()) baked.passes = 0;
    if (stops) break;
    if (i + 1 == bands.size()) break;
    maps = job.maps();
    if (i == 0) settings = with_numbers_of(settings, job.key());  // A key hashes the scene.
    // Both bands have the rows around their border; limits may give each other numbers of samples.
    const PixelBounds next = bands[i + 1].rendered;
    if (baked.ending == Ending::samples_done && !is_adaptive(settings) && !(settings.noise_target > 0))
      maps->rows = job.film().rows(next.y0, std::min(next.y1, bands[i].rendered.y1));
  }
  return baked;
}

Baked points_of_part(const std::string& path, const Scene& scene, const PointGrid& points,
                     const RenderSettings& settings, const std::vector<const Option*>& given) {
  const Part part = read_part(path);
  RenderSettings own = part.picture.settings;
  own.indirect_only = settings.indirect_only;
  own.bounds = {0, 0, points.width, points.height};
  for (const Option* option : given)
    if (option->shows) option->parse(own, option->print(settings));
  const RenderKey key = key_of_whole(render_key(scene, own, &points));
  check_same_whole({"this bake", key}, {path, part.key}, true);
  MemoryBudget budget(bake_settings(settings, points).memory_bytes, memory_remedy(!points.on_surfaces));
  const Reservation memory(budget, "film", merge_bytes(part) + kFilterBytes * own.bounds.pixel_count());
  Film film = film_for(part);
  add_part(path, part, film);
  Baked baked;
  baked.irradiance = TexelIrradiance(points.normal.size());
  baked.irradiance.take(film, points, part.picture.settings, 0, points.height);
  baked.passes = film.whole_passes();
  baked.seconds = part.picture.seconds;
  return baked;
}

}  // namespace glowworm
