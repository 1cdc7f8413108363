#include "density/engine_choice.h"

#include <algorithm>
#include <cmath>

namespace glowworm {

namespace {

// Printed by bench/engine_costs.cc: AMD EPYC (Zen 3), AVX2. Building of `blocked` was 221 then; it takes 0.66 of the
// time since its blocks are sorted in vectors (bench/build_times.cc, one thread).
constexpr EngineCosts kCosts[] = {
    {"blocked", 146, 0.0996, 50.5, 0.25, 0.428, 0.0462, 29.7},
    {"forward", 213, 0.131, 48.1, 11.3, 11.4, 1.79, 0},
    {"reverse", 136, 0.213, 76.1, 2.09, 1.84, 14.8, 0.57},
    {"single", 71.6, 0.254, 394, 3.22, 42.2, 0.238, 0},
};

}  // namespace

std::span<const EngineCosts> engine_costs() { return kCosts; }

double expected_seconds(const EngineCosts& costs, const EngineWorkload& workload) {
  const double photons = std::max(workload.photons, 1.0), queries = std::max(workload.queries, 1.0);
  const double at_once = std::clamp(workload.queries_at_once, 1.0, queries), k = std::max(workload.nearest, 1.0);
  const double reach = 1 + std::sqrt(costs.spread * photons / (k * at_once));
  const double tested = std::min(photons, k * reach * reach);
  const double query = costs.query + costs.level * std::log2(photons) + costs.pair * tested;
  const double build = costs.build * std::pow(photons / kCostPhotons, costs.growth);
  return 1e-9 * (photons * build + queries * query + queries / at_once * photons * costs.batch);
}

std::string choose_engine(const EngineWorkload& workload) {
  return std::min_element(std::begin(kCosts), std::end(kCosts),
                          [&](const auto& a, const auto& b) {
                            return expected_seconds(a, workload) < expected_seconds(b, workload);
                          })
      ->engine;
}

}  // namespace glowworm
