#include "settings/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/memory_budget.h"
#include "core/parallel.h"
#include "gather/direct_light.h"
#include "photon/material_lobes.h"
#include "scene/light_groups.h"
#include "scene/scene.h"
#include "settings/cost.h"
#include "settings/options.h"

namespace glowworm {

namespace {

constexpr std::uint64_t kMemoryStep = std::uint64_t{64} << 20;
/// Most camera samples of a render that ends by time or noise.
constexpr std::uint32_t kOpenEndedSamples = 1u << 20;
/// Camera samples of a path-traced pixel, where the file does not say.
constexpr std::uint32_t kDefaultPathSamples = 256;
/// Photons of a map for each gather ray of a pixel, times the root of the number of pixels. The bias of 8 x 8 pixels
/// falls with the photons and their noise with the rays of a pixel; for a given time, their sum is least where photons
/// grow so. The noise of points is not averaged with that of neighbours, so that they need fewer.
constexpr double kPhotonsOfRays = 16, kPhotonsOfRaysOfPoint = 2;
/// The least number is for a room lit through a door, where the noise of one map is wider than the filter and covers
/// the whole picture, and for blinds, between which wider radii let light leak. The largest number fits into the memory
/// of most machines.
constexpr double kMinPhotons = 500'000, kMostPhotons = 4'000'000;
/// A photon takes about as long as this number of gather rays. Where kMinPhotons would take longer than all rays of a
/// picture, it has fewer, but at least kFewPhotons: with 50,000, light leaks between blinds (5% too bright).
constexpr double kRaysInTimeOfPhoton = 2, kFewPhotons = 250'000;
/// Photons of a sample of the path tracer: this number, unless there are so many samples that all together have the
/// second one, and at least this multiple of k. Their maps cost as much as paths, and few photons blur the light.
constexpr double kPhotonsOfPaths = 50'000, kAllPhotonsOfPaths = 3'200'000, kMinMapOfPaths = 20;
/// Photons of a sample of few points, at which they are aimed: this number, or k for each point.
constexpr double kPhotonsOfPoints = 1562;
/// Photons of an estimate: radii hold so many. Points by paths take fewer: thousands of maps average the noise, but all
/// have the same blur.
constexpr std::uint32_t kNearest = 50, kNearestOfPoints = 20;
/// A render with a time limit makes its first image within this share of it, on a machine with this number of cores. It
/// is a constant because the choice must not depend on the machine.
constexpr double kFirstImageShare = 0.25, kReckonedCores = 4;

void resolve_size(RenderSettings& s, const Scene& scene) {
  if (s.width == 0 && s.height == 0) {
    constexpr int kLongerSide = 512;
    const float aspect = scene.camera(s.camera).aspect;
    const auto side = [](float share) { return std::max(static_cast<int>(std::lround(kLongerSide * share)), 1); };
    const bool is_shaped = aspect > 0 && scene.film().width == 0 && scene.film().height == 0;
    s.width = scene.film().width > 0 ? scene.film().width : side(is_shaped ? std::min(aspect, 1.0f) : 1);
    s.height = scene.film().height > 0 ? scene.film().height : side(is_shaped ? std::min(1 / aspect, 1.0f) : 1);
  }
  if (s.width < 1 || s.height < 1 || s.width > kMaxPictureSide || s.height > kMaxPictureSide)
    throw Error(fmt::format("a picture of {}x{} pixels cannot be rendered", s.width, s.height),
                fmt::format("Give --size WxH with both from 1 to {}.", kMaxPictureSide));
}

/// The pixels to render: those asked for, or else those that the file asks for.
PixelBounds resolved_bounds(const RenderSettings& s, const FilmRequest& film) {
  const PixelBounds all{0, 0, s.width, s.height};
  PixelBounds wanted = s.bounds;
  std::string what = "--pixel-bounds";
  if (wanted.empty()) {
    what = s.crop.empty() ? "the crop of the file" : "--crop";
    const CropWindow of_file{film.crop[0], film.crop[2], film.crop[1], film.crop[3]};
    wanted = (s.crop.empty() ? of_file : s.crop).pixels(s.width, s.height);
  }
  const PixelBounds out{std::max(wanted.x0, 0), std::max(wanted.y0, 0), std::min(wanted.x1, all.x1),
                        std::min(wanted.y1, all.y1)};
  if (out.empty())
    throw Error(fmt::format("{} holds no pixel of a picture of {}x{}", what, s.width, s.height),
                "Give a larger part, or --crop 0,0,1,1 for the whole picture.");
  return out;
}

double pixel_count(const RenderSettings& s) { return static_cast<double>(s.width) * static_cast<double>(s.height); }

void resolve_gather(RenderSettings& s) {
  double gather = s.default_gather;
  if (s.time_limit_s > 0) {
    const double queries = s.time_limit_s * kFirstImageShare * kReckonedCores / kUsualCost.ray_s;
    gather = std::min(gather, queries / pixel_count(s));
  }
  s.gather = static_cast<std::uint32_t>(std::max(gather, 1.0));
}

/// The share that a map gets of the usual photons.
/// A pass of a progressive render has half, since passes average the noise of their maps.
double photon_share(const RenderSettings& s) { return s.progressive ? 0.5 : 1; }

/// Samples of the usual number of gather rays.
double usual_samples(const RenderSettings& s) {
  return std::max(kDefaultSamples, kDefaultSamples * kDefaultGather / s.gather);
}

/// Gather rays for which a map has photons: those of the samples, or of the time where that alone ends the render.
/// Passes of progressive renders, and renders that end by noise, have no more than those of the usual samples.
double gather_rays(const RenderSettings& s) {
  const bool is_open = s.samples == kOpenEndedSamples;
  const bool ends_by_time = is_open && s.time_limit_s > 0 && !(s.noise_target > 0);
  if (ends_by_time && !s.progressive) return s.time_limit_s * kReckonedCores / kUsualCost.ray_s;
  const bool grows = !s.progressive && !is_open;
  return pixel_count(s) * s.gather * (grows ? s.samples : std::min<double>(s.samples, usual_samples(s)));
}

double most_photons(const RenderSettings& s) { return photon_share(s) * kMostPhotons; }

double least_photons(const RenderSettings& s) {
  if (s.of_points || s.progressive) return kMinPhotons;
  return std::clamp(gather_rays(s) / kRaysInTimeOfPhoton, kFewPhotons, kMinPhotons);
}

void resolve_photons(RenderSettings& s) {
  const double of_rays = s.of_points ? kPhotonsOfRaysOfPoint : kPhotonsOfRays;
  double photons = std::clamp(photon_share(s) * of_rays * gather_rays(s) / std::sqrt(pixel_count(s)), least_photons(s),
                              most_photons(s));
  if (s.time_limit_s > 0)
    photons = std::min(photons, s.time_limit_s * kFirstImageShare * kReckonedCores / kUsualCost.photon_s);
  s.photons = std::max(two_digits(photons), kLeastPhotons);
}

/// A path tracer has photons for light that no path finds. Each sample has new ones, so that the spread of the samples
/// contains their noise.
void resolve_photons_of_paths(RenderSettings& s, const Scene& scene) {
  s.photons = s.thinned = 0;
  if (!bends_delta_lights(scene)) return;
  s.progressive = true;
  s.fixed_radius = false;
  s.engine = engine_traits(kAutomaticEngine).name;
  s.nearest = s.of_points ? kNearestOfPoints : kNearest;
  // Renders with an open end may stop after a few samples.
  const double samples = s.samples == kOpenEndedSamples ? kDefaultPathSamples : s.samples;
  double least = std::clamp(kAllPhotonsOfPaths / samples, kMinMapOfPaths * kNearest, kPhotonsOfPaths);
  if (s.of_points) least = std::min(least, std::max(kPhotonsOfPoints, kNearest * pixel_count(s)));
  s.photons = static_cast<std::uint64_t>(std::min(std::max(pixel_count(s), least), kMostPhotons));
}

/// Whether the noise of the first photons decides how many there are. A render with a time limit takes as many as there
/// is time for, and a progressive render has new ones for every sample.
bool chooses_photons_by_noise(const RenderSettings& s) {
  return s.integrator == Integrator::gather && s.photons == 0 && s.thinned == 0 && s.time_limit_s <= 0 &&
         !s.progressive && !s.of_points;
}

/// The samples of a share of all.
SampleRange range_of(const SampleShare& share, std::uint64_t samples) {
  if (share.is_all()) return {0, static_cast<std::uint32_t>(samples)};
  const auto until = [&](std::uint64_t shares) { return static_cast<std::uint32_t>(samples * shares / share.count); };
  return {until(share.index - 1), until(share.index)};
}

/// Throws Error for settings under which light cannot be kept apart.
void check_light_groups(const RenderSettings& s) {
  std::string reason;
  if (s.integrator != Integrator::path && engine_traits(s.engine).takes_nearest)
    reason = fmt::format("--engine {} looks for the nearest photons of all lights", s.engine);
  else if (s.thinned > 0)
    reason = "--thinned joins photons of several lights";
  else if (s.indirect_only)
    reason = "--indirect-only shows a part of the light";
  if (!reason.empty())
    throw Error(fmt::format("--light-groups cannot keep lights apart: {}", reason), "Leave one of the two out.");
}

}  // namespace

std::uint64_t two_digits(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(std::max(value, 1.0))) - 1);
  return static_cast<std::uint64_t>(std::max(std::floor(value / unit) * unit, 1.0));
}

PixelBounds CropWindow::pixels(int width, int height) const {
  // Not of the rounding errors of fractions such as 0.1 * 30.
  const auto up = [](double share, int side) { return static_cast<int>(std::ceil(share * side - 1e-6 * side)); };
  return {up(x0, width), up(y0, height), up(x1, width), up(y1, height)};
}

SampleRange RenderSettings::sample_range() const { return range_of(part, samples); }

SampleRange RenderSettings::slice_range() const {
  const SampleRange all = sample_range(), own = range_of(slice, samples);
  const std::uint32_t first = std::max(all.first, own.first);
  return {first, std::max(first, std::min(all.end, own.end))};
}

PlaceLayers RenderSettings::place_layers() const {
  PlaceLayers out = places_for(aovs);
  out.surface_samples = filters(*this) && !of_points;
  out.medium = media && separate_layers;
  return out;
}

void check_part(const RenderSettings& asked) {
  if (asked.part.is_all()) return;
  if (asked.noise_target > 0)
    throw Error("--part cannot end by --noise: a part cannot measure the noise of the whole picture",
                "Give --samples in place of --noise.");
  if (asked.time_limit_s > 0 && asked.samples == 0)
    throw Error("--part with --time needs --samples", "All parts must agree on the number of samples.");
}

std::vector<std::string> guide_cameras(const std::vector<std::string>& names) {
  // Each of the cameras takes as long as the guide of a still.
  const std::size_t count = std::min<std::size_t>(names.size(), 16);
  std::vector<std::string> out;
  for (std::size_t i = 0; i < count; ++i) out.push_back(names[i * names.size() / count]);
  return out;
}

bool filters(const RenderSettings& settings) {
  return settings.filter == Filtering::automatic && settings.integrator == Integrator::gather;
}

bool is_adaptive(const RenderSettings& settings) {
  return settings.adaptive && settings.integrator == Integrator::gather && !settings.progressive &&
         (settings.noise_target > 0 || (settings.time_limit_s > 0 && settings.samples == kOpenEndedSamples));
}

bool has_time_for_caustics(const RenderSettings& settings) {
  constexpr double kMinSeconds = 30;
  return !(settings.time_limit_s > 0 && settings.time_limit_s < kMinSeconds);
}

std::uint64_t default_memory_bytes() {
  const std::uint64_t half = physical_memory_bytes() / 2;
  return half > kMemoryStep ? half / kMemoryStep * kMemoryStep : half;
}

int default_threads(std::uint64_t memory_bytes, int cores) {
  // Each thread takes 32 MB, of which its rays take a quarter (kBytesPerThread).
  const std::uint64_t fit = (memory_bytes > 0 ? memory_bytes : default_memory_bytes()) / 32'000'000;
  return static_cast<int>(std::clamp<std::uint64_t>(fit, 1, static_cast<std::uint64_t>(std::max(cores, 1))));
}

void set_thread_count(const RenderSettings& asked) {
  set_thread_count(asked.threads);
  if (asked.threads == 0) set_thread_count(default_threads(asked.memory_bytes, thread_count()));
}

RenderSettings resolve(const RenderSettings& asked, const Scene& scene) {
  check_settings(asked);
  RenderSettings s = asked;
  check_part(s);
  resolve_size(s, scene);
  s.bounds = resolved_bounds(s, scene.film());
  for (const std::string& aov : s.aovs) name_index("AOV", aov, aov_names());
  engine_traits(s.engine);  // throws if there is no such engine
  s.camera = scene.camera(s.camera).name;
  s.threads = thread_count();
  s.media = !scene.media().empty();
  if (s.light_groups) {
    check_light_groups(s);
    s.light_group_count = static_cast<std::uint32_t>(light_groups(scene).names.size());
  }
  if (s.memory_bytes == 0) s.memory_bytes = default_memory_bytes();
  if (!s.aovs.empty() || filters(s) || s.light_groups) s.separate_layers = true;
  const bool open_ended = s.time_limit_s > 0 || s.noise_target > 0;
  if (s.integrator == Integrator::path) {
    const std::uint32_t usual = scene.film().samples > 0 ? scene.film().samples : kDefaultPathSamples;
    if (s.samples == 0) s.samples = open_ended ? kOpenEndedSamples : usual;
    resolve_photons_of_paths(s, scene);
  } else {
    s.engine = engine_traits(s.engine).name;
    if (!engine_traits(s.engine).goes_over_photons) s.thinned = 0;
    if (s.samples == 0) s.samples = open_ended ? kOpenEndedSamples : kDefaultSamples;
    if (s.gather == 0) resolve_gather(s);
    if (s.photon_target == 0 && chooses_photons_by_noise(s)) s.photon_target = s.noise_target;
    if (s.photons == 0) resolve_photons(s);
    // The cost of knn grows with k, and final gathering averages many of its estimates. [SF07] and [HHS05] use k >= 30.
    if (s.nearest == 0) s.nearest = engine_traits(s.engine).takes_nearest ? 30 : kNearest;
    if (s.light_samples == 0) s.light_samples = default_light_samples(s.gather);
  }
  if (s.sample_range().count() == 0)
    throw Error(fmt::format("part {} of {} has none of {} samples", s.part.index, s.part.count, s.samples),
                fmt::format("Give --samples {} or more, or fewer parts.", s.part.count));
  return s;
}

std::vector<std::string> choice_notes(const RenderSettings& asked, const RenderSettings& chosen) {
  const bool open_ended = chosen.time_limit_s > 0 || chosen.noise_target > 0;
  const bool by_photons = chosen.integrator != Integrator::path;
  std::vector<std::string> notes;
  const auto note = [&](bool left, std::string text) {
    if (left) notes.push_back(std::move(text));
  };
  note(asked.memory_bytes == 0, fmt::format("memory {} MB: half of the machine's; the image does not depend on it",
                                            chosen.memory_bytes / 1'000'000));
  note(asked.samples == 0, open_ended ? std::string("samples: as many as time or noise allow")
                                      : fmt::format("{} samples: enough for edges{}", chosen.samples,
                                                    by_photons ? ", while gather rays see to the rest" : " and light"));
  if (!by_photons && chosen.photons > 0)
    notes.push_back(
        fmt::format("{} photons for each sample: no path finds light of lamps without size that mirrors or glass bend; "
                    "photons bring it, a little blurred",
                    chosen.photons));
  if (!by_photons) return notes;
  note(
      asked.gather == 0 && chosen.integrator == Integrator::gather,
      fmt::format("{} gather rays a sample: {}", chosen.gather,
                  chosen.gather < kDefaultGather   ? "as many as give a first image within a quarter of the time"
                  : chosen.gather > kDefaultGather ? "sensors are few, and a pass of photons costs as much as many rays"
                                                   : "the default, for pictures that are filtered"));
  note(asked.photons == 0,
       fmt::format("{} photons: so many that their bias falls with the noise of the gather rays, at least {} and at "
                   "most {}{}",
                   chosen.photons, two_digits(least_photons(chosen)), most_photons(chosen),
                   chosen.time_limit_s > 0    ? ", within a quarter of the time"
                   : chosen.photon_target > 0 ? "; more, with a larger k, if their noise is too large for --noise"
                                              : ""));
  note(asked.nearest == 0,
       fmt::format("k = {}: photons within a radius; fewer look blotched, more blur", chosen.nearest));
  note(asked.engine == "auto", fmt::format("engine {}: the fastest but for a few hundred query points", chosen.engine));
  return notes;
}

}  // namespace glowworm
