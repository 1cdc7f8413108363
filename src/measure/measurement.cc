#include "measure/measurement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/json_text.h"
#include "core/memory_budget.h"

namespace glowworm {

namespace {

/// The type of coordinates in files: float, unless the origin would round them.
const char* coordinate_type(const Measurement& m) { return m.origin == Vec3{0, 0, 0} ? "float" : "double"; }

/// The three coordinates with a separator between them, and all digits that they have.
std::string place_of(const Measurement& m, std::size_t sensor, char separator) {
  const auto coordinate = [&](int axis) {
    return m.origin[axis] == 0 ? fmt::format("{}", m.sensors.position[sensor][axis])
                               : fmt::format("{:.12g}", m.place(sensor)[axis]);
  };
  return fmt::format("{}{}{}{}{}", coordinate(0), separator, coordinate(1), separator, coordinate(2));
}

/// A column that only some measurements have.
struct MoreColumn {
  std::string name;
  std::vector<double> values;
};

std::vector<MoreColumn> more_columns(const Measurement& m) {
  std::vector<MoreColumn> out;
  if (m.alpha_opic.empty()) return out;
  out.push_back({"melanopic_EDI_lx", {}});
  for (const char* response : kAlphaOpicNames) out.push_back({fmt::format("E_{}_W_m2", response), {}});
  for (const AlphaOpic& e : m.alpha_opic) {
    out[0].values.push_back(equivalent_daylight(e[kMelanopic], kMelanopic));
    for (std::size_t k = 0; k < kAlphaOpicCount; ++k) out[k + 1].values.push_back(e[k]);
  }
  return out;
}

}  // namespace

RenderSettings sensor_settings(RenderSettings settings) {
  const bool by_paths = settings.integrator == Integrator::path;
  settings.progressive = !by_paths;
  settings.default_gather = kPathsOfSample;
  if (by_paths && settings.samples == 0 && !(settings.time_limit_s > 0 || settings.noise_target > 0))
    settings.samples = kDefaultSamples * kPathsOfSample;
  settings.filter = Filtering::off;
  return settings;
}

namespace {

/// Most characters of a sensor in a file: eighteen numbers with their names.
constexpr std::size_t kTextOfSensor = 640;
/// Bytes of a sensor in all tables.
constexpr std::size_t kBytesOfSensor = 3 * Sensors::kBytesEach + sizeof(std::uint32_t) + 2 * sizeof(Vec3) +
                                       sizeof(RGB) + sizeof(float) + sizeof(AlphaOpic) + kTextOfSensor;

}  // namespace

std::size_t most_sensors(std::uint64_t memory_bytes) {
  return std::min<std::uint64_t>(memory_bytes / 2 / kBytesOfSensor, kMaxSensors);
}

RenderSettings with_room_for(std::size_t sensors, RenderSettings settings) {
  const std::size_t most = most_sensors(settings.memory_bytes);
  if (sensors > most)
    throw MemoryError(fmt::format("{} sensors take {:.1f} MB; half of the memory budget has room for {}", sensors,
                                  static_cast<double>(sensors * kBytesOfSensor) / 1e6, most),
                      "Give a larger --memory or fewer sensors.");
  settings.memory_bytes -= sensors * kBytesOfSensor;
  return settings;
}

JobEnd end_of_sensors() { return {0, nullptr, 2}; }

double student_factor(std::uint32_t degrees) {
  constexpr double kChance = 0.95, z = 1.959964;  // the normal quantile
  const double n = degrees;
  if (degrees == 0) return 1;
  if (degrees == 1) return std::tan(M_PI / 2 * kChance) / z;
  if (degrees == 2) return kChance * std::sqrt(2 / (1 - kChance * kChance)) / z;
  const double y = z * z;
  const double first = (y + 1) / 4, second = ((5 * y + 16) * y + 3) / 96;
  const double third = (((3 * y + 19) * y + 17) * y - 15) / 384;
  const double fourth = ((((79 * y + 776) * y + 1482) * y - 1920) * y - 945) / 92160;
  return 1 + (first + (second + (third + fourth / n) / n) / n) / n;
}

Measurement measurement_of(const Sensors& sensors, const Film& film, const Scene& scene, std::uint32_t batches) {
  Measurement out;
  out.sensors = sensors;
  const Vec3 zero{0, 0, 0};  // + 0 writes 0 in place of -0
  for (Vec3& p : out.sensors.position) p = scene.to_file_axes(p) + zero;
  for (Vec3& n : out.sensors.normal) n = scene.to_file_axes(n) + zero;
  out.origin = scene.to_file_axes(scene.origin()) + zero;
  out.z_up = scene.z_up();
  out.samples = film.whole_passes();
  // Samples that all missed the light agree on 0, and tell nothing of what they missed.
  const float of_darkness = scene.light_power().total() > 0 ? std::numeric_limits<float>::infinity() : 0;
  out.irradiance.reserve(sensors.size());
  out.relative_error.reserve(sensors.size());
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const RGB e = film.radiance(i, false);
    const std::uint32_t known = std::min(batches, film.sample_count(i));
    const double factor = student_factor(known > 0 ? known - 1 : 0);
    const float level = luminance(e), deviation = static_cast<float>(factor * std::sqrt(film.variance(i)));
    out.irradiance.push_back(e);
    out.relative_error.push_back(level > 0 ? deviation / level : of_darkness);
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
      "{} lm/W\n# relative_error: error of E_lx over E_lx; the truth lies within twice of it with a chance of 95%; "
      "inf: no light found\n"
      "x,y,z,nx,ny,nz,E_W_m2,E_R,E_G,E_B,E_lx,relative_error",
      one_line(about), kLuminousEfficacy);
  const std::vector<MoreColumn> more = more_columns(m);
  for (const MoreColumn& column : more) text += "," + column.name;
  text += "\n";
  for (std::size_t i = 0; i < m.sensors.size(); ++i) {
    const Vec3 n = m.sensors.normal[i];
    const RGB e = m.irradiance[i];
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.3g}",
                   place_of(m, i, ','), n.x, n.y, n.z, mean(e), e.r, e.g, e.b, illuminance(e), m.relative_error[i]);
    for (const MoreColumn& column : more) fmt::format_to(std::back_inserter(text), ",{:.6g}", column.values[i]);
    text += "\n";
  }
  return text;
}

std::string measurement_json(const Measurement& m, const std::string& about) {
  using nlohmann::json;
  // A tree of all points would take ten times as much memory as the text.
  const json head = {{"about", about}, {"lumens_per_watt", kLuminousEfficacy}};
  std::string text = json_text(head, 1);
  text.resize(text.size() - 2);  // without the end
  text += ",\n \"points\": [";
  const std::vector<MoreColumn> more = more_columns(m);
  for (std::size_t i = 0; i < m.sensors.size(); ++i) {
    const Vec3d p = m.place(i);
    const Vec3 n = m.sensors.normal[i];
    const RGB e = m.irradiance[i];
    json point = {{"x", p.x},
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
                  {"relative_error", m.relative_error[i]}};
    for (const MoreColumn& column : more) point[column.name] = column.values[i];
    text += (i > 0 ? ",\n  " : "\n  ") + point.dump();
  }
  return text + "\n ]\n}\n";
}

std::string measurement_ply(const Measurement& m, const std::string& about) {
  std::string text =
      fmt::format("ply\nformat ascii 1.0\ncomment {}\nelement vertex {}\n", one_line(about), m.sensors.size());
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "E_W_m2", "E_lx", "relative_error"})
    text += fmt::format("property {} {}\n", name[1] == '\0' ? coordinate_type(m) : "float", name);
  const std::vector<MoreColumn> more = more_columns(m);
  for (const MoreColumn& column : more) text += fmt::format("property float {}\n", column.name);
  text += "end_header\n";
  for (std::size_t i = 0; i < m.sensors.size(); ++i) {
    const Vec3 n = m.sensors.normal[i];
    fmt::format_to(std::back_inserter(text), "{} {} {} {} {:.6g} {:.6g} {:.3g}", place_of(m, i, ' '), n.x, n.y, n.z,
                   mean(m.irradiance[i]), illuminance(m.irradiance[i]), m.relative_error[i]);
    for (const MoreColumn& column : more) fmt::format_to(std::back_inserter(text), " {:.6g}", column.values[i]);
    text += "\n";
  }
  return text;
}

std::string measurement_vtk(const Measurement& m, const std::string& about) {
  const std::size_t count = m.sensors.size();
  // The format allows a title of 256 characters.
  std::string text = fmt::format("# vtk DataFile Version 3.0\n{}\nASCII\nDATASET POLYDATA\nPOINTS {} {}\n",
                                 one_line(about).substr(0, 255), count, coordinate_type(m));
  for (std::size_t i = 0; i < count; ++i) text += place_of(m, i, ' ') + "\n";
  text += fmt::format("VERTICES {} {}\n", count, 2 * count);
  for (std::size_t i = 0; i < count; ++i) fmt::format_to(std::back_inserter(text), "1 {}\n", i);
  text += fmt::format("POINT_DATA {}\nNORMALS normals float\n", count);
  for (const Vec3 n : m.sensors.normal) fmt::format_to(std::back_inserter(text), "{} {} {}\n", n.x, n.y, n.z);
  const auto scalars = [&](const std::string& name, const auto& value) {
    text += fmt::format("SCALARS {} float 1\nLOOKUP_TABLE default\n", name);
    for (std::size_t i = 0; i < count; ++i) fmt::format_to(std::back_inserter(text), "{:.6g}\n", value(i));
  };
  scalars("E_W_m2", [&](std::size_t i) { return mean(m.irradiance[i]); });
  scalars("E_lx", [&](std::size_t i) { return illuminance(m.irradiance[i]); });
  // Readers of the format take no inf.
  scalars("relative_error",
          [&](std::size_t i) { return std::min(m.relative_error[i], std::numeric_limits<float>::max()); });
  for (const MoreColumn& column : more_columns(m))
    scalars(column.name, [&](std::size_t i) { return column.values[i]; });
  return text;
}

}  // namespace glowworm
