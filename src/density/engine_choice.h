// Which engine is the fastest for a task: a cost model with measured constants.
#pragma once
#include <span>
#include <string>

namespace glowworm {

/// What is asked of an engine between one photon map and the next.
struct EngineWorkload {
  double photons = 0;          ///< V: in the map
  double queries = 0;          ///< query points that are looked up in it
  double queries_at_once = 0;  ///< F: those of one call of estimate(); the density of query points decides how many
                               ///< share a packet, a tile, or the search of a photon
  double nearest = 50;         ///< k: photons that a query point is to see
};

/// Photons of the map for which EngineCosts::build is given.
inline constexpr double kCostPhotons = 1e5;

/// Costs of an engine, in nanoseconds on one core.
struct EngineCosts {
  const char* engine;
  double build;   ///< a photon, in building a map of kCostPhotons
  double growth;  ///< exponent by which that grows with the map, as it leaves the caches
  double query;   ///< a query point: moving, ordering, answering it
  double level;   ///< a query point and a level of the tree, of which there are log2 V
  double pair;    ///< a pair that is tested
  double spread;  ///< query points that are tested together, as far as they lie apart (see expected_seconds())
  double batch;   ///< a photon in each call of estimate(): engines that go over photons, not query points
};

/// The measured costs of the engines that `auto` chooses from: all that sum photons within the photons' own radii.
/// bench/engine_costs.cc measures them and prints them as they stand in engine_choice.cc.
std::span<const EngineCosts> engine_costs();

/// Seconds on one core for building the map and all lookups:
///   V build (V / kCostPhotons)^growth + Q (query + level log2 V + pair min(V, k (1 + sqrt(spread V / (k F)))^2)) + Q /
///   F V batch.
/// On surfaces, query points looked up together lie in a patch of an area in proportion to 1/F, and photons are tested
/// that lie in the patch grown by their radius, whose square is in proportion to k / V; hence the square.
double expected_seconds(const EngineCosts& costs, const EngineWorkload& workload);

/// The engine of least cost.
std::string choose_engine(const EngineWorkload& workload);

}  // namespace glowworm
