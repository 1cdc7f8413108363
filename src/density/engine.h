// The density engine: radiance that leaves query points, from the photons around them.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/rgb.h"
#include "core/statistics.h"
#include "kernels/kernel_shape.h"
#include "kernels/simd.h"
#include "points/photon_batch.h"
#include "points/query_points.h"

namespace glowworm {

enum class RadiusKind : std::uint8_t {
  nearest,     ///< every query takes its k nearest photons (normal photon mapping; knn and brute alone)
  fixed,       ///< one radius for all photons
  per_photon,  ///< a radius for each photon: the sample-point estimator of [HHS05] eq. 3
};

/// Over which radius photons are counted; passed to the engine by the caller.
struct RadiusPolicy {
  RadiusKind kind = RadiusKind::per_photon;
  std::uint32_t k = 50;      ///< nearest
  float max_radius = 0;      ///< nearest: photons further away are not counted, metres; 0: no limit
  float radius = 0;          ///< fixed: metres
  std::vector<float> radii;  ///< per_photon: metres, one for each photon of the batch
  /// Indices of the photons in an order in which neighbours lie together, where that is known (each once; to stay while
  /// build() runs). It saves engines to find one; empty: they do.
  std::span<const std::uint32_t> order;
  KernelShape kernel = KernelShape::epanechnikov;
  /// A photon counts at a query point where the dot product of their normals is above this: it keeps photons on the
  /// back of a thin wall, and beyond a corner, out.
  float min_normal_cosine = 0.7f;
};

/// What an engine would need for a task.
struct EnginePlan {
  std::uint64_t bytes = 0;   ///< that it holds at once beside photons, query points and radiances
  std::uint32_t passes = 1;  ///< how often it would go over the query points within the budget
};

/// An engine holds an index of one batch of photons and answers any number of batches of query points; query state
/// never lives in it. All engines that are given the same radii agree with the brute-force sum to rounding.
class DensityEngine {
 public:
  /// Query points that are worth handing to estimate() at once: the more there are, the closer they lie together, and
  /// the more their searches share. Beyond that engines may work them off in parts.
  static constexpr std::uint64_t kMostPointsAtOnce = std::uint64_t{10} << 20;

  virtual ~DensityEngine() = default;
  virtual std::string name() const = 0;

  /// What estimate() would need for so many points and photons within `budget_bytes` (0: without limit).
  virtual EnginePlan plan(std::size_t points, std::size_t photons, std::uint64_t budget_bytes) const = 0;

  /// Takes a batch of photons and builds the index over it, on all threads (Phase::build_photon_map). Replaces the one
  /// before. Throws Error where the policy is of a kind that the engine does not do.
  virtual void build(const PhotonBatch& photons, const RadiusPolicy& policy, Statistics& statistics) = 0;

  /// Adds to radiance[i] (W sr^-1 m^-2) what leaves point i from the photons of the index, on all threads
  /// (Phase::reorder and Phase::density; counts query_points, pairs_tested, shader_operations). What is added depends
  /// on the photons and on point i alone: the same bits for any number of threads, and for any other points that are
  /// asked about in the same call. Several batches of photons add up: build, estimate, build, estimate.
  virtual void estimate(const QueryPoints& points, std::span<RGB> radiance, Statistics& statistics) const = 0;
};

/// What callers take into account about an engine.
struct EngineTraits {
  const char* name;  ///< on the command line and in statistics
  /// Its usual estimate is that of the k nearest photons (RadiusKind::nearest).
  bool takes_nearest = false;
  /// Photons search for query points: every call of estimate() goes over all photons. So it wants many query points at
  /// once, and no more photons than the estimate needs.
  bool goes_over_photons = false;
  bool for_tests = false;        ///< too slow for pictures
  int (*lanes)() = &simd_lanes;  ///< query points or photons in a vector, on the instruction set in use
};

/// The engine that "auto" names. Others are faster only for a few hundred query points, and save at most 30 ms.
inline constexpr const char* kAutomaticEngine = "blocked";
/// Names of all engines, in order of preference.
std::vector<std::string> engine_names();
/// Traits of an engine by name, or of kAutomaticEngine for "auto". Throws Error, listing the names there are, for
/// another name.
const EngineTraits& engine_traits(const std::string& name);

/// What may be asked of some engines. 0: automatic; engines that it means nothing to do not read it.
struct EngineOptions {
  std::uint32_t reorder = 0;  ///< forward: query points in a cell of the octree that is not divided further
};

/// Makes an engine by name. Throws Error as engine_traits() does.
std::unique_ptr<DensityEngine> make_engine(const std::string& name, const EngineOptions& options = {});

}  // namespace glowworm
