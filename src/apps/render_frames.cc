#include "apps/render_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <utility>

#include "apps/commands.h"
#include "apps/interrupt.h"
#include "apps/open_scene.h"
#include "control/scheduler.h"
#include "core/disk_memory.h"
#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"
#include "film/checkpoint.h"
#include "film/part.h"
#include "session/command_text.h"
#include "settings/settings.h"
#include "share/crew.h"

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

/// Takes memory from a render. Throws Error if there is too little.
void set_aside(RenderSettings& settings, std::uint64_t bytes, const char* what) {
  if (bytes >= settings.memory_bytes)
    throw Error(fmt::format("{} does not fit into memory", what), "Give a larger --memory.", ErrorCode::memory);
  settings.memory_bytes -= bytes;
}

/// Pieces of the samples of each slice of time: enough for all ranks, if there are so many samples.
std::uint32_t pieces_of_slice(const RenderSettings& s, std::uint32_t slices, int ranks) {
  const auto groups = [slices](std::uint32_t n, std::uint32_t most_of_slice) {
    const std::uint64_t most = std::uint64_t{slices} * most_of_slice;
    return static_cast<std::uint32_t>((n + most - 1) / most);
  };
  // Films of several samples hold all ids of their pixels only if they have few samples.
  const std::uint32_t for_ids = groups(s.samples, most_shared_samples(s));
  return std::max(for_ids, std::min(groups(static_cast<std::uint32_t>(ranks), 1), s.samples / slices));
}

/// Divides pieces (SharedWork::divide()) until Ctrl-C, which leaves none half done. Returns whether all are done.
bool divide_until_interrupt(SharedWork& sharers, const char* name, std::size_t count, const SharedWork::Make& make,
                            const SharedWork::Take& take) {
  const Interrupt never;
  const CancellationScope scope(signal_interrupt());
  try {
    const auto make_whole = [&](std::size_t piece) {
      const CancellationScope whole(never);
      return make(piece);
    };
    const auto take_whole = [&](std::size_t piece, std::span<const std::byte> bytes) {
      const CancellationScope whole(never);
      take(piece, bytes);
    };
    sharers.divide(name, count, make_whole, take_whole);
    return true;
  } catch (const Cancelled&) {
    return false;
  }
}

/// The first frame whose light counts in the noise of a frame. Every (--reuse + 1)-th frame reaches --noise by its own
/// light: the bits of a frame would otherwise depend on all before.
std::uint32_t first_tested(const RenderOptions& o, std::uint32_t number) {
  return o.settings.noise_target > 0 ? number - number % (o.sequence.reuse + 1) : number;
}

/// Renders frames, or one picture with motion blur. Those in the same light share their photons and guides.
class FrameRenderer {
 public:
  /// @param opened the scene to begin with @param ranks that share the work; null: none
  FrameRenderer(const Opened& opened, Sequence& sequence, OutputFiles& files, TevStream& tev, const Ranks* ranks)
      : sequence_(sequence),
        files_(files),
        tev_(tev),
        shown_(opened),
        helps_(ranks && ranks->rank() > 0),
        rank_count_(ranks ? ranks->count() : 1) {}

  /// Renders a frame, or one picture with motion blur. If that shall end by noise or time, tries find the samples.
  /// Returns the exit status. @param o of the frame
  /// @param sharers divide the slices of time of one picture; null: none
  int render_frame(RenderOptions o, std::uint32_t number, SharedWork* sharers = nullptr) {
    RenderSettings& s = o.settings;
    const bool open_ended = s.noise_target > 0 || s.time_limit_s > 0;
    if (!open_ended || sequence_.moments(number).front().slice == 0)
      return render_moments(o, number, Purpose::picture, sharers);
    kept_.goal =
        BlurGoal{s.noise_target, s.time_limit_s, Clock::now(), {}, 0, s.samples > 0 ? s.samples : Film::kMaxSamples};
    s.photon_target = resolve(s, *shown_.scene).photon_target;
    s.noise_target = s.time_limit_s = 0;
    s.samples = std::min(kept_.goal->most, kMostSlices);
    int status = 0;
    do {
      kept_.goal->samples = s.samples;
      kept_.goal->begun = Clock::now();
      status = render_moments(o, number, Purpose::picture);
      s.samples = kept_.goal->next;
    } while (status == 0 && kept_.goal->next > 0);
    kept_.goal.reset();
    return status;
  }

  /// Renders some of the frames, those that are there already apart. Returns the exit status.
  /// @param all frames that are rendered, here or by others
  int render_frames(const RenderOptions& o, std::span<const std::uint32_t> numbers,
                    const std::vector<std::uint32_t>& all) {
    for (const std::uint32_t number : numbers) {
      RenderOptions frame = options_of_frame(o, number);
      if (is_done(frame)) {
        inform(fmt::format("frame {} exists, and is not rendered again", number));
        continue;
      }
      const auto place = std::find(all.begin(), all.end(), number) - all.begin();
      inform(fmt::format("frame {} ({} of {})", number, place + 1, all.size()));
      const std::uint32_t first = number - std::min(number, o.sequence.reuse);
      std::erase_if(lights_,
                    [&](const auto& light) { return light.first < first_tested(o, first) || light.first >= number; });
      int status = find_earlier_light(frame, number, first);
      if (status == 0) status = render_frame(frame, number);
      if (status != 0) return status;
      if (o.sequence.reuse > 0) lights_[number] = kept_.light;
    }
    return 0;
  }

 private:
  /// What is rendered of a frame.
  struct Moments {
    std::vector<FrameMoment> rendered;       ///< the frame's own, or those of slices of time
    std::vector<RenderSettings> each;        ///< settings of these
    std::vector<RenderSettings> of_samples;  ///< resolved settings of the frame, with these slices
  };

  int render(const RenderOptions& o, Purpose purpose) {
    const int status = render_picture(o, shown_, files_, tev_, nullptr, &kept_, purpose);
    shown_.load_s = shown_.build_s = 0;
    return status;
  }

  /// Learns what moments with the light of the first one are guided by, in the scene at that moment: once, and only
  /// where more than the camera moves. Returns false if Ctrl-C ends it.
  bool learn_guides(RenderOptions o) try {
    const bool learns = sequence_.changes() && o.settings.integrator != Integrator::path;
    if (!learns || kept_.guides || !sequence_.starts_lit()) return true;
    const LitScene& lit = sequence_.scene_at({0, 0});
    shown_.scene = lit.scene;
    shown_.tracer = lit.tracer;
    sequence_.set_moment({0, 0}, o.settings);
    o.settings.only_maps = true;
    o.resume.clear();
    render(o, Purpose::maps);
    kept_.guides = *kept_.maps;
    return true;
  } catch (const Cancelled&) {
    return false;
  }

  /// Shows a moment; makes what is kept fit another scene than that of the job before.
  /// @param begins whether the job is the first of its picture
  void show(FrameMoment moment, bool begins) {
    const LitScene& lit = sequence_.scene_at(moment);
    if (shown_.scene == lit.scene) return;
    shown_.scene = lit.scene;
    shown_.tracer = lit.tracer;
    const bool is_guided = lit.as_at_first && kept_.guides;
    if (begins && !is_guided) kept_.maps.reset();
    if (!kept_.maps) return;
    JobGuides learned = is_guided ? *kept_.guides : JobGuides();
    if (!begins) {
      learned.numbers = kept_.maps->numbers;
      learned.photon_variance = kept_.maps->photon_variance;
    }
    kept_.maps->change_scene(std::move(learned));
  }

  /// The moments of a frame that have samples. @param o its key is set for a part of a picture with motion blur
  Moments moments_of(RenderOptions& o, std::uint32_t number) {
    const std::vector<FrameMoment> all = sequence_.moments(number);
    const RenderSettings resolved = resolve(o.settings, *shown_.scene);
    if (all.front().slice > 0 && !o.settings.part.is_all())
      o.key = key_of_slices(o, sequence_, all.front(), o.settings);
    Moments out;
    for (const FrameMoment moment : all) {
      RenderSettings own = o.settings, of_samples = resolved;
      sequence_.set_moment(moment, own);
      of_samples.slice = own.slice;
      // A part of the render may have no samples of it.
      if (of_samples.slice_range().count() == 0) continue;
      out.rendered.push_back(moment);
      out.each.push_back(own);
      out.of_samples.push_back(of_samples);
    }
    return out;
  }

  /// Renders one frame, or one picture with motion blur: each slice of time adds its samples to the film.
  /// @param o of the frame @param purpose of the frame: picture or light
  int render_moments(RenderOptions o, std::uint32_t number, Purpose purpose, SharedWork* sharers = nullptr) {
    const Moments moments = moments_of(o, number);
    const std::size_t count = moments.rendered.size();
    shown_.start = Clock::now();
    std::size_t first = slice_to_resume(o.resume, moments.of_samples);
    // If all slices are done, the last job has no samples to take, and finishes the picture.
    if (sharers) first = std::min(share_moments(o, moments, *sharers), count - 1);
    if (sharers && helps_) return 0;
    if (!learn_guides(o)) return end_without_picture(o);
    for (std::size_t i = first; i < count; ++i) {
      show(moments.rendered[i], i == first && !sharers);
      o.settings = moments.each[i];
      const bool goes_on = i + 1 < count;
      if (const int status = render(o, goes_on ? Purpose::slice : purpose); status != 0) return status;
      // The errors of photons of several moments average.
      if (i == first && goes_on && !sharers && moments.each[i].photon_stream > 0)
        *kept_.maps->photon_variance /= static_cast<double>(count);
    }
    // The mean over the moments of this frame is not the variance of the next.
    if (kept_.maps && count > 1 && moments.each.front().photon_stream > 0) kept_.maps->photon_variance.reset();
    return 0;
  }

  /// Divides the samples of all slices of time among ranks; rank 0 keeps them for the next job. Returns the first slice
  /// that is not whole, if Ctrl-C ends the work before.
  std::size_t share_moments(RenderOptions o, const Moments& moments, SharedWork& sharers) {
    const RenderSettings& s = moments.of_samples.front();
    const std::uint64_t bytes =
        Film::bytes(s.bounds, s.separate_layers, s.place_layers(), filters(s), s.light_group_count);
    const std::unique_ptr<DiskMemory> disk = DiskMemory::for_arrays(s.disk, bytes, s.memory_bytes / 3);
    const std::uint32_t slices = moments.each.front().slice.count,
                        pieces_each = pieces_of_slice(s, slices, rank_count_);
    const auto part_of = [&](std::size_t piece) {
      const std::uint32_t slice = moments.each[piece / pieces_each].slice.index;
      return SampleShare{(slice - 1) * pieces_each + static_cast<std::uint32_t>(piece % pieces_each) + 1,
                         slices * pieces_each};
    };
    const std::size_t pieces = moments.rendered.size() * pieces_each;
    std::optional<Film> sum;
    std::size_t added = 0;
    bool begins = true;
    const RenderOptions whole = o;
    o.preview = false;
    const auto make = [&](std::size_t piece) {
      const std::size_t i = piece / pieces_each;
      if (!learn_guides(whole)) throw Cancelled();
      show(moments.rendered[i], std::exchange(begins, false));
      o.settings = moments.each[i];
      o.settings.part = part_of(piece);
      if (!disk) set_aside(o.settings, bytes, "the film of all slices of time");
      kept_.part = {static_cast<double>(added) / static_cast<double>(pieces), 1 / static_cast<double>(pieces)};
      render(o, Purpose::share);
      const Film film = *std::exchange(kept_.maps->rows, std::nullopt);
      if (piece == 0) {  // rank 0 makes it
        const DiskMemory::Scope scope(disk.get());
        sum = film.like(film.bounds());
        if (o.settings.photon_stream > 0) *kept_.maps->photon_variance /= static_cast<double>(moments.rendered.size());
      }
      return packed_film(film);
    };
    const auto take = [&](std::size_t piece, std::span<const std::byte> film) {
      const PixelBounds& all = sum->bounds();
      RenderSettings part = s;
      part.part = part_of(piece);
      unpack_film(film, {all.x0, all.y0, all.x1, all.y1, 0, part.sample_range().end}, *sum);
      ++added;
    };
    divide_until_interrupt(sharers, "slices", pieces, make, take);
    if (sum) kept_.maps->rows = std::move(sum);
    return added / pieces_each;
  }

  /// Finds the light that a frame uses again, and renders what is missing of it.
  /// @param o of the frame @param first frame to use
  int find_earlier_light(RenderOptions& o, std::uint32_t number, std::uint32_t first) {
    o.earlier.clear();
    o.tested = 0;
    for (std::uint32_t before = first; before < number; ++before) {
      if (!sequence_.shares_light(number, before)) continue;
      if (const int status = make_light(o, before); status != 0) return status;
      o.earlier.push_back(lights_[before]);
      if (before >= first_tested(o, number)) ++o.tested;
    }
    return 0;
  }

  /// Renders the light of a frame, unless it is there.
  int make_light(RenderOptions o, std::uint32_t number) {
    if (lights_.contains(number)) return 0;
    if (const int status = find_earlier_light(o, number, first_tested(o, number)); status != 0) return status;
    detail(fmt::format("frame {} is rendered for its light", number));
    if (const int status = render_moments(o, number, Purpose::light); status != 0) return status;
    lights_[number] = kept_.light;
    return 0;
  }

  Sequence& sequence_;
  OutputFiles& files_;
  TevStream& tev_;
  Opened shown_;  // the scene that kept_ is of
  bool helps_;    // another rank has the pictures
  int rank_count_;
  Kept kept_;
  std::map<std::uint32_t, std::shared_ptr<const FrameLight>> lights_;  // of frames by their numbers
};

/// Divides work among ranks, if there are some. Returns the exit status, which is rank 0's alone to tell.
/// @param settings that all ranks must have
int by_ranks(const std::shared_ptr<Ranks>& ranks, const Scene& scene, const RenderSettings& settings,
             const std::function<int(SharedWork*)>& work) {
  if (!ranks) return work(nullptr);
  const RenderKey key = render_key(scene, resolve(settings, scene));
  if (ranks->rank() > 0) {
    RankWorker worker(ranks);
    worker.introduce(key);
    work(&worker);
    return 0;
  }
  Crew crew(ranks);
  crew.check(key);
  const int status = work(&crew);
  dismiss_ranks(crew, *ranks, status);
  return status;
}

/// Renders the frames, or divides them. Returns the exit status.
int share_frames(const RenderOptions& o, FrameRenderer& renderer, const std::vector<std::uint32_t>& numbers,
                 int rank_count, SharedWork* sharers) {
  if (!sharers) return renderer.render_frames(o, numbers, numbers);
  const std::size_t pieces = o.sequence.reuse > 0 ? static_cast<std::size_t>(rank_count) : numbers.size();
  const auto make = [&](std::size_t piece) {
    const std::vector<std::uint32_t> own = share_of(numbers, piece, pieces, true);
    const int status = renderer.render_frames(o, own, numbers);
    if (caught_interrupt()) throw Cancelled();
    if (status != 0) {
      const auto missing = std::find_if(own.begin(), own.end() - 1,
                                        [&](std::uint32_t number) { return !is_done(options_of_frame(o, number)); });
      throw Error(fmt::format("frame {} has no picture", *missing),
                  "Give a longer --time. Frames whose files exist are not rendered again.");
    }
    return std::vector<std::byte>();
  };
  const bool all =
      divide_until_interrupt(*sharers, "frames", pieces, make, [](std::size_t, std::span<const std::byte>) {});
  return all ? 0 : kExitSignalled + caught_interrupt();
}

}  // namespace

void check_blur(const RenderOptions& o, bool has_ranks) {
  const bool open_ended = o.settings.time_limit_s > 0 || o.settings.noise_target > 0;
  const bool is_part = !o.settings.part.is_all();
  std::string reason;
  if (open_ended && (o.resumes || is_part || has_ranks))
    reason = "--time and --noise find the number of samples by tries, so they do not go with --resume, --part or ranks";
  else if (has_ranks && (o.resumes || is_part))
    reason = "ranks divide the slices of time, so they do not go with --resume or --part";
  if (!reason.empty())
    throw CommandLineError("no motion blur: " + reason,
                           o.sequence.shutter.empty()
                               ? "Leave out what does not go with the shutter of the file, or give --shutter 0."
                               : "Leave out --shutter, or what it does not go with.");
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

int render_blurred(const RenderOptions& o, const Opened& opened, Sequence& sequence, OutputFiles& files, TevStream& tev,
                   const std::shared_ptr<Ranks>& ranks) {
  check_blur(o, ranks != nullptr);
  return by_ranks(ranks, *opened.scene, o.settings, [&](SharedWork* sharers) {
    return FrameRenderer(opened, sequence, files, tev, ranks.get()).render_frame(o, 0, sharers);
  });
}

int render_sequence(RenderOptions& o, const Opened& opened, OutputFiles& files, TevStream& tev,
                    const std::shared_ptr<SceneMotion>& motion, const std::shared_ptr<Ranks>& ranks) {
  Sequence sequence = sequence_of(o, opened, motion);
  const SampleShare part = o.sequence.part;
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
  if (o.sequence.reuse > 0 && !numbers.empty()) {
    // One more for the frame itself, and with --noise those by which frames before were tested.
    const std::uint64_t before = std::uint64_t{o.sequence.reuse} * (o.settings.noise_target > 0 ? 2 : 1);
    const std::uint64_t frames = std::min<std::uint64_t>(before, numbers.back()) + 1;
    const std::size_t pixels = resolve(o.settings, *opened.scene).bounds.pixel_count();
    set_aside(o.settings, frames * kFrameLightBytes * pixels, "the light of --reuse");
  }
  FrameRenderer renderer(opened, sequence, files, tev, ranks.get());
  const int status = by_ranks(ranks, *opened.scene, o.settings, [&](SharedWork* sharers) {
    return share_frames(o, renderer, numbers, ranks ? ranks->count() : 1, sharers);
  });
  if (movie && status == 0) {
    movie->write(numbers);
    inform(fmt::format("wrote {}", movie->path()));
  }
  return status;
}

}  // namespace glowworm
