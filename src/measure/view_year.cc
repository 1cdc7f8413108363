#include "measure/view_year.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "gather/camera_pass.h"
#include "measure/measurement.h"
#include "measure/sky_rays.h"
#include "scene/sky_model.h"

namespace glowworm {

namespace {

/// Camera samples of a pixel in a round, and gather rays of each where their number is automatic.
constexpr std::uint32_t kSamplesOfView = 2, kRaysOfPicture = 64;
/// Ways to the sky along either side of a pixel.
constexpr int kWaysAcross = 3;
/// Hours whose pictures are held at once.
constexpr std::size_t kHoursAtOnce = 64;

/// What a render of a view finds.
struct RoundLight {
  DaylightCoefficients pixels;  ///< a row for each: radiance, where sensors have irradiance
  GatherPoints points;          ///< of one camera sample of each pixel; slots are pixels
};

/// What a view shows under any sky and sun.
struct ViewLight {
  const Camera* camera = nullptr;
  std::vector<RoundLight> rounds;
  std::vector<SkyRay> ways;  ///< that end above the horizon
  GatherPoints glints;       ///< of sky_rays()
  std::vector<std::uint32_t> patch_of_way;
  GlarePicture blank;  ///< its luminance is black
  std::vector<PixelView> views;
};

/// Photons that are kept for later views take at most this inverse share of the memory.
constexpr std::uint64_t kShareOfPhotons = 4;

/// Bytes that stand beside the render of a view: coefficients, hours, and ways with glints, which are held twice while
/// rows are joined.
std::uint64_t bytes_of_view(std::uint32_t side, const YearModel& model) {
  const std::uint64_t of_coefficients = (model.patches.size() + model.suns.places().size()) * sizeof(RGB);
  const std::uint64_t of_ways =
      kWaysAcross * kWaysAcross * (2 * (sizeof(SkyRay) + bytes_each<GatherPoints>()) + sizeof(std::uint32_t));
  return std::uint64_t{side} * side *
         (kRoundsOfView * (of_coefficients + bytes_each<GatherPoints>()) + of_ways + sizeof(PixelView) +
          (kRoundsOfView + 2) * sizeof(float) * kHoursAtOnce);
}

/// Settings of pictures that keep the light of sources apart.
/// @param photons if none are asked for @param beside bytes that the render leaves free
RenderSettings picture_settings(const RenderSettings& asked, std::uint64_t photons, std::uint64_t beside,
                                std::uint32_t side, const std::vector<std::string>& names) {
  RenderSettings s = asked;
  s.light_groups = true;
  s.filter = Filtering::off;
  if (s.memory_bytes == 0) s.memory_bytes = default_memory_bytes();
  s.memory_bytes -= beside;
  if (s.photons == 0) s.photons = photons;
  if (s.gather == 0) s.gather = kRaysOfPicture;
  s.samples = kSamplesOfView;
  s.noise_target = s.time_limit_s = 0;
  s.width = s.height = static_cast<int>(side);
  s.bounds = {0, 0, s.width, s.height};
  s.guide_cameras = guide_cameras(names);
  return s;
}

/// Renders views of a scene under one kind of light; they share photons.
class PictureMaker {
 public:
  PictureMaker(YearScene lit, RenderSettings settings) : lit_(std::move(lit)), settings_(std::move(settings)) {}

  const Tracer& tracer() const { return *lit_.tracer; }
  /// @param round   whose photons are taken, if another view has traced them
  /// @param held    bytes of photons that others hold
  /// @param light_of gets the Job @return false if it was cancelled
  template <typename LightOf>
  bool make(const std::string& camera, std::uint32_t round, std::uint64_t held, const std::function<void(Job&)>& wait,
            LightOf&& light_of) {
    RenderSettings s = settings_;
    s.camera = camera;
    s.seed = hash_combine(s.seed, round);
    std::shared_ptr<JobMaps>& maps = maps_[round];
    s.memory_bytes -= std::min(held + held_bytes() - bytes_of(maps), s.memory_bytes - 1);
    Job job(lit_.scene, lit_.tracer, s, nullptr, {}, nullptr, nullptr, maps);
    wait(job);
    if (job.ending() == Ending::cancelled) return false;
    light_of(job);
    maps = job.maps();
    return true;
  }
  /// Bytes of all photons.
  std::uint64_t held_bytes() const {
    std::uint64_t bytes = 0;
    for (const auto& maps : maps_) bytes += bytes_of(maps);
    return bytes;
  }
  /// Forgets the photons of a round.
  void forget(std::uint32_t round) { maps_[round] = nullptr; }

 private:
  static std::uint64_t bytes_of(const std::shared_ptr<JobMaps>& maps) { return maps ? maps->maps.bytes() : 0; }

  YearScene lit_;
  RenderSettings settings_;
  std::array<std::shared_ptr<JobMaps>, kRoundsOfView> maps_;
};

/// One camera sample of each pixel.
GatherPoints points_of_view(const Tracer& tracer, const Camera& camera, int side, std::uint32_t seed) {
  GatherPoints out;
  CameraPassSettings pass;
  pass.width = pass.height = side;
  pass.seed = seed;
  SlotRadiance unused;
  FirstHit first_hit;
  Statistics statistics;
  camera_pass(tracer, camera, CameraTask{0, 0, side, side}, pass, unused, first_hit, out, statistics);
  return out;
}

/// All but the rounds.
ViewLight view_light(const Tracer& tracer, const Camera& camera, std::uint32_t side, const YearModel& model) {
  ViewLight out;
  out.camera = &camera;
  const int pixels = static_cast<int>(side);
  for (const SkyRay& way : sky_rays(tracer, camera, pixels, pixels, kWaysAcross, true, &out.glints)) {
    if (!(way.towards.y > 0)) continue;
    out.ways.push_back(way);
    out.patch_of_way.push_back(static_cast<std::uint32_t>(model.patches.patch_of(way.towards)));
  }
  out.blank.kind = camera.kind;
  out.blank.width = out.blank.height = pixels;
  out.blank.half_x = out.blank.half_y = camera.half_extent;
  out.blank.luminance.resize(std::size_t{side} * side);
  out.views = pixel_views(out.blank);
  return out;
}

/// Lobes narrower than the distance of ways would hide between them, and the sun's own image is no narrower than it.
float least_alpha(const ViewLight& view) {
  const float spacing = 2 * view.blank.half_x / static_cast<float>(view.blank.width * kWaysAcross);
  return std::max(static_cast<float>(kSunRadius), spacing);
}

/// Hours whose pictures are held at once.
struct HourBlock {
  std::span<const std::uint32_t> hours;      ///< as indices into YearSky::lit
  std::vector<float> glints;                 ///< luminance: hours of a pixel
  std::vector<std::vector<float>> of_round;  ///< the same of all that the rounds find
};

HourBlock light_of_hours(const Tracer& tracer, const ViewLight& view, const YearModel& model,
                         std::span<const std::uint32_t> hours) {
  const YearSky& sky = model.sky;
  const std::size_t pixels = view.blank.luminance.size(), count = hours.size();
  const auto in_cd = [&](std::vector<float>& of_sun) {
    parallel_for_each(pixels, 64, [&](std::size_t i) {
      for (std::size_t k = 0; k < count; ++k) of_sun[i * count + k] *= kLuminousEfficacy * sky.beam[hours[k]];
    });
  };
  HourBlock out{hours, reflected_sun(tracer, view.glints, pixels, sky, hours, {kSpecular, least_alpha(view)}), {}};
  in_cd(out.glints);
  const DiffuseLight light(sky, model.suns, {hours.begin(), hours.end()});
  for (const RoundLight& round : view.rounds) {
    std::vector<float>& sum = out.of_round.emplace_back(reflected_sun(tracer, round.points, pixels, sky, hours));
    in_cd(sum);
    parallel_for_each(pixels, 64, [&](std::size_t i) {
      std::vector<float> row(count);
      light.illuminance(round.pixels, i, row);
      for (std::size_t k = 0; k < count; ++k) sum[i * count + k] += row[k];
    });
  }
  return out;
}

/// Adds the sky as pixels see it, less the light of its patches.
void add_sky(const ViewLight& view, const YearSky& sky, std::uint32_t hour, std::vector<float>& luminance_of) {
  if (sky.shape.empty()) return;
  for (std::size_t i = 0; i < view.ways.size(); ++i) {
    const SkyRay& way = view.ways[i];
    const float exact = sky_radiance(sky.shape[hour], way.towards),
                mean = luminance(sky.sky.at(view.patch_of_way[i], hour));
    luminance_of[way.pixel] +=
        kLuminousEfficacy * way.share * (exact - mean) / static_cast<float>(kWaysAcross * kWaysAcross);
  }
}

/// The standard error of a number from its values without each of the rounds, by student_factor().
float jackknife_error(std::span<const double> without) {
  const double n = static_cast<double>(without.size());
  double mean = 0, squares = 0;
  for (const double value : without) mean += value / n;
  for (const double value : without) squares += (value - mean) * (value - mean);
  return static_cast<float>(student_factor(static_cast<std::uint32_t>(without.size()) - 1) *
                            std::sqrt((n - 1) / n * squares));
}

/// Rates the k-th hour of a block.
void rate_hour(const Tracer& tracer, const ViewLight& view, const YearSky& sky, const HourBlock& block, std::size_t k,
               ViewYear& out) {
  const std::uint32_t hour = block.hours[k];
  const std::size_t pixels = view.blank.luminance.size(), count = block.hours.size(), rounds = block.of_round.size();
  std::vector<float> same(pixels);  // in every round
  for (std::size_t i = 0; i < pixels; ++i) same[i] = block.glints[i * count + k];
  add_sky(view, sky, hour, same);
  std::vector<GlareSource> suns;
  if (sky.beam[hour] > 0) suns = sources_of_sun(tracer, *view.camera, view.ways, sky.sun[hour], RGB(sky.beam[hour]));
  GlarePicture picture = view.blank;
  // All rounds but one; `rounds`: all.
  const auto rate_without = [&](std::size_t left_out) {
    const float each = 1 / static_cast<float>(rounds - (left_out < rounds ? 1 : 0));
    for (std::size_t i = 0; i < pixels; ++i) {
      float sum = 0;
      for (std::size_t round = 0; round < rounds; ++round)
        if (round != left_out) sum += block.of_round[round][i * count + k];
      picture.luminance[i] = std::max(same[i] + sum * each, 0.0f);
    }
    return rate_glare(picture, view.views, suns);
  };
  const Glare glare = rate_without(rounds);
  std::array<double, kRoundsOfView> dgp{}, lux{};
  for (std::size_t round = 0; round < rounds; ++round) {
    const Glare without = rate_without(round);
    dgp[round] = without.dgp;
    lux[round] = without.vertical_illuminance;
  }
  const std::uint32_t row = sky.lit[hour];
  out.dgp[row] = static_cast<float>(glare.dgp);
  out.illuminance[row] = static_cast<float>(glare.vertical_illuminance);
  out.dgp_error[row] = jackknife_error(dgp);
  out.illuminance_error[row] = jackknife_error(lux);
}

void rate_hours(const Tracer& tracer, const ViewLight& view, const YearModel& model,
                std::span<const std::uint32_t> hours, const std::function<void(double)>& progress, ViewYear& out) {
  for (std::size_t first = 0; first < hours.size(); first += kHoursAtOnce) {
    progress(static_cast<double>(first) / static_cast<double>(hours.size()));
    const HourBlock block =
        light_of_hours(tracer, view, model, hours.subspan(first, std::min(kHoursAtOnce, hours.size() - first)));
    parallel_for_each(block.hours.size(), 1, [&](std::size_t k) { rate_hour(tracer, view, model.sky, block, k, out); });
  }
  progress(1);
}

/// The scene with the views as cameras.
Scene scene_with_views(const Scene& plain, std::span<const Camera> views, const std::vector<std::string>& names) {
  SceneEdit edit{plain.emissions(), plain.lights(), plain.environment(), plain.shared_geometry(), {}, ""};
  for (std::size_t i = 0; i < views.size(); ++i) {
    edit.more_cameras.push_back(views[i]);
    edit.more_cameras.back().name = names[i];
  }
  return Scene(plain, std::move(edit));
}

}  // namespace

void check_view_room(std::uint32_t side, const YearModel& model, std::uint64_t memory_bytes) {
  const std::uint64_t bytes = bytes_of_view(side, model);
  if (bytes > memory_bytes / 2)
    throw MemoryError(fmt::format("pictures of {0} x {0} pixels take {1:.0f} MB; half of the memory budget has room "
                                  "for less",
                                  side, static_cast<double>(bytes) / 1e6),
                      "Give a larger memory budget or fewer pixels.");
}

bool rate_views(const Scene& plain, std::span<const Camera> views, std::uint32_t side, const YearModel& model,
                std::span<const std::uint32_t> hours, const RenderSettings& asked, const YearWatch& watch,
                std::span<ViewYear> out) {
  const std::uint64_t memory = asked.memory_bytes > 0 ? asked.memory_bytes : default_memory_bytes();
  check_view_room(side, model, memory);
  const std::uint64_t beside = bytes_of_view(side, model);
  const std::size_t pixels = std::size_t{side} * side, places = model.suns.places().size();
  std::vector<std::string> names;
  for (std::size_t i = 0; i < views.size(); ++i) names.push_back(fmt::format("view of the year {}", i + 1));
  const Scene seen = scene_with_views(plain, views, names);
  PictureMaker of_sky(under_sky(seen, model),
                      picture_settings(asked, kPhotonsOfPatch * model.patches.size(), beside, side, names));
  std::unique_ptr<PictureMaker> of_suns;
  if (places > 0)
    of_suns = std::make_unique<PictureMaker>(YearScene(scene_under_suns(seen, model.suns.places())),
                                             picture_settings(asked, kPhotonsOfSun * places, beside, side, names));
  // One part more for each view: its hours.
  std::size_t left = views.size() * (kRoundsOfView * (of_suns ? 2 : 1) + 1);
  YearWork work;
  const auto wait_on = [&](Job& job) { watch.wait(job, work.next(left--)); };
  for (std::size_t i = 0; i < views.size(); ++i) {
    ViewLight view = view_light(of_sky.tracer(), views[i], side, model);
    for (std::uint32_t round = 0; round < kRoundsOfView; ++round) {
      RoundLight found{
          {{}, {pixels, 0, {}}},
          points_of_view(of_sky.tracer(), views[i], static_cast<int>(side), hash_combine(asked.seed, round))};
      if (!of_sky.make(names[i], round, of_suns ? of_suns->held_bytes() : 0, wait_on,
                       [&](const Job& job) { found.pixels.sky = daylight_matrix(job, pixels); }))
        return false;
      if (of_suns && !of_suns->make(names[i], round, of_sky.held_bytes(), wait_on,
                                    [&](const Job& job) { found.pixels.suns = sun_matrix(job, pixels, places); }))
        return false;
      view.rounds.push_back(std::move(found));
      // Photons are kept for the next view unless they would take the memory to trace others.
      const std::uint64_t held = of_sky.held_bytes() + (of_suns ? of_suns->held_bytes() : 0);
      if (i + 1 < views.size() && held <= memory / kShareOfPhotons) continue;
      of_sky.forget(round);
      if (of_suns) of_suns->forget(round);
    }
    const YearProgress part = work.next(left--);
    const auto rated = [&](double share) {
      if (watch.rays) watch.rays(part.before + part.share * share);
    };
    rate_hours(of_sky.tracer(), view, model, hours, rated, out[i]);
  }
  return true;
}

}  // namespace glowworm
