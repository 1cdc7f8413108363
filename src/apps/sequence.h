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
  std::string frames, script, shutter;
  std::uint32_t turntable = 0, reuse = 0;
  double frames_per_second = 24;
  SampleShare part;  ///< of the frames

  bool is_given() const { return !frames.empty() || !script.empty() || turntable > 0; }
  /// Throws CommandLineError if the options do not make a sequence.
  void check() const;
};

/// Adds --frames, --turntable, --script, --fps, --shutter and --reuse.
void add_sequence_options(CLI::App& command, const std::string& group, SequenceOptions& options);

/// The motion to import with the scene; null if what is rendered is not of its animation.
/// @param path of the scene @param moment of the scene options
std::shared_ptr<SceneMotion> motion_of(const SequenceOptions& options, const std::string& path, const Moment& moment,
                                       const RenderSettings& settings);

/// A scene as it is at a moment of a frame.
struct LitScene {
  std::shared_ptr<const Scene> scene;  ///< has the cameras of all moments, FrameMoment::camera()
  std::shared_ptr<const Tracer> tracer;
  bool as_at_first = false;  ///< all lights have the power of the first moment
};

/// The frames that the options ask for, or one picture with motion blur, and the scene that each shows.
class Sequence {
 public:
  /// Opens the scene at a moment of its animation, s.
  using OpenAt = std::function<std::shared_ptr<const Scene>(double seconds)>;

  /// Throws CommandLineError for a script that is invalid or a camera that does not exist.
  /// @param settings with the camera that starts the sequence
  /// @param motion with which the scene was imported, or null
  Sequence(const SequenceOptions& options, std::shared_ptr<const Scene> scene, std::shared_ptr<const Tracer> tracer,
           const RenderSettings& settings, std::shared_ptr<const SceneMotion> motion, OpenAt open_at);

  /// Numbers of the frames to render.
  const std::vector<std::uint32_t>& numbers() const { return numbers_; }
  /// The moments that a frame shows: its own, or those of the slices of the shutter's time if anything moves meanwhile.
  std::vector<FrameMoment> moments(std::uint32_t number) const;
  /// Whether a frame may use light of another: only the camera differs, and neither has motion blur.
  bool shares_light(std::uint32_t number, std::uint32_t other) const;
  /// Whether lights, or other things than the camera, differ between moments.
  bool changes() const;
  /// Whether a light is on at the first moment.
  bool starts_lit();
  /// Whether a frame without motion blur may keep light paths of another moment.
  bool keeps_paths() const;
  /// Makes these the settings of a moment.
  void set_moment(FrameMoment moment, RenderSettings& settings) const;
  /// The scene at a moment: the same object as for the last call if nothing but the camera moves.
  const LitScene& scene_at(FrameMoment moment);
  /// An exposure for PNG files of all frames, in stops: the automatic one of small pictures along the way.
  float exposure(const RenderSettings& settings);

 private:
  bool moves() const { return motion_ && motion_->anything_else_moves; }
  /// Index in frames_.
  std::size_t index(FrameMoment m) const { return m.frame * std::size_t{1 + timing_.slice_count()} + m.slice; }
  /// Whether lights, or other things than the camera, differ between two moments.
  bool lit_alike(FrameMoment a, FrameMoment b) const;
  /// The scene at a moment, with the cameras of all moments.
  LitScene open_lit(FrameMoment moment) const;
  /// As scene_at(), though no light may be on.
  const LitScene& show(FrameMoment moment);

  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const SceneMotion> motion_;
  SceneMotion timing_;  // frames and slices
  OpenAt open_at_;
  std::vector<FrameOfSequence> frames_;  // of timing_.moments()
  std::vector<std::string> guides_;
  std::vector<std::uint32_t> numbers_;
  std::optional<LightPowers> first_powers_;  // once they are known, if anything changes
  std::optional<bool> starts_lit_;           // once it is known
  bool keeps_paths_ = false;                 // keeps_paths()
  FrameMoment shown_;                        // of lit_
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
