#include "apps/render_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <utility>

#include "apps/commands.h"
#include "apps/interrupt.h"
#include "apps/open_scene.h"
#include "core/error.h"
#include "core/log.h"
#include "film/checkpoint.h"
#include "session/command_text.h"
#include "settings/settings.h"

namespace glowworm {

namespace {

using Clock = std::chrono::steady_clock;

/// The options of one frame.
RenderOptions options_of_frame(const RenderOptions& o, std::uint32_t number) {
  RenderOptions frame = o;
  for (Output& output : frame.outputs) output.path = frame_file(output.path, number);
  frame.report.statistics = frame_file(o.report.statistics, number);
  return frame;
}

/// Whether all files of a frame are there, by an earlier run.
bool is_done(const RenderOptions& frame) {
  return std::all_of(frame.outputs.begin(), frame.outputs.end(),
                     [](const Output& output) { return std::filesystem::exists(output.path); });
}

/// One of `count` shares of some frames: every `count`-th, or neighbours if frames use light of those before.
/// @param index from 0
std::vector<std::uint32_t> share_of(const std::vector<std::uint32_t>& frames, std::size_t index, std::size_t count,
                                    bool neighbours) {
  std::vector<std::uint32_t> out;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if ((neighbours ? i * count / frames.size() : i % count) == index) out.push_back(frames[i]);
  return out;
}

/// The key of a picture with motion blur: the key of its first slice of time, and the shutter.
RenderKey key_of_slices(const RenderOptions& o, Sequence& sequence, FrameMoment first, RenderSettings settings) {
  sequence.set_moment(first, settings);
  settings.slice = {};
  settings.photon_stream = 0;
  const Scene& scene = *sequence.scene_at(first).scene;
  RenderKey key = render_key(scene, resolve(settings, scene));
  key.push_back({"--shutter", o.sequence.shutter.empty() ? "of the file" : o.sequence.shutter});
  return key;
}

/// The first of some slices of time that a checkpoint leaves something to do of, or the last.
/// @param each settings of the slices, resolved
std::size_t slice_to_resume(const std::string& file, const std::vector<RenderSettings>& each) {
  const std::optional<Checkpoint> made = file.empty() ? std::nullopt : read_key_of_checkpoint(file);
  std::size_t i = 0;
  // The key of a checkpoint is that of the slice that it was written in.
  while (made && i + 1 < each.size() && each[i].slice_range().end - each[i].sample_range().first <= made->passes) ++i;
  return i;
}

/// Learns what moments with the light of the first one are guided by, in the scene at that moment: once, and only where
/// more than the camera moves.
int learn_guides(RenderOptions o, Opened& shown, Sequence& sequence, OutputFiles& files, TevStream& tev, Kept& kept) {
  const bool learns = sequence.changes() && o.settings.integrator != Integrator::path;
  if (!learns || kept.guides || !sequence.starts_lit()) return 0;
  const LitScene& lit = sequence.scene_at({0, 0});
  shown.scene = lit.scene;
  shown.tracer = lit.tracer;
  sequence.set_moment({0, 0}, o.settings);
  o.settings.only_maps = true;
  o.resume.clear();
  const int status = render_picture(o, shown, files, tev, nullptr, &kept, Purpose::maps);
  shown.load_s = shown.build_s = 0;
  if (status == 0) kept.guides = *kept.maps;
  return status;
}

/// Makes what is kept fit another scene than that of the job before.
/// @param begins whether the job is the first of its picture
void change_scene(const LitScene& lit, bool begins, Kept& kept) {
  const bool is_guided = lit.as_at_first && kept.guides;
  if (begins && !is_guided) kept.maps.reset();
  if (!kept.maps) return;
  JobGuides learned = is_guided ? *kept.guides : JobGuides();
  if (!begins) {
    learned.numbers = kept.maps->numbers;
    learned.photon_variance = kept.maps->photon_variance;
  }
  kept.maps->change_scene(std::move(learned));
}

/// Renders one frame, or one picture with motion blur: each slice of time adds its samples to the film.
/// @param o of the frame @param shown the scene that `kept` is of, and then the last one
/// @param purpose of the frame: picture or light
int render_moments(RenderOptions o, Opened& shown, Sequence& sequence, std::uint32_t number, OutputFiles& files,
                   TevStream& tev, Kept& kept, Purpose purpose = Purpose::picture) {
  const std::vector<FrameMoment> moments = sequence.moments(number);
  const RenderSettings settings = o.settings, resolved = resolve(settings, *shown.scene);
  if (moments.front().slice > 0 && !settings.part.is_all())
    o.key = key_of_slices(o, sequence, moments.front(), settings);
  std::vector<RenderSettings> each, ranges;
  std::vector<FrameMoment> rendered;
  for (const FrameMoment moment : moments) {
    RenderSettings own = settings;
    sequence.set_moment(moment, own);
    ranges.push_back(resolved);
    ranges.back().slice = own.slice;
    // A part of the render may have no samples of it.
    if (ranges.back().slice_range().count() > 0) {
      each.push_back(own);
      rendered.push_back(moment);
    } else {
      ranges.pop_back();
    }
  }
  shown.start = Clock::now();
  const std::size_t first = slice_to_resume(o.resume, ranges);
  if (const int status = learn_guides(o, shown, sequence, files, tev, kept); status != 0) return status;
  for (std::size_t i = first; i < rendered.size(); ++i) {
    const LitScene& lit = sequence.scene_at(rendered[i]);
    if (shown.scene != lit.scene) {
      change_scene(lit, i == first, kept);
      shown.scene = lit.scene;
      shown.tracer = lit.tracer;
    }
    o.settings = each[i];
    const bool goes_on = i + 1 < rendered.size();
    const Purpose now = goes_on ? Purpose::slice : purpose;
    if (const int status = render_picture(o, shown, files, tev, nullptr, &kept, now); status != 0) return status;
    shown.load_s = shown.build_s = 0;
    // The errors of photons of several moments average.
    if (i == first && goes_on && each[i].photon_stream > 0)
      *kept.maps->photon_variance /= static_cast<double>(rendered.size());
  }
  // The mean over the moments of this frame is not the variance of the next.
  if (kept.maps && rendered.size() > 1 && each.front().photon_stream > 0) kept.maps->photon_variance.reset();
  return 0;
}

/// Light of frames by their numbers.
using FrameLights = std::map<std::uint32_t, std::shared_ptr<const FrameLight>>;

/// Renders a frame, or one picture with motion blur. If that shall end by noise or time, tries find the samples.
int render_frame(RenderOptions o, Opened& shown, Sequence& sequence, std::uint32_t number, OutputFiles& files,
                 TevStream& tev, Kept& kept) {
  RenderSettings& s = o.settings;
  const bool open_ended = s.noise_target > 0 || s.time_limit_s > 0;
  if (!open_ended || sequence.moments(number).front().slice == 0)
    return render_moments(o, shown, sequence, number, files, tev, kept);
  kept.goal =
      BlurGoal{s.noise_target, s.time_limit_s, Clock::now(), {}, 0, s.samples > 0 ? s.samples : Film::kMaxSamples};
  s.photon_target = resolve(s, *shown.scene).photon_target;
  s.noise_target = s.time_limit_s = 0;
  s.samples = std::min(kept.goal->most, kMostSlices);
  int status = 0;
  do {
    kept.goal->samples = s.samples;
    kept.goal->begun = Clock::now();
    status = render_moments(o, shown, sequence, number, files, tev, kept);
    s.samples = kept.goal->next;
  } while (status == 0 && kept.goal->next > 0);
  kept.goal.reset();
  return status;
}

/// Finds the light that a frame uses again, and renders what is missing of it.
/// @param lights of earlier frames, and then also of those @param o of the frame
int find_earlier_light(RenderOptions& o, Opened& shown, Sequence& sequence, std::uint32_t number, OutputFiles& files,
                       TevStream& tev, Kept& kept, FrameLights& lights) {
  const std::uint32_t first = number - std::min(number, o.sequence.reuse);
  std::erase_if(lights, [&](const auto& entry) { return entry.first < first || entry.first >= number; });
  std::vector<std::shared_ptr<const FrameLight>> earlier;
  for (std::uint32_t before = first; before < number; ++before) {
    if (!sequence.shares_light(number, before)) continue;
    if (!lights.contains(before)) {
      detail(fmt::format("frame {} is rendered for its light", before));
      const int status = render_moments(o, shown, sequence, before, files, tev, kept, Purpose::light);
      if (status != 0) return status;
      lights[before] = kept.light;
    }
    earlier.push_back(lights[before]);
  }
  o.earlier = std::move(earlier);
  return 0;
}

/// Takes the memory of the light of earlier frames from each frame's.
void reserve_light(RenderOptions& o, const Scene& scene, const std::vector<std::uint32_t>& numbers) {
  if (o.sequence.reuse == 0 || numbers.empty()) return;
  // One more for the frame itself.
  const std::uint64_t frames = std::min(o.sequence.reuse, numbers.back()) + 1;
  const std::uint64_t bytes = frames * kFrameLightBytes * resolve(o.settings, scene).bounds.pixel_count();
  if (bytes >= o.settings.memory_bytes)
    throw Error("the light of --reuse does not fit into memory", "Give fewer frames, or a larger --memory.",
                ErrorCode::memory);
  o.settings.memory_bytes -= bytes;
}

/// Renders frames, those that are there already apart. Frames in the same light share their photons and guides.
int render_frames(RenderOptions& o, const Opened& opened, Sequence& sequence, const std::vector<std::uint32_t>& numbers,
                  OutputFiles& files, TevStream& tev) {
  Kept kept;
  FrameLights lights;
  Opened shown = opened;
  reserve_light(o, *opened.scene, numbers);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    RenderOptions frame = options_of_frame(o, numbers[i]);
    if (is_done(frame)) {
      inform(fmt::format("frame {} exists, and is not rendered again", numbers[i]));
      continue;
    }
    inform(fmt::format("frame {} ({} of {})", numbers[i], i + 1, numbers.size()));
    const std::uint32_t number = numbers[i];
    int status = find_earlier_light(frame, shown, sequence, number, files, tev, kept, lights);
    if (status == 0) status = render_frame(frame, shown, sequence, number, files, tev, kept);
    if (status != 0) return status;
    if (o.sequence.reuse > 0) lights[number] = kept.light;
  }
  return 0;
}

/// Why a picture, or the frames, cannot have motion blur; "" if they can.
std::string reason_against_blur(const RenderOptions& o, bool has_ranks) {
  const bool open_ended = o.settings.time_limit_s > 0 || o.settings.noise_target > 0;
  if (open_ended && (o.resumes || !(o.settings.part.is_all() || o.sequence.is_given())))
    return "--time and --noise find the number of samples by tries, so they do not go with --resume or --part";
  if (has_ranks && !o.sequence.is_given())
    return "ranks divide the frames of a sequence, but not one picture; --part I/N and 'glowworm merge' do";
  return "";
}

}  // namespace

void check_blur(const RenderOptions& o, SceneMotion* motion, bool has_ranks) {
  const std::string reason = reason_against_blur(o, has_ranks);
  if (reason.empty()) return;
  const bool asked = !o.sequence.shutter.empty() && parse_shutter(o.sequence.shutter) != Shutter();
  if (asked) throw CommandLineError("no motion blur: " + reason, "Leave out --shutter, or what it does not go with.");
  if (motion && motion->slice_count() > 0) {
    inform("note: no motion blur: " + reason);
    motion->shutter.reset();
  }
}

Sequence sequence_of(RenderOptions& o, const Opened& opened, const std::shared_ptr<SceneMotion>& motion) {
  const auto open_at = [&o, import_options = opened.import, named = opened.named](double seconds) {
    SceneChanges changes = o.changes.changes;
    changes.moment.seconds = seconds;
    std::string camera = o.settings.camera;
    return scene_of_view(open_scene(o.scene, import_options, changes), o.lights, o.view, camera, named.get());
  };
  return Sequence(o.sequence, opened.scene, opened.tracer, o.settings, motion, open_at);
}

int render_blurred(const RenderOptions& o, const Opened& opened, Sequence& sequence, OutputFiles& files,
                   TevStream& tev) {
  Kept kept;
  Opened shown = opened;
  return render_frame(o, shown, sequence, 0, files, tev, kept);
}

int render_sequence(RenderOptions& o, const Opened& opened, OutputFiles& files, TevStream& tev,
                    const std::shared_ptr<SceneMotion>& motion, const std::shared_ptr<Ranks>& ranks) {
  Sequence sequence = sequence_of(o, opened, motion);
  const SampleShare part = std::exchange(o.settings.part, {});
  std::vector<std::uint32_t> numbers = sequence.numbers();
  if (!part.is_all()) numbers = share_of(numbers, part.index - 1, part.count, o.sequence.reuse > 0);
  const bool helps = ranks && ranks->rank() > 0;
  for (const std::uint32_t number : numbers)
    if (!helps) prepare_outputs(options_of_frame(o, number), files);
  std::optional<Movie> movie;
  if (o.movie && !helps) movie.emplace(*o.movie, o.names, o.sequence.frames_per_second);
  const bool any_png = std::any_of(o.outputs.begin(), o.outputs.end(),
                                   [](const Output& output) { return output.format == OutputFormat::png; });
  if (any_png && !o.picture.exposure) o.picture.exposure = sequence.exposure(o.settings);
  const std::vector<std::uint32_t> own = ranks
                                             ? share_of(numbers, static_cast<std::size_t>(ranks->rank()),
                                                        static_cast<std::size_t>(ranks->count()), o.sequence.reuse > 0)
                                             : numbers;
  int status = render_frames(o, opened, sequence, own, files, tev);
  if (helps) {
    report_end(*ranks);
    return status;
  }
  if (ranks)
    for (const std::string& failure : wait_for_ends(*ranks, [] { return caught_interrupt() != 0; })) {
      warn(failure);
      status = std::max(status, 1);
    }
  if (movie && status == 0) {
    movie->write(numbers);
    inform(fmt::format("wrote {}", movie->path()));
  }
  return status;
}

}  // namespace glowworm
