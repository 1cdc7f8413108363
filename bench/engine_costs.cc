// Measures what the engines cost and fits the constants of density/engine_choice.h to it: prints a table of measured
// against modelled times, and the constants as they stand in engine_choice.cc. Two threads; three minutes.
//
// usage: engine_costs [ENGINE]...     (default: all that `auto` chooses from; of fewer, each is fitted where it is the
// best of these)
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "density/engine_choice.h"
#include "density/radius.h"
#include "support/calibration.h"
#include "support/recording.h"
#include "support/table.h"

namespace glowworm::bench {
namespace {

/// Threads of the measurement. `auto` may not choose by their number, since images may not depend on it; most machines
/// have more than one.
constexpr int kThreads = 2;
/// Runs of one task in a round: at least so many and for so long, but one alone where it takes this long.
constexpr int kFewestRuns = 2, kMostRuns = 20;
constexpr double kEnoughSeconds = 0.05, kLongSeconds = 1;
constexpr int kRounds = 4;

struct Sample {
  EngineWorkload workload;
  double build, estimate;  ///< seconds
  double weight = 1;       ///< in the fit

  double seconds() const { return build + estimate; }
};

PhotonBatch first_photons(const PhotonBatch& all, std::size_t count) {
  PhotonBatch some;
  for (std::size_t i = 0; i < std::min(count, all.size()); ++i)
    some.push_back(all.position[i], all.direction[i], all.flux[i], all.normal[i]);
  return some;
}

/// Least of several runs, more of them where they are short: other programs only ever add to a time.
double least_seconds(const std::function<void()>& work) {
  double least = measure_seconds(1, work).least, spent = least;
  for (int run = 1; run < kMostRuns && (run < kFewestRuns || spent < kEnoughSeconds) && least < kLongSeconds; ++run) {
    const double seconds = measure_seconds(1, work).least;
    least = std::min(least, seconds);
    spent += seconds;
  }
  return least;
}

/// Appends the samples of one map: for each number of query points, the least of several rounds through all engines,
/// so that an hour's change of speed meets them all.
void measure_map(const Recording& recording, const PhotonBatch& photons, std::uint32_t k,
                 const std::vector<std::string>& engines, std::vector<std::vector<Sample>>& samples) {
  RadiusPolicy policy;
  policy.radii = per_photon_radii(photons, k);
  std::vector<QueryPoints> points;
  for (const std::size_t queries : {1'000u, 10'000u, 100'000u, 500'000u})
    points.push_back(runs_of(recording.points, {}, 1, std::max<std::size_t>(1, recording.points.size() / queries)));
  std::vector<RGB> radiance(points.back().size());
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t e = 0; e < engines.size(); ++e) {
      const auto engine = make_engine(engines[e]);
      Statistics unused;
      const double build = least_seconds([&] { engine->build(photons, policy, unused); });
      for (std::size_t p = 0; p < points.size(); ++p) {
        const auto n = static_cast<double>(points[p].size());
        const double estimate =
            least_seconds([&] { engine->estimate(points[p], std::span(radiance).first(points[p].size()), unused); });
        if (round == 0) {
          samples[e].push_back({{static_cast<double>(photons.size()), n, n, static_cast<double>(k)}, build, estimate});
          continue;
        }
        Sample& sample = samples[e][samples[e].size() - points.size() + p];
        sample.build = std::min(sample.build, build);
        sample.estimate = std::min(sample.estimate, estimate);
      }
    }
}

void measure_scene(const std::string& scene, const std::vector<std::string>& engines,
                   std::vector<std::vector<Sample>>& samples) {
  const Recording recording = record(Stage(scene), {1'000'000, 160, 160, 20});
  for (const double photons : kCostPhotons)
    for (const std::uint32_t k : {15u, 60u})
      measure_map(recording, first_photons(recording.photons, static_cast<std::size_t>(photons)), k, engines, samples);
}

using Constants = std::array<double, 5>;

EngineCosts costs_of(const EngineCosts& build, const Constants& c) {
  return {build.engine, build.build, c[0], c[1], c[2], c[3], c[4]};
}

/// Weighted mean square of the logarithms of modelled over measured times of building and lookups together: a factor of
/// two is as bad for small tasks as for large ones.
double misfit(const std::vector<Sample>& samples, const EngineCosts& costs) {
  double sum = 0, weights = 0;
  for (const Sample& s : samples) {
    const double off = std::log(expected_seconds(costs, s.workload) / s.seconds());
    sum += s.weight * off * off;
    weights += s.weight;
  }
  return sum / weights;
}

/// The building times of maps of kCostPhotons, the least of all that were measured: they hardly depend on the scene.
EngineCosts measured_build(const char* engine, const std::vector<Sample>& samples) {
  EngineCosts costs{};
  costs.engine = engine;
  costs.build.fill(std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < kCostPhotons.size(); ++i)
    for (const Sample& s : samples)
      if (std::abs(s.workload.photons - kCostPhotons[i]) < kCostPhotons[i] / 2)
        costs.build[i] = std::min(costs.build[i], 1e9 * s.build / s.workload.photons);
  return costs;
}

/// Of each task that of the scene where looking up takes longest, since `auto` does not know scenes apart: an engine
/// that is slow in one of them is a bad choice where another is as fast in both. `samples` are those of one scene after
/// the other.
std::vector<Sample> slowest_of_scenes(const std::vector<Sample>& samples, std::size_t scenes) {
  const std::size_t tasks = samples.size() / scenes;
  std::vector<Sample> slowest(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(tasks));
  for (std::size_t i = tasks; i < samples.size(); ++i) {
    Sample& worst = slowest[i % tasks];
    if (samples[i].estimate > worst.estimate) worst = samples[i];
  }
  return slowest;
}

/// Weighs each engine's time of a task by the square of the best engine's over it: what an engine takes where it is
/// many times slower than another decides nothing. All engines have the same tasks.
void weigh_by_rank(std::vector<std::vector<Sample>>& samples) {
  for (std::size_t task = 0; task < samples.front().size(); ++task) {
    double best = samples.front()[task].seconds();
    for (const auto& of_engine : samples) best = std::min(best, of_engine[task].seconds());
    for (auto& of_engine : samples) of_engine[task].weight = std::pow(best / of_engine[task].seconds(), 2);
  }
}

/// Where the fit begins. What does not exist is zero and stays so: `single` looks up one point at a time, and only
/// `reverse` goes over all photons in each call.
Constants first_guess(const std::string& engine) {
  return {50, 5, 2, engine == "single" ? 0.0 : 5.0, engine == "reverse" ? 5.0 : 0.0};
}

/// Improves one constant after another by ever smaller factors.
EngineCosts fit(const EngineCosts& build, const std::vector<Sample>& samples) {
  Constants best = first_guess(build.engine);
  for (double factor = 4; factor > 1.002; factor = std::sqrt(factor)) {
    for (int round = 0; round < 30; ++round) {
      bool better = false;
      for (double& constant : best) {
        for (const double change : {factor, 1 / factor}) {
          const double before = misfit(samples, costs_of(build, best)), old = constant;
          constant *= change;
          if (misfit(samples, costs_of(build, best)) < before)
            better = true;
          else
            constant = old;
        }
      }
      if (!better) break;
    }
  }
  return costs_of(build, best);
}

}  // namespace
}  // namespace glowworm::bench

int main(int argc, char** argv) {
  using namespace glowworm;
  using namespace glowworm::bench;
  set_thread_count(kThreads);
  std::vector<std::string> engines(argv + 1, argv + argc);
  if (engines.empty())
    for (const EngineCosts& costs : engine_costs()) engines.emplace_back(costs.engine);
  std::vector<std::vector<Sample>> samples(engines.size());
  const std::array scenes = {"builtin:cornell", "builtin:atrium"};
  for (const char* scene : scenes) measure_scene(scene, engines, samples);
  std::vector<std::vector<Sample>> fitted;
  for (const auto& of_engine : samples) fitted.push_back(slowest_of_scenes(of_engine, scenes.size()));
  weigh_by_rank(fitted);
  std::string constants;
  fmt::print("| engine | photons | query points | k | build, s | lookups, s | model over measured |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- | --- |\n");
  for (std::size_t e = 0; e < samples.size(); ++e) {
    const EngineCosts c = fit(measured_build(engines[e].c_str(), samples[e]), fitted[e]);
    for (const Sample& s : samples[e])
      fmt::print("| {} | {} | {} | {} | {:.5f} | {:.5f} | {:.2f} |\n", c.engine, s.workload.photons, s.workload.queries,
                 s.workload.nearest, s.build, s.estimate, expected_seconds(c, s.workload) / s.seconds());
    constants += fmt::format("    {{\"{}\", {{{:.3g}, {:.3g}, {:.3g}}}, {:.3g}, {:.3g}, {:.3g}, {:.3g}, {:.3g}}},\n",
                             c.engine, c.build[0], c.build[1], c.build[2], c.query, c.level, c.pair, c.spread, c.batch);
  }
  fmt::print("\n{}, commit {}:\n{}", machine_name(), commit_name(), constants);
}
