// Measures what the engines cost and fits the constants of density/engine_choice.h to it: prints a table of measured
// against modelled times, and the constants as they stand in engine_choice.cc. One thread; about two minutes.
//
// usage: engine_costs [ENGINE]...     (default: all that `auto` chooses from)
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
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

struct Sample {
  EngineWorkload workload;
  double build, estimate;  ///< seconds
};

PhotonBatch first_photons(const PhotonBatch& all, std::size_t count) {
  PhotonBatch some;
  for (std::size_t i = 0; i < std::min(count, all.size()); ++i)
    some.push_back(all.position[i], all.direction[i], all.flux[i], all.normal[i]);
  return some;
}

/// Least of three runs, or of one where that takes long: other programs only ever add to a time.
double least_seconds(const std::function<void()>& work) {
  const double first = measure_seconds(1, work).least;
  return first > 0.1 ? first : std::min(first, measure_seconds(2, work).least);
}

void measure_scene(const std::string& scene, const std::vector<std::string>& engines,
                   std::vector<std::vector<Sample>>& samples) {
  const Recording recording = record(Stage(scene), {1'000'000, 160, 160, 20});
  for (const std::size_t photons : {10'000u, 100'000u, 1'000'000u}) {
    const PhotonBatch batch = first_photons(recording.photons, photons);
    for (const std::uint32_t k : {15u, 60u}) {
      RadiusPolicy policy;
      policy.radii = per_photon_radii(batch, k);
      for (std::size_t e = 0; e < engines.size(); ++e) {
        const auto engine = make_engine(engines[e]);
        Statistics unused;
        const double build = least_seconds([&] { engine->build(batch, policy, unused); });
        for (const std::size_t queries : {1'000u, 10'000u, 100'000u, 500'000u}) {
          const std::size_t step = std::max<std::size_t>(1, recording.points.size() / queries);
          const QueryPoints points = runs_of(recording.points, {}, 1, step);
          std::vector<RGB> radiance(points.size());
          Sample sample;
          sample.build = build;
          sample.estimate = least_seconds([&] { engine->estimate(points, radiance, unused); });
          const auto n = static_cast<double>(points.size());
          sample.workload = {static_cast<double>(batch.size()), n, n, static_cast<double>(k)};
          samples[e].push_back(sample);
        }
      }
    }
  }
}

using Constants = std::array<double, 5>;

EngineCosts costs_of(const EngineCosts& build, const Constants& c) {
  return {build.engine, build.build, build.growth, c[0], c[1], c[2], c[3], c[4]};
}

/// Mean square of the logarithms of modelled over measured times of building and lookups together: a factor of two is
/// as bad for small tasks as for large ones.
double misfit(const std::vector<Sample>& samples, const EngineCosts& costs) {
  double sum = 0;
  for (const Sample& s : samples) {
    const double off = std::log(expected_seconds(costs, s.workload) / (s.build + s.estimate));
    sum += off * off;
  }
  return sum / static_cast<double>(samples.size());
}

/// Line through the logarithms of building times over those of photons.
EngineCosts fit_build(const char* engine, const std::vector<Sample>& samples) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const Sample& s : samples) {
    const double a = std::log(s.workload.photons / kCostPhotons), b = std::log(1e9 * s.build / s.workload.photons);
    n += 1;
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
  }
  const double growth = (n * xy - x * y) / (n * xx - x * x);
  EngineCosts costs{};
  costs.engine = engine;
  costs.build = std::exp((y - growth * x) / n);
  costs.growth = growth;
  return costs;
}

/// Improves one constant after another by ever smaller factors.
EngineCosts fit(const char* engine, const std::vector<Sample>& samples) {
  const EngineCosts build = fit_build(engine, samples);
  Constants best{50, 5, 2, 5, 5};
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
  set_thread_count(1);
  std::vector<std::string> engines(argv + 1, argv + argc);
  if (engines.empty())
    for (const EngineCosts& costs : engine_costs()) engines.emplace_back(costs.engine);
  std::vector<std::vector<Sample>> samples(engines.size());
  for (const char* scene : {"builtin:cornell", "builtin:atrium"}) measure_scene(scene, engines, samples);
  std::string constants;
  fmt::print("| engine | photons | query points | k | build, s | lookups, s | model over measured |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- | --- |\n");
  for (std::size_t e = 0; e < samples.size(); ++e) {
    const EngineCosts c = fit(engines[e].c_str(), samples[e]);
    for (const Sample& s : samples[e])
      fmt::print("| {} | {} | {} | {} | {:.4f} | {:.4f} | {:.2f} |\n", c.engine, s.workload.photons, s.workload.queries,
                 s.workload.nearest, s.build, s.estimate, expected_seconds(c, s.workload) / (s.build + s.estimate));
    constants += fmt::format("    {{\"{}\", {:.3g}, {:.3g}, {:.3g}, {:.3g}, {:.3g}, {:.3g}, {:.3g}}},\n", c.engine,
                             c.build, c.growth, c.query, c.level, c.pair, c.spread, c.batch);
  }
  fmt::print("\n{}, commit {}:\n{}", machine_name(), commit_name(), constants);
}
