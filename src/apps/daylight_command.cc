#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/attend.h"
#include "apps/commands.h"
#include "apps/fisheye_views.h"
#include "apps/interrupt.h"
#include "apps/open_scene.h"
#include "apps/output_files.h"
#include "apps/sensor_options.h"
#include "apps/table_options.h"
#include "control/job.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/input_file.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/text.h"
#include "measure/annual_metrics.h"
#include "measure/find_year.h"
#include "measure/measurement.h"
#include "measure/view_year.h"
#include "measure/year.h"
#include "measure/year_files.h"
#include "measure/zones.h"
#include "scene/radiance_view.h"

namespace glowworm {

namespace {

struct DaylightOptions : LightOptions {
  std::string weather, output, metrics, hours = "8-18", schedule, shade_schedule;
  std::string write_matrix, write_sky, sky_matrix, useful = "100,300,3000";
  SensorOptions sensors;
  std::vector<std::string> shades, boxes;
  std::string views, dgp;
  int patches = 145;
  std::uint32_t side = kViewSide;
  double turn = 0;  // degrees: SkyMoment::turn
  double ground = 0.2, sun_step = 7.5, autonomy = 300, sun_lux = 1000, sun_hours = 250, glare = 0.4;

  /// Shows the progress of the work on a state of the scene.
  YearWatch watched() const {
    const auto bar = std::make_shared<ProgressBar>(!report.quiet);
    return {[bar](Job& job, YearProgress part) { finish_job(job, *bar, part.before, part.share); },
            [bar](double share) {
              bar->update(share, "rays to the sun");
              if (share >= 1) bar->finish();
            }};
  }
};

MetricLimits limits_of(const DaylightOptions& o) {
  MetricLimits out;
  const std::vector<double> useful = numbers_of<double>(o.useful);
  if (useful.size() == out.useful.size()) std::copy(useful.begin(), useful.end(), out.useful.begin());
  if (useful.size() != out.useful.size() || !out.are_sound())
    throw CommandLineError(fmt::format("--udi '{}' are not three rising illuminances", o.useful),
                           "Write lx, for example 100,300,3000.");
  out.autonomy = o.autonomy;
  out.sun = o.sun_lux;
  out.sun_hours = o.sun_hours;
  out.glare = o.glare;
  return out;
}

void check_options(const DaylightOptions& o) {
  if (o.views.empty() != o.dgp.empty()) throw CommandLineError("--views and --dgp are given together or not at all");
  if (o.views.empty() && o.side != kViewSide)
    throw CommandLineError("--side is the size of pictures of --views", "Give --views, or leave --side out.");
  if (!o.dgp.empty() && o.dgp != kStandardOutput && lower_ending(o.dgp) != ".csv")
    throw CommandLineError(fmt::format("'{}' does not end in .csv", o.dgp));
  if (o.views.empty() || o.sensors.are_given()) o.sensors.check();
  if (o.output.empty() && o.metrics.empty() && o.write_matrix.empty() && o.write_sky.empty() && o.dgp.empty())
    throw CommandLineError("no output was given", "Give -o, --metrics, --dgp, --write-matrix or --write-sky.");
  if (!o.output.empty() && o.output != kStandardOutput && lower_ending(o.output) != ".csv" &&
      lower_ending(o.output) != ".mtx")
    throw CommandLineError(fmt::format("'{}' does not end in .csv or .mtx", o.output));
  if (!o.metrics.empty() && lower_ending(o.metrics) != ".csv" && lower_ending(o.metrics) != ".json")
    throw CommandLineError(fmt::format("'{}' does not end in .csv or .json", o.metrics));
  if (o.shades.empty() != o.shade_schedule.empty())
    throw CommandLineError("--shade and --shade-schedule are given together or not at all");
  for (const char* const option : {"--sky", "--environment", "--environment-scale"})
    if (std::count(o.changes.given.begin(), o.changes.given.end(), option) > 0)
      throw CommandLineError(fmt::format("{} does not apply: the sky of a year is that of --epw", option));
  read_command_line([&] { check_year_settings(o.table.settings); });
  limits_of(o);
}

/// The files that the command reads and writes.
OutputFiles files_of(const DaylightOptions& o) {
  OutputFiles files;
  files.add_input("the scene", o.scene);
  files.add_input("--epw", o.weather);
  files.add_input("--points", o.sensors.points);
  files.add_input("--views", o.views);
  files.add_input("--schedule", o.schedule);
  files.add_input("--shade-schedule", o.shade_schedule);
  files.add_input("--sky-matrix", o.sky_matrix);
  for (const std::string& shade : o.shades) files.add_input("--shade", shade);
  files.add("-o", o.output);
  files.add("--metrics", o.metrics);
  files.add("--dgp", o.dgp);
  files.add("--write-matrix", o.write_matrix);
  files.add("--write-sky", o.write_sky);
  files.probe_all();
  return files;
}

/// What is read before any scene.
struct YearInputs {
  YearModel model;
  std::vector<std::uint8_t> occupied;
  std::vector<std::uint32_t> state_of_hour;
};

YearInputs read_inputs(const DaylightOptions& o) {
  const WeatherYear weather = parse_weather_year(read_input_file(o.weather), o.weather, o.turn);
  for (const std::string& note : weather.notes) inform(fmt::format("note: {}: {}", o.weather, note));
  YearInputs out{YearModel(weather, o.weather, o.patches, o.ground, o.sun_step), {}, {}};
  if (!o.sky_matrix.empty())
    replace_sky(out.model.sky, parse_matrix(read_input_file(o.sky_matrix), o.sky_matrix), o.sky_matrix);
  const std::size_t hours = weather.hours.size();
  if (o.schedule.empty())
    read_command_line([&] { out.occupied = occupied_hours(o.hours, weather.hours); });
  else
    for (const std::uint32_t v : parse_schedule(read_input_file(o.schedule), o.schedule, hours, 1))
      out.occupied.push_back(v != 0);
  if (!o.shades.empty())
    out.state_of_hour = parse_schedule(read_input_file(o.shade_schedule), o.shade_schedule, hours,
                                       static_cast<std::uint32_t>(o.shades.size()));
  return out;
}

/// A scene as read, and under the sky.
struct ReadScene {
  std::shared_ptr<const Scene> plain;
  YearScene sky;
};

ReadScene open_lit(DaylightOptions& o, const std::string& path, const YearInputs& inputs, OutputFiles& files) {
  std::shared_ptr<const Scene> plain = open_measured_scene(o, path, files);
  YearScene sky = under_sky(*plain, inputs.model);
  return {std::move(plain), std::move(sky)};
}

/// Finds coefficients; nothing after a Ctrl-C.
std::optional<FoundState> find_shown(const DaylightOptions& o, const ReadScene& scene, const Sensors& sensors,
                                     const YearInputs& inputs) {
  return find_state(*scene.plain, scene.sky, sensors, o.sensors.on_surfaces(), inputs.model, o.table.settings,
                    o.watched());
}

/// The eyes of views as sensors that face as they do.
Sensors sensors_of_views(const std::vector<RadianceView>& views, const Scene& scene) {
  Sensors out;
  for (const RadianceView& view : views) {
    const Camera camera = camera_of(view, scene);
    out.add(camera.to_world.translation, normalize(camera.to_world.z));
  }
  return out;
}

/// Whether what sensors get is asked for.
bool measures(const DaylightOptions& o) {
  return o.sensors.are_given() || !o.output.empty() || !o.metrics.empty() || !o.write_matrix.empty();
}

/// Rates the views in the hours of a state of the scene; false after a Ctrl-C.
bool rate_state(const DaylightOptions& o, const ReadScene& scene, const std::vector<RadianceView>& views,
                std::size_t state, const YearInputs& inputs, std::vector<ViewYear>& out) {
  if (views.empty()) return true;
  std::vector<Camera> cameras;
  for (const RadianceView& view : views) cameras.push_back(camera_of(view, *scene.plain));
  return rate_views(*scene.plain, cameras, o.side, inputs.model,
                    hours_of_state(inputs.model.sky, inputs.state_of_hour, state), o.table.settings, o.watched(), out);
}

RatedYear rate(const DaylightOptions& o, const Year& year, const YearInputs& inputs, const Sensors& sensors,
               const std::vector<Zone>& zones, const Scene& scene, const YearState& bare,
               const std::vector<float>& relative_error) {
  constexpr float kLevel = 0.02f;  // of a normal: a degree
  RatedYear out;
  out.limits = limits_of(o);
  out.metrics = metrics_of(year, inputs.occupied, out.limits);
  out.daylight_factor = share_under(bare.coefficients, overcast_sky(inputs.model.patches, o.ground));
  out.relative_error = relative_error;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    out.place.push_back(scene.to_file_axes(scene.outside(sensors.position[i])));
    out.normal.push_back(scene.to_file_axes(sensors.normal[i]) + Vec3{0, 0, 0});
    out.upright.push_back(std::abs(sensors.normal[i].y) < kLevel);
  }
  std::vector<std::uint32_t> all(sensors.size());
  std::iota(all.begin(), all.end(), 0u);
  const auto add_zone = [&](const std::string& name, std::span<const std::uint32_t> chosen) {
    out.zone_names.push_back(name);
    out.zones.push_back(metrics_of_zone(out.metrics, chosen, sensors.weight, out.limits));
  };
  add_zone("all", all);
  for (const Zone& zone : zones) add_zone(zone.name, std::span(all).subspan(zone.first, zone.count));
  for (const std::string& text : o.boxes) {
    const RatedBox box = parse_rated_box(text);
    std::vector<std::uint32_t> chosen;
    for (const std::uint32_t i : all)
      if (sensors.weight[i] > 0 && box.contains(out.place[i])) chosen.push_back(i);
    if (chosen.empty()) throw Error(fmt::format("no sensor is in --box '{}'", text));
    add_zone(box.name, chosen);
  }
  return out;
}

/// A year as a matrix of irradiance, as dctimestep writes it: times 179 it is illuminance.
ColorMatrix matrix_of_year(const Year& year) {
  ColorMatrix out{year.sensors, year.hours, {}};
  for (const float lux : year.total) out.value.emplace_back(lux / kLuminousEfficacy);
  return out;
}

void write_year(const DaylightOptions& o, const Year& year, const YearInputs& inputs, const RatedYear& rated,
                const std::vector<YearState>& states, const std::vector<ViewYear>& views, OutputFiles& files) {
  files.write_text(o.output, [&] {
    return lower_ending(o.output) == ".mtx" ? matrix_text(matrix_of_year(year), o.command_line)
                                            : year_csv(year, inputs.model.sky.hours, o.command_line);
  });
  files.write_text(o.metrics, [&] {
    return lower_ending(o.metrics) == ".json" ? metrics_json(rated, o.command_line)
                                              : metrics_csv(rated, o.command_line);
  });
  files.write_text(o.dgp, [&] { return glare_csv(views, inputs.model.sky.hours, inputs.occupied, o.command_line); });
  files.write_text(o.write_matrix, [&] { return matrix_text(states.front().coefficients.sky, o.command_line); });
  files.write_text(o.write_sky, [&] { return matrix_text(matrix_of_sky(inputs.model.sky), o.command_line); });
  files.throw_if_any_failed();
}

int run_daylight(DaylightOptions& o) {
  o.apply();
  check_options(o);
  o.turn = std::exchange(o.changes.changes.environment_turn, 0.0f);
  for (const std::string& box : o.boxes) read_command_line([&] { parse_rated_box(box); });
  OutputFiles files = files_of(o);
  const std::uint64_t memory_bytes = o.memory_bytes();
  const YearInputs inputs = read_inputs(o);
  const std::vector<RadianceView> views = o.views.empty() ? std::vector<RadianceView>() : read_fisheyes(o.views);
  std::vector<ViewYear> rated_views(views.size(), ViewYear(inputs.model.sky.hours.size()));
  const SunGrid& suns = inputs.model.suns;
  const ReadScene first = open_lit(o, o.scene, inputs, files);
  MemoryBudget budget(memory_bytes);
  std::vector<Zone> zones;
  const Sensors sensors = o.sensors.are_given() ? make_sensors(o.sensors, *first.sky.tracer, budget, zones, false)
                                                : sensors_of_views(views, *first.plain);
  if (!views.empty()) check_view_room(o.side, inputs.model, memory_bytes);
  check_year_room(sensors.size(), inputs.model.sky.hours.size(), 1 + o.shades.size(), memory_bytes);
  inform(fmt::format("{}: {} triangles, {} sensors, {} hours with light, {} patches of the sky, {} places of the sun",
                     first.plain->name(), first.plain->geometry().triangle_count(), sensors.size(),
                     inputs.model.sky.lit.size(), o.patches, suns.places().size()));
  catch_interrupts();
  std::vector<YearState> states;
  std::vector<float> relative_error;  // of the first state
  try {
    const CancellationScope scope(signal_interrupt());
    for (std::size_t state = 0; state <= o.shades.size(); ++state) {
      const ReadScene lit = state == 0 ? first : open_lit(o, o.shades[state - 1], inputs, files);
      if (measures(o)) {
        std::optional<FoundState> here = find_shown(o, lit, moved_sensors(sensors, *first.plain, *lit.plain), inputs);
        if (!here) return kExitSignalled + caught_interrupt();
        if (state == 0) relative_error = std::move(here->relative_error);
        states.push_back(std::move(here->state));
      }
      if (!rate_state(o, lit, views, state, inputs, rated_views)) return kExitSignalled + caught_interrupt();
    }
  } catch (const Cancelled&) {
    return kExitSignalled + caught_interrupt();
  }
  Year year;
  RatedYear rated;
  if (measures(o)) {
    year = year_of(inputs.model.sky, suns, states, inputs.state_of_hour);
    rated = rate(o, year, inputs, sensors, zones, *first.plain, states.front(), relative_error);
  }
  for (std::size_t i = 0; i < rated.zones.size(); ++i)
    inform(zone_text(rated.zone_names[i], rated.zones[i], rated.limits));
  for (std::size_t i = 0; i < rated_views.size(); ++i) inform(glare_text(i, rated_views[i], inputs.occupied));
  write_year(o, year, inputs, rated, states, rated_views, files);
  return 0;
}

constexpr const char* kDaylightFooter = R"help(
Sky and sun of every hour follow the weather file by Perez (1990, 1993); the hour's sun
stands in the middle of the time that it is up. Light of the sky comes by daylight
coefficients of its patches; direct sunlight by rays towards the actual sun; reflected
sunlight is interpolated between sun positions --sun-step degrees apart: smaller steps
are closer for sensors beside a patch of sun. Illuminance is in lx by 179 lm/W of visible
light.
Radiance's gendaymtx spreads the sun over four patches and takes the middle of each
patch; here patches have their mean radiance and the sun is apart. --write-matrix and
--write-sky files suit dctimestep; their product lacks the sun.
Metrics count occupied hours: sDA and ASE as in LM-83 (the sun without bounces, the
scene without its shades), UDI in four bins, simplified DGP for sensors that face the
horizon. The mean over hours is within twice relative_error of the truth with a chance
of 95%. --samples N makes N/2 rounds; without it, rounds end at --noise (2.5%) or --time.
--views rates glare by luminances: DGP of every hour and view, from fisheye pictures that
keep patches of the sky and places of the sun apart, with the sun and its mirror images as
sources at their real places, as 'glowworm glare' has them. These pictures have 8 samples a
pixel, whatever --samples, --noise and --time say; four renders of 2 samples give the errors.
Without sensors, the eyes are the sensors.
A schedule has a number a line for every hour of the weather file: 1 for occupied, or
the scene of the hour, 0 for SCENE and N for the N-th --shade.

Examples:
  glowworm daylight office.glb --epw munich.epw --points desks.pts -o year.csv
  glowworm daylight office.glb --epw munich.epw --grid y=0.8,0.5 --metrics rooms.json
  glowworm daylight office.glb --epw munich.epw --zone south=0,0.8,1,6,0.8,4 --metrics m.csv
  glowworm daylight office.glb --epw munich.epw --views desks.vf --dgp glare.csv
  glowworm daylight up.glb --epw a.epw --grid y=0.8,0.5 --shade down.glb
      --shade-schedule blinds.txt --box south,0,0,0,6,1,4 --metrics rooms.csv)help";

void add_year_options(CLI::App& c, DaylightOptions& o) {
  const auto number = [&](const std::string& name, double& value, double least, double most, const char* unit,
                          const std::string& help) {
    add_number(c, "Year", name, value, least, most, fmt::format("{} [{}]", unit, value), help);
  };
  add_text(c, "Year", "--epw", o.weather, "FILE", "Weather file of EnergyPlus")->required();
  add_text(c, "Year", "-o,--output", o.output, "FILE",
           "Illuminance of every hour and sensor as .csv, or as a matrix of Radiance as .mtx; - is CSV on standard "
           "output");
  add_text(c, "Year", "--metrics", o.metrics, "FILE", "Metrics of sensors and zones as .csv or .json");
  add_text(c, "Year", "--views", o.views, "FILE",
           "Views to rate for glare, a line each: -vp X Y Z -vd X Y Z -vu X Y Z");
  add_text(c, "Year", "--dgp", o.dgp, "FILE", "DGP of every hour and view as .csv; - is standard output");
  add_number(c, "Year", "--side", o.side, 16, 1024, fmt::format("PIXELS [{}]", kViewSide),
             "Pixels along a side of the pictures of views");
  add_text(c, "Year", "--hours", o.hours, "FROM-TO [" + o.hours + "]", "Occupied hours of every day, standard time");
  add_text(c, "Year", "--schedule", o.schedule, "FILE", "Occupied hours, in place of --hours: 0 or 1 a line");
  add_list(c, "Year", "--shade", o.shades, "SCENE", "The scene in another state of its shades");
  add_text(c, "Year", "--shade-schedule", o.shade_schedule, "FILE",
           "The state of each hour: 0, or N of the N-th --shade");
  add_list(c, "Year", "--box", o.boxes, "NAME,X0,Y0,Z0,X1,Y1,Z1", "Rate the sensors in a box together (m)");
  add_sky_patches_option(c, "Year", o.patches, "145|577 [145]", "Patches of the sky: 145 (Tregenza) or 577 (Reinhart)");
  number("--sun-step", o.sun_step, 2, 30, "DEGREES", "Degrees between places of the sun for its reflected light");
  number("--ground", o.ground, 0, 1, "SHARE", "Reflectance of the ground outside");
  number("--da-lux", o.autonomy, 1, 1e6, "LX", "Illuminance of daylight autonomy (lx)");
  add_text(c, "Year", "--udi", o.useful, "LX,LX,LX [" + o.useful + "]", "Limits of useful daylight illuminance");
  number("--ase-lux", o.sun_lux, 1, 1e6, "LX", "Direct sunlight that counts as exposure (lx)");
  number("--ase-hours", o.sun_hours, 0, 8784, "HOURS", "A place with more hours than this is exposed");
  number("--dgps", o.glare, 0.184, 1, "DGPS", "Simplified DGP from which hours count as glare");
  add_text(c, "Year", "--write-matrix", o.write_matrix, "FILE", "Daylight matrix of SCENE (.mtx)");
  add_text(c, "Year", "--write-sky", o.write_sky, "FILE", "Sky matrix of the year (.smx)");
  add_text(c, "Year", "--sky-matrix", o.sky_matrix, "FILE",
           "Sky matrix of gendaymtx -s in place of the sky of --epw, which still gives the sun");
}

}  // namespace

void add_daylight_command(CLI::App& program, const std::string& command_line, int& exit_status) {
  auto o = std::make_shared<DaylightOptions>();
  o->command_line = command_line;
  CLI::App* c = program.add_subcommand("daylight", "Finds the daylight of a year at points: sDA, ASE, UDI.");
  add_scene_argument(*c, o->scene);
  add_sensor_options(*c, o->sensors);
  add_year_options(*c, *o);
  add_method_options(*c, Command::measure, *o);
  add_report_options(*c, false, o->report);
  c->footer(kDaylightFooter);
  c->callback([o, &exit_status] { exit_status = run_daylight(*o); });
}

}  // namespace glowworm
