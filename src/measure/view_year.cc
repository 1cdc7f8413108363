#include "measure/view_year.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "gather/camera_pass.h"
#include "measure/measurement.h"
#include "measure/sky_rays.h"
#include "scene/sky_model.h"

namespace glowworm {

namespace {

/// Camera samples of a pixel and gather rays of each, where their numbers are automatic.
constexpr std::uint32_t kSamplesOfPicture = 8, kRaysOfPicture = 64;
/// Ways to the sky along either side of a pixel.
constexpr int kWaysAcross = 3;
/// Hours whose pictures are held at once.
constexpr std::size_t kHoursAtOnce = 64;

/// What a view shows under any sky and sun.
struct ViewLight {
  const Camera* camera = nullptr;
  std::uint32_t side = 0;
  DaylightCoefficients pixels;  ///< a row for each: radiance, where sensors have irradiance
  GatherPoints points;          ///< of one camera sample of each pixel; slots are pixels
  std::vector<SkyRay> ways;     ///< that end above the horizon
  std::vector<std::uint32_t> patch_of_way;
  GlarePicture blank;  ///< its luminance is black
  std::vector<PixelView> views;
};

/// Bytes that stand beside the render of a view: coefficients, hours, and ways, which are held twice while rows are
/// joined.
std::uint64_t bytes_of_view(std::uint32_t side, const YearModel& model) {
  const std::uint64_t of_coefficients = (model.patches.size() + model.suns.places().size()) * sizeof(RGB);
  const std::uint64_t of_ways = kWaysAcross * kWaysAcross * (2 * sizeof(SkyRay) + sizeof(std::uint32_t));
  return std::uint64_t{side} * side *
         (of_coefficients + of_ways + sizeof(PixelView) + 2 * sizeof(float) * kHoursAtOnce);
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
  s.samples = kSamplesOfPicture;
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
  /// @param light_of gets the Job @return false if it was cancelled
  template <typename LightOf>
  bool make(const std::string& camera, const std::function<void(Job&)>& wait, LightOf&& light_of) {
    settings_.camera = camera;
    Job job(lit_.scene, lit_.tracer, settings_, nullptr, {}, nullptr, nullptr, maps_);
    wait(job);
    if (job.ending() == Ending::cancelled) return false;
    light_of(job);
    maps_ = job.maps();
    return true;
  }

 private:
  YearScene lit_;
  RenderSettings settings_;
  std::shared_ptr<JobMaps> maps_;
};

/// All but the coefficients.
ViewLight view_light(const Tracer& tracer, const Camera& camera, std::uint32_t side, const YearModel& model,
                     std::uint32_t seed) {
  ViewLight out;
  out.camera = &camera;
  out.side = side;
  const int pixels = static_cast<int>(side);
  CameraPassSettings pass;
  pass.width = pass.height = pixels;
  pass.seed = seed;
  SlotRadiance unused;
  FirstHit first_hit;
  Statistics statistics;
  camera_pass(tracer, camera, CameraTask{0, 0, pixels, pixels}, pass, unused, first_hit, out.points, statistics);
  for (const SkyRay& way : sky_rays(tracer, camera, pixels, pixels, kWaysAcross, true)) {
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

/// Rates the picture of an hour. @param picture without what follows from the ways to the sky
Glare rate_hour(const Tracer& tracer, const ViewLight& view, const YearSky& sky, std::uint32_t hour,
                GlarePicture& picture) {
  if (!sky.shape.empty())
    for (std::size_t i = 0; i < view.ways.size(); ++i) {
      const SkyRay& way = view.ways[i];
      const float exact = sky_radiance(sky.shape[hour], way.towards),
                  mean = luminance(sky.sky.at(view.patch_of_way[i], hour));
      picture.luminance[way.pixel] +=
          kLuminousEfficacy * way.share * (exact - mean) / static_cast<float>(kWaysAcross * kWaysAcross);
    }
  for (float& value : picture.luminance) value = std::max(value, 0.0f);
  std::vector<GlareSource> suns;
  if (sky.beam[hour] > 0) suns = sources_of_sun(tracer, *view.camera, view.ways, sky.sun[hour], RGB(sky.beam[hour]));
  return rate_glare(picture, view.views, suns);
}

void rate_hours(const Tracer& tracer, const ViewLight& view, const YearModel& model,
                std::span<const std::uint32_t> hours, ViewYear& out) {
  const YearSky& sky = model.sky;
  const std::size_t pixels = view.blank.luminance.size();
  for (std::size_t first = 0; first < hours.size(); first += kHoursAtOnce) {
    const std::span<const std::uint32_t> block = hours.subspan(first, std::min(kHoursAtOnce, hours.size() - first));
    const DiffuseLight light(sky, model.suns, {block.begin(), block.end()});
    // Hours of a pixel.
    std::vector<float> luminance(pixels * block.size());
    constexpr std::size_t kPixelsAtOnce = 64;
    parallel_for_each(pixels, kPixelsAtOnce, [&](std::size_t i) {
      light.illuminance(view.pixels, i, std::span(luminance).subspan(i * block.size(), block.size()));
    });
    const std::vector<float> sun = reflected_sun(tracer, view.points, pixels, sky, block);
    parallel_for_each(block.size(), 1, [&](std::size_t k) {
      GlarePicture picture = view.blank;
      for (std::size_t i = 0; i < pixels; ++i)
        picture.luminance[i] =
            luminance[i * block.size() + k] + kLuminousEfficacy * sky.beam[block[k]] * sun[i * block.size() + k];
      const Glare glare = rate_hour(tracer, view, sky, block[k], picture);
      out.dgp[sky.lit[block[k]]] = static_cast<float>(glare.dgp);
      out.illuminance[sky.lit[block[k]]] = static_cast<float>(glare.vertical_illuminance);
    });
  }
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
                std::span<const std::uint32_t> hours, const RenderSettings& asked,
                const std::function<void(Job&, YearProgress)>& wait, std::span<ViewYear> out) {
  check_view_room(side, model, asked.memory_bytes > 0 ? asked.memory_bytes : default_memory_bytes());
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
  const double share = 1.0 / static_cast<double>(views.size() * (of_suns ? 2 : 1));
  double before = 0;
  const auto wait_on = [&](Job& job) {
    wait(job, {before, share});
    before += share;
  };
  for (std::size_t i = 0; i < views.size(); ++i) {
    ViewLight view = view_light(of_sky.tracer(), views[i], side, model, asked.seed);
    view.pixels.suns = {pixels, 0, {}};
    if (!of_sky.make(names[i], wait_on, [&](const Job& job) { view.pixels.sky = daylight_matrix(job, pixels); }) ||
        (of_suns && !of_suns->make(names[i], wait_on,
                                   [&](const Job& job) { view.pixels.suns = sun_matrix(job, pixels, places); })))
      return false;
    rate_hours(of_sky.tracer(), view, model, hours, out[i]);
  }
  return true;
}

}  // namespace glowworm
