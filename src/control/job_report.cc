#include "control/job_report.h"

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "core/json_text.h"
#include "core/version.h"
#include "density/engine.h"
#include "film/filtered.h"
#include "film/output.h"
#include "kernels/simd.h"
#include "scene/radiance_view.h"
#include "settings/options.h"

namespace glowworm {

namespace {

using nlohmann::json;

/// By Ending.
constexpr const char* kEndingNames[] = {"running", "samples_done", "time_up", "noise_reached", "cancelled", "failed"};

using Matrix = std::array<double, 16>;  // in rows; points are rows

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix out{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t k = 0; k < 4; ++k) out[4 * i + j] += a[4 * i + k] * b[4 * k + j];
  return out;
}

std::array<float, 16> rounded(const Matrix& m) {
  std::array<float, 16> out{};
  std::transform(m.begin(), m.end(), out.begin(), [](double v) { return static_cast<float>(v); });
  return out;
}

/// The matrices by which compositing programs find the camera. The camera looks along +z with y up; normalised
/// device coordinates go from (0, 0) at the upper left corner of the picture to (1, 1), as in RenderMan.
std::map<std::string, std::array<float, 16>> matrices_of(const Camera& camera, int width, int height) {
  if (is_angular(camera.kind)) return {};  // no matrix maps angles
  Transform to_world = camera.to_world;
  const bool divides = camera.kind == CameraKind::perspective;
  // An orthographic camera takes its axes by their directions.
  if (!divides) to_world = {normalize(to_world.x), normalize(to_world.y), normalize(to_world.z), to_world.translation};
  const Transform t = inverse(to_world);
  const Matrix to_camera = {t.x.x, t.x.y, t.x.z, 0, t.y.x,           t.y.y,           t.y.z,           0,
                            t.z.x, t.z.y, t.z.z, 0, t.translation.x, t.translation.y, t.translation.z, 1};
  const ScreenWindow window = screen_window(camera, width, height);
  const double sx = 1 / (double{window.right} - window.left), sy = 1 / (double{window.bottom} - window.top);
  const double x0 = -window.left * sx, y0 = -window.top * sy;
  Matrix to_ndc = {sx, 0, 0, 0, 0, sy, 0, 0, 0, 0, 1, 0, x0, y0, 0, 1};
  if (divides) to_ndc = {sx, 0, 0, 0, 0, sy, 0, 0, x0, y0, 1, 1, 0, 0, 0, 0};
  return {{"worldToCamera", rounded(to_camera)}, {"worldToNDC", rounded(product(to_camera, to_ndc))}};
}

std::string json_of(const api::RenderStatistics& s, const Job& job) {
  const RenderSettings settings = job.settings();
  json out = {{"settings", settings_json(settings)},
              {"version", version()},
              {"passes", s.passes},
              {"mean_samples", s.mean_samples},
              {"samples_not_finite", s.samples_not_finite},
              {"tasks", s.tasks},
              {"ending", kEndingNames[static_cast<std::size_t>(s.ending)]},
              {"isa", s.instruction_set},
              {"threads", s.threads},
              {"time_s", s.seconds},
              {"count", s.counts},
              {"rate", s.rates},
              {"memory_bytes", s.memory}};
  out["scene"] = {{"name", job.scene().name()},
                  {"triangles", job.scene().geometry().triangle_count()},
                  {"lights", job.scene().light_source_count()},
                  {"materials", job.scene().materials().size()}};
  const auto ratio = [&](const char* of, const char* to) {
    return s.counts.at(to) > 0 ? static_cast<double>(s.counts.at(of)) / static_cast<double>(s.counts.at(to)) : 0.0;
  };
  out["mean"] = {{"photons_per_query", ratio("shader_operations", "query_points")},
                 {"active_lanes", ratio("packet_active_lanes", "packet_steps")},
                 {"lanes", engine_traits(settings.engine).lanes()}};
  out["paged"] = {{"bytes_read", job.query_traffic().read}, {"bytes_written", job.query_traffic().written}};
  out["lights"] = json::array();
  for (const LightPhotons& light : s.lights)
    out["lights"].push_back({{"name", light.name},
                             {"sources", light.sources},
                             {"photons_emitted", light.emitted},
                             {"photons_stored", light.stored},
                             {"photons_used", light.used},
                             {"photons_wasted", light.wasted()}});
  out["memory_bytes"]["reserved"] = s.reserved_peaks;
  return json_text(out, 2);
}

}  // namespace

PictureInfo picture_info(const Job& job) {
  const RenderSettings settings = job.settings();
  const Scene& scene = job.scene();
  PictureInfo info;
  info.settings = settings;
  info.scene = scene.name();
  info.scale = scene.film().scale;
  info.origin = scene.origin();
  info.seconds = job.seconds();
  info.photon_variance = job.photon_variance();
  if (settings.place_layers().objects)
    for (const ObjectStart& object : scene.geometry().objects) info.objects.push_back(object.name);
  if (settings.place_layers().materials)
    for (const Material& material : scene.materials()) info.materials.push_back(material.name);
  if (job.light_groups()) info.light_groups = job.light_groups()->names;
  const Camera& camera = scene.camera(settings.camera);
  info.view = radiance_view_text(camera, scene, settings.width, settings.height);
  info.matrices = matrices_of(camera, settings.width, settings.height);
  return info;
}

FrameView frame_view(const Film& film, const Job& job) {
  FrameView view = job.frame_view();
  view.bounds = film.bounds();
  return view;
}

FrameLight frame_light(const Job& job) {
  return light_of_frame(job.film(), frame_view(job.film(), job), job.settings().indirect_only);
}

Image make_image(const Film& film, const Job& job) { return make_image(film, picture_info(job)); }

Part part_of(const Job& job) {
  Part part{key_of_whole(job.key()), {job.settings().sample_range()}, picture_info(job)};
  part.picture.settings.part = part.picture.settings.slice = SampleShare();
  part.picture.settings.photon_stream = 0;
  return part;
}

api::RenderStatistics statistics_of(const Job& job, const Tracer& tracer) {
  const Statistics& s = job.statistics();
  const RenderSettings settings = job.settings();
  api::RenderStatistics out;
  out.ending = job.ending();
  out.passes = job.passes();
  out.mean_samples = job.mean_samples();
  out.samples_not_finite = job.samples_not_finite();
  out.tasks = job.tasks();
  out.threads = settings.threads;
  out.instruction_set = simd_name();
  for (int i = 0; i < static_cast<int>(Phase::count_); ++i)
    out.seconds[name(static_cast<Phase>(i))] = s.seconds(static_cast<Phase>(i));
  for (int i = 0; i < static_cast<int>(Counter::count_); ++i)
    out.counts[name(static_cast<Counter>(i))] = s.count(static_cast<Counter>(i));
  const auto per_second = [](std::uint64_t n, double seconds) {
    return seconds > 0 ? static_cast<double>(n) / seconds : 0.0;
  };
  const double density = s.seconds(Phase::density) + s.seconds(Phase::reorder);
  const std::uint64_t operations = s.count(Counter::shader_operations), queries = s.count(Counter::query_points);
  out.rates = {{"gather_rays_per_s", per_second(s.count(Counter::gather_rays), s.seconds(Phase::gather_rays))},
               {"query_points_per_s", per_second(queries, density)},
               {"shader_operations_per_s_per_core", per_second(operations, density) / settings.threads}};
  const std::uint64_t reserved = job.budget().peak(), beside_scene = job.peak_beside_scene_bytes();
  out.memory = {{"budget", settings.memory_bytes},
                {"peak_reserved", reserved},
                {"peak_rss", job.peak_resident()},
                {"scene", job.scene_bytes()},
                {"peak_beside_scene", beside_scene},
                {"unaccounted", beside_scene > reserved ? beside_scene - reserved : 0},
                {"on_disk", job.disk_bytes()},
                {"photon_map", job.photon_map_bytes()},
                {"query_points", job.query_point_bytes()},
                {"acceleration_structure", tracer.bytes()}};
  out.reserved_peaks = job.budget().peaks();
  out.lights = job.light_photons();
  out.json = json_of(out, job);
  return out;
}

}  // namespace glowworm
