#include "measure/measurement.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

namespace glowworm {

RenderSettings sensor_settings(RenderSettings settings) {
  settings.progressive = settings.integrator != Integrator::path;
  settings.default_gather = 256;
  settings.filter = Filtering::off;
  return settings;
}

JobTime sensor_time() { return {0, nullptr, 2}; }

Measurement measurement_of(const Sensors& sensors, const Film& film, const Scene& scene) {
  Measurement out;
  out.sensors = sensors;
  for (Vec3& p : out.sensors.position) p = scene.outside(p);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const RGB e = film.radiance(i, false);
    const float level = luminance(e), deviation = std::sqrt(film.variance(i));
    out.irradiance.push_back(e);
    out.relative_error.push_back(level > 0 ? deviation / level : 0.0f);
  }
  return out;
}

float illuminance(RGB irradiance) { return kLuminousEfficacy * luminance(irradiance); }

std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

std::string measurement_csv(const Measurement& m, const std::string& about) {
  std::string text = fmt::format(
      "# {}\n# places in m; irradiance E_W_m2 (mean of the channels), E_R, E_G, E_B in W m^-2; illuminance E_lx in lx, "
      "by "
      "{} lm/W\n# relative_error: standard error of E_lx over E_lx\n"
      "x,y,z,nx,ny,nz,E_W_m2,E_R,E_G,E_B,E_lx,relative_error\n",
      one_line(about), kLuminousEfficacy);
  for (std::size_t i = 0; i < m.sensors.size(); ++i) {
    const Vec3 p = m.sensors.position[i], n = m.sensors.normal[i];
    const RGB e = m.irradiance[i];
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.3g}\n", p.x, p.y,
                   p.z, n.x, n.y, n.z, mean(e), e.r, e.g, e.b, illuminance(e), m.relative_error[i]);
  }
  return text;
}

std::string measurement_json(const Measurement& m, const std::string& about) {
  using nlohmann::json;
  json out = {{"about", about}, {"lumens_per_watt", kLuminousEfficacy}, {"points", json::array()}};
  for (std::size_t i = 0; i < m.sensors.size(); ++i) {
    const Vec3 p = m.sensors.position[i], n = m.sensors.normal[i];
    const RGB e = m.irradiance[i];
    out["points"].push_back({{"x", p.x},
                             {"y", p.y},
                             {"z", p.z},
                             {"nx", n.x},
                             {"ny", n.y},
                             {"nz", n.z},
                             {"E_W_m2", mean(e)},
                             {"E_R", e.r},
                             {"E_G", e.g},
                             {"E_B", e.b},
                             {"E_lx", illuminance(e)},
                             {"relative_error", m.relative_error[i]}});
  }
  return out.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

std::string measurement_ply(const Measurement& m, const std::string& about) {
  std::string text =
      fmt::format("ply\nformat ascii 1.0\ncomment {}\nelement vertex {}\n", one_line(about), m.sensors.size());
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "E_W_m2", "E_lx", "relative_error"})
    text += fmt::format("property float {}\n", name);
  text += "end_header\n";
  for (std::size_t i = 0; i < m.sensors.size(); ++i) {
    const Vec3 p = m.sensors.position[i], n = m.sensors.normal[i];
    fmt::format_to(std::back_inserter(text), "{} {} {} {} {} {} {:.6g} {:.6g} {:.3g}\n", p.x, p.y, p.z, n.x, n.y, n.z,
                   mean(m.irradiance[i]), illuminance(m.irradiance[i]), m.relative_error[i]);
  }
  return text;
}

std::string measurement_vtk(const Measurement& m, const std::string& about) {
  const std::size_t count = m.sensors.size();
  // The format allows a title of 256 characters.
  std::string text = fmt::format("# vtk DataFile Version 3.0\n{}\nASCII\nDATASET POLYDATA\nPOINTS {} float\n",
                                 one_line(about).substr(0, 255), count);
  for (const Vec3 p : m.sensors.position) fmt::format_to(std::back_inserter(text), "{} {} {}\n", p.x, p.y, p.z);
  text += fmt::format("VERTICES {} {}\n", count, 2 * count);
  for (std::size_t i = 0; i < count; ++i) fmt::format_to(std::back_inserter(text), "1 {}\n", i);
  text += fmt::format("POINT_DATA {}\nNORMALS normals float\n", count);
  for (const Vec3 n : m.sensors.normal) fmt::format_to(std::back_inserter(text), "{} {} {}\n", n.x, n.y, n.z);
  const auto scalars = [&](const char* name, const auto& value) {
    text += fmt::format("SCALARS {} float 1\nLOOKUP_TABLE default\n", name);
    for (std::size_t i = 0; i < count; ++i) fmt::format_to(std::back_inserter(text), "{:.6g}\n", value(i));
  };
  scalars("E_W_m2", [&](std::size_t i) { return mean(m.irradiance[i]); });
  scalars("E_lx", [&](std::size_t i) { return illuminance(m.irradiance[i]); });
  scalars("relative_error", [&](std::size_t i) { return m.relative_error[i]; });
  return text;
}

}  // namespace glowworm
