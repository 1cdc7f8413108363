#include "measure/room_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "core/round_step.h"
#include "core/text.h"
#include "core/version.h"
#include "image/html_page.h"
#include "import/ies/photometry.h"
#include "measure/glare.h"
#include "measure/isolines.h"
#include "measure/lamp_glare.h"
#include "scene/light_sampling.h"

namespace glowworm {

namespace {

constexpr const char* kStyle = R"(
@page { size: A4; margin: 16mm 15mm; }
body { font: 10pt/1.45 system-ui, "DejaVu Sans", Arial, sans-serif; color: #1a1a1a; max-width: 180mm; margin: 8mm auto; }
@media print { body { margin: 0; } }
h1 { font-size: 17pt; margin: 0 0 1mm; } h2 { font-size: 12.5pt; margin: 8mm 0 2mm; border-bottom: 0.4mm solid #1a1a1a; break-after: avoid; }
.about { color: #555; overflow-wrap: anywhere; margin: 0; font-size: 8.5pt; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: 0.8mm 0 0.8mm 3mm; border-bottom: 0.2mm solid #ccc; vertical-align: top; }
th { font-weight: 600; border-bottom-color: #1a1a1a; } th:first-child, td:first-child { text-align: left; padding-left: 0; }
td.text, th.text { text-align: left; } tr { break-inside: avoid; }
figure { margin: 3mm 0 0; break-inside: avoid; } figcaption { color: #555; font-size: 8.5pt; }
svg { width: 100%; height: auto; } ul { margin: 1mm 0; padding-left: 5mm; }
)";

double lux(const Measurement& m, std::size_t sensor) { return illuminance(m.irradiance[sensor]); }

/// A number to about three digits, without an exponent.
std::string figure_text(double value) {
  if (!(std::abs(value) > 0)) return "0";
  const int digits = 2 - static_cast<int>(std::floor(std::log10(std::abs(value))));
  return fmt::format("{:.{}f}", value, std::clamp(digits, 0, 3));
}

/// Coordinates of the plan: metres from the corner of the zone, x to the right, y downwards.
struct PlanAxes {
  Vec3 corner, right, down;  ///< unit
  double width, height;      ///< m

  Vec2 point(Vec3 place) const { return {dot(place - corner, right), dot(place - corner, down)}; }
};

PlanAxes axes_of(const Zone& zone) {
  const double width = length(zone.across), height = length(zone.along);
  PlanAxes out{zone.corner, zone.across / static_cast<float>(width), zone.along / static_cast<float>(height), width,
               height};
  if (zone.is_level() || zone.along.y < 0) return out;
  out.corner = zone.corner + zone.along;  // upright zones have their top above
  out.down = -out.down;
  return out;
}

/// A picture in millimetres. @param width of the drawing
struct Drawing {
  double scale;  ///< mm for a metre
  std::string text;

  template <typename... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text), format, std::forward<Values>(values)...);
  }
  double mm(double metres) const { return metres * scale; }
};

/// A tint from white to amber. @param t in [0, 1]
std::string tint(double t) {
  const auto mix = [&](double white, double full) { return static_cast<int>(std::lround(white + (full - white) * t)); };
  return fmt::format("#{:02x}{:02x}{:02x}", mix(255, 255), mix(255, 196), mix(250, 92));
}

void draw_tints(const Zone& zone, const std::vector<float>& values, const PlanAxes& axes, Drawing& out) {
  const float most = std::max(*std::max_element(values.begin(), values.end()), 1e-6f);
  const double w = axes.width / zone.columns, h = axes.height / zone.rows;
  out.add("<g shape-rendering=\"crispEdges\">\n");
  for (int j = 0; j < zone.rows; ++j)
    for (int i = 0; i < zone.columns; ++i)
      out.add("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"/>\n", out.mm(i * w),
              out.mm(j * h), out.mm(w), out.mm(h),
              tint(double{values[static_cast<std::size_t>(j * zone.columns + i)]} / most));
  out.add("</g>\n");
}

/// Outlines of the lamps over a level zone, as all their triangles.
void draw_lamps(const Zone& zone, const PlanAxes& axes, const Scene& scene, Drawing& out) {
  if (!zone.is_level()) return;
  const auto is_inside = [&](Vec2 p) { return p.x >= 0 && p.y >= 0 && p.x <= axes.width && p.y <= axes.height; };
  std::string path;
  for (const std::uint32_t triangle : scene.emissive_triangles()) {
    const DiffuseTriangle& t = scene.diffuse_triangle(triangle);
    const Vec2 a = axes.point(t.corner), b = axes.point(t.corner + t.edge[0]), c = axes.point(t.corner + t.edge[1]);
    if (!(t.corner.y > zone.corner.y) || !is_inside(a) || !is_inside(b) || !is_inside(c)) continue;
    // All one way around, so that those above others do not cut holes.
    const bool clockwise = (b.x - a.x) * (c.y - a.y) < (b.y - a.y) * (c.x - a.x);
    const Vec2 second = clockwise ? c : b, third = clockwise ? b : c;
    path += fmt::format("M{:.2f} {:.2f}L{:.2f} {:.2f}L{:.2f} {:.2f}Z", out.mm(a.x), out.mm(a.y), out.mm(second.x),
                        out.mm(second.y), out.mm(third.x), out.mm(third.y));
  }
  for (const Light& light : scene.lights()) {
    const Vec2 p = axes.point(light.position);
    if (light.kind == LightKind::directional || is_black(light.intensity)) continue;
    if (!(light.position.y > zone.corner.y) || !is_inside(p)) continue;
    path += fmt::format("M{0:.2f} {1:.2f}m-1 0a1 1 0 1 0 2 0a1 1 0 1 0 -2 0Z", out.mm(p.x), out.mm(p.y));
  }
  if (!path.empty()) out.add("<path d=\"{}\" fill=\"#3f78c0\" fill-opacity=\"0.6\"/>\n", path);
}

/// The middle of the part of a line that is farthest from the sensors, where values are written. @param line in cells
Vec2 label_place(const Isoline& line) {
  Vec2 best = line.points.front();
  double most = -1;
  for (std::size_t i = 1; i < line.points.size(); ++i) {
    const Vec2 middle = (line.points[i - 1] + line.points[i]) * 0.5f;
    const double apart = std::hypot(middle.x - std::round(middle.x), middle.y - std::round(middle.y));
    if (apart > most) {
      most = apart;
      best = middle;
    }
  }
  return best;
}

/// Draws lines, and returns their labels.
/// @param noise lx: no levels are as close
std::string draw_isolines(const Zone& zone, const std::vector<float>& values, double noise, const PlanAxes& axes,
                          Drawing& out) {
  constexpr double kLabelled = 12;  // mm of a line
  const double w = axes.width / zone.columns, h = axes.height / zone.rows;
  std::string labels;
  for (const Isoline& line : isolines(values, zone.columns, round_levels(values, noise))) {
    std::string path;
    double drawn = 0;
    for (std::size_t i = 0; i < line.points.size(); ++i) {
      const Vec2 p = line.points[i], before = line.points[i > 0 ? i - 1 : 0];
      drawn += std::hypot(out.mm((p.x - before.x) * w), out.mm((p.y - before.y) * h));
      path +=
          fmt::format("{}{:.2f} {:.2f}", path.empty() ? "M" : "L", out.mm((p.x + 0.5) * w), out.mm((p.y + 0.5) * h));
    }
    out.add("<path d=\"{}\" fill=\"none\" stroke=\"#7a3b00\" stroke-width=\"0.35\"/>\n", path);
    if (drawn < kLabelled) continue;
    const Vec2 middle = label_place(line);
    labels += fmt::format(
        "<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"3\" fill=\"#7a3b00\" stroke=\"#fff\" stroke-width=\"0.9\" "
        "paint-order=\"stroke\" text-anchor=\"middle\">{:g}</text>\n",
        out.mm((middle.x + 0.5) * w), out.mm((middle.y + 0.5) * h) + 1, line.level);
  }
  return labels;
}

/// Values at sensors, where a cell has room for them.
void draw_values(const Zone& zone, const std::vector<float>& values, const PlanAxes& axes, Drawing& out) {
  constexpr double kRoom = 8.5;  // mm
  const double w = axes.width / zone.columns, h = axes.height / zone.rows;
  if (out.mm(w) < kRoom || out.mm(h) < kRoom / 2) return;
  for (int j = 0; j < zone.rows; ++j)
    for (int i = 0; i < zone.columns; ++i)
      out.add(
          "<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"2.4\" fill=\"#333\" stroke=\"#fff\" stroke-width=\"0.7\" "
          "paint-order=\"stroke\" text-anchor=\"middle\">{}</text>\n",
          out.mm((i + 0.5) * w), out.mm((j + 0.5) * h) + 0.9,
          figure_text(values[static_cast<std::size_t>(j * zone.columns + i)]));
}

/// A bar of a round length below the plan.
void draw_scale(const PlanAxes& axes, Drawing& out) {
  const double step = round_step_below(axes.width / 3);
  const double y = out.mm(axes.height) + 4;
  out.add("<path d=\"M0 {0:.2f}v1.4h{1:.2f}v-1.4\" fill=\"none\" stroke=\"#1a1a1a\" stroke-width=\"0.3\"/>\n", y,
          out.mm(step));
  out.add("<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"3\">{:g} m</text>\n", out.mm(step) + 1.5, y + 1.6, step);
}

std::string row(const std::vector<std::string>& cells, const char* tag, const std::set<std::size_t>& texts = {}) {
  std::string out = "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i)
    out += fmt::format("<{0}{1}>{2}</{0}>", tag, texts.contains(i) ? " class=\"text\"" : "", html_text(cells[i]));
  return out + "</tr>\n";
}

std::string report_place(const Scene& scene, Vec3 place) {
  const Vec3d p = scene.to_file_axes(scene.outside(place));
  return fmt::format("{}, {}, {}", coordinate_text(p.x), coordinate_text(p.y), coordinate_text(p.z));
}

std::string view_name(const Scene& scene, Vec3 view) {
  const Vec3 d = scene.to_file_axes(view);
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(d[axis]) > 0.5f) return fmt::format("{}{}", d[axis] > 0 ? "+" : "-", "xyz"[axis]);
  return "";
}

std::string zone_table(const std::vector<Zone>& zones, const std::vector<ZoneFigures>& figures, const Scene& scene) {
  std::string out = "<table>\n" + row({"zone", "sensors", "mean lx", "min lx", "max lx", "U0 min/mean",
                                       "cylindrical lx", "UGR", "UGR at", "error of mean"},
                                      "th");
  for (std::size_t i = 0; i < zones.size(); ++i) {
    const ZoneFigures& f = figures[i];
    const bool rated = zones[i].is_level() && f.ugr > 0;
    out += row({zones[i].name, fmt::format("{}", zones[i].count), figure_text(f.mean), figure_text(f.least),
                figure_text(f.most), fmt::format("{:.2f}", f.uniformity()),
                zones[i].is_level() ? figure_text(f.cylindrical) : "", rated ? fmt::format("{:.1f}", f.ugr) : "",
                rated ? fmt::format("{} to {}", report_place(scene, f.ugr_eye), view_name(scene, f.ugr_view)) : "",
                std::isfinite(f.error) ? fmt::format("{:.1f}%", 100 * f.error) : "unknown"},
               "td");
  }
  return out + "</table>\n";
}

std::string luminaire_table(const std::vector<LuminaireRow>& rows) {
  if (rows.empty()) return "";
  std::string out =
      "<h2>Luminaires</h2>\n<table>\n" +
      row({"file", "luminaire", "opening", "quantity", "lm each", "W each", "lm/W", "total W"}, "th", {1, 2});
  double power = 0;
  const auto known = [](double value) { return value > 0 ? figure_text(value) : std::string(); };
  for (const LuminaireRow& r : rows) {
    const double all = r.power * static_cast<double>(r.places.size());
    power += all;
    out += row({r.file, r.name, r.opening, fmt::format("{}", r.places.size()), fmt::format("{:.0f}", r.flux),
                known(r.power), r.power > 0 ? figure_text(r.flux / r.power) : "", known(all)},
               "td", {1, 2});
  }
  if (power > 0) out += row({"all", "", "", "", "", "", "", figure_text(power)}, "td");
  out += "</table>\n<ul>\n";
  for (const LuminaireRow& r : rows)
    out += fmt::format("<li>{} at {} (m)</li>\n", html_text(r.file),
                       html_text(fmt::format("{}", fmt::join(r.places, "; "))));
  return out + "</ul>\n";
}

/// Lights of the scene by their names, with their flux.
std::string light_table(const Scene& scene) {
  std::map<std::string, double> flux;
  for (std::uint32_t i = 0; i < scene.source_powers().size(); ++i)
    flux[light_source_name(scene, i)] += double{luminance(scene.source_powers()[i])} * kLuminousEfficacy;
  std::string out = "<h2>Lights</h2>\n<table>\n" + row({"light", "lm"}, "th");
  for (const auto& [name, lumens] : flux) out += row({name, fmt::format("{:.0f}", lumens)}, "td");
  return out + "</table>\n";
}

}  // namespace

ZoneFigures zone_figures(const Zone& zone, const Measurement& m, const Tracer& tracer) {
  ZoneFigures out;
  out.least = HUGE_VAL;
  double sum = 0, weights = 0, errors = 0, of_darkness = 0;
  for (std::size_t i = zone.first; i < zone.first + zone.count; ++i) {
    const double value = lux(m, i), weight = m.sensors.weight[i];
    if (!(weight > 0)) continue;  // inside of an object
    sum += weight * value;
    weights += weight;
    if (value > 0)
      errors += weight * value * m.relative_error[i];
    else
      of_darkness = m.relative_error[i];
    out.least = std::min(out.least, value);
    out.most = std::max(out.most, value);
  }
  if (!(weights > 0)) return {};
  out.mean = sum / weights;
  out.error = sum > 0 ? errors / sum : of_darkness;
  const Scene& scene = tracer.scene();
  std::size_t seen = 0;
  for (std::size_t e = 0; e < zone.eyes; ++e)
    for (std::size_t k = 0; k < kEyeDirections; ++k) {
      const std::size_t i = zone.first_eye + e * kEyeDirections + k;
      if (!(m.sensors.weight[i] > 0)) continue;  // inside of an object
      out.cylindrical += lux(m, i);
      ++seen;
      if (k % 2 != 0) continue;
      const Vec3 eye = scene.from_file_axes(m.sensors.position[i]), view = scene.from_file_axes(m.sensors.normal[i]);
      const std::vector<GlareSource> lamps = lamps_in_view(tracer, eye, view);
      double direct = 0;
      for (const GlareSource& lamp : lamps) direct += lamp.illuminance;
      const double background = (lux(m, i) - direct) / M_PI;
      if (lamps.empty() || !(background > 0)) continue;
      const double ugr = unified_glare_rating(background, lamps);
      if (ugr <= out.ugr) continue;
      out.ugr = ugr;
      out.ugr_eye = eye;
      out.ugr_view = view;
    }
  if (seen > 0) out.cylindrical /= static_cast<double>(seen);
  return out;
}

std::vector<LuminaireRow> luminaire_rows(const std::vector<std::string>& texts) {
  std::vector<LuminaireRow> out;
  std::map<std::string, std::size_t> known;
  for (const std::string& text : texts) {
    const LuminaireText parsed = parse_luminaire_text(text);
    const std::string key = fmt::format("{}\n{}\n{}", parsed.path, parsed.lamps, parsed.factor);
    const auto [found, is_new] = known.try_emplace(key, out.size());
    if (is_new) {
      const PhotometricFile file = read_photometric_file(parsed.path, parsed.lamps);
      const Photometry facts = photometry_of(file);
      LuminaireRow& row = out.emplace_back();
      row.file = parsed.path.substr(parsed.path.find_last_of('/') + 1);
      row.name = file.name;
      if (const std::string& lamps = file.sets[file.set].name; !lamps.empty())
        row.name += (row.name.empty() ? "" : ", ") + lamps;
      if (parsed.factor != 1) row.name += fmt::format("{}factor {:g}", row.name.empty() ? "" : ", ", parsed.factor);
      row.opening = parsed.point ? "point" : facts.opening;
      row.flux = facts.flux * parsed.factor;
      row.power = file.sets[file.set].power;
    }
    out[found->second].places.push_back(
        fmt::format("{:g}, {:g}, {:g}", parsed.place.x, parsed.place.y, parsed.place.z));
  }
  return out;
}

std::string zone_plan(const Zone& zone, const Measurement& m, const Scene& scene) {
  const PlanAxes axes = axes_of(zone);
  constexpr double kWidth = 180, kHeight = 135;  // mm; a table and a plan fit on a page
  Drawing out{std::min(kWidth / axes.width, kHeight / axes.height), {}};
  std::vector<float> values;
  double noise = 0;
  for (int j = 0; j < zone.rows; ++j)
    for (int i = 0; i < zone.columns; ++i) {
      const bool upwards = !zone.is_level() && zone.along.y > 0;
      const int line = upwards ? zone.rows - 1 - j : j;
      const std::size_t sensor = zone.first + static_cast<std::size_t>(line * zone.columns + i);
      values.push_back(static_cast<float>(lux(m, sensor)));
      if (lux(m, sensor) > 0) noise = std::max(noise, 2 * lux(m, sensor) * m.relative_error[sensor]);
    }
  draw_tints(zone, values, axes, out);
  draw_lamps(zone, axes, scene, out);
  const std::string labels = draw_isolines(zone, values, noise, axes, out);
  draw_values(zone, values, axes, out);
  out.text += labels;
  out.add(
      "<rect x=\"0\" y=\"0\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"none\" stroke=\"#1a1a1a\" "
      "stroke-width=\"0.4\"/>\n",
      out.mm(axes.width), out.mm(axes.height));
  draw_scale(axes, out);
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-1 -1 {:.2f} {:.2f}\" font-family=\"DejaVu Sans, Arial, "
      "sans-serif\">\n{}</svg>\n",
      kWidth + 2, out.mm(axes.height) + 9, out.text);
}

std::string room_report(const std::vector<Zone>& zones, const Measurement& m,
                        const std::vector<LuminaireRow>& luminaires, const Tracer& tracer, const ReportTexts& texts) {
  const Scene& scene = tracer.scene();
  std::vector<ZoneFigures> figures;
  for (const Zone& zone : zones) figures.push_back(zone_figures(zone, m, tracer));
  std::string body = "<h2>Zones</h2>\n" + zone_table(zones, figures, scene);
  body +=
      "<p class=\"about\">Cylindrical illuminance and UGR (CIE 117, the greatest of four directions) are at eyes 1.2 m "
      "above the floor, or above the zone where no floor is below. Twice the error bounds the mean with a chance of "
      "95%. "
      "UGR counts lamps that have a size.</p>\n";
  for (const Zone& zone : zones)
    if (zone.columns > 0)
      body += fmt::format(
          "<figure>\n<h2>{}</h2>\n{}<figcaption>{:g} x {:g} m, {} x {} sensors; illuminance in lx{}</figcaption>\n"
          "</figure>\n",
          html_text(zone.name), zone_plan(zone, m, scene), length(zone.across), length(zone.along), zone.columns,
          zone.rows, zone.is_level() ? "; blue: lamps" : "");
  body += luminaire_table(luminaires) + light_table(scene);
  body += "<h2>Calculation</h2>\n<table>\n" + row({"program", fmt::format("Glowworm {}", version())}, "td");
  for (const auto& [name, value] : texts.settings) body += row({name, value}, "td");
  body += "</table>\n";
  if (!texts.notes.empty()) {
    body += "<ul>\n";
    for (const std::string& note : texts.notes) body += "<li>" + html_text(note) + "</li>\n";
    body += "</ul>\n";
  }
  return fmt::format(
      "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<title>{0}</title>\n<style>{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n<p class=\"about\">{2}</p>\n{3}</body>\n"
      "</html>\n",
      html_text(texts.title), kStyle, html_text(texts.command_line), body);
}

}  // namespace glowworm
