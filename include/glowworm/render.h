// Rendering a scene to a picture.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "glowworm/scene.h"

namespace glowworm::api {

/// What you ask of a render. 0 and "" leave the choice to Glowworm.
struct RenderOptions {
  int width = 0, height = 0;      ///< pixels
  std::uint32_t samples = 0;      ///< camera samples of each pixel
  std::uint32_t gather = 0;       ///< final gather rays of each camera sample
  std::uint64_t photons = 0;      ///< in the global map
  std::string engine;             ///< density engine: "blocked", "forward", "reverse", "knn", "single"
  bool path_tracing = false;      ///< by the path tracer, the reference, in place of photon maps
  bool progressive = false;       ///< new photons and smaller radii in every pass: converges to the truth
  std::uint32_t seed = 0;         ///< one seed, one picture, bit for bit
  double time_limit = 0;          ///< seconds; stops after the part under way
  double noise_target = 0;        ///< relative standard error of the picture at which it stops
  std::uint64_t memory = 0;       ///< bytes beside the scene
  std::string camera;             ///< name; "": the scene's first
  std::vector<std::string> aovs;  ///< further layers: emitted, direct, indirect, caustic, albedo, normal, depth
};

/// A picture: planes of floats, row by row from the top.
struct Picture {
  struct Plane {
    std::string name;            ///< as in an EXR file: "R", "albedo.G", "depth.Z"
    std::vector<float> samples;  ///< width * height. Radiance in W sr^-1 m^-2, depth in metres
  };
  int width = 0, height = 0;
  std::vector<Plane> planes;

  /// The plane of that name. Throws Error that lists the names there are.
  std::span<const float> plane(const std::string& name) const;
};

/// Writes a picture by the ending of the path: .exr with all planes, linear; .png with R, G, B through a filmic curve.
/// The file appears whole or not at all. Throws Error where it cannot be written.
void write_picture(const std::string& path, const Picture& picture);

/// A render in a thread of its own, which uses all threads that set_threads() allows.
class Render {
 public:
  /// Starts at once. Throws Error for options that make no sense.
  Render(const Scene& scene, const RenderOptions& options);
  ~Render();  ///< cancels and waits
  Render(Render&&) noexcept;
  Render& operator=(Render&&) noexcept;

  /// Asks the render to stop after the part under way. Any thread; safe in signal handlers.
  void cancel();
  /// Waits for the end. Throws what the render failed with. After cancel() it returns as usual.
  void wait();
  bool done() const;
  bool cancelled() const;  ///< whether it ended because of cancel()
  /// Share of the work that is done, in [0, 1]. Any thread.
  double progress() const;
  /// The picture so far, or the whole one; any time, any thread. Black where there is nothing yet.
  Picture picture() const;
  /// Settings, counts and times as JSON; the guide lists the keys. Call it when the render is done.
  std::string statistics() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Renders and waits.
Picture render(const Scene& scene, const RenderOptions& options = {});

}  // namespace glowworm::api
