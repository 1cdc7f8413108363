#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "apps/attend.h"
#include "apps/commands.h"
#include "apps/interrupt.h"
#include "apps/open_scene.h"
#include "apps/output_files.h"
#include "apps/picture_output.h"
#include "apps/sensor_options.h"
#include "apps/table_options.h"
#include "control/job.h"
#include "control/job_report.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/log.h"
#include "core/text.h"
#include "film/filtered.h"
#include "film/output.h"
#include "measure/alpha_opic.h"
#include "measure/doubts.h"
#include "measure/matrix_file.h"
#include "measure/measurement.h"
#include "measure/plan.h"
#include "measure/room_report.h"
#include "measure/sensor_plan.h"
#include "measure/sky_patches.h"
#include "measure/zones.h"
#include "scene/light_groups.h"
#include "settings/settings.h"

namespace glowworm {

namespace {

struct MeasureOptions : LightOptions {
  std::string page;
  SensorOptions sensors;
  std::vector<std::string> outputs;
  bool melanopic = false;
  std::vector<std::string> spectra;  ///< LAMP=SPECTRUM
  int sky_patches = 0;               ///< 0: no matrix
  std::optional<ColorScale> scale;   ///< lx, of pictures
};

/// The writer for a file of this name. Throws CommandLineError for an unknown ending.
std::function<std::string(const Measurement&)> writer_of(const MeasureOptions& o, const std::string& name) {
  using Writer = std::string (*)(const Measurement&, const std::string&);
  const std::map<std::string, Writer> tables = {
      {".csv", measurement_csv}, {".json", measurement_json}, {".ply", measurement_ply}, {".vtk", measurement_vtk}};
  const std::string ending = name == kStandardOutput ? ".csv" : lower_ending(name);
  const ColorScale scale = o.scale.value_or(ColorScale());
  if (ending == ".png") return [&o, scale](const Measurement& m) { return measurement_png(m, o.command_line, scale); };
  if (ending == ".html")
    return [&o, scale](const Measurement& m) { return measurement_page(m, o.command_line, scale); };
  const auto table = tables.find(ending);
  if (table == tables.end())
    throw CommandLineError(fmt::format("'{}' does not end in .csv, .json, .ply, .vtk, .png or .html", name),
                           "Give -o a name with one of these endings, or - for CSV on standard output.");
  return [&o, write = table->second](const Measurement& m) { return write(m, o.command_line); };
}

/// Throws CommandLineError if the format of a file does not suit the measurement.
void check_outputs(const MeasureOptions& o) {
  for (const std::string& name : o.outputs) {
    const bool is_matrix = lower_ending(name) == ".mtx";
    if (o.sky_patches == 0 && !is_matrix) writer_of(o, name);
    if (is_matrix != (o.sky_patches > 0))
      throw CommandLineError(is_matrix ? fmt::format("'{}' is a matrix, but --sky-patches is not given", name)
                                       : fmt::format("--sky-patches does not write '{}'", name),
                             "Give --sky-patches 145 (or 577) with -o FILE.mtx.");
  }
}

void check_options(const MeasureOptions& o) {
  o.sensors.check();
  if (o.outputs.empty() && o.page.empty())
    throw CommandLineError("no output was given", "Give -o FILE or --report FILE.");
  if (!o.page.empty() && (o.sensors.zones.empty() || o.sky_patches > 0))
    throw CommandLineError("--report needs zones and does not work with --sky-patches",
                           "Give --zone NAME=..., without --sky-patches.");
  check_outputs(o);
  read_command_line([&] {
    for (const std::string& spectrum : o.spectra) parse_lamp_spectrum(spectrum);
    if (!o.spectra.empty() && !o.melanopic) throw Error("--spectrum has no effect", "Give --melanopic, too.");
    if (o.melanopic && o.sky_patches > 0)
      throw Error("--melanopic does not work with --sky-patches", "Leave one of them out.");
    if (o.table.settings.samples == 1)
      throw Error("--samples 1 leaves the error of a measurement unknown", "Give two samples or more.");
  });
}

/// The settings that were asked for.
RenderSettings asked_settings(const MeasureOptions& o) {
  RenderSettings s = o.table.settings;
  s.memory_bytes = o.memory_bytes();
  if (o.melanopic) s.light_groups = s.separate_layers = true;
  return s;
}

/// What measures the sensors: paths or photons, as a pilot chooses. The spread of samples includes the noise of
/// photons.
SensorPlan plan_of(const MeasureOptions& o, const std::shared_ptr<const Scene>& scene,
                   const std::shared_ptr<const Tracer>& tracer, const PointGrid& grid, const RenderSettings& asked) {
  if (o.sky_patches > 0) return {patch_settings(sensor_settings(asked)), ""};
  const bool is_chosen = std::any_of(o.table.given.begin(), o.table.given.end(),
                                     [](const Option* option) { return option->name == std::string("--integrator"); });
  if (is_chosen) return {sensor_settings(asked), ""};
  return plan_sensors(scene, tracer, grid, asked, [](Job& pilot) { finish_job(pilot, true); });
}

std::string report_of(const MeasureOptions& o, const std::vector<Zone>& zones, const Measurement& measurement,
                      const Job& job, const Tracer& tracer) {
  const RenderSettings& s = job.settings();
  ReportTexts texts;
  texts.title = "Illuminance: " + job.scene().name();
  texts.command_line = o.command_line;
  texts.settings = {{"integrator", s.integrator == Integrator::path ? "path" : "gather"},
                    {"samples of each sensor", fmt::format("{}", job.snapshot().whole_passes())},
                    {"seed", fmt::format("{}", s.seed)},
                    {"time", fmt::format("{:.1f} s", job.seconds())},
                    {"luminous efficacy", fmt::format("{:g} lm/W", kLuminousEfficacy)}};
  texts.notes = choice_notes(o.table.settings, s);
  for (const std::string& note : job.scene().notes()) texts.notes.push_back(note);
  for (const std::string& doubt : doubts_after(measurement, job.scene())) texts.notes.push_back(doubt);
  return room_report(zones, measurement, luminaire_rows(o.changes.changes.luminaires), tracer, texts);
}

/// Writes the results of a job to all files.
void write_results(const MeasureOptions& o, const Sensors& sensors, const std::vector<Zone>& zones,
                   const std::vector<AlphaOpic>& efficacies, const SensorPlan& plan, const Job& job,
                   const Tracer& tracer, OutputFiles& files) {
  const Film film = job.snapshot();
  Measurement measurement = measurement_of(sensors, film, job.scene());
  if (!efficacies.empty()) measurement.alpha_opic = alpha_opic_irradiances(film, sensors.size(), efficacies);
  for (const std::string& name : o.outputs)
    files.write_text(name, [&] {
      return o.sky_patches > 0 ? matrix_text(daylight_matrix(job, sensors.size()), o.command_line)
                               : writer_of(o, name)(measurement);
    });
  files.write_text(o.page, [&] { return report_of(o, zones, measurement, job, tracer); });
  if (!o.report.statistics.empty())
    files.write(o.report.statistics, [&] { write_file(o.report.statistics, statistics_of(job, tracer).json + "\n"); });
  files.throw_if_any_failed();
  if (o.sky_patches == 0)
    for (const std::string& doubt : doubts_after(measurement, job.scene())) warn(doubt);
  FilmPicture measured = unfiltered_picture(film, false);
  measured.width = 0;  // sensors need not be beside each other
  const bool by_paths = job.settings().integrator == Integrator::path;
  const bool knows_error = std::any_of(measurement.relative_error.begin(), measurement.relative_error.end(),
                                       [](float error) { return std::isfinite(error); });
  inform(fmt::format("{} {} of each sensor in {:.2f} s, relative error {}{}", film.whole_passes(),
                     by_paths ? "paths" : "samples", job.seconds(),
                     knows_error ? fmt::format("{:.2g}", relative_error(measured)) : "unknown",
                     plan.reason.empty() ? "" : fmt::format(" ({})", plan.reason)));
}

/// The efficacies of the scene's lights for --melanopic; none without that. Says what makes the results approximate.
std::vector<AlphaOpic> light_efficacies(const MeasureOptions& o, const Scene& scene) {
  if (!o.melanopic) return {};
  std::vector<LampSpectrum> spectra;
  for (const std::string& text : o.spectra) spectra.push_back(parse_lamp_spectrum(text));
  std::vector<std::string> without;
  std::vector<AlphaOpic> out;
  read_command_line([&] { out = efficacies_of_groups(light_groups(scene), spectra, without); });
  if (!without.empty())
    inform(fmt::format("note: lights without --spectrum count as D65: {}", fmt::join(without, ", ")));
  std::vector<std::string> coloured = coloured_materials(scene);
  if (coloured.empty()) return out;
  constexpr std::size_t kShown = 5;
  const std::size_t count = coloured.size();
  coloured.resize(std::min(count, kShown));
  warn(
      fmt::format("coloured materials change the spectrum of the light that they reflect: its alpha-opic part is "
                  "approximate. There are {}: {}{}",
                  count, fmt::join(coloured, ", "), count > kShown ? ", ..." : ""));
  return out;
}

int run_measure(MeasureOptions& o) {
  o.apply();
  check_options(o);
  const RenderSettings asked = asked_settings(o);
  OutputFiles files;
  files.add_input("the scene", o.scene);
  files.add_input("--points", o.sensors.points);
  for (const std::string& name : o.outputs) files.add("-o", name);
  files.add("--report", o.page);
  files.add("--stats", o.report.statistics);
  files.probe_all();
  const auto start = std::chrono::steady_clock::now();
  std::shared_ptr<const Scene> scene = open_measured_scene(o, o.scene, files);
  if (o.sky_patches > 0) scene = std::make_shared<const Scene>(scene_under_patches(*scene, SkyPatches(o.sky_patches)));
  const auto loaded = std::chrono::steady_clock::now();
  const auto tracer = std::make_shared<const Tracer>(*scene);
  const auto built = std::chrono::steady_clock::now();
  const std::vector<AlphaOpic> efficacies = light_efficacies(o, *scene);
  MemoryBudget budget(asked.memory_bytes);
  std::vector<Zone> zones;
  const Sensors sensors = make_sensors(o.sensors, *tracer, budget, zones, true);
  if (o.sky_patches == 0)
    for (const std::string& doubt : doubts_before(sensors, *tracer)) warn(doubt);
  catch_interrupts();
  const auto grid = std::make_shared<const PointGrid>(
      sensor_grid(sensors, o.sensors.on_surfaces(), o.sky_patches > 0 ? kPatchBatches : kSensorBatches));
  const SensorPlan plan = plan_of(o, scene, tracer, *grid, with_room_for(sensors.size(), asked));
  Job job(scene, tracer, plan.settings, nullptr, plan.end(), grid);
  inform(
      fmt::format("{}: {} triangles, {} sensors", scene->name(), scene->geometry().triangle_count(), sensors.size()));
  if (o.sky_patches > 0)
    inform(fmt::format("{} patches of the sky and the ground; other lights are off", o.sky_patches));
  if (!plan.reason.empty()) detail("chosen: " + plan.reason);
  for (const std::string& note : choice_notes(o.table.settings, job.settings())) detail("chosen: " + note);
  finish_job(job, o.report.quiet);
  if (job.snapshot().whole_passes() < 2) {
    warn("the measurement ended before every sensor had two samples: no file was written");
    return job.ending() == Ending::cancelled ? kExitSignalled + caught_interrupt() : 1;
  }
  job.statistics().add_time(Phase::load, std::chrono::duration<double>(loaded - start).count());
  job.statistics().add_time(Phase::build_accel, std::chrono::duration<double>(built - loaded).count());
  job.statistics().add_time(Phase::total, std::chrono::duration<double>(built - start).count());
  write_results(o, sensors, zones, efficacies, plan, job, *tracer, files);
  if (job.samples_not_finite() > 0)
    warn(fmt::format("{} samples are black, because their light was beyond what can be summed",
                     job.samples_not_finite()));
  return job.ending() == Ending::cancelled ? kExitSignalled + caught_interrupt() : 0;
}

constexpr const char* kMeasureFooter = R"help(
Sensors measure the light that arrives from the half space around their normal:
irradiance in W m^-2 for each channel of linear RGB, and illuminance in lx by 179 lm/W.
The columns of CSV are x,y,z,nx,ny,nz,E_W_m2,E_R,E_G,E_B,E_lx,relative_error; E_W_m2 is
the mean of the channels, relative_error the error of E_lx over E_lx: the truth lies
within twice of it with a chance of 95%. Where no sample found light, it is unknown:
inf, or null in JSON.
A .pts file has a sensor a line: x y z nx ny nz. Sensors inside of objects that are closed
all around are refused, and left out of --grid. Sensors inside of an object without a
bottom, or of one that is half as long as the scene, measure darkness. Photons are new
for each sample, so that relative_error contains their noise.
Unless --integrator, --gather or --photons is given, pilot measurements choose paths or
photons, whichever take less work, and as many as an error of 2% takes, or --noise or
--time allow; the last line says which. --samples N are N times 256 paths then.
Where paths end by --noise, each sensor takes 256 at least: fewer may all miss a lamp,
and then agree on a wrong value.

Examples:
  glowworm measure builtin:ajar --grid y=0.8,0.5 -o lux.csv
  glowworm measure office.glb --points desks.pts --noise 1% -o lux.csv -o lux.vtk
  glowworm measure office.glb --grid y=0.8,0.25 -o lux.html --false-color 50,2000
  glowworm measure office.glb --surface table,0.1 --sky cie:16 -o table.json
  glowworm measure office.glb --points desks.pts --light lamp.ies@2,2.8,1 -o -
  glowworm measure office.glb --zone desk=1,0.8,1,3,0.8,2 --zone floor=Floor --report room.html
  glowworm measure office.glb --points eyes.pts --melanopic --spectrum all=4000 -o edi.csv
  glowworm measure office.glb --points desks.pts --sky-patches 145 -o daylight.mtx

The matrix has the irradiance for a radiance of 1 from the ground and from each patch,
as Radiance's rfluxmtx writes it and dctimestep reads it; y is up, -z is north.
With NumPy, sensors x (ground and patches) x RGB are
  text = open("daylight.mtx").read().split("\n\n", 1)[1]
  matrix = np.loadtxt(text.splitlines(), ndmin=2).reshape(-1, 146, 3)
and the irradiance under a sky of radiances sky[146, 3] is
  np.einsum("spc,pc->sc", matrix, sky))help";

}  // namespace

void add_measure_command(CLI::App& program, const std::string& command_line, int& exit_status) {
  auto o = std::make_shared<MeasureOptions>();
  o->command_line = command_line;
  CLI::App* c = program.add_subcommand("measure", "Measures irradiance and illuminance at points.");
  add_scene_argument(*c, o->scene);
  add_sensor_options(*c, o->sensors);
  add_list(*c, "Sensors", "-o,--output", o->outputs, "FILE",
           "File to write: a table as .csv, .json, .ply or .vtk, a plan in false colour as .png, or a report as .html; "
           "- is CSV on standard output");
  add_text(*c, "Sensors", "--report", o->page, "FILE.html",
           "Report of the zones for A4: mean, minimum, uniformity, cylindrical illuminance, UGR, plans with isolines, "
           "luminaires, settings");
  add_sky_patches_option(
      *c, "Sensors", o->sky_patches, "145|577",
      "Write the daylight matrix of 145 (Tregenza) or 577 (Reinhart) patches of the sky to .mtx files");
  c->add_flag("--melanopic", o->melanopic,
              "Add the melanopic equivalent daylight illuminance (lx) and the five alpha-opic irradiances of CIE S 026 "
              "(W m^-2), by the spectrum of each light: exact where surfaces are grey")
      ->group("Sensors");
  add_list(*c, "Sensors", "--spectrum", o->spectra, "LAMP=SPECTRUM [all=D65]",
           "The spectrum of a light (as --light names it, or all), for --melanopic: A, D50, D55, D65, D75, E, F2, F7, "
           "F11; a colour temperature (K); or a file of nm and power, .spd or .csv");
  add_false_color_option(*c, "Sensors", "Scale of .png and .html from LOW to HIGH (lx)", o->scale);
  add_light_option(*c, "Scene", o->lights);
  add_method_options(*c, Command::measure, *o);
  add_report_options(*c, true, o->report);
  c->footer(kMeasureFooter);
  c->callback([o, &exit_status] { exit_status = run_measure(*o); });
}

}  // namespace glowworm
