#include "measure/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

#include "core/box.h"
#include "core/text.h"
#include "image/html_page.h"

namespace glowworm {

namespace {

constexpr double kLongSide = 640;  // pixels

/// A map of sensors to pixels.
struct Plan {
  int across = 0, down = 2;   ///< axes of the picture
  bool upwards = false;       ///< the second axis grows upwards
  double left = 0, top = 0;   ///< metres at the upper left corner
  double spacing = 1;         ///< metres between sensors
  double pixel = 1;           ///< metres
  int width = 0, height = 0;  ///< pixels

  double x(Vec3 place) const { return (place[across] - left) / pixel; }
  double y(Vec3 place) const { return (upwards ? top - place[down] : place[down] - top) / pixel; }
};

/// The place of a sensor as people write it.
std::string shown_place(const Measurement& m, std::size_t sensor, const char* separator) {
  const Vec3d p = m.place(sensor);
  return coordinate_text(p.x) + separator + coordinate_text(p.y) + separator + coordinate_text(p.z);
}

Plan plan_of(const Measurement& m) {
  const Sensors& sensors = m.sensors;
  Vec3 sum{0, 0, 0};
  Box3 box;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const Vec3 n = sensors.normal[i];
    for (int axis = 0; axis < 3; ++axis) sum[axis] += std::abs(n[axis]);
    box.grow(sensors.position[i]);
  }
  const int axis = sum.y >= sum.x && sum.y >= sum.z ? 1 : sum.x >= sum.z ? 0 : 2;
  Plan plan;
  // Walls have their top above; of a floor, the axis that is north (-z, or y where z is up) points upwards.
  const int up = m.z_up ? 2 : 1, north = 3 - up;
  plan.across = axis == 0 ? north : 0;
  plan.down = axis == up ? north : up;
  plan.upwards = axis != up || m.z_up;
  const Vec3 size = box.diagonal();
  const double w = size[plan.across], h = size[plan.down], n = static_cast<double>(sensors.size());
  // (w + s)(h + s) = n s^2
  if (n > 1 && w + h > 0) plan.spacing = (w + h + std::sqrt((w + h) * (w + h) + 4 * (n - 1) * w * h)) / (2 * (n - 1));
  const double s = plan.spacing;
  plan.pixel = (std::max(w, h) + s) / kLongSide;
  plan.left = box.min[plan.across] - s / 2;
  plan.top = plan.upwards ? box.max[plan.down] + s / 2 : box.min[plan.down] - s / 2;
  plan.width = std::max(static_cast<int>(std::lround((w + s) / plan.pixel)), 1);
  plan.height = std::max(static_cast<int>(std::lround((h + s) / plan.pixel)), 1);
  return plan;
}

/// Interpolates by Shepard's method with weights ((R - d) / (R d))^2 within R = 1.5 spacings (Franke and Nielson,
/// "Smooth interpolation of large sets of scattered data", 1980).
std::vector<float> interpolate(const Measurement& m, const Plan& plan) {
  const double radius = 1.5 * plan.spacing / plan.pixel, covered = 0.75 * plan.spacing / plan.pixel;
  const std::size_t pixels = static_cast<std::size_t>(plan.width) * static_cast<std::size_t>(plan.height);
  std::vector<double> sum(pixels), weight(pixels), nearest(pixels, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < m.sensors.size(); ++i) {
    const double cx = plan.x(m.sensors.position[i]), cy = plan.y(m.sensors.position[i]);
    const int x1 = std::min(static_cast<int>(cx + radius), plan.width - 1);
    const int y1 = std::min(static_cast<int>(cy + radius), plan.height - 1);
    for (int y = std::max(static_cast<int>(cy - radius), 0); y <= y1; ++y)
      for (int x = std::max(static_cast<int>(cx - radius), 0); x <= x1; ++x) {
        const double d = std::max(std::hypot(x + 0.5 - cx, y + 0.5 - cy), 1e-3 * radius);
        if (d >= radius) continue;
        const std::size_t at =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(plan.width) + static_cast<std::size_t>(x);
        const double share = (radius - d) / (radius * d), w = share * share;
        sum[at] += w * illuminance(m.irradiance[i]);
        weight[at] += w;
        nearest[at] = std::min(nearest[at], d);
      }
  }
  std::vector<float> out(pixels, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < pixels; ++i)
    if (nearest[i] <= covered) out[i] = static_cast<float>(sum[i] / weight[i]);
  return out;
}

std::vector<float> levels_of(const Measurement& m) {
  std::vector<float> out;
  for (const RGB& e : m.irradiance) out.push_back(illuminance(e));
  return out;
}

/// A relative error; it is unknown where no sample found light.
std::string percent(float error) { return std::isfinite(error) ? fmt::format("{:.2g}%", 100 * error) : "unknown"; }

std::string key_figures(const Measurement& m) {
  const std::vector<float> levels = levels_of(m);
  const auto [least, most] = std::minmax_element(levels.begin(), levels.end());
  double sum = 0, weights = 0;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    sum += double{m.sensors.weight[i]} * levels[i];
    weights += m.sensors.weight[i];
  }
  const double mean = sum / weights;
  const float error = *std::max_element(m.relative_error.begin(), m.relative_error.end());
  const auto place = [&](auto at) {
    return fmt::format("{:.5g} lx at {} m", *at, shown_place(m, static_cast<std::size_t>(at - levels.begin()), ", "));
  };
  const auto ratio = [](double a, double b) { return b > 0 ? fmt::format("{:.3f}", a / b) : std::string("no light"); };
  return html_table({{"sensors", fmt::format("{}", levels.size())},
                     {"mean illuminance", fmt::format("{:.5g} lx", mean)},
                     {"minimum", place(least)},
                     {"maximum", place(most)},
                     {"uniformity, minimum / mean", ratio(*least, mean)},
                     {"uniformity, minimum / maximum", ratio(*least, *most)},
                     {"largest relative error", percent(error)}});
}

/// Shows the nearest sensor's numbers below the plan.
constexpr const char* kScript = R"(
const plan = document.getElementById("plan"), shown = document.getElementById("sensor");
plan.onpointermove = event => {
  const box = plan.getBoundingClientRect(), scale = plan.naturalWidth / box.width;
  const x = (event.clientX - box.left) * scale, y = (event.clientY - box.top) * scale;
  let best = null, least = Infinity;
  for (const s of sensors) {
    const d = (s[0] - x) ** 2 + (s[1] - y) ** 2;
    if (d < least) { least = d; best = s; }
  }
  shown.textContent = `${best[5]} lx, relative error ${best[6]}, at ${best.slice(2, 5).join(", ")} m`;
};
)";

}  // namespace

std::string measurement_png(const Measurement& m, const std::string& about, ColorScale scale) {
  const Plan plan = plan_of(m);
  if (scale.high == 0) scale = fitting_scale(levels_of(m));
  Image plot = false_color_plot(interpolate(m, plan), plan.width, plan.height, scale, "lx");
  plot.metadata["comments"] = about;
  return png_bytes("the plan", plot, ToneCurve::srgb);
}

std::string measurement_page(const Measurement& m, const std::string& about, ColorScale scale) {
  const Plan plan = plan_of(m);
  std::string script = "const sensors = [";
  for (std::size_t i = 0; i < m.sensors.size(); ++i) {
    const Vec3 p = m.sensors.position[i];
    fmt::format_to(std::back_inserter(script), "[{:.1f},{:.1f},{},{:.4g},\"{}\"],\n", plan.x(p), plan.y(p),
                   shown_place(m, i, ","), illuminance(m.irradiance[i]), percent(m.relative_error[i]));
  }
  const std::string axes = fmt::format("{} to the right, {} {}", "xyz"[plan.across], "xyz"[plan.down],
                                       plan.upwards ? "upwards" : "downwards");
  const std::string body =
      "<div class=\"row\">\n<figure>" + html_picture("plan", measurement_png(m, about, scale)) +
      "<figcaption>Illuminance: " + axes +
      "</figcaption>\n<output id=\"sensor\">Point at a sensor for its numbers.</output></figure>\n" + key_figures(m) +
      "</div>\n";
  return html_page("Illuminance", about, body, script + "];" + kScript);
}

}  // namespace glowworm
