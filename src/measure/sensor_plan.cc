#include "measure/sensor_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "measure/measurement.h"
#include "photon/material_lobes.h"

namespace glowworm {

namespace {

/// Sensors of a pilot, at most.
constexpr std::size_t kPilotSensors = 32;
/// Paths of the first pilot, and of one that a gathering pilot is compared with.
constexpr std::uint32_t kPilotPaths = 4096, kComparedPaths = 16384;
/// Fewest and most paths of each sensor. Both are whole batches of powers of two, which random sequences fill evenly.
constexpr std::uint32_t kLeastPaths = 2048, kMostPaths = 1u << 17;
/// Fewest paths, and most of a pilot, where each has a photon map of its own: for light that no path finds.
constexpr std::uint32_t kLeastMappedPaths = 256;
/// Passes of a gathering pilot, and fewest and most of a measurement. A pass has so many rays of each sensor.
constexpr std::uint32_t kPilotPasses = 4, kLeastPasses = 8, kMostPasses = 64, kRaysOfPass = 1024;
/// Photons of a pass: one of so many gather rays, within bounds. Passes average the noise of their maps.
constexpr double kRaysPerPhoton = 4, kLeastPhotonsOfPass = 20'000, kMostPhotonsOfPass = 250'000;
/// Work in gather rays, which take about as long as photons: of a vertex of a path, and of the guides of photons and
/// gather rays.
constexpr double kVertexWork = 0.5, kGuideWork = 500'000;
/// Factor on the work of gathering that is extrapolated: it looks photons up twice.
constexpr double kExtrapolationWork = 1.5;
/// A gathering pilot pays where paths take so many times the least work of gathering.
constexpr double kWorthTrying = 4;
/// Standard errors by which light is seen to differ.
constexpr double kSeenErrors = 3;

/// What a pilot found.
struct Pilot {
  double mean = 0;      ///< luminance of the sensors
  double variance = 0;  ///< of a sample of a sensor, over the square of the mean: the mean over sensors
  double error = 0;     ///< relative, of the mean
  double work = 0;      ///< of a sample of a sensor
};

PointGrid pilot_grid(const PointGrid& grid) {
  PointGrid out;
  const std::size_t cells = grid.normal.size(), count = std::min(cells, kPilotSensors);
  for (std::size_t i = 0; i < count; ++i) {
    out.append(grid, (2 * i + 1) * cells / (2 * count));
  }
  out.width = static_cast<int>(count);
  out.height = 1;
  out.on_surfaces = grid.on_surfaces;
  out.learns = grid.learns;
  out.batches = kSensorBatches;
  return out;
}

/// The sensors, and what measures them.
struct Stage {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Tracer> tracer;
  std::shared_ptr<const PointGrid> grid;
  const std::function<void(Job&)>& wait;
  double& seconds;  ///< of all pilots

  Pilot run(RenderSettings settings) const {
    settings.seed = hash_combine(settings.seed, kPilotStream);
    settings.time_limit_s = settings.noise_target = 0;
    settings.light_groups = false;
    Job job(scene, tracer, settings, nullptr, end_of_sensors(), grid);
    wait(job);
    seconds += job.seconds();
    const Film film = job.snapshot();
    const auto count = static_cast<double>(grid->normal.size());
    Pilot out;
    double variance = 0;
    for (std::size_t i = 0; i < grid->normal.size(); ++i) {
      out.mean += luminance(film.radiance(i, false)) / count;
      variance += film.variance(i) / count;
    }
    const double samples = std::max(film.whole_passes(), 1u), square = out.mean * out.mean;
    out.variance = square > 0 ? variance * samples / square : std::numeric_limits<double>::infinity();
    out.error = std::sqrt(out.variance / samples / count);
    const Statistics& s = job.statistics();
    const auto vertices = static_cast<double>(s.count(Counter::camera_rays) + s.count(Counter::occlusion_rays));
    out.work = settings.integrator == Integrator::path ? kVertexWork * vertices / samples / count
                                                       : static_cast<double>(settings.gather);
    return out;
  }
};

/// Samples of a variance that reach an error: at least, and at most, those numbers.
std::uint32_t samples_for(double variance, double error, std::uint32_t least, std::uint32_t most) {
  const double wanted = std::ceil(variance / (error * error));
  // Whole powers of two beyond the least number, as sequences fill space evenly by them.
  std::uint32_t samples = least;
  while (samples < most && samples < wanted) samples *= 2;
  return samples;
}

RenderSettings path_settings(const RenderSettings& asked, std::uint32_t samples) {
  RenderSettings s = asked;
  s.integrator = Integrator::path;
  s.samples = samples;
  return sensor_settings(s);
}

RenderSettings gather_settings(const RenderSettings& asked, std::uint32_t passes, double sensors) {
  RenderSettings s = asked;
  s.integrator = Integrator::gather;
  s.samples = passes;
  s.gather = kRaysOfPass;
  s.photons = static_cast<std::uint64_t>(
      std::clamp(sensors * kRaysOfPass / kRaysPerPhoton, kLeastPhotonsOfPass, kMostPhotonsOfPass));
  return sensor_settings(s);
}

/// Photon maps as they are without a choice.
SensorPlan usual_plan(const RenderSettings& asked, std::string reason) {
  return {sensor_settings(asked), std::move(reason)};
}

/// Samples asked for, or those of an open end, or the number that was chosen.
std::uint32_t asked_or(const RenderSettings& asked, std::uint32_t for_each, std::uint32_t chosen) {
  if (asked.samples > 0) return std::min(asked.samples, kMostPaths) * for_each;
  return asked.time_limit_s > 0 || asked.noise_target > 0 ? 0 : chosen;
}

}  // namespace

SensorPlan plan_sensors(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Tracer>& tracer,
                        const PointGrid& grid, const RenderSettings& asked, const std::function<void(Job&)>& wait) {
  if (asked.integrator != Integrator::gather || asked.photons > 0 || asked.gather > 0 || asked.nearest > 0 ||
      asked.indirect_only)
    return usual_plan(asked, "");
  if (bends_delta_lights(*scene, false))
    return usual_plan(asked, "photons, because mirrors or glass bend light of lamps without size");
  double seconds = 0;
  const Stage stage{scene, tracer, std::make_shared<const PointGrid>(pilot_grid(grid)), wait, seconds};
  const double error = asked.noise_target > 0 ? asked.noise_target : kSensorError;
  const auto sensors = static_cast<double>(grid.normal.size());
  const bool mapped = bends_delta_lights(*scene);
  const std::uint32_t least = mapped ? kLeastMappedPaths : kLeastPaths;
  const auto paths_each = [&](std::uint32_t all) {
    const std::uint32_t each = all / static_cast<std::uint32_t>(stage.grid->normal.size());
    return mapped ? std::min(each, kLeastMappedPaths) : each;
  };
  double traced_paths = 0;  // by all pilots
  const auto run_paths = [&](std::uint32_t all) {
    traced_paths += paths_each(all) * static_cast<double>(stage.grid->normal.size());
    return stage.run(path_settings(asked, paths_each(all)));
  };
  Pilot paths = run_paths(kPilotPaths);
  const auto all_paths = [&] { return samples_for(paths.variance, error, least, kMostPaths); };
  const auto work_of_paths = [&] {
    return paths.work * sensors * std::max<double>(all_paths(), paths.variance / (error * error));
  };
  const auto by_paths = [&](std::string reason) {
    const std::uint32_t traced = mapped ? 0 : static_cast<std::uint32_t>(traced_paths / sensors);
    return SensorPlan{path_settings(asked, asked_or(asked, kPathsOfSample, all_paths())), std::move(reason), seconds,
                      std::clamp(traced, 2u, kLeastPaths)};
  };
  RenderSettings gather = gather_settings(asked, kPilotPasses, sensors);
  const auto photons = static_cast<double>(gather.photons);
  const double work_of_pass = (photons + kRaysOfPass * sensors) * (asked.extrapolates ? kExtrapolationWork : 1);
  const auto work_of_gathering = [&](double passes) { return passes * work_of_pass + kGuideWork; };
  if (work_of_paths() < kWorthTrying * (kLeastPasses * photons + kGuideWork))
    return by_paths("paths, because all of them cost no more than a few photon maps");
  if (paths_each(kComparedPaths) > paths_each(kPilotPaths)) paths = run_paths(kComparedPaths);
  const Pilot gathered = stage.run(gather);
  if (!(gathered.mean > 0)) {
    if (paths.mean > 0) return by_paths("paths, because no photon of the pilot brought light");
    gather.samples = asked_or(asked, 1, kLeastPasses);
    return {gather, "photons, because no pilot found light", seconds};
  }
  const double seen = kSeenErrors * std::hypot(paths.error * paths.mean, gathered.error * gathered.mean);
  if (paths.mean > 0 && std::abs(gathered.mean - paths.mean) > seen)
    return by_paths(fmt::format("paths, because photons bring {:.2g} times their light", gathered.mean / paths.mean));
  const std::uint32_t passes = samples_for(gathered.variance, error, kLeastPasses, kMostPasses);
  const double ratio =
      work_of_paths() / work_of_gathering(std::max<double>(passes, gathered.variance / (error * error)));
  if (!(ratio > 1)) return by_paths(fmt::format("paths, because photons take {:.2g} times the work", 1 / ratio));
  gather.samples = asked_or(asked, 1, passes);
  return {gather,
          std::isfinite(ratio) ? fmt::format("photons, because paths take {:.2g} times the work", ratio)
                               : "photons, because no path of the pilot found light",
          seconds};
}

}  // namespace glowworm
