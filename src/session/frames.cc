#include "session/frames.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/frame.h"
#include "core/text.h"
#include "session/camera_control.h"

namespace glowworm {

namespace {

/// Most frames of a sequence: ten hours at 24 a second.
constexpr std::uint32_t kMostFrames = 1'000'000;

/// The whole number that a text is; throws Error for another text.
std::uint32_t frame_number(const std::string& text, const std::string& whole) {
  const bool digits = !text.empty() && text.size() <= 7 && text.find_first_not_of("0123456789") == std::string::npos;
  if (!digits || std::stoul(text) >= kMostFrames)
    throw Error(fmt::format("'{}' are no numbers of frames", whole),
                fmt::format("Give the first and the last, and a step: 1-240 or 1-240:2, below {}.", kMostFrames));
  return static_cast<std::uint32_t>(std::stoul(text));
}

/// The last run of '#': its place and length; npos and 0 if there is none.
std::pair<std::size_t, std::size_t> number_place(const std::string& pattern) {
  const std::size_t last = pattern.rfind('#');
  if (last == std::string::npos) return {last, 0};
  const std::size_t before = pattern.find_last_not_of('#', last);
  const std::size_t first = before == std::string::npos ? 0 : before + 1;
  return {first, last + 1 - first};
}

}  // namespace

std::vector<std::uint32_t> FrameRange::numbers() const {
  std::vector<std::uint32_t> out;
  for (std::uint32_t number = first; number <= last; number += step) out.push_back(number);
  return out;
}

FrameRange parse_frame_range(const std::string& text) {
  const std::size_t colon = std::min(text.find(':'), text.size()), dash = std::min(text.find('-'), colon);
  FrameRange range;
  range.first = range.last = frame_number(text.substr(0, dash), text);
  if (dash < colon) range.last = frame_number(text.substr(dash + 1, colon - dash - 1), text);
  if (colon < text.size()) range.step = frame_number(text.substr(colon + 1), text);
  if (range.last < range.first || range.step == 0)
    throw Error(fmt::format("--frames {} has no frame", text), "Give the first frame first, and a step of at least 1.");
  return range;
}

std::string frame_file(const std::string& pattern, std::uint32_t number) {
  const auto [first, length] = number_place(pattern);
  if (length == 0) return pattern;
  return pattern.substr(0, first) + fmt::format("{:0{}}", number, length) + pattern.substr(first + length);
}

bool has_frame_number(const std::string& pattern) { return number_place(pattern).second > 0; }

std::vector<FrameOfSequence> turntable(const Scene& scene, const LightRig& rig, const Camera& camera,
                                       std::uint32_t count, const std::vector<double>& moments) {
  const Vec3 up = nearest_up(camera), to_middle = scene.center() - camera.to_world.translation;
  // The camera keeps its direction, so it turns around the axis through the middle.
  const float ahead = dot(to_middle, forward(camera));
  std::vector<FrameOfSequence> frames;
  for (const double moment : moments) {
    const float angle = 2 * kPi * static_cast<float>(moment) / static_cast<float>(count);
    frames.push_back({moment == 0 ? camera : orbit(camera, ahead, up, angle, 0), {}});
    frames.back().lights.resize(rig.lights().size());
  }
  return frames;
}

std::vector<FrameOfSequence> frames_of_script(const Script& script, const Tracer& tracer, const LightRig& rig,
                                              const Camera& camera, const std::vector<double>& moments) {
  for (const ScriptMove& move : script.moves)
    if (move.focus || move.drop)
      throw Error(fmt::format("the script's move at frame {} has a \"{}\", which needs the frames of a window",
                              move.from, move.focus ? "focus" : "drop"),
                  "Leave it out, or play the script by 'glowworm view --script'.");
  ViewState state;
  state.camera = camera;
  state.pivot_distance = pivot_distance(tracer, camera);
  state.lights.resize(rig.lights().size());
  const double last = moments.empty() ? 0 : *std::max_element(moments.begin(), moments.end());
  std::vector<ViewState> whole;
  for (std::uint32_t i = 0; i <= std::max(last, 0.0); ++i) {
    play(script, i, tracer.scene(), rig, nullptr, state);
    whole.push_back(state);
  }
  std::vector<FrameOfSequence> frames;
  for (const double moment : moments) {
    const auto before = static_cast<std::uint32_t>(std::max(moment, 0.0));
    ViewState between = whole[before];
    const auto part = static_cast<float>(std::max(moment, 0.0) - before);
    if (part > 0) play(script, before + 1, tracer.scene(), rig, nullptr, between, part);
    frames.push_back({between.camera, between.lights});
  }
  return frames;
}

}  // namespace glowworm
