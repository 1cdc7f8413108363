// Rendering a scene to a picture.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "glowworm/scene.h"

namespace glowworm::api {

/// Settings of a render. 0 and "" leave the choice to Glowworm.
struct RenderOptions {
  int width = 0, height = 0;      ///< pixels
  std::uint32_t samples = 0;      ///< camera samples of each pixel
  std::uint32_t gather = 0;       ///< final gather rays of each camera sample
  std::uint64_t photons = 0;      ///< in the global map
  std::string engine;             ///< density engine: "blocked", "forward", "reverse", "knn", "single"
  bool path_tracing = false;      ///< use the path tracer, the reference, instead of photon maps
  bool progressive = false;       ///< new photons and smaller radii in every pass: converges to the exact solution
  std::uint32_t seed = 0;         ///< the same seed gives the same picture, bit for bit
  double time_limit = 0;          ///< seconds; stops after the task under way
  double noise_target = 0;        ///< relative standard error of the picture at which it stops
  std::uint64_t memory = 0;       ///< bytes, in addition to the scene
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

  /// Returns the plane of that name. Throws Error, which lists the existing names, if there is none.
  std::span<const float> plane(const std::string& name) const;
};

/// Writes a picture in the format of the path's extension: .exr with all planes, linear; .png with R, G, B and a filmic
/// tone curve. The file appears whole or not at all. Throws Error if it cannot be written.
void write_picture(const std::string& path, const Picture& picture);

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
  bool done() const;
  bool cancelled() const;  ///< whether cancel() ended it
  /// Finished share of the work, in [0, 1]. Any thread may call it.
  double progress() const;
  /// The picture so far, or the finished one. Any thread may call it at any time. Black where nothing is rendered yet.
  Picture picture() const;
  /// Settings, counts and times as JSON; the guide lists the keys. Call it after the render has ended.
  std::string statistics() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Renders and waits.
Picture render(const Scene& scene, const RenderOptions& options = {});

}  // namespace glowworm::api
