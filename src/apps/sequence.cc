#include "apps/sequence.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "apps/commands.h"
#include "apps/table_options.h"
#include "control/job.h"
#include "control/job_report.h"
#include "core/error.h"
#include "core/input_file.h"
#include "core/temporary_files.h"
#include "core/text.h"
#include "film/output.h"
#include "image/tone_map.h"

namespace glowworm {

namespace {

/// Pixels along the longer side, samples and photons of the pictures that the exposure is chosen by. Gathered light has
/// little noise: paths of as many samples leave most pixels of a dim room black, and the others too bright.
constexpr int kExposureSide = 48;
constexpr std::uint32_t kExposureSamples = 4, kExposurePhotons = 50'000;

/// Slices of the time of a shutter. A render that ends by time or noise may need many.
std::uint32_t slices_of(const RenderSettings& s) {
  const bool open_ended = s.integrator == Integrator::path || s.time_limit_s > 0 || s.noise_target > 0;
  const std::uint32_t usual = open_ended ? kMostSlices : kDefaultSamples;
  return std::min(s.samples > 0 ? s.samples : usual, kMostSlices);
}

/// Sets what the options say of the time of frames and of the shutter.
void set_timing(const SequenceOptions& options, const RenderSettings& settings, SceneMotion& motion) {
  motion.frames_per_second = options.frames_per_second;
  motion.slices = slices_of(settings);
  motion.seed = settings.seed;
  if (!options.shutter.empty()) motion.shutter = parse_shutter(options.shutter);
}

/// The path of a program on PATH; "" if there is none.
std::string find_program(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::stringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const std::string file = folder + "/" + name; !folder.empty() && access(file.c_str(), X_OK) == 0) return file;
  return "";
}

}  // namespace

void SequenceOptions::check() const {
  if (turntable > 0 && !script.empty())
    throw CommandLineError("--turntable and --script both move the camera", "Give one of them.");
  if (reuse > 0 && !is_given())
    throw CommandLineError("--reuse is of frames", "Give --frames, --turntable or --script with it, or leave it out.");
  read_command_line([&] {
    if (!frames.empty()) parse_frame_range(frames);
    if (!shutter.empty()) parse_shutter(shutter);
  });
}

void add_sequence_options(CLI::App& c, const std::string& group, SequenceOptions& o) {
  add_text(c, group, "--frames", o.frames, "FIRST-LAST[:STEP]",
           "Render these frames of the scene's animation, --script or --turntable; '#' in -o becomes the number. "
           "Frames whose files exist are skipped, and --part I/N renders every N-th");
  add_number(c, group, "--turntable", o.turntable, 0, 100'000, "N",
             "Turn the camera once around the scene in so many frames");
  add_text(c, group, "--script", o.script, "FILE", "Move camera and lights by a script, as 'glowworm view --script'");
  add_number(c, group, "--fps", o.frames_per_second, 0.01, 1000, "N [24]",
             "Frames a second, of animations and of films, -o NAME.mp4");
  add_text(c, group, "--shutter", o.shutter, "SECONDS|OPEN:CLOSE",
           "Motion blur: the shutter is open for so long from the moment of the picture, such as 1/48, or between two "
           "times (s). pbrt files bring their own; 0 turns it off. Samples divide the time");
  add_number(c, group, "--reuse", o.reuse, 0, 1000, "N [0]",
             "Against flicker: use gathered light of this many frames before again, where the same places show the "
             "same light. A frame is the same alone, but then takes as long as all of these; so --part and mpirun "
             "divide the frames into runs of neighbours. --noise counts this light, except in every (N + 1)-th frame. "
             "Where lights or things move, no light is used again");
}

std::shared_ptr<SceneMotion> motion_of(const SequenceOptions& options, const std::string& path, const Moment& moment,
                                       const RenderSettings& settings) {
  const bool other = options.turntable > 0 || !options.script.empty();
  if (options.is_given() ? other && moment.animation.empty() : !has_moments(path)) return nullptr;
  auto motion = std::make_shared<SceneMotion>();
  motion->camera = settings.camera;
  motion->is_still = !options.is_given();
  motion->start = motion->is_still ? moment.seconds : 0;
  motion->frames = motion->is_still ? 1 : 0;
  if (!options.frames.empty()) motion->frames = parse_frame_range(options.frames).last + 1;
  set_timing(options, settings, *motion);
  return motion;
}

Sequence::Sequence(const SequenceOptions& options, std::shared_ptr<const Scene> scene,
                   std::shared_ptr<const Tracer> tracer, const RenderSettings& settings,
                   std::shared_ptr<const SceneMotion> motion, OpenAt open_at)
    : scene_(std::move(scene)), motion_(std::move(motion)), open_at_(std::move(open_at)) {
  const LightRig rig(scene_);
  read_command_line([&] {
    const Camera& start = scene_->camera(settings.camera);
    const Script script = options.script.empty() ? Script() : read_script(options.script);
    const bool turns = options.turntable > 0, scripted = !options.script.empty();
    std::uint32_t count = turns ? options.turntable : scripted ? script_length(script) : motion_ ? motion_->frames : 1;
    FrameRange range{0, count - 1, 1};
    if (!options.frames.empty()) range = parse_frame_range(options.frames);
    if (turns && range.last >= count)
      throw Error(fmt::format("--frames {} is beyond --turntable {}", options.frames, count),
                  fmt::format("Frames are counted from 0 to {}.", count - 1));
    count = std::max(count, range.last + 1);
    numbers_ = range.numbers();
    if (motion_) timing_ = *motion_;
    timing_.frames = count;
    set_timing(options, settings, timing_);
    if (turns || scripted) {
      std::vector<double> at;
      timing_.start = 0;
      for (const FrameMoment m : timing_.moments())
        at.push_back(m.slice > 0 ? timing_.seconds(m) * timing_.frames_per_second : m.frame);
      frames_ = turns ? turntable(*scene_, rig, start, count, at) : frames_of_script(script, *tracer, rig, start, at);
      return;
    }
    const std::vector<Camera>& all = scene_->cameras();
    for (const FrameMoment m : timing_.moments()) {
      const auto own = std::find_if(all.begin(), all.end(), [&](const Camera& c) { return c.name == m.camera(); });
      frames_.push_back({own == all.end() ? start : *own, std::vector<LightEdit>(rig.lights().size())});
    }
  });
  std::vector<std::string> names;
  for (const FrameMoment m : timing_.moments()) {
    frames_[index(m)].camera.name = m.camera();
    // All frames have the same guides; a single picture is guided by what its slices see.
    if ((m.slice > 0) == !options.is_given()) names.push_back(m.camera());
  }
  guides_ = guide_cameras(names);
  keeps_paths_ = keeps_paths();
}

bool Sequence::lit_alike(FrameMoment a, FrameMoment b) const {
  return (!moves() || (a.frame == b.frame && a.slice == b.slice)) &&
         frames_[index(a)].lights == frames_[index(b)].lights;
}

std::vector<FrameMoment> Sequence::moments(std::uint32_t number) const {
  const FrameMoment own{number, 0};
  std::vector<FrameMoment> slices;
  bool any = false;
  for (std::uint32_t slice = 1; slice <= timing_.slice_count(); ++slice) {
    slices.push_back({number, slice});
    any |=
        !lit_alike(own, slices.back()) || !same_view(frames_[index(own)].camera, frames_[index(slices.back())].camera);
  }
  return any ? slices : std::vector{own};
}

bool Sequence::shares_light(std::uint32_t number, std::uint32_t other) const {
  return moments(number).front().slice == 0 && moments(other).front().slice == 0 && lit_alike({number, 0}, {other, 0});
}

void Sequence::set_moment(FrameMoment moment, RenderSettings& settings) const {
  settings.camera = moment.camera();
  settings.guide_cameras = guides_;
  settings.frame = moment.frame;
  settings.scene_moves = keeps_paths_ && moment.slice == 0;
  if (moment.slice == 0) return;
  settings.slice = {moment.slice, timing_.slices};
  const FrameMoment first{moment.frame, 1};
  bool still = true;
  for (FrameMoment other = first; other.slice <= timing_.slice_count(); ++other.slice) still &= lit_alike(first, other);
  // Photons of several moments average their noise.
  settings.photon_stream = still ? 0 : moment.slice;
}

bool Sequence::changes() const {
  return moves() || std::any_of(frames_.begin(), frames_.end(), [&](const FrameOfSequence& frame) {
           return !(frame.lights == frames_.front().lights);
         });
}

LitScene Sequence::open_lit(FrameMoment moment) const {
  const std::vector<LightEdit>& lights = frames_[index(moment)].lights;
  const std::shared_ptr<const Scene> unlit = moves() ? open_at_(timing_.seconds(moment)) : scene_;
  const bool edited = std::any_of(lights.begin(), lights.end(), [](const LightEdit& e) { return !(e == LightEdit()); });
  const LightRig rig(unlit);
  const std::shared_ptr<const Scene> lit = edited ? rig.edited(rig.edits_of(LightRig(scene_), lights)) : unlit;
  SceneEdit edit{lit->emissions(), lit->lights(), lit->environment(), lit->shared_geometry(), {}, ""};
  for (const FrameOfSequence& frame : frames_) edit.more_cameras.push_back(frame.camera);
  edit.lit_as = first_powers_;
  LitScene out;
  out.scene = std::make_shared<const Scene>(*lit, std::move(edit));
  out.as_at_first = first_powers_ && first_powers_->are_as(out.scene->source_powers());
  return out;
}

const LitScene& Sequence::show(FrameMoment moment) {
  if (lit_.scene && lit_alike(moment, shown_)) return lit_;
  lit_ = {};
  if (changes() && !first_powers_) {
    lit_ = open_lit({0, 0});
    first_powers_ = lit_.scene->light_powers();
    lit_.as_at_first = true;
    if (!lit_alike(moment, {0, 0})) lit_ = {};
  }
  if (!lit_.scene) lit_ = open_lit(moment);
  lit_.tracer = std::make_shared<const Tracer>(*lit_.scene, changes() ? TieRule::number : TieRule::structure);
  shown_ = moment;
  return lit_;
}

bool Sequence::starts_lit() {
  if (!starts_lit_) starts_lit_ = show({0, 0}).scene->light_power().total() > 0;
  return *starts_lit_;
}

bool Sequence::keeps_paths() const {
  return changes() && std::any_of(numbers_.begin(), numbers_.end(), [&](std::uint32_t number) {
           return number > 0 && moments(number).front().slice == 0;
         });
}

const LitScene& Sequence::scene_at(FrameMoment moment) {
  const LitScene& lit = show(moment);
  if (!(lit.scene->light_power().total() > 0))
    throw Error(fmt::format("no light is on in frame {}", moment.frame), "Leave one on in each frame of the script.");
  return lit;
}

float Sequence::exposure(const RenderSettings& settings) {
  const LitScene& lit = scene_at({0, 0});
  const RenderSettings size = resolve(settings, *lit.scene);
  RenderSettings s;
  s.samples = kExposureSamples;
  s.photons = kExposurePhotons;
  const double scale = std::min(1.0, 1.0 * kExposureSide / std::max(size.width, size.height));
  s.width = std::max(1, static_cast<int>(size.width * scale));
  s.height = std::max(1, static_cast<int>(size.height * scale));
  s.bounds = {0, 0, s.width, s.height};
  s.memory_bytes = size.memory_bytes;
  s.threads = size.threads;
  std::vector<RGB> pixels;
  for (const std::string& camera : guides_) {
    s.camera = camera;
    Job job(lit.scene, lit.tracer, s);
    job.wait();
    const std::vector<RGB> seen = make_image(job.film(), job).rgb();
    pixels.insert(pixels.end(), seen.begin(), seen.end());
  }
  return automatic_exposure(pixels);
}

std::optional<std::string> take_movie(std::vector<std::string>& names) {
  const auto found =
      std::find_if(names.begin(), names.end(), [](const std::string& n) { return lower_ending(n) == ".mp4"; });
  if (found == names.end()) return std::nullopt;
  std::string path = *found;
  names.erase(found);
  return path;
}

Movie::Movie(std::string path, const std::vector<std::string>& names, double frames_per_second)
    : path_(std::move(path)), program_(find_program("ffmpeg")), frames_per_second_(frames_per_second) {
  const auto found = std::find_if(names.begin(), names.end(), [](const std::string& name) {
    return lower_ending(name) == ".png" && has_frame_number(name);
  });
  if (found == names.end())
    throw CommandLineError(fmt::format("-o {}: a film is made of PNG files of its frames", path_),
                           "Add, for example, -o frame_####.png.");
  pictures_ = *found;
  if (program_.empty())
    throw CommandLineError(
        fmt::format("-o {}: films need the program ffmpeg, which is not on PATH", path_),
        fmt::format("Install ffmpeg, or leave this out and encode {} with another program.", pictures_));
}

namespace {

/// A file of another program, which is removed unless it is given its final name.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(std::string path) : path_(std::move(path)), registered_(path_) {}
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;
  ~UnfinishedFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }

  const std::string& path() const { return path_; }

 private:
  std::string path_;
  TemporaryName registered_;
};

}  // namespace

void Movie::write(const std::vector<std::uint32_t>& numbers) const {
  const UnfinishedFile unfinished(path_ + ".unfinished.mp4");  // outlives ffmpeg
  const std::string command = fmt::format(
      "{} -nostdin -y -loglevel error -f image2pipe -framerate {} -c:v png -i pipe:0 "
      "-vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' -pix_fmt yuv420p {} >/dev/null",
      shell_word(program_), frames_per_second_, shell_word(unfinished.path()));
  std::unique_ptr<FILE, int (*)(FILE*)> input(popen(command.c_str(), "we"), pclose);
  if (!input) throw Error(fmt::format("ffmpeg cannot be started: {}", std::strerror(errno)));
  const auto passed = [&](std::uint32_t number) {
    const std::string picture = read_input_file(frame_file(pictures_, number));
    return std::fwrite(picture.data(), 1, picture.size(), input.get()) == picture.size();
  };
  const bool all_passed = std::all_of(numbers.begin(), numbers.end(), passed) && std::fflush(input.get()) == 0;
  if (pclose(input.release()) != 0)
    throw Error(fmt::format("ffmpeg has not written {}", path_), "Its message is above; the frames are there.");
  if (!all_passed)
    throw Error(fmt::format("ffmpeg ended before it had read all frames of {}", path_), "The frames are there.");
  std::error_code error;
  std::filesystem::rename(unfinished.path(), path_, error);
  if (error) throw Error({path_}, fmt::format("cannot give the finished film its name: {}", error.message()));
}

}  // namespace glowworm
