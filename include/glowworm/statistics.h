// What a render did.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace glowworm::api {

/// Why a render ended.
enum class Ending : std::uint8_t { running, samples_done, time_up, noise_reached, cancelled, failed };

/// Photons of the light sources of one name.
struct LightPhotons {
  std::string name;
  std::uint64_t sources = 0;  ///< light sources of this name: the triangles of a lamp, for example
  std::uint64_t emitted = 0;  ///< paths
  std::uint64_t stored = 0;   ///< photons of the global map
  std::uint64_t used = 0;     ///< those at places that the image needs; the others are wasted
  std::uint64_t wasted() const { return stored - used; }
};

/// Counts and times of a render. The guide lists the names, and what they count.
struct RenderStatistics {
  Ending ending = Ending::running;
  std::uint32_t passes = 0;              ///< camera samples of every pixel
  double mean_samples = 0;               ///< of a pixel
  std::uint64_t samples_not_finite = 0;  ///< samples that are black because their light was not finite
  std::uint64_t tasks = 0;               ///< parts of the picture computed at once
  int threads = 0;
  std::string instruction_set;
  std::map<std::string, double> seconds;                ///< wall time by phase: "total", "gather_rays"
  std::map<std::string, std::uint64_t> counts;          ///< "photons_stored", "gather_rays"
  std::map<std::string, double> rates;                  ///< "gather_rays_per_s"
  std::map<std::string, std::uint64_t> memory;          ///< bytes: "budget", "peak_reserved"
  std::map<std::string, std::uint64_t> reserved_peaks;  ///< bytes, by part of the render
  std::vector<LightPhotons> lights;                     ///< none for the path tracer
  /// All of this, the scene and the settings as a JSON object.
  std::string json;
};

}  // namespace glowworm::api
