// Sequences of frames: a way of cameras and light edits through a scene.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "scene/light_rig.h"
#include "session/script.h"
#include "session/view_state.h"
#include "trace/tracer.h"

namespace glowworm {

/// Numbers of frames: first, first + step, ... up to last.
struct FrameRange {
  std::uint32_t first = 0, last = 0, step = 1;

  std::vector<std::uint32_t> numbers() const;
};
/// Reads "1-240", "1-240:2" or "7". Throws Error with an example if the text is none of them.
FrameRange parse_frame_range(const std::string& text);

/// The name of a frame's file: the last run of '#' in `pattern` becomes the number with at least as many digits. The
/// pattern itself where it has no '#'.
std::string frame_file(const std::string& pattern, std::uint32_t number);
/// Whether a pattern gives each frame a file of its own.
bool has_frame_number(const std::string& pattern);

/// What a frame shows.
struct FrameOfSequence {
  Camera camera;
  std::vector<LightEdit> lights;  ///< one for each of LightRig::lights()
};

/// Moments of one turn of `count` frames around the middle of the scene, to the right, about the camera's up axis.
/// @param moments in frames: 1.5 lies between frames 1 and 2
std::vector<FrameOfSequence> turntable(const Scene& scene, const LightRig& rig, const Camera& camera,
                                       std::uint32_t count, const std::vector<double>& moments);

/// Moments of a script: its cameras and lights. What else a script changes is of interactive views.
/// Throws Error for what play() refuses, and for "focus" and "drop", which need a window's frames.
/// @param moments in frames; those before frame 0 show it
std::vector<FrameOfSequence> frames_of_script(const Script& script, const Tracer& tracer, const LightRig& rig,
                                              const Camera& camera, const std::vector<double>& moments);

}  // namespace glowworm
