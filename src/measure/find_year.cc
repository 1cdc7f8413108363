#include "measure/find_year.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/log.h"
#include "core/memory_budget.h"
#include "core/random.h"
#include "measure/measurement.h"
#include "measure/sensor_plan.h"

namespace glowworm {

namespace {

/// Samples of sensors in a round; the spread of rounds tells their error.
constexpr std::uint32_t kSamplesOfRound = 2;
/// Gather rays of a sample, where their number is automatic: few of them find a window, and that is most of the noise.
constexpr std::uint32_t kGatherRays = 1024;
/// Rounds among which the samples of a plan are divided. Reflected sunlight has most of the noise of a round.
constexpr std::uint32_t kRoundsOfPlan = 16;

/// Settings of a round that keeps the light of sources apart, without its seed. @param photons if none are asked for
RenderSettings round_settings(const RenderSettings& asked, std::uint64_t photons) {
  RenderSettings s = sensor_settings(asked);
  s.light_groups = true;
  s.extrapolates = false;
  if (s.memory_bytes == 0) s.memory_bytes = default_memory_bytes();
  if (s.photons == 0) s.photons = photons;
  s.default_gather = kGatherRays;
  s.samples = kSamplesOfRound;
  s.noise_target = 0;
  s.time_limit_s = 0;
  return s;
}

/// Of the known values whose weight is not 0.
double root_mean_square(const std::vector<float>& v, const std::vector<float>& weight) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (!(weight[i] > 0 && std::isfinite(v[i]))) continue;
    sum += double{v[i]} * v[i];
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(count, 1)));
}

/// When rounds end.
struct RoundEnd {
  std::uint32_t rounds = 0;  ///< 0: by noise or time
  double noise = 0, time_s = 0;

  explicit RoundEnd(const RenderSettings& asked)
      : rounds((asked.samples + kSamplesOfRound - 1) / kSamplesOfRound),
        noise(asked.noise_target > 0   ? asked.noise_target
              : asked.time_limit_s > 0 ? 0
                                       : kYearNoise),
        time_s(asked.time_limit_s > 0 ? asked.time_limit_s : std::numeric_limits<double>::infinity()) {}

  /// Rounds that `done` of them with this error and time let expect.
  std::uint32_t expected(std::uint32_t done, double error, double spent_s) const {
    if (rounds > 0) return rounds;
    const double n = done, by_time = time_s * n / spent_s;
    const double by_noise = noise > 0 ? n * (error / noise) * (error / noise) : by_time;
    constexpr double kMost = 1e6;
    return static_cast<std::uint32_t>(std::clamp(std::ceil(std::min(by_noise, by_time)), 2.0, kMost));
  }
};

}  // namespace

YearModel::YearModel(const WeatherYear& weather, const std::string& path, int patch_count, double ground_reflectance,
                     double sun_step)
    : patches(patch_count),
      sky(year_sky(weather, patches, ground_reflectance)),
      suns(weather.hours.front().moment, sky.sun, sky.beam, sun_step),
      ground(ground_reflectance) {
  if (sky.lit.empty()) throw Error({path}, "has no hour with light");
}

YearScene::YearScene(Scene lit)
    : scene(std::make_shared<const Scene>(std::move(lit))), tracer(std::make_shared<const Tracer>(*scene)) {}

YearScene under_sky(const Scene& plain, const YearModel& model) {
  return YearScene(scene_under_patches(plain, model.patches));
}

Sensors moved_sensors(Sensors sensors, const Scene& from, const Scene& to) {
  for (Vec3& p : sensors.position) p = narrow(from.outside(p) - Vec3d(to.origin()));
  return sensors;
}

void check_year_room(std::size_t sensors, std::size_t hours, std::size_t states, std::uint64_t memory_bytes) {
  const std::uint64_t bytes = Year::bytes(sensors, hours) * (1 + states);
  if (bytes > memory_bytes / 2)
    throw MemoryError(fmt::format("{} hours of {} sensors take {:.0f} MB; half of the memory budget has room for less",
                                  hours, sensors, static_cast<double>(bytes) / 1e6),
                      "Give a larger memory budget or fewer sensors.");
}

void check_year_settings(const RenderSettings& asked) {
  if (asked.integrator != Integrator::gather)
    throw Error("the integrator of a year is chosen: paths or photons for the sky, photons for the sun",
                "Leave the integrator out, or choose gather.");
  if (asked.samples > 0 && asked.samples <= kSamplesOfRound)
    throw Error(fmt::format("{} samples leave the error of a year unknown", asked.samples),
                fmt::format("Give {} or more, for two rounds.", kSamplesOfRound + 1));
}

namespace {

/// What measures a round of coefficients.
struct RoundPlan {
  RenderSettings sky, suns;
};

RoundPlan plan_rounds(const YearScene& sky, const PointGrid& grid, const YearModel& model, const RenderSettings& asked,
                      const YearWatch& watch) {
  RoundPlan out{round_settings(asked, kPhotonsOfPatch * model.patches.size()),
                round_settings(asked, kPhotonsOfSun * model.suns.places().size())};
  RenderSettings pilot = asked;
  pilot.memory_bytes = out.sky.memory_bytes;
  pilot.samples = 0;
  pilot.extrapolates = false;  // as in patch_settings()
  pilot.time_limit_s = pilot.noise_target = 0;
  const SensorPlan plan = plan_sensors(sky.scene, sky.tracer, grid, pilot, [&](Job& job) { watch.wait(job, {}); });
  if (plan.reason.empty()) return out;
  detail("the sky by " + plan.reason);
  out.sky = plan.settings;
  out.sky.light_groups = true;
  out.sky.samples = std::max(plan.settings.samples / kRoundsOfPlan, kSamplesOfRound);
  return out;
}

}  // namespace

std::optional<FoundState> find_state(const Scene& plain, const YearScene& sky, const Sensors& sensors, bool on_surfaces,
                                     const YearModel& model, const RenderSettings& asked, const YearWatch& watch) {
  const auto start = std::chrono::steady_clock::now();
  const auto grid = coefficient_grid(sensors, on_surfaces);
  const std::size_t places = model.suns.places().size();
  std::optional<YearScene> sunny;
  if (places > 0) sunny.emplace(scene_under_suns(plain, model.suns.places()));
  const RoundEnd end(asked);
  const RoundPlan plan = plan_rounds(sky, *grid, model, asked, watch);
  CoefficientMean mean(model.sky, model.suns);
  FoundState out;
  std::uint32_t expected = std::max(end.rounds, 2u);
  const std::uint32_t parts = sunny ? 2 : 1;
  YearWork work;
  // The light that a Job of the round finds, or nothing.
  const auto run = [&](const YearScene& lit, RenderSettings s, std::uint32_t part,
                       auto&& light_of) -> std::optional<ColorMatrix> {
    s.seed = hash_combine(s.seed, out.rounds);
    Job job(lit.scene, lit.tracer, with_room_for(sensors.size(), s), nullptr, end_of_sensors(), grid);
    watch.wait(job, work.next(parts * (expected - out.rounds) - part + 1));  // one part more: rays to the sun
    if (job.ending() == Ending::cancelled) return std::nullopt;
    return light_of(job);
  };
  while (out.rounds < expected) {
    const auto of_sky = run(sky, plan.sky, 0, [&](const Job& job) { return daylight_matrix(job, sensors.size()); });
    if (!of_sky) return std::nullopt;
    std::optional<ColorMatrix> of_suns = ColorMatrix{sensors.size(), 0, {}};
    if (sunny)
      of_suns = run(*sunny, plan.suns, 1, [&](const Job& job) { return sun_matrix(job, sensors.size(), places); });
    if (!of_suns) return std::nullopt;
    mean.add({*of_sky, *of_suns});
    out.rounds = mean.count();
    out.relative_error = mean.relative_error();
    out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const double error = root_mean_square(out.relative_error, sensors.weight);
    detail(fmt::format("round {}: relative error {:.3g}, {:.1f} s", out.rounds, error, out.seconds));
    if (out.rounds >= 2) expected = end.expected(out.rounds, error, out.seconds);
  }
  const YearProgress last = work.next(1);
  const auto rays = [&](double share) {
    if (watch.rays) watch.rays(last.before + last.share * share);
  };
  out.state = {mean.mean(), direct_sun(*sky.tracer, *grid, sensors.size(), model.sky, rays)};
  inform(fmt::format("{} rounds in {:.2f} s, relative error {:.2g}", out.rounds, out.seconds,
                     root_mean_square(out.relative_error, sensors.weight)));
  return out;
}

}  // namespace glowworm
