// The analytic cases of CIE 171:2006, 5.2 to 5.14, measured by sensors. Expected values are computed here from the
// geometry, by closed form or quadrature. Rooms are 4 x 4 x 3 m: x and z from 0 to 4, y (up) from 0 to 3.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <vector>

#include "bsdf/bsdf.h"
#include "control/job.h"
#include "measure/measurement.h"
#include "scene/scene_parts.h"
#include "scene/sky_model.h"

namespace glowworm {
namespace {

constexpr double kTolerance = 0.01;  // the norm's reader asks for 1% at every point

struct Point {
  double x, y, z;
};
Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Point operator*(Point a, double s) { return {a.x * s, a.y * s, a.z * s}; }
double product(Point a, Point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec3 vec(Point p) { return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}; }

struct Rectangle {
  Point corner, u, v;
  Point normal() const {
    const Point n{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
    return n * (1 / std::sqrt(product(n, n)));
  }
  double area() const { return std::sqrt(product(u, u) * product(v, v) - product(u, v) * product(u, v)); }
};

struct Sensor {
  Point place, normal;
};

/// Integral over the rectangle, by midpoints, of value(direction) cos(sensor) dω as the sensor sees it.
double seen_through(const Sensor& sensor, const Rectangle& r, const std::function<double(Point)>& value,
                    int parts = 400) {
  double sum = 0;
  const Point n = r.normal();
  for (int j = 0; j < parts; ++j)
    for (int i = 0; i < parts; ++i) {
      const Point to = r.corner + r.u * ((i + 0.5) / parts) + r.v * ((j + 0.5) / parts) - sensor.place;
      const double squared = product(to, to), length = std::sqrt(squared);
      const double cosine = product(to, sensor.normal) / length;
      if (cosine > 0) sum += value(to * (1 / length)) * cosine * std::abs(product(to, n)) / length / squared;
    }
  return sum * r.area() / (double{1.0} * parts * parts);
}

/// Points A to F of the wall z = 0 from the top down, and those of the floor, G on, away from that wall.
std::vector<Sensor> wall_and_floor(int on_floor = 4) {
  std::vector<Sensor> out;
  for (int i = 0; i < 6; ++i) out.push_back({{2, 2.75 - 0.5 * i, 0}, {0, 0, 1}});
  for (int i = 0; i < on_floor; ++i) out.push_back({{2, 0, 0.25 + 0.5 * i}, {0, 1, 0}});
  return out;
}

/// A scene of black surfaces and what tests add to it.
SceneDescription black_scene() {
  SceneDescription d;
  d.materials.resize(1);
  d.materials[0].reflectance.value = RGB(0.0f);
  return d;
}

void add(SceneDescription& d, const Rectangle& r, std::uint32_t material = 0, std::uint32_t emission = kNone) {
  add_quad(d, vec(r.corner), vec(r.u), vec(r.v), material, emission);
}

std::uint32_t add_material(SceneDescription& d, double reflectance) {
  Material m;
  m.reflectance.value = RGB(static_cast<float>(reflectance));
  d.materials.push_back(m);
  return static_cast<std::uint32_t>(d.materials.size() - 1);
}

/// The walls, floor and ceiling that are not left out; black.
enum Side { kLeft = 1, kRight = 2, kBack = 4, kFacade = 8, kFloor = 16, kRoof = 32 };
void add_room(SceneDescription& d, int without) {
  if (!(without & kLeft)) add(d, {{0, 0, 0}, {0, 3, 0}, {0, 0, 4}});
  if (!(without & kRight)) add(d, {{4, 0, 0}, {0, 3, 0}, {0, 0, 4}});
  if (!(without & kBack)) add(d, {{0, 0, 0}, {4, 0, 0}, {0, 3, 0}});
  if (!(without & kFacade)) add(d, {{0, 0, 4}, {4, 0, 0}, {0, 3, 0}});
  if (!(without & kFloor)) add(d, {{0, 0, 0}, {4, 0, 0}, {0, 0, 4}});
  if (!(without & kRoof)) add(d, {{0, 3, 0}, {4, 0, 0}, {0, 0, 4}});
}

/// A side with a hole: the four rectangles around it.
void add_frame(SceneDescription& d, const Rectangle& side, const Rectangle& hole) {
  const double width = std::sqrt(product(side.u, side.u)), height = std::sqrt(product(side.v, side.v));
  const Point u = side.u * (1 / width), v = side.v * (1 / height);
  const double x0 = product(hole.corner - side.corner, u), x1 = x0 + product(hole.u, u);
  const double y0 = product(hole.corner - side.corner, v), y1 = y0 + product(hole.v, v);
  const auto part = [&](double ax, double ay, double bx, double by) {
    if (bx > ax && by > ay) add(d, {side.corner + u * ax + v * ay, u * (bx - ax), v * (by - ay)});
  };
  part(0, 0, x0, height);
  part(x1, 0, width, height);
  part(x0, 0, x1, y0);
  part(x0, y1, x1, height);
}

struct Effort {
  std::uint32_t samples, gather;
  std::uint64_t photons = 1000;
  bool on_surfaces = false;
  bool without_direct = false;
};

/// Light at the sensors in W m^-2. Sensors whose relative standard error is above 0.2% are measured again with four
/// times as many samples, up to three times.
std::vector<double> measured(SceneDescription d, const std::vector<Sensor>& sensors, const Effort& effort) {
  constexpr float kErrorAsked = 0.002f;
  const auto scene = std::make_shared<const Scene>(std::move(d));
  const auto tracer = std::make_shared<const Tracer>(*scene);
  RenderSettings s;
  s.samples = effort.samples;
  s.gather = effort.gather;
  s.photons = effort.photons;
  s.filter = Filtering::off;
  std::vector<double> out(sensors.size());
  std::vector<std::size_t> pending(sensors.size());
  std::iota(pending.begin(), pending.end(), std::size_t{0});
  for (int round = 0; round < 4 && !pending.empty(); ++round, s.samples *= 4) {
    Sensors places;
    for (const std::size_t i : pending) places.add(vec(sensors[i].place), vec(sensors[i].normal));
    Job job(scene, tracer, s, nullptr, 0, std::make_shared<const PointGrid>(sensor_grid(places, effort.on_surfaces)));
    job.wait();
    const Film film = job.snapshot();
    const Measurement result = measurement_of(places, film, *scene);
    std::vector<std::size_t> noisy;
    for (std::size_t k = 0; k < pending.size(); ++k) {
      out[pending[k]] = result.irradiance[k].g - (effort.without_direct ? film.mean(Film::Layer::direct, k).g : 0.0f);
      if (result.relative_error[k] > kErrorAsked) noisy.push_back(pending[k]);
    }
    pending = noisy;
    // The mean over many sensors needs no more.
    if (effort.on_surfaces) break;
  }
  return out;
}

/// Values of the norm's tables, as open sources quote them.
struct Published {
  std::vector<double> values;
  double scale = 1;  ///< of our values to theirs
  const char* unit = "W m^-2";
  double tolerance = 0;
};

/// What a page of results says: one row for each point with a published value, one for each other set-up.
class Page {
 public:
  static Page& get() {
    static Page page;
    return page;
  }
  void add(const std::string& row) { rows_ += row + "\n"; }
  ~Page() {
    const char* file = std::getenv("GLOWWORM_CIE171");
    if (!file) return;
    std::ofstream(file)
        << "# The analytic cases of CIE 171:2006\n\n"
           "Written by `cie171_test`. Expected values are closed forms or quadratures of the test's own; "
           "published ones are those of the\nnorm's tables as CyclesCIEtest and DAU's validation of Iray "
           "(2016) quote them.\n\n"
           "| set-up | point | ours | expected | published | unit | ours / expected |\n"
           "| --- | --- | ---: | ---: | ---: | --- | ---: |\n"
        << rows_
        << "\nThe norm's tables are wrong where DAU or quadrature shows it: 5.7 (table 19; the row above is "
           "DAU's correction), 5.9 with the\nopen roof at A (46.74 for the uniform sky, 45.12 by closed "
           "form) and 5.11 with the open facade at A, C, D and F; tables B.22\n(skies 1 to 4, 6 to 9 and "
           "11), B.25 and B.26 (A to D). At grazing angles the table of 5.5 passes more than Fresnel's equations "
           "for\nindex 1.52.\n";
  }

 private:
  std::string rows_;
};

/// Ours lies within the tolerance of the norm's reader, and expected values within that of published ones, which checks
/// the geometry.
void compare(const std::string& what, const std::vector<double>& ours, const std::vector<double>& expected,
             const Published& published = {}) {
  double worst = 0;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const std::string point(1, static_cast<char>('A' + i));
    EXPECT_NEAR(ours[i], expected[i], kTolerance * expected[i]) << what << ", point " << point;
    const double ratio = expected[i] > 0 ? ours[i] / expected[i] : 1;
    if (std::abs(ratio - 1) > std::abs(worst)) worst = ratio - 1;
    if (i >= published.values.size()) continue;
    const double scaled = published.scale * expected[i];
    EXPECT_NEAR(scaled, published.values[i], published.tolerance * published.values[i]) << what << ", point " << point;
    Page::get().add(fmt::format("| {} | {} | {:.4g} | {:.4g} | {:.4g} | {} | {:.4f} |", what, point,
                                published.scale * ours[i], scaled, published.values[i], published.unit, ratio));
  }
  if (ours.size() > published.values.size())
    Page::get().add(fmt::format("| {} | all {}, the worst | | | | | {:.4f} |", what, ours.size(), 1 + worst));
}

TEST(SlowCie171, Case52PointLight) {
  SceneDescription d = black_scene();
  add(d, {{-2, 0, -2}, {4, 0, 0}, {0, 0, 4}});
  Light light;
  light.kind = LightKind::luminaire;
  light.intensity = RGB(1 / kLuminousEfficacy);
  light.position = {0, 3, 0};
  light.direction = {0, -1, 0};
  std::vector<float> angles, candela;
  for (int i = 0; i <= 90; ++i) {
    angles.push_back(static_cast<float>(i * M_PI / 180));
    candela.push_back(1000 * std::cos(angles.back()));
  }
  candela.back() = 0;
  light.table = std::make_shared<const IntensityTable>(TablePole::forward, std::vector<float>{0}, angles, candela);
  d.lights.push_back(light);
  std::vector<Sensor> sensors;
  std::vector<double> expected;
  for (const auto& [x, z] : std::vector<std::pair<double, double>>{
           {0, 0}, {0.5, 0}, {1, 0}, {1.5, 0}, {0.5, 0.5}, {1, 0.5}, {1.5, 0.5}, {1, 1}, {1.5, 1}, {1.5, 1.5}}) {
    sensors.push_back({{x, 0, z}, {0, 1, 0}});
    const double squared = 9 + x * x + z * z;
    expected.push_back(1000 * 9 / (squared * squared) / kLuminousEfficacy);
  }
  compare("5.2 point source", measured(d, sensors, {2, 4}), expected,
          {{111.11, 105.21, 90.02, 71.11, 99.73, 85.64, 68.06, 74.36, 59.98, 49.39}, kLuminousEfficacy, "lx", 1e-3});
}

TEST(SlowCie171, Case53AreaLight) {
  SceneDescription d = black_scene();
  add_room(d, kRoof);
  const Rectangle source{{1.5, 3, 1.5}, {1, 0, 0}, {0, 0, 1}};  // its front faces down
  add(d, source, 0, add_emission(d, RGB(1000 / kLuminousEfficacy)));
  const std::vector<Sensor> sensors = wall_and_floor();
  std::vector<double> expected;
  for (const Sensor& s : sensors)
    expected.push_back(seen_through(s, source, [](Point) { return 1000 / kLuminousEfficacy; }));
  compare("5.3 area source", measured(d, sensors, {16, 1024}), expected,
          {{32.68, 75.09, 81.38, 69.12, 53.41, 39.90, 61.27, 79.18, 95.52, 105.89}, kLuminousEfficacy, "lx", 0.004});
}

/// Sensors in the middles of cells of all sides of a box, facing inwards, and the area of a cell.
std::vector<Sensor> all_sides(Point size, int parts) {
  std::vector<Sensor> out;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool far : {false, true})
      for (int j = 0; j < parts; ++j)
        for (int i = 0; i < parts; ++i) {
          const double s[3] = {size.x, size.y, size.z};
          double p[3], n[3] = {0, 0, 0};
          p[axis] = far ? s[axis] : 0;
          n[axis] = far ? -1 : 1;
          p[(axis + 1) % 3] = (i + 0.5) / parts * s[(axis + 1) % 3];
          p[(axis + 2) % 3] = (j + 0.5) / parts * s[(axis + 2) % 3];
          out.push_back({{p[0], p[1], p[2]}, {n[0], n[1], n[2]}});
        }
  return out;
}

Light isotropic(double lumens, Vec3 place) {
  Light light;
  light.intensity = RGB(static_cast<float>(lumens / (4 * M_PI) / kLuminousEfficacy));
  light.position = place;
  return light;
}

TEST(SlowCie171, Case54FluxConservation) {
  SceneDescription d = black_scene();
  add_room(d, 0);
  d.lights.push_back(isotropic(10'000, {2, 1.5f, 2}));
  constexpr int kParts = 40;
  const std::vector<Sensor> sensors = all_sides({4, 3, 4}, kParts);
  const std::vector<double> ours = measured(d, sensors, {1, 1});
  double flux = 0;
  for (std::size_t i = 0; i < sensors.size(); ++i)
    flux += ours[i] * (sensors[i].normal.y == 0 ? 12.0 : 16.0) / (kParts * kParts);
  flux *= kLuminousEfficacy / 10'000;
  EXPECT_NEAR(flux, 1, 0.001);
  Page::get().add(
      fmt::format("| 5.4 flux on surfaces over flux emitted | | {:.5f} | 1 | 1 | 1 | {:.4f} |", flux, flux));
}

/// Directional transmittance of a pane: index 1.52, both faces with inter-reflection, for both polarisations.
/// @param inside share that one passage of the glass keeps at normal incidence
double pane_transmittance(double cosine, double inside) {
  constexpr double kIndex = 1.52;
  const double refracted = std::sqrt(1 - (1 - cosine * cosine) / (kIndex * kIndex));
  const double s = (cosine - kIndex * refracted) / (cosine + kIndex * refracted);
  const double p = (kIndex * cosine - refracted) / (kIndex * cosine + refracted);
  const double t = std::pow(inside, 1 / refracted);
  double sum = 0;
  for (const double r : {s * s, p * p}) sum += (1 - r) * (1 - r) * t / (1 - r * r * t * t) / 2;
  return sum;
}

std::uint32_t add_glass(SceneDescription& d, double inside) {
  Material m;
  m.kind = MaterialKind::thin_dielectric;
  m.ior = 1.52f;
  m.reflectance.value = RGB(1.0f);
  m.transmittance.value = RGB(static_cast<float>(inside));
  d.materials.push_back(m);
  return static_cast<std::uint32_t>(d.materials.size() - 1);
}

TEST(SlowCie171, Case55GlassByAngle) {
  Bsdf pane;
  pane.kind = BsdfKind::thin_dielectric;
  pane.eta = RGB(1.52f);
  pane.specular = RGB(1.0f);
  std::map<int, double> passed_at;  // without absorption
  for (const double inside : {1.0, 0.96}) {
    pane.transmission = RGB(static_cast<float>(inside));
    for (int degrees = 0; degrees <= 85; degrees += 5) {
      const double cosine = std::cos(degrees * M_PI / 180);
      const Vec3 wo = vec({std::sqrt(1 - cosine * cosine), 0, cosine});
      double passed = 0;
      constexpr int kSamples = 10'000;
      for (int i = 0; i < kSamples; ++i) {
        const BsdfSample s = sample(pane, wo, (i + 0.5f) / kSamples, {0.5f, 0.5f}, kAllLobes, Transport::radiance);
        if (s.valid && s.wi.z < 0) passed += s.weight.g / kSamples;
      }
      const double expected = pane_transmittance(cosine, inside);
      EXPECT_NEAR(passed, expected, 0.002 * expected) << degrees << " degrees, " << inside;
      if (inside == 1) passed_at[degrees] = passed;
    }
  }
  for (const auto& [degrees, published] : {std::pair{0, 0.917}, {60, 0.860}, {75, 0.690}, {80, 0.533}}) {
    const double expected = pane_transmittance(std::cos(degrees * M_PI / 180), 1);
    if (degrees == 0) {
      EXPECT_NEAR(expected, published, 0.002);
    }
    Page::get().add(fmt::format("| 5.5 transmittance of glass | {} degrees | {:.4f} | {:.4f} | {} | 1 | {:.4f} |",
                                degrees, passed_at[degrees], expected, published, passed_at[degrees] / expected));
  }
}

TEST(SlowCie171, Case56ReflectionOfTheFloor) {
  SceneDescription d = black_scene();
  const Rectangle floor{{0, 0, 0}, {0, 0, 4}, {4, 0, 0}};
  add(d, floor, add_material(d, 0.3));
  Light sun = sun_light();
  sun.direction = {0, -1, 0};
  sun.intensity = RGB(1.0f);
  d.lights.push_back(sun);
  std::vector<Sensor> sensors;
  for (int i = 0; i < 5; ++i) sensors.push_back({{2, 0.75 + 0.5 * i, 0}, {0, 0, 1}});
  for (int i = 0; i < 4; ++i) sensors.push_back({{2, 3, 0.25 + 0.5 * i}, {0, -1, 0}});
  std::vector<double> expected;
  for (const Sensor& s : sensors) expected.push_back(seen_through(s, floor, [](Point) { return 0.3 / M_PI; }));
  compare("5.6 reflection of the floor", measured(d, sensors, {8, 1024, 1'000'000}), expected,
          {{35.90, 27.99, 21.64, 16.72, 12.97, 26.80, 30.94, 33.98, 35.57}, 100 / 0.3, "%", 0.001});
}

TEST(SlowCie171, Case57ReflectionOverAnObstacle) {
  SceneDescription d = black_scene();
  const Rectangle wall{{0, 0, 4}, {0, 3, 0}, {4, 0, 0}};
  add(d, wall, add_material(d, 0.6));
  add(d, {{0, 0, 2.5}, {4, 0, 0}, {0, 1, 0}});
  add(d, {{0, 0, 2.7}, {4, 0, 0}, {0, 1, 0}});
  add(d, {{0, 1, 2.5}, {4, 0, 0}, {0, 0, 0.2}});
  // Steep enough for the obstacle to cast no shadow on the wall.
  Light sun = sun_light();
  sun.direction = normalize({0, -2, 1});
  sun.intensity = RGB(std::sqrt(5.0f));
  d.lights.push_back(sun);
  std::vector<Sensor> sensors = wall_and_floor(3);
  std::vector<double> expected;
  for (const Sensor& s : sensors) {
    const auto over_box = [&](Point w) {
      if (w.z <= 0) return 0.0;
      // Within the box's depth the ray must be above it.
      for (const double z : {2.5, 2.7})
        if (s.place.y + w.y * (z - s.place.z) / w.z < 1) return 0.0;
      return 0.6 / M_PI;
    };
    expected.push_back(seen_through(s, wall, over_box, 800));
  }
  compare("5.7 reflection over an obstacle", measured(d, sensors, {8, 4096, 1'000'000, false, true}), expected,
          {{16.07, 16.33, 15.40, 13.32, 10.32, 7.08}, 100 / 0.6, "%", 0.005});
}

TEST(SlowCie171, Case58Interreflection) {
  for (const auto& [rho, published] : {std::pair{0.05, 5.48},
                                       {0.1, 11.6},
                                       {0.2, 26.0},
                                       {0.3, 44.6},
                                       {0.4, 69.4},
                                       {0.5, 104.0},
                                       {0.6, 156.0},
                                       {0.7, 243.0},
                                       {0.8, 417.0},
                                       {0.9, 937.0},
                                       {0.95, 1979.0}}) {
    SceneDescription d = black_scene();
    d.materials[0].reflectance.value = RGB(static_cast<float>(rho));
    for (int axis = 0; axis < 3; ++axis)
      for (const float side : {0.0f, 4.0f}) {
        Vec3 corner{0, 0, 0}, u{0, 0, 0}, v{0, 0, 0};
        corner[axis] = side;
        u[(axis + 1) % 3] = v[(axis + 2) % 3] = 4;
        side == 0 ? add_quad(d, corner, u, v) : add_quad(d, corner, v, u);
      }
    d.lights.push_back(isotropic(10'000, {2, 2, 2}));
    const std::vector<Sensor> sensors = all_sides({4, 4, 4}, 12);
    const std::vector<double> ours = measured(d, sensors, {4, 64, 400'000, true, true});
    double mean = 0;
    for (const double e : ours) mean += e / static_cast<double>(ours.size());
    const double expected = rho * 10'000 / (96 * (1 - rho));
    mean *= kLuminousEfficacy;
    EXPECT_NEAR(mean, expected, kTolerance * expected) << rho;
    Page::get().add(
        fmt::format("| 5.8 interreflection at reflectance {} | mean | {:.4g} | {:.4g} | {:.4g} | lx | {:.4f} |", rho,
                    mean, expected, published, mean / expected));
  }
}

/// The sky's radiance in its own numbers: CIE S 011/E:2003, table 1; type 16 is the overcast sky. North is -z.
struct TestSky {
  explicit TestSky(int type) : type_(type) {
    double sum = 0;
    constexpr int kParts = 1000;
    for (int i = 0; i < kParts; ++i)
      for (int j = 0; j < kParts; ++j) {
        const double theta = (i + 0.5) / kParts * M_PI / 2, phi = (j + 0.5) / kParts * 2 * M_PI;
        sum += relative({std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)}) *
               std::cos(theta) * std::sin(theta);
      }
    scale_ = 1 / (sum * M_PI / 2 * 2 * M_PI / (kParts * kParts));
  }
  /// For a horizontal irradiance of 1 W m^-2.
  double radiance(Point w) const { return w.y > 0 ? relative(w) * scale_ : 0; }

 private:
  double relative(Point w) const {
    if (type_ == 16) return (1 + 2 * w.y) / 3;
    static constexpr int kGradation[15] = {1, 1, 2, 2, 3, 3, 3, 3, 4, 4, 4, 5, 5, 6, 6};
    static constexpr int kIndicatrix[15] = {1, 2, 1, 2, 1, 2, 3, 4, 2, 3, 4, 4, 5, 5, 6};
    static constexpr double kA[6] = {4, 1.1, 0, -1, -1, -1}, kB[6] = {-0.7, -0.8, -1, -0.55, -0.32, -0.15};
    static constexpr double kC[6] = {0, 2, 5, 10, 16, 24}, kD[6] = {-1, -1.5, -2.5, -3, -3, -2.8},
                            kE[6] = {0, 0.15, 0.3, 0.45, 0.3, 0.15};
    const int g = kGradation[type_ - 1] - 1, k = kIndicatrix[type_ - 1] - 1;
    const double cosine = product(w, {0, std::sin(M_PI / 3), std::cos(M_PI / 3)}),
                 chi = std::acos(std::min(cosine, 1.0));
    return (1 + kA[g] * std::exp(kB[g] / w.y)) *
           (1 + kC[k] * (std::exp(kD[k] * chi) - std::exp(kD[k] * M_PI / 2)) + kE[k] * cosine * cosine);
  }
  int type_;
  double scale_ = 1;
};

Environment sky_of(int type, double ground) {
  return sky_environment(cie_sky(type, sky_direction(60, 180), 1, ground));
}

const Rectangle kSmallRoofHole{{1.5, 3, 1.5}, {1, 0, 0}, {0, 0, 1}}, kOpenRoof{{0, 3, 0}, {4, 0, 0}, {0, 0, 4}};
const Rectangle kRoofPlane = kOpenRoof;

/// A black room under a sky with a hole in the roof, which glass may cover.
void compare_roof(const Rectangle& hole, int type, double glass, const Effort& effort,
                  const std::vector<double>& published = {}) {
  SceneDescription d = black_scene();
  add_room(d, kRoof);
  add_frame(d, kRoofPlane, hole);
  if (glass > 0) add(d, hole, add_glass(d, glass));
  d.environment = sky_of(type, 0);
  const TestSky sky(type);
  const std::vector<Sensor> sensors = wall_and_floor();
  std::vector<double> expected;
  for (const Sensor& s : sensors)
    expected.push_back(seen_through(
        s, hole, [&](Point w) { return sky.radiance(w) * (glass > 0 ? pane_transmittance(w.y, glass) : 1); }));
  compare(fmt::format("{} roof {:g} x {:g} m{}, sky {}", glass > 0 ? "5.10" : "5.9", hole.u.x, hole.v.z,
                      glass > 0 ? " with glass" : "", type),
          measured(d, sensors, effort), expected, {published, 100, "%", 0.02});
}

TEST(SlowCie171, Case59SkyThroughTheRoof) {
  compare_roof(kSmallRoofHole, 5, 0, {32, 4096}, {1.04, 2.39, 2.59, 2.20, 1.70, 1.27, 1.95, 2.52, 3.04, 3.37});
  compare_roof(kSmallRoofHole, 1, 0, {32, 4096}, {0.46, 1.64, 2.34, 2.26, 1.88, 1.47, 2.33, 3.11, 3.84, 4.29});
  compare_roof(kSmallRoofHole, 16, 0, {32, 4096}, {0.56, 1.78, 2.32, 2.20, 1.82, 1.43, 2.29, 3.07, 3.82, 4.29});
  for (int type = 1; type <= 16; ++type) compare_roof(kOpenRoof, type, 0, {16, 1024});
}

TEST(SlowCie171, Case510SkyThroughGlassInTheRoof) {
  compare_roof(kSmallRoofHole, 5, 0.96, {32, 4096}, {0.35, 1.69, 2.12, 1.87, 1.47, 1.11, 1.71, 2.22, 2.68, 2.96});
  for (const int type : {1, 12, 16}) compare_roof(kOpenRoof, type, 0.96, {16, 1024});
}

const Rectangle kFacadePlane{{0, 0, 4}, {4, 0, 0}, {0, 3, 0}}, kWindow{{1, 1, 4}, {2, 0, 0}, {0, 1, 0}};

/// What stands before the facade, as the test sees it and as the scene holds it.
struct Mask {
  Rectangle plate{};
  bool present = false;

  bool hides(Point from, Point w) const {
    if (!present) return false;
    const Point n = plate.normal();
    const double t = product(plate.corner - from, n) / product(w, n);
    if (!(t > 0)) return false;
    const Point at = from + w * t - plate.corner;
    const double x = product(at, plate.u) / product(plate.u, plate.u),
                 y = product(at, plate.v) / product(plate.v, plate.v);
    return x >= 0 && x <= 1 && y >= 0 && y <= 1;
  }
};

/// A black room under a sky over a ground of reflectance 0.3, with a hole in the facade, which faces south.
void compare_facade(const Rectangle& hole, int type, double glass, const Mask& mask, const Effort& effort,
                    const std::vector<double>& published = {}) {
  SceneDescription d = black_scene();
  add_room(d, kFacade);
  add_frame(d, kFacadePlane, hole);
  if (glass > 0) add(d, hole, add_glass(d, glass));
  if (mask.present) add(d, mask.plate);
  d.environment = sky_of(type, 0.3);
  const TestSky sky(type);
  std::vector<Sensor> sensors = wall_and_floor(8);
  std::vector<double> expected;
  for (const Sensor& s : sensors)
    expected.push_back(seen_through(
        s, hole,
        [&](Point w) {
          const double light = mask.hides(s.place, w) ? 0 : w.y > 0 ? sky.radiance(w) : 0.3 / M_PI;
          return light * (glass > 0 ? pane_transmittance(std::abs(w.z), glass) : 1);
        },
        mask.present ? 800 : 400));
  const char* const number = mask.present ? (mask.plate.v.y > 0 ? "5.14" : "5.13") : glass > 0 ? "5.12" : "5.11";
  const std::string masked = mask.present ? fmt::format(", mask {:g} m", mask.plate.v.y + mask.plate.v.z) : "";
  compare(fmt::format("{} facade {:g} x {:g} m{}{}, sky {}", number, hole.u.x, hole.v.y, glass > 0 ? " with glass" : "",
                      masked, type),
          measured(d, sensors, effort), expected, {published, 100, "%", 0.02});
}

TEST(SlowCie171, Case511SkyAndGroundThroughTheFacade) {
  compare_facade(kWindow, 5, 0, {}, {32, 4096}, {0.95, 1.06, 1.79, 3.09, 3.54, 3.17});
  for (const int type : {1, 4, 8, 12, 16}) compare_facade(kFacadePlane, type, 0, {}, {16, 1024});
}

TEST(SlowCie171, Case512SkyAndGroundThroughGlassInTheFacade) {
  compare_facade(kWindow, 5, 0.96, {}, {32, 4096});
  compare_facade(kFacadePlane, 12, 0.96, {}, {16, 1024});
}

TEST(SlowCie171, Case513HorizontalMask) {
  for (const double depth : {0.5, 1.0, 2.0})
    compare_facade(kWindow, 16, 0, {{{1, 2, 4}, {2, 0, 0}, {0, 0, depth}}, true}, {32, 4096});
}

TEST(SlowCie171, Case514VerticalMask) {
  for (const double height : {3.0, 6.0, 9.0})
    compare_facade(kWindow, 16, 0, {{{-20, 0, 10}, {44, 0, 0}, {0, height, 0}}, true}, {32, 4096});
}

}  // namespace
}  // namespace glowworm
