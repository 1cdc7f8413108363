#include "density/engine_choice.h"

#include <algorithm>
#include <cmath>

namespace glowworm {

namespace {

// Printed by bench/engine_costs.cc: AMD EPYC (Zen 3), AVX2, two threads.
constexpr EngineCosts kCosts[] = {
    {"blocked", {61.3, 50, 74.8}, 1.25e-14, 1.51, 0.347, 33.7, 0},
    {"forward", {75.8, 97.7, 135}, 1.9e-13, 3.55, 9.99, 2.24, 0},
    {"reverse", {57.1, 62.2, 107}, 27.7, 0.382, 1.7, 5.01, 21.8},
    {"single", {31.9, 29.7, 51}, 98.7, 0.000331, 66.3, 0, 0},
};

// The first engine is taken unless another is expected to need less than this share of its time: the model errs by
// about as much from scene to scene, and the time of the first depends on the scene the least.
constexpr double kShareThatPays = 0.9;

/// Nanoseconds a photon in building a map of so many.
double build_nanoseconds(const EngineCosts& costs, double photons) {
  const double low = kCostPhotons.front(), high = kCostPhotons.back();
  const double at = std::log(std::clamp(photons, low, high) / low) / std::log(high / low) *
                    static_cast<double>(kCostPhotons.size() - 1);
  const auto node = std::min(static_cast<std::size_t>(at), kCostPhotons.size() - 2);
  const double part = at - static_cast<double>(node);
  return std::pow(costs.build[node], 1 - part) * std::pow(costs.build[node + 1], part);
}

}  // namespace

std::span<const EngineCosts> engine_costs() { return kCosts; }

double expected_seconds(const EngineCosts& costs, const EngineWorkload& workload) {
  const double photons = std::max(workload.photons, 1.0), queries = std::max(workload.queries, 1.0);
  const double at_once = std::clamp(workload.queries_at_once, 1.0, queries), k = std::max(workload.nearest, 1.0);
  const double reach = 1 + std::sqrt(costs.spread * photons / (k * at_once));
  const double tested = std::min(photons, k * reach * reach);
  const double query = costs.query + costs.level * std::log2(photons) + costs.pair * tested;
  return 1e-9 *
         (photons * build_nanoseconds(costs, photons) + queries * query + queries / at_once * photons * costs.batch);
}

std::string choose_engine(const EngineWorkload& workload) {
  const auto* best = std::begin(kCosts);
  double least = kShareThatPays * expected_seconds(*best, workload);
  for (const EngineCosts& costs : kCosts) {
    const double seconds = expected_seconds(costs, workload);
    if (seconds >= least) continue;
    least = seconds;
    best = &costs;
  }
  return best->engine;
}

}  // namespace glowworm
