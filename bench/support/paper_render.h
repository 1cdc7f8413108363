// Renders with the settings of [HHS05], and what they took.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "render/settings.h"
#include "trace/tracer.h"

namespace glowworm::bench {

inline constexpr std::uint32_t kPaperRays = 600;    // final gather rays of a pixel
inline constexpr std::uint32_t kPaperSamples = 24;  // camera samples, which share them out
inline constexpr std::uint32_t kPaperNearest = 50;  // the paper's K is between 30 and 65

/// A scene that any number of renders use.
struct RenderedScene {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Tracer> tracer;

  /// Loads "builtin:NAME" or a file.
  explicit RenderedScene(const std::string& path);
};

/// Folder of the scenes that are handed around beside the project; empty where it is not there.
std::string shared_folder();

/// Indirect light alone, box kernel, 600 gather rays a pixel, 500,000 photons, square pictures.
RenderSettings paper_settings(const char* engine, int side);

/// What a render took, in wall seconds.
struct RenderTimes {
  double photons = 0;  ///< tracing them and building their map
  double rest = 0;     ///< all that grows with the pixels
  double look_up = 0;  ///< of it, reordering and density estimation
  double k = 0;        ///< shader operations of a query point
  double tested = 0;   ///< pairs tested for a query point
  std::uint64_t queries = 0, tasks = 0, peak = 0;

  /// Of a picture of so many times the pixels, with the same photons.
  double whole(double pixel_factor) const { return photons + rest * pixel_factor; }
};

/// Renders; the picture is forgotten.
RenderTimes render(const RenderedScene& set, const RenderSettings& settings);

}  // namespace glowworm::bench
