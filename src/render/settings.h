// What a person asks of a render, and what becomes of it when every 'auto' has been resolved.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/random.h"
#include "density/engine.h"

namespace glowworm {

class Scene;

enum class Integrator : std::uint8_t {
  gather,   ///< photon mapping with final gathering
  path,     ///< path tracing: the reference
  photons,  ///< the photon map shown directly, without final gathering
};

/// Whether query points may go through a file (density/query_store.h).
enum class DiskUse : std::uint8_t {
  automatic,  ///< where memory holds too few of them at once for the engine to be fast
  never,
  always,
};

/// What a pass of so many query points is made of ([HHS05], section 5.1).
enum class Preference : std::uint8_t {
  automatic,  ///< large tiles, and several samples of a pixel where one of each would be too few query points
  preview,    ///< as large tiles as may be, one sample of a pixel: the whole image gets better evenly
  quality,    ///< after a first whole image small tiles that get as many samples at once as may be
};

/// Pixels of a side of a picture at most.
inline constexpr int kLargestPictureSide = 65536;

/// Camera samples of a pixel where nobody says how many, and that cost models reckon with.
inline constexpr std::uint32_t kDefaultSamples = 16;

/// Settings of a render. 0 (or "auto", or empty) is automatic everywhere; resolve() replaces those by numbers.
struct RenderSettings {
  Integrator integrator = Integrator::gather;
  std::string engine = "auto";
  std::uint32_t samples = 0;         ///< camera samples of each pixel
  std::uint32_t gather = 0;          ///< final gather rays of each camera sample
  std::uint64_t photons = 0;         ///< photons in the global map
  std::uint64_t photons_traced = 0;  ///< photons that are traced for it; density control thins them to `photons`
  std::uint32_t nearest = 0;         ///< k: photons that an estimate should catch
  std::uint32_t light_samples = 0;   ///< light samples of each gather point
  KernelShape kernel = KernelShape::epanechnikov;
  bool fixed_radius = false;  ///< one radius for all photons, as in [SF07], in place of one for each
  std::uint32_t reorder = 0;  ///< engine forward: points of an octree's cell that is not divided; 0: as far as it pays
  int width = 0, height = 0;  ///< pixels
  std::string camera;         ///< name; empty is the scene's first
  std::uint32_t seed = 0;
  int threads = 0;
  std::uint64_t memory_bytes = 0;
  DiskUse disk = DiskUse::automatic;
  Preference preference = Preference::automatic;
  double time_limit_s = 0;  ///< stops after the task under way; 0: no limit
  double noise_target = 0;  ///< relative standard error of the image at which it stops; 0: none
  bool indirect_only = false;
  bool progressive = false;         ///< photons of its own for every pass, radii that shrink from pass to pass
  bool guiding = true;              ///< photons emitted where the image needs them (render/photon_guiding.h)
  bool secondary_gather = true;     ///< gather rays shorter than the photons' radius gather again at their end
  bool gather_guiding = true;       ///< some gather rays look for small bright places (gather/bright_patches.h)
  bool boundary_correction = true;  ///< make up for kernels that reach over edges (render/boundary.h)
  int max_bounces = 64;             ///< bounces of a path at most (Russian roulette ends nearly all earlier)
  SamplerKind sampler = SamplerKind::sobol;
  bool separate_layers = true;    ///< keep the film's layers apart; always so where there are AOVs
  std::vector<std::string> aovs;  ///< layers beside the image itself; names as in aov_names()
};

/// Query points that a core of the year 2020 gathers and looks up in a second at least; others do two or three times
/// as many. Renders with a limit of time reckon with it.
inline constexpr double kQueriesPerSecond = 500'000;

/// Names that --aov knows.
std::vector<std::string> aov_names();

/// Whether a render has the time to trace photons for its caustic map alone.
bool has_time_for_caustics(const RenderSettings& settings);

/// Memory of a render that is not told: half of the machine's, rounded down so that it is the same at every start.
std::uint64_t default_memory_bytes();

/// The settings with every automatic value replaced. What shows in the picture is chosen from the scene and the other
/// settings alone: never from the machine, its cores or its memory. Throws Error for what cannot be (a size of 0, an
/// unknown AOV).
RenderSettings resolve(const RenderSettings& asked, const Scene& scene);

/// What was left to the program, what it chose and why, a line each; nothing for what was asked for.
/// @param chosen resolve(asked)
std::vector<std::string> choice_notes(const RenderSettings& asked, const RenderSettings& chosen);

}  // namespace glowworm
