// Rendering a scene to a picture.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "glowworm/density.h"
#include "glowworm/picture.h"
#include "glowworm/scene.h"
#include "glowworm/statistics.h"

namespace glowworm::api {

/// Ways to compute light.
enum class Integrator : std::uint8_t {
  gather,   ///< photon maps with final gathering
  path,     ///< path tracing: the reference
  photons,  ///< the photon map shown directly, without final gathering
};

/// A part of a picture, as fractions of its width and height from the upper left corner.
struct Crop {
  double x0 = 0, y0 = 0, x1 = 1, y1 = 1;
};

/// Settings of a render. 0, "" and automatic leave the choice to Glowworm.
struct RenderOptions {
  int width = 0, height = 0;  ///< pixels
  std::optional<Crop> crop;   ///< the part to render; none: all, or what the scene's file asks for
  std::uint32_t samples = 0;  ///< camera samples of each pixel
  std::uint32_t gather = 0;   ///< final gather rays of each camera sample
  std::uint64_t photons = 0;  ///< in the global map
  Integrator integrator = Integrator::gather;
  Engine engine = Engine::automatic;
  bool filter = true;             ///< average pixels of gathered light whose difference is noise
  bool progressive = false;       ///< new photons and smaller radii in every pass: converges to the exact solution
  std::uint32_t seed = 0;         ///< the same seed gives the same picture, bit for bit
  double time_limit = 0;          ///< seconds, until the picture is made; 0: none
  double noise_target = 0;        ///< relative standard error of the picture at which it stops
  std::uint64_t memory = 0;       ///< bytes, in addition to the scene
  std::string camera;             ///< name; "": the scene's first
  std::vector<std::string> aovs;  ///< layers beside the image: names of aov_names()
  /// Further options of `glowworm render`, by name without dashes, with their text: {"nearest", "100"}; flags have the
  /// text "": {"indirect-only", ""}. They overrule the members above.
  std::vector<std::pair<std::string, std::string>> more;
};

/// Names for RenderOptions::aovs.
std::vector<std::string> aov_names();
/// Names for RenderOptions::more.
std::vector<std::string> render_option_names();
/// A whole number as options of renders take it: "10000", "1e4", "10k" or "0.01M". Throws Error for another text.
std::uint64_t parse_count(const std::string& text);

/// A render in its own thread. It uses as many threads as set_threads() allows.
class Render {
 public:
  /// Starts the render. Throws Error for settings that make no sense.
  Render(const Scene& scene, const RenderOptions& options);
  ~Render();  ///< cancels and waits
  Render(Render&&) noexcept;
  Render& operator=(Render&&) noexcept;

  /// Stops the render after the task under way. Any thread may call it; safe in signal handlers.
  void cancel();
  /// Waits for the end. Throws the render's error. After cancel() it returns normally.
  void wait();
  /// Waits for the end, but no longer than this. Returns done(). Throws nothing of the render's.
  bool wait_for(double seconds);
  bool done() const;
  bool cancelled() const;  ///< whether cancel() ended it
  /// Finished share of the work, in [0, 1]. Any thread may call it.
  double progress() const;
  /// The picture so far, or the finished one. Any thread may call it at any time. Black where nothing is rendered yet.
  Picture picture() const;
  /// Counts and times. Call it after the render has ended.
  RenderStatistics statistics() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Frames of a still scene from many cameras. They share photons, and what guides them, which are made once for all
/// cameras; so a frame is the same, bit for bit, whichever others are rendered.
class FrameSequence {
 public:
  /// @param cameras of all frames; their names do not count @param options RenderOptions::camera is not used
  /// Throws Error for a camera that shows nothing, and for settings that make no sense.
  FrameSequence(const Scene& scene, std::span<const Camera> cameras, const RenderOptions& options = {});
  ~FrameSequence();
  FrameSequence(FrameSequence&&) noexcept;
  FrameSequence& operator=(FrameSequence&&) noexcept;

  std::size_t size() const;  ///< number of frames
  /// Renders a frame, in any order, and waits. One at a time. @param progress as for render()
  /// Throws Error if there is no such frame.
  Picture render(std::size_t frame, const std::function<void(double)>& progress = {});

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Renders and waits.
/// @param progress called on this thread ten times a second with the finished share; if it throws, the render is
/// cancelled, and its exception is thrown on
Picture render(const Scene& scene, const RenderOptions& options = {}, const std::function<void(double)>& progress = {});

}  // namespace glowworm::api
