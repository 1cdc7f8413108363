#include "import/ies/photometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/round_step.h"
#include "image/canvas.h"

namespace glowworm {

namespace {

constexpr double kDegree = M_PI / 180;

/// @param c, gamma degrees
Vec3 direction_of(double c, double gamma) {
  const double sine = std::sin(gamma * kDegree);
  return {static_cast<float>(sine * std::cos(c * kDegree)), static_cast<float>(sine * std::sin(c * kDegree)),
          static_cast<float>(std::cos(gamma * kDegree))};
}

/// Whether a change of each direction leaves all intensities as they are, but for the rounding of angles.
bool is_symmetric(const IntensityTable& table, const std::function<Vec3(Vec3)>& change) {
  constexpr double kStep = 2.5;
  for (double c = 0; c < 360; c += kStep)
    for (double gamma = 0; gamma <= 180; gamma += kStep) {
      const Vec3 d = direction_of(c, gamma);
      if (std::abs(table.intensity(d) - table.intensity(change(d))) > 1e-3f * table.greatest()) return false;
    }
  return true;
}

std::string symmetry_of(const IntensityTable& table) {
  const auto turned = [](Vec3 d) { return Vec3{-d.y, d.x, d.z}; };
  const auto askew = [](Vec3 d) { return Vec3{0.8f * d.x - 0.6f * d.y, 0.6f * d.x + 0.8f * d.y, d.z}; };
  if (is_symmetric(table, turned) && is_symmetric(table, askew)) return "around the axis";
  const bool across = is_symmetric(table, [](Vec3 d) { return Vec3{d.x, -d.y, d.z}; });
  const bool along = is_symmetric(table, [](Vec3 d) { return Vec3{-d.x, d.y, d.z}; });
  if (across && along) return "to the planes C0-C180 and C90-C270";
  return across ? "to the plane C0-C180" : along ? "to the plane C90-C270" : "none";
}

std::string opening_text(const LuminousOpening& o) {
  const int extent = o.extent();
  if (extent < 2) return "point";
  const std::string sizes =
      extent == 2 && o.size.z == 0
          ? fmt::format("{:.4g} x {:.4g} m along C0 and across it", o.size.x, o.size.y)
          : fmt::format("{:.4g} x {:.4g} x {:.4g} m along C0, across it and in height", o.size.x, o.size.y, o.size.z);
  const char* const axes[] = {"along C0", "across C0", "upright"};
  switch (o.shape) {
    case LuminousOpening::Shape::box:
      return (extent == 3 ? "box, " : "rectangle, ") + sizes;
    case LuminousOpening::Shape::ellipsoid:
      return (o.size.x == o.size.y && o.size.y == o.size.z ? "sphere, " : "ellipsoid, ") + sizes;
    case LuminousOpening::Shape::cylinder:
      break;
  }
  return (extent == 3 ? fmt::format("cylinder {}, ", axes[o.axis]) : std::string("disc, ")) + sizes;
}

const RGB kPaper(1.0f), kGrid(0.6f), kInk(0.05f), kFirst(0.7f, 0.05f, 0.02f), kSecond(0.02f, 0.1f, 0.6f);
constexpr int kSide = 640, kTitle = 40, kMargin = 40;

/// The diagram: where an angle and an intensity lie.
struct Diagram {
  double x, y;      ///< the luminaire, pixels
  double candela;   ///< at the rim
  double radius;    ///< pixels
  double greatest;  ///< angle from straight down that is shown, degrees
  Vec2 place(double angle, double value) const {
    const double r = radius * value / candela;
    return {static_cast<float>(x + r * std::sin(angle * kDegree)),
            static_cast<float>(y + r * std::cos(angle * kDegree))};
  }
};

void draw_grid(const Diagram& d, double step, Canvas& canvas) {
  const auto segment = [&](Vec2 a, Vec2 b) { canvas.line(a.x, a.y, b.x, b.y, 1, kGrid); };
  for (double value = step; value <= d.candela * (1 + 1e-9); value += step) {
    for (double a = -d.greatest; a < d.greatest; a += 2) segment(d.place(a, value), d.place(a + 2, value));
    const Vec2 label = d.place(0, value);
    canvas.write(static_cast<int>(label.x) + 3, static_cast<int>(label.y) - 10, fmt::format("{:g}", value), kInk);
  }
  for (double a = -d.greatest; a <= d.greatest; a += 15) {
    if (a == -180) continue;
    segment(d.place(a, 0), d.place(a, d.candela));
    if (std::fmod(a, 30) != 0) continue;
    const std::string text = fmt::format("{:g}", std::abs(a));
    const Vec2 at = d.place(a, d.candela * 1.06);
    canvas.write(static_cast<int>(at.x) - Canvas::width_of(text) / 2, static_cast<int>(at.y) - 4, text, kInk);
  }
}

/// A curve from the plane C at the right to the opposite one.
void draw_curve(const Diagram& d, const IntensityTable& table, double c, RGB color, Canvas& canvas) {
  const auto value = [&](double a) { return table.intensity(direction_of(a < 0 ? c + 180 : c, std::abs(a))); };
  for (double a = -d.greatest; a < d.greatest; ++a) {
    const Vec2 from = d.place(a, value(a)), to = d.place(a + 1, value(a + 1));
    canvas.line(from.x, from.y, to.x, to.y, 2, color);
  }
}

}  // namespace

Photometry photometry_of(const PhotometricFile& file) {
  const IntensityTable& table = file.table;
  Photometry out;
  out.flux = table.integral();
  out.candela = table.greatest();
  if (const float power = file.sets[file.set].power; power > 0) out.efficacy = out.flux / power;
  const Vec3 peak = table.brightest();
  out.gamma = std::atan2(std::hypot(peak.x, peak.y), peak.z) / kDegree;
  out.c = out.gamma > 0.01 && out.gamma < 179.99 ? std::atan2(peak.y, peak.x) / kDegree : 0;
  if (out.c < -1e-3) out.c += 360;
  out.symmetry = symmetry_of(table);
  out.opening = opening_text(file.opening);
  double below = 0, all = 0;
  for (double gamma = 0.25; gamma < 180; gamma += 0.5)
    for (double c = 2.5; c < 360; c += 5) {
      const double part = table.intensity(direction_of(c, gamma)) * std::sin(gamma * kDegree);
      all += part;
      if (gamma < 90) below += part;
    }
  out.down = all > 0 ? below / all : 0;
  return out;
}

Image polar_curve(const PhotometricFile& file, const std::string& title) {
  const IntensityTable& table = file.table;
  const Photometry facts = photometry_of(file);
  constexpr double kNegligible = 0.002;
  const bool lower_half = facts.down > 1 - kNegligible;
  Diagram d;
  d.greatest = lower_half ? 90 : 180;
  const double step = round_step_above(std::max(facts.candela, 1e-6) / 5);
  d.candela = step * std::ceil(facts.candela / step * (1 - 1e-9));
  d.radius = kSide / 2.0 - kMargin;
  d.x = kSide / 2.0;
  d.y = kTitle + kMargin + (lower_half ? 0 : d.radius);
  Canvas canvas(kSide, static_cast<int>(d.y + d.radius) + kMargin + 2 * Canvas::kLineHeight, kPaper);
  draw_grid(d, step, canvas);
  draw_curve(d, table, 90, kSecond, canvas);
  draw_curve(d, table, 0, kFirst, canvas);
  canvas.write(10, 8, fmt::format("{}: {:.4g} lm, peak {:.4g} cd", title, facts.flux, facts.candela), kInk);
  const int foot = canvas.height - Canvas::kLineHeight - 8;
  canvas.fill(10, foot + 2, 34, foot + 5, kFirst);
  canvas.write(40, foot, "C0 (right) - C180", kInk);
  canvas.fill(170, foot + 2, 194, foot + 5, kSecond);
  canvas.write(200, foot, "C90 (right) - C270", kInk);
  const std::string units = "candela; angles in degrees";
  canvas.write(kSide - 10 - Canvas::width_of(units), foot, units, kInk);
  return canvas.image();
}

}  // namespace glowworm
