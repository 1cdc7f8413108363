// Frames of a sequence on the command line: --frames of an animation, --turntable, --script, and films of them.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "import/import.h"
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

/// The motion to import with the scene; null if the frames are not of its animation.
/// @param moment of the scene options
/// @param camera name; empty is the file's first
std::shared_ptr<CameraMotion> camera_motion(const SequenceOptions& options, const Moment& moment,
                                            const std::string& camera);

/// A scene as it is in a frame.
struct LitScene {
  std::shared_ptr<const Scene> scene;  ///< has the cameras of all frames, named by frame_camera()
  std::shared_ptr<const Tracer> tracer;
};

/// The frames that the options ask for, and the scene that each shows.
class Sequence {
 public:
  /// Opens the scene at a moment of its animation, s.
  using OpenAt = std::function<std::shared_ptr<const Scene>(double seconds)>;

  /// Throws CommandLineError for a script that is invalid or a camera that does not exist.
  /// @param camera name of the camera that starts the sequence
  /// @param motion with which the scene was imported, or null
  Sequence(const SequenceOptions& options, std::shared_ptr<const Scene> scene, std::shared_ptr<const Tracer> tracer,
           const std::string& camera, std::shared_ptr<const CameraMotion> motion, OpenAt open_at);

  /// Numbers of the frames to render.
  const std::vector<std::uint32_t>& numbers() const { return numbers_; }
  /// Makes these the settings of a frame.
  void set_frame(std::uint32_t number, RenderSettings& settings) const;
  /// The scene of a frame: the same object as for the last call if nothing but the camera moves.
  const LitScene& scene_of(std::uint32_t number);
  /// An exposure for PNG files of all frames, in stops: the automatic one of small pictures along the way.
  float exposure(const RenderSettings& settings);

 private:
  bool moves() const { return motion_ && motion_->anything_else_moves; }

  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const CameraMotion> motion_;
  OpenAt open_at_;
  std::vector<FrameOfSequence> frames_;
  std::vector<std::string> guides_;
  std::vector<std::uint32_t> numbers_;
  std::uint32_t shown_ = 0;  // the frame of lit_
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
