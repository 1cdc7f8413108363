#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/attend.h"
#include "apps/commands.h"
#include "apps/fisheye_views.h"
#include "apps/interrupt.h"
#include "apps/open_scene.h"
#include "apps/output_files.h"
#include "apps/picture_output.h"
#include "apps/table_options.h"
#include "control/job.h"
#include "control/job_report.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/input_file.h"
#include "core/log.h"
#include "core/text.h"
#include "measure/glare.h"
#include "measure/glare_picture.h"
#include "measure/measurement.h"
#include "measure/sky_rays.h"
#include "scene/light_rig.h"
#include "scene/radiance_view.h"

namespace glowworm {

namespace {

struct GlareOptions : LightOptions {
  std::string views, view, output, picture, task;
  double threshold = kGlareThreshold;
  std::uint32_t side = 512;
};

/// Whether a picture is rated, and not views of a scene.
bool rates_picture(const GlareOptions& o) {
  const std::string ending = lower_ending(o.scene);
  return ending == ".hdr" || ending == ".pic" || ending == ".exr";
}

/// The directions of a view in the axes of the user's file.
struct ViewAxes {
  Vec3 right, up, forward;
};

/// The suns that the eye sees, straight and in mirrors. @param side pixels of the picture
std::vector<GlareSource> sources_of_suns(const Tracer& tracer, const Camera& camera, std::uint32_t side) {
  std::vector<GlareSource> out;
  std::vector<SkyRay> ways;
  for (const Light& light : tracer.scene().lights()) {
    if (light.kind != LightKind::directional || is_black(light.intensity)) continue;
    if (ways.empty()) ways = sky_rays(tracer, camera, static_cast<int>(side), static_cast<int>(side), 1, false);
    for (const GlareSource& source : sources_of_sun(tracer, camera, ways, -light.direction, light.intensity))
      out.push_back(source);
  }
  return out;
}

/// What a job has rendered, as luminance.
GlarePicture picture_of(const Job& job) {
  const Image image = make_image(job.film(), job);
  GlarePicture picture;
  picture.width = image.width();
  picture.height = image.height();
  for (const RGB& pixel : image.rgb()) picture.luminance.push_back(illuminance(pixel) / image.radiance_scale);
  return picture;
}

/// The pixels around which lamps or sky are seen, unless all of these are sources by their means.
/// @param emitted cd/m^2
std::vector<std::uint32_t> pixels_at_edges(const GlarePicture& picture, const std::vector<float>& emitted,
                                           double threshold) {
  std::vector<std::uint32_t> out;
  const auto is_edge = [&](int x, int y) {
    bool sees_light = false, within = true;
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, picture.height - 1); ++v)
      for (int u = std::max(x - 1, 0); u <= std::min(x + 1, picture.width - 1); ++u) {
        const auto i = static_cast<std::size_t>(v * picture.width + u);
        sees_light |= emitted[i] > 0;
        within &= picture.luminance[i] > threshold;
      }
    return sees_light && !within;
  };
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if (is_edge(x, y)) out.push_back(static_cast<std::uint32_t>(y * picture.width + x));
  return out;
}

/// Adds to a job's picture what is known within pixels: their light from lamps and sky, in place of its mean.
void add_details(const Job& job, const Tracer& tracer, const Camera& camera, double threshold, GlarePicture& picture) {
  std::vector<float> emitted;
  for (std::size_t i = 0; i < picture.luminance.size(); ++i)
    emitted.push_back(illuminance(job.film().mean(Film::Layer::surface_emitted, i)));
  picture.details =
      light_within_pixels(tracer, camera, picture.width, picture.height, pixels_at_edges(picture, emitted, threshold));
  for (PixelDetail& detail : picture.details) {
    const float rest = std::max(picture.luminance[detail.pixel] - emitted[detail.pixel], 0.0f);
    double sum = 0;
    for (float& luminance : detail.luminance) sum += luminance += rest;
    picture.luminance[detail.pixel] = static_cast<float>(sum / static_cast<double>(detail.luminance.size()));
  }
}

/// The task of --task, if one is given.
std::optional<GlareTask> task_of(const GlareOptions& o) {
  if (o.task.empty()) return std::nullopt;
  const std::vector<double> v = numbers_of<double>(o.task);
  if (v.size() != 3 || !(v[2] > 0 && v[2] < M_PI))
    throw CommandLineError(fmt::format("--task '{}' is no circle in a picture", o.task),
                           "Write X,Y,ANGLE: pixels from the lower left corner, and radians across.");
  return GlareTask{v[0], v[1], v[2]};
}

/// The luminance above which pixels of a picture are sources.
double threshold_of(const GlareOptions& o, const GlarePicture& picture) {
  const std::optional<GlareTask> task = task_of(o);
  if (!task) return o.threshold;
  double mean = 0;
  read_command_line([&] { mean = task_luminance(picture, *task); });
  inform(fmt::format("the task has {:.5g} cd/m^2: sources begin at {:.5g}", mean, kTaskFactor * mean));
  return kTaskFactor * mean;
}

std::string table_head(const GlareOptions& o) {
  return fmt::format(
      "# {}\n# {} lm/W; each view is followed by its sources; directions from the eye\n"
      "view,source,DGP,DGI,UGR,E_v_lx,background_cd_m2,dx,dy,dz,solid_angle_sr,luminance_cd_m2,"
      "position_index,E_lx\n",
      one_line(o.command_line), kLuminousEfficacy);
}

/// Rows of a view: its indices, then its sources.
void add_rows(std::string& text, std::size_t view, const Glare& g, const ViewAxes& axes) {
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "{},,{:.4g},{:.4g},{:.4g},{:.6g},{:.5g},,,,,,,\n", view, g.dgp, g.dgi, g.ugr,
                 g.vertical_illuminance, g.background);
  for (std::size_t i = 0; i < g.sources.size(); ++i) {
    const GlareSource& s = g.sources[i];
    const Vec3 d = axes.right * s.direction.x + axes.up * s.direction.y + axes.forward * s.direction.z;
    fmt::format_to(out, "{},{},,,,,,{:.5g},{:.5g},{:.5g},{:.5g},{:.6g},{:.4g},{:.5g}\n", view, i + 1, d.x, d.y, d.z,
                   s.solid_angle, s.luminance, s.position_index, s.illuminance);
  }
}

/// The names of the pictures of views: --picture, with the number of the view where there are several.
std::vector<std::string> picture_names(const GlareOptions& o, std::size_t views) {
  std::vector<std::string> names;
  if (o.picture.empty()) return names;
  if (output_of(o.picture).format == OutputFormat::part)
    throw CommandLineError("--picture cannot be written as a part", "Give it a name that ends in .png, .hdr or .exr.");
  const std::string ending = lower_ending(o.picture), stem = o.picture.substr(0, o.picture.size() - ending.size());
  for (std::size_t i = 1; i <= views; ++i)
    names.push_back(views == 1 ? o.picture : fmt::format("{}-{}{}", stem, i, ending));
  return names;
}

/// Writes the picture of a view that shows its sources. @param view as radiance_view_text() has it
void write_sources(const std::string& name, const GlarePicture& picture, const Glare& glare, const std::string& view,
                   OutputFiles& files) {
  const Output output = output_of(name);
  Image image = glare_image(picture, glare, output.format == OutputFormat::png);
  image.metadata[kRadianceView] = view;
  files.write_and_report(name, [&] { write_picture(output, image, {}); });
}

void tell_glare(std::size_t view, const Glare& glare) {
  inform(fmt::format("view {}: DGP {:.3f}, DGI {:.1f}, UGR {:.1f}, {:.5g} lx, {} sources", view, glare.dgp, glare.dgi,
                     glare.ugr, glare.vertical_illuminance, glare.sources.size()));
}

/// Writes the table.
void finish(const GlareOptions& o, const std::string& text, OutputFiles& files) {
  files.write_text(o.output, [&] { return text; });
  files.throw_if_any_failed();
}

/// Adds the files that are written.
void add_outputs(const GlareOptions& o, const std::vector<std::string>& pictures, OutputFiles& files) {
  files.add("-o", o.output);
  for (const std::string& name : pictures) files.add("--picture", name);
  files.probe_all();
}

/// Rates a picture of a file.
int rate_picture(const GlareOptions& o) {
  if (!o.views.empty())
    throw CommandLineError("--views is for scenes, but a picture was given",
                           "Give --view for the view of the picture, or nothing if its header has one.");
  OutputFiles files;
  files.add_input("the picture", o.scene);
  const std::vector<std::string> names = picture_names(o, 1);
  add_outputs(o, names, files);
  const Image image = read_image(o.scene);
  RadianceView view;
  if (o.view.empty())
    view = view_of_picture(image, o.scene, "");
  else
    read_command_line([&] { view = view_of_picture(image, o.scene, o.view); });
  const GlarePicture picture = glare_picture_of(image, view);
  const Glare glare = rate_glare(picture, {}, threshold_of(o, picture));
  // Radiance's pictures have x to the right of the view.
  const Vec3 forward = normalize(narrow(view.direction)), right = normalize(cross(forward, narrow(view.up)));
  tell_glare(1, glare);
  std::string text = table_head(o);
  add_rows(text, 1, glare, {right, cross(right, forward), forward});
  for (const std::string& name : names) write_sources(name, picture, glare, radiance_view_text(view), files);
  finish(o, text, files);
  return 0;
}

/// No ray of a picture meets them, so that what they send straight into the eye is missing.
void warn_of_lamps_without_size(const Scene& scene) {
  const auto count = std::count_if(scene.lights().begin(), scene.lights().end(), [](const Light& light) {
    return light.kind != LightKind::directional && !is_black(light.intensity);
  });
  if (count > 0)
    warn(
        fmt::format("lamps without size: {}. They are no sources of glare, and the illuminance at the eye lacks their "
                    "direct light. Give them a shape that emits",
                    count));
}

int run_glare(GlareOptions& o) {
  o.apply();
  task_of(o);
  if (rates_picture(o)) return rate_picture(o);
  if (o.views.empty()) throw CommandLineError("no views were given", "Give --views FILE with a line for each view.");
  if (!o.view.empty())
    throw CommandLineError("--view is for pictures, but a scene was given", "Give --views FILE for views of a scene.");
  RenderSettings asked = o.table.settings;
  asked.memory_bytes = o.memory_bytes();
  asked.width = asked.height = static_cast<int>(o.side);
  asked.bounds = {0, 0, asked.width, asked.height};
  OutputFiles files;
  files.add_input("the scene", o.scene);
  files.add_input("--views", o.views);
  const std::vector<RadianceView> views = read_fisheyes(o.views);
  const std::vector<std::string> pictures = picture_names(o, views.size());
  add_outputs(o, pictures, files);
  std::shared_ptr<const Scene> scene = open_measured_scene(o, o.scene, files);
  SceneEdit edit{scene->emissions(), scene->lights(), scene->environment(), scene->shared_geometry(), {}, ""};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < views.size(); ++i) {
    names.push_back(fmt::format("glare view {}", i + 1));
    edit.more_cameras.push_back(camera_of(views[i], *scene));
    edit.more_cameras.back().name = names.back();
  }
  asked.guide_cameras = guide_cameras(names);
  warn_of_lamps_without_size(*scene);
  scene = std::make_shared<const Scene>(*scene, std::move(edit));
  const auto tracer = std::make_shared<const Tracer>(*scene);
  catch_interrupts();
  std::string text = table_head(o);
  std::shared_ptr<JobMaps> maps;
  for (std::size_t i = 0; i < views.size(); ++i) {
    asked.camera = names[i];
    const Camera& camera = scene->camera(asked.camera);
    Job job(scene, tracer, asked, nullptr, {}, nullptr, nullptr, maps);
    finish_job(job, o.report.quiet);
    if (job.ending() == Ending::cancelled) return kExitSignalled + caught_interrupt();
    GlarePicture picture = picture_of(job);
    const double threshold = threshold_of(o, picture);
    add_details(job, *tracer, camera, threshold, picture);
    const Glare glare = rate_glare(picture, sources_of_suns(*tracer, camera, o.side), threshold);
    tell_glare(i + 1, glare);
    const Transform& m = camera.to_world;
    const auto axis = [&](Vec3 d) { return scene->to_file_axes(normalize(d)); };
    add_rows(text, i + 1, glare, {axis(m.x), axis(m.y), axis(m.z)});
    if (!pictures.empty())
      write_sources(pictures[i], picture, glare, radiance_view_text(camera, *scene, picture.width, picture.height),
                    files);
    maps = job.maps();
  }
  finish(o, text, files);
  return 0;
}

constexpr const char* kGlareFooter = R"help(
A line of the file of views gives a place and a direction as Radiance does, in metres and
the axes of the scene's file: -vp 1 1.2 2 -vd 0 0 -1 -vu 0 1 0. Each view is rendered as
an equidistant fisheye of 180 degrees; all of them share their photons. Sources are
connected pixels above --threshold; the sun is one of half a degree. Lamps without size
give light to the room, but are no sources. Lamps and sky are known at 16 places of a
pixel at the edge of a source; a source of less than ten pixels needs a larger --side.
In place of a scene you can give a fisheye picture (.hdr, .pic or .exr; -vta or -vth),
with its exposure and view in the header.

Examples:
  glowworm glare office.glb --views desks.vf --sky cie:12,35,180,30000 -o glare.csv
  glowworm glare photo.hdr -o glare.csv --picture sources.png)help";

}  // namespace

void add_glare_command(CLI::App& program, const std::string& command_line, int& exit_status) {
  auto o = std::make_shared<GlareOptions>();
  o->command_line = command_line;
  CLI::App* c = program.add_subcommand("glare", "Rates the glare of views: DGP, DGI, UGR.");
  add_scene_argument(*c, o->scene);
  add_text(*c, "Glare", "--views", o->views, "FILE", "Views of the scene, a line each: -vp X Y Z -vd X Y Z -vu X Y Z");
  add_text(*c, "Glare", "--view", o->view, "VIEW",
           "View of a picture without one in its header: \"-vta -vd X Y Z -vu X Y Z -vh 180 -vv 180\"");
  add_text(*c, "Glare", "--picture", o->picture, "FILE",
           "Picture to write as .png, .hdr or .exr: each source has a colour of its own, the rest is grey");
  add_text(*c, "Glare", "-o,--output", o->output, "FILE", "Table to write as CSV; - is standard output")->required();
  CLI::Option* const threshold =
      add_number(*c, "Glare", "--threshold", o->threshold, 1, 1e9, fmt::format("LUMINANCE [{:.0f}]", kGlareThreshold),
                 "Luminance above which pixels are sources of glare (cd/m^2)");
  add_text(*c, "Glare", "--task", o->task, "X,Y,ANGLE",
           "A circle in the picture that shows the task, by pixels from the lower left corner and radians across: "
           "sources begin at five times its mean luminance, as by evalglare -t X Y ANGLE -b 5")
      ->excludes(threshold);
  add_number(*c, "Glare", "--side", o->side, 16, 4096, fmt::format("PIXELS [{}]", o->side),
             "Pixels along a side of the pictures");
  add_light_option(*c, "Scene", o->lights);
  add_method_options(*c, Command::measure, *o);
  add_report_options(*c, false, o->report);
  c->footer(kGlareFooter);
  c->callback([o, &exit_status] { exit_status = run_glare(*o); });
}

}  // namespace glowworm
