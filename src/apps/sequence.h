// Frames of a sequence on the command line: --frames, --turntable, --script, and films of them.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scene/light_rig.h"
#include "session/frames.h"
#include "settings/settings.h"
#include "trace/tracer.h"

namespace CLI {
class App;
}

namespace glowworm {

/// Options of a sequence.
struct SequenceOptions {
  std::string frames, script;
  std::uint32_t turntable = 0;
  double frames_per_second = 24;

  bool is_given() const { return !frames.empty() || !script.empty() || turntable > 0; }
  /// Throws CommandLineError if the options do not make a sequence.
  void check() const;
};

/// Adds --frames, --turntable, --script and --fps.
void add_sequence_options(CLI::App& command, const std::string& group, SequenceOptions& options);

/// A scene in the light of a frame.
struct LitScene {
  std::shared_ptr<const Scene> scene;  ///< has the cameras of all frames, named by frame_camera()
  std::shared_ptr<const Tracer> tracer;
};

/// The frames that the options ask for, and the scene that each shows.
class Sequence {
 public:
  /// Throws CommandLineError for a script that is invalid or a camera that does not exist.
  /// @param camera name of the camera that starts the sequence
  Sequence(const SequenceOptions& options, std::shared_ptr<const Scene> scene, std::shared_ptr<const Tracer> tracer,
           const std::string& camera);

  /// Numbers of the frames to render.
  const std::vector<std::uint32_t>& numbers() const { return numbers_; }
  /// Makes these the settings of a frame.
  void set_frame(std::uint32_t number, RenderSettings& settings) const;
  /// The scene of a frame: the same object as for the last call if the lights are the same.
  const LitScene& scene_of(std::uint32_t number);
  /// An exposure for PNG files of all frames, in stops: the automatic one of small pictures along the way.
  float exposure(const RenderSettings& settings);

 private:
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const Tracer> tracer_;
  LightRig rig_;
  std::vector<FrameOfSequence> frames_;
  std::vector<std::string> guides_;
  std::vector<std::uint32_t> numbers_;
  std::vector<LightEdit> lights_;  // of lit_
  LitScene lit_;
};

/// A film of PNG files, encoded by the program ffmpeg.
class Movie {
 public:
  /// Throws CommandLineError if ffmpeg is not installed, or no output makes PNG files of the frames.
  /// @param path of the film, .mp4 @param names values of -o
  Movie(std::string path, const std::vector<std::string>& names, double frames_per_second);

  const std::string& path() const { return path_; }
  /// Writes the film. Throws Error, with what ffmpeg says, if it fails.
  void write(const std::vector<std::uint32_t>& numbers) const;

 private:
  std::string path_, pictures_, program_;
  double frames_per_second_;
};

/// Takes the film out of the values of -o; nothing if none is one.
std::optional<std::string> take_movie(std::vector<std::string>& names);

}  // namespace glowworm
