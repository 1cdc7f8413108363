// Which engine is the fastest for a task: a cost model with measured constants.
#pragma once
#include <array>
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

/// Sizes of maps for which EngineCosts::build is given.
inline constexpr std::array<double, 3> kCostPhotons = {1e4, 1e5, 1e6};

/// Costs of an engine on two threads, in nanoseconds of a clock. One set for any number of threads: an image may not
/// depend on them, so neither may the engine.
struct EngineCosts {
  const char* engine;
  std::array<double, 3> build;  ///< a photon, in building a map of so many as kCostPhotons says
  double query;                 ///< a query point: moving, ordering, answering it
  double level;                 ///< a query point and a level of the tree, of which there are log2 V
  double pair;                  ///< a pair that is tested
  double spread;  ///< query points that are tested together, as far as they lie apart (see expected_seconds())
  double batch;   ///< a photon in each call of estimate(): engines that go over photons, not query points
};

/// The measured costs of the engines that `auto` chooses from: all that sum photons within the photons' own radii.
/// bench/engine_costs.cc measures them and prints them as they stand in engine_choice.cc.
std::span<const EngineCosts> engine_costs();

/// Seconds on two threads for building the map and all lookups:
///   V build(V) + Q (query + level log2 V + pair min(V, k (1 + sqrt(spread V / (k F)))^2)) + Q / F V batch,
/// build(V) along the line through the logarithms of EngineCosts::build, and constant outside.
/// On surfaces, query points looked up together lie in a patch of an area in proportion to 1/F, and photons are tested
/// that lie in the patch grown by their radius, whose square is in proportion to k / V; hence the square.
double expected_seconds(const EngineCosts& costs, const EngineWorkload& workload);

/// The engine of least cost; `blocked` where none is expected to take less than nine tenths of its time, which is as
/// near as the model tells.
std::string choose_engine(const EngineWorkload& workload);

}  // namespace glowworm
