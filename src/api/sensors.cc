// The public header glowworm/sensors.h.
#include "glowworm/sensors.h"

#include <memory>
#include <string>

#include "api/run_job.h"
#include "api/scene_implementation.h"
#include "api/sensor_input.h"
#include "control/job.h"
#include "core/error.h"
#include "core/log.h"
#include "measure/doubts.h"
#include "measure/measurement.h"
#include "measure/sensor_plan.h"
#include "settings/options.h"

namespace glowworm::api {

namespace {

/// The settings of `glowworm measure`.
RenderSettings measure_settings(const RenderOptions& options) {
  RenderSettings s = settings_of(options, Command::measure);
  if (s.memory_bytes == 0) s.memory_bytes = default_memory_bytes();
  if (s.samples == 1) throw Error("with 1 sample the error of a measurement is unknown", "Give two samples or more.");
  s.separate_layers = true;
  return s;
}

Rgb outer(RGB c) { return {c.r, c.g, c.b}; }

}  // namespace

std::vector<std::string> measure_option_names() { return option_names(Command::measure); }

Measurement measure(const Scene& scene, std::span<const Vec3> position, std::span<const Vec3> normal,
                    const MeasureOptions& options, const std::function<void(double)>& progress) {
  const Scene::Implementation& inner = scene.implementation();
  const std::shared_ptr<const glowworm::Scene> lit = lit_by_its_own(inner.scene);
  const auto tracer = lit == inner.scene ? inner.tracer : std::make_shared<const glowworm::Tracer>(*lit);
  const Sensors sensors = sensors_of(position, normal, *tracer, options.on_surfaces);
  for (const std::string& doubt : doubts_before(sensors, *tracer)) warn(doubt);
  const auto grid = std::make_shared<const PointGrid>(sensor_grid(sensors, options.on_surfaces));
  const RenderSettings asked = with_room_for(sensors.size(), measure_settings(options.render));
  const auto wait = [&](Job& pilot) { attend(pilot, {}); };
  const SensorPlan plan = plan_sensors(lit, tracer, *grid, asked, wait);
  Job job(lit, tracer, plan.settings, nullptr, plan.end(), grid);
  attend(job, progress);
  const Film film = job.snapshot();
  if (film.whole_passes() < 2)
    throw Error("the measurement ended before every sensor had two samples", "Give it more time.");
  const glowworm::Measurement measured = measurement_of(sensors, film, *lit);
  for (const std::string& doubt : doubts_after(measured, *lit)) warn(doubt);
  Measurement out;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    out.irradiance.push_back(outer(measured.irradiance[i]));
    out.direct.push_back(outer(film.mean(Film::Layer::direct, i)));
    out.indirect.push_back(outer(film.mean(Film::Layer::indirect, i)));
    out.caustic.push_back(outer(film.mean(Film::Layer::caustic, i)));
    out.illuminance.push_back(illuminance(measured.irradiance[i]));
  }
  out.relative_error = measured.relative_error;
  return out;
}

}  // namespace glowworm::api
