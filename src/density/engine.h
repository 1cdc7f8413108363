// The density engine: estimates the outgoing radiance of query points from the photons around them.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/rgb.h"
#include "core/statistics.h"
#include "glowworm/density.h"
#include "kernels/kernel_shape.h"
#include "kernels/simd.h"
#include "points/photon_batch.h"
#include "points/query_points.h"

namespace glowworm {

/// A half-space that bounds a photon's kernel: a query point q counts if dot(normal, q - photon) > -distance.
struct KernelCut {
  Vec3 normal{0, 0, 0};  ///< unit, from the plane to the photon; 0: no bound
  float distance = 1;    ///< of the photon from the plane, metres
};

/// The bounds of a photon's kernel.
struct PhotonCuts {
  std::uint32_t photon = 0;  ///< its index in the batch
  std::array<KernelCut, 2> cuts;

  /// Whether they leave the place at `way` from the photon.
  bool keep(Vec3 way) const {
    return dot(cuts[0].normal, way) > -cuts[0].distance && dot(cuts[1].normal, way) > -cuts[1].distance;
  }
};

/// The cuts of a photon; null: none. @param cuts in the order of the photons
const PhotonCuts* cuts_of(std::span<const PhotonCuts> cuts, std::uint32_t photon);

enum class RadiusKind : std::uint8_t {
  nearest,     ///< the k photons nearest to each query point (normal photon mapping; knn and brute only)
  fixed,       ///< one radius for all photons
  per_photon,  ///< a radius for each photon: the sample-point estimator of [HHS05] eq. 3 (all but knn)
};

/// Cosine of 45 degrees. A photon counts at a query point only if the dot product of their normals is above this. It
/// excludes photons on the back of a thin wall and around a corner.
inline constexpr float kMinNormalCosine = 0.70710678f;

/// Radius within which photons count; passed to the engine by the caller.
struct RadiusPolicy {
  RadiusKind kind = RadiusKind::per_photon;
  std::uint32_t k = 50;      ///< nearest
  float max_radius = 0;      ///< nearest: photons further away are not counted, metres; 0: no limit
  float radius = 0;          ///< fixed: metres
  std::vector<float> radii;  ///< per_photon: metres, one for each photon of the batch
  /// Indices of the photons in a spatially coherent order, each once, if the caller has one; must live while build()
  /// runs. Saves engines that need an order the time to compute it. Empty: engines compute their own.
  std::span<const std::uint32_t> order;
  /// Kernels that end at walls, in the order of the photons.
  std::vector<PhotonCuts> cuts;
  KernelShape kernel = KernelShape::epanechnikov;
  float min_normal_cosine = kMinNormalCosine;
};

/// An engine indexes one batch of photons and estimates any number of batches of query points; it keeps no state of
/// queries. All engines with the same radii agree with the brute-force sum to rounding.
class DensityEngine {
 public:
  /// Useful batch size of query points for estimate(): larger batches are denser and share more of the search. Engines
  /// may split larger batches.
  static constexpr std::uint64_t kMaxPointsAtOnce = std::uint64_t{10} << 20;

  virtual ~DensityEngine() = default;
  virtual std::string name() const = 0;

  /// Bytes of an index of so many photons, at most.
  virtual std::uint64_t index_bytes(std::size_t photons) const = 0;

  /// Builds the index over a batch of photons, on all threads (Phase::build_photon_map). Replaces the previous index.
  /// Throws Error if the engine does not support the kind of policy.
  /// @param flux what estimate() sums: one value for each photon, W, in place of PhotonBatch::flux
  virtual void build(const PhotonBatch& photons, std::span<const RGB> flux, const RadiusPolicy& policy,
                     Statistics& statistics) = 0;

  /// Adds to radiance[i] (W sr^-1 m^-2) the radiance that leaves point i from the photons of the index, on all threads
  /// (Phase::reorder and Phase::density; counts query_points, pairs_tested, shader_operations). The amount depends on
  /// the photons and on point i only: it is the same, bit for bit, for any number of threads and any other points in
  /// the call. Several batches of photons add up: build, estimate, build, estimate.
  virtual void estimate(const QueryPoints& points, std::span<RGB> radiance, Statistics& statistics) const = 0;
};

/// Properties of an engine that callers take into account.
struct EngineTraits {
  const char* name;  ///< on the command line and in statistics
  /// Takes the k nearest photons (RadiusKind::nearest) in place of a radius for each.
  bool takes_nearest = false;
  /// Photons search for query points, so every call of estimate() visits all photons. Callers pass many query points at
  /// once, and no more photons than the estimate needs.
  bool goes_over_photons = false;
  bool for_tests = false;        ///< too slow for pictures
  int (*lanes)() = &simd_lanes;  ///< query points or photons in a vector, on the instruction set in use
};

/// The engine named by "auto": the fastest, for few query points, too.
inline constexpr const char* kAutomaticEngine = "blocked";
/// Names of all engines, in order of preference.
std::vector<std::string> engine_names();
/// The name of an engine of the public interface. Throws Error for a number that is none.
std::string engine_name(api::Engine engine);
/// Traits of an engine by name, or of kAutomaticEngine for "auto". Throws Error, which lists the names, for another
/// name.
const EngineTraits& engine_traits(const std::string& name);

/// Options of some engines. 0: automatic; other engines ignore them.
struct EngineOptions {
  std::uint32_t reorder = 0;  ///< forward: query points in a cell of the octree that is not divided further
};

/// Makes an engine by name. Throws Error as engine_traits() does.
std::unique_ptr<DensityEngine> make_engine(const std::string& name, const EngineOptions& options = {});

}  // namespace glowworm
