// Zones, isolines, glare of lamps by formula, and the page of a room.
#include "measure/room_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "measure/isolines.h"
#include "measure/lamp_glare.h"
#include "measure/zones.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

TEST(Isolines, FollowAPlaneAndARing) {
  std::vector<float> plane, cone;
  for (int y = 0; y < 11; ++y)
    for (int x = 0; x < 11; ++x) {
      plane.push_back(static_cast<float>(x + 2 * y));
      cone.push_back(static_cast<float>(std::hypot(x - 5, y - 5)));
    }
  const std::vector<float> level = {10.5f};
  const std::vector<Isoline> lines = isolines(plane, 11, level);
  ASSERT_EQ(lines.size(), 1u);
  for (const Vec2 p : lines[0].points) EXPECT_NEAR(p.x + 2 * p.y, 10.5f, 1e-4f);
  EXPECT_NEAR(std::abs(lines[0].points.front().x - lines[0].points.back().x), 10, 1e-4f) << "from border to border";
  const std::vector<float> radius = {3.3f};
  const std::vector<Isoline> rings = isolines(cone, 11, radius);
  ASSERT_EQ(rings.size(), 1u);
  EXPECT_EQ(rings[0].points.front().x, rings[0].points.back().x);
  EXPECT_EQ(rings[0].points.front().y, rings[0].points.back().y);
  for (const Vec2 p : rings[0].points) EXPECT_NEAR(std::hypot(p.x - 5, p.y - 5), 3.3, 0.06);
  // A saddle has two lines, whatever its middle is.
  for (const float lift : {0.0f, 0.4f, -0.4f}) {
    const std::vector<float> saddle = {1 + lift, 0, 0, 1 + lift}, half = {0.5f};
    EXPECT_EQ(isolines(saddle, 2, half).size(), 2u) << lift;
  }
}

TEST(Isolines, HaveRoundLevels) {
  const std::vector<float> values = {98, 512}, even = {100, 100.01f};
  EXPECT_EQ(round_levels(values), (std::vector<float>{100, 200, 300, 400, 500}));
  EXPECT_TRUE(round_levels(even).empty());
}

/// A room of 4 x 3 x 4 m around the origin, floor at y = 0, with a panel of 1 m^2 below the ceiling.
SceneDescription room(float radiance = 10) {
  SceneDescription d;
  d.name = "room";
  d.materials.emplace_back();
  const Vec3 x{4, 0, 0}, y{0, 3, 0}, z{0, 0, 4}, corner{-2, 0, -2};
  d.geometry.begin_object("floor");
  add_quad(d, corner, z, x);
  d.geometry.begin_object("shell");
  add_quad(d, corner + y, x, z);
  add_quad(d, corner, x, y);
  add_quad(d, corner + z, y, x);
  add_quad(d, corner, y, z);
  add_quad(d, corner + x, z, y);
  const std::uint32_t emission = add_emission(d, RGB(radiance));
  d.emissions[emission].name = "panel & co";
  d.geometry.begin_object("panel");
  add_quad(d, {-0.5f, 2.9f, -0.5f}, {1, 0, 0}, {0, 0, 1}, 0, emission);
  return d;
}

TEST(Zones, HaveTheGridOfTheStandard) {
  const Scene scene(room());
  const Tracer tracer(scene);
  Sensors sensors;
  // 0.2 * 5^log10(3.5) = 0.48 m.
  const Zone desk = add_zone("desk=-1.75,0.8,-1,1.75,0.8,1", tracer, sensors, 10'000);
  EXPECT_EQ(desk.columns, 8);
  EXPECT_EQ(desk.rows, 5);
  EXPECT_EQ(desk.count, 40u);
  EXPECT_EQ(desk.eyes, 4u * 3);
  EXPECT_EQ(sensors.size(), 40 + desk.eyes * kEyeDirections);
  EXPECT_LT(length(sensors.position[0] - Vec3{-1.75f + 3.5f / 16, 0.8f, -0.8f}), 1e-5f);
  EXPECT_EQ(sensors.normal[0], (Vec3{0, 1, 0}));
  EXPECT_NEAR(sensors.position[desk.first_eye].y, 1.2, 1e-5) << "above the floor";
  const Zone wall = add_zone("wall=2,0,-1,2,2,1,0.5", tracer, sensors, 10'000);
  EXPECT_EQ(wall.count, 4u * 4);
  EXPECT_EQ(wall.eyes, 0u);
  EXPECT_LT(length(sensors.normal[wall.first] - Vec3{-1, 0, 0}), 1e-6f) << "the first corner is at the left";
  const Zone floor = add_zone("ground=floor,1", tracer, sensors, 10'000);
  EXPECT_GT(floor.count, 16u);
  for (const char* bad : {"desk", "=0,0,0,1,0,1", "a=0,0,0,1,1,1", "a=0,0,0,0,0,1", "a=none", "a=0,0,0,1,0,1,0",
                          "a=0,0,0,1,0", "a=0,0,0,100,0,100,0.1"})
    EXPECT_THROW(add_zone(bad, tracer, sensors, 1000), Error) << bad;
}

/// Files wind floors either way; the undersides of slabs are none.
TEST(Zones, EyesAreAboveFloorsThatFaceDownAndAboveSlabs) {
  for (const bool slab : {false, true}) {
    SceneDescription d;
    d.materials.emplace_back();
    if (slab) add_quad(d, {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
    add_quad(d, {-2, slab ? -0.3f : 0.0f, -2}, {4, 0, 0}, {0, 0, 4});
    // A table top of 4 cm below the zone.
    add_quad(d, {-1, 0.74f, -1}, {0, 0, 2}, {2, 0, 0});
    add_quad(d, {-1, 0.7f, -1}, {2, 0, 0}, {0, 0, 2});
    const Scene scene(d);
    const Tracer tracer(scene);
    Sensors sensors;
    const Zone desk = add_zone("desk=-0.5,0.8,-0.5,0.5,0.8,0.5", tracer, sensors, 10'000);
    EXPECT_NEAR(sensors.position[desk.first_eye].y, 1.2, 1e-5) << slab;
  }
}

class LampGlare : public testing::TestWithParam<double> {};

TEST_P(LampGlare, IsThatOfTheFormulaForOnePanel) {
  SceneDescription in_air = room();
  in_air.media.emplace_back().sigma_a = RGB(static_cast<float>(GetParam()));
  in_air.ambient_medium = 0;
  const Scene scene(std::move(in_air));
  const Tracer tracer(scene);
  const Vec3 eye{0, 1.2f, 1.5f}, view{0, 0, -1};
  const std::vector<GlareSource> lamps = lamps_in_view(tracer, eye, view);
  // By hand: the panel in a hundred by a hundred pieces.
  double sum = 0, direct = 0;
  const double luminance = 10 * kLuminousEfficacy, area = 1e-4, background = 30;
  for (int i = 0; i < 100; ++i)
    for (int j = 0; j < 100; ++j) {
      const Vec3 way = Vec3{-0.5f + (i + 0.5f) / 100, 2.9f, -0.5f + (j + 0.5f) / 100} - eye;
      const double squared = length_squared(way), distance = std::sqrt(squared),
                   omega = area * way.y / distance / squared;
      const Vec3 d = way / static_cast<float>(distance);
      const double p = position_index({d.x, d.y, -d.z}), seen = luminance * std::exp(-GetParam() * distance);
      sum += seen * seen * omega / (p * p);
      direct += seen * omega * -d.z;
    }
  double found = 0;
  for (const GlareSource& lamp : lamps) found += lamp.illuminance;
  EXPECT_NEAR(found, direct, 0.005 * direct);
  EXPECT_NEAR(unified_glare_rating(background, lamps), 8 * std::log10(0.25 / background * sum), 0.05);
  EXPECT_TRUE(lamps_in_view(tracer, eye, {0, 0, 1}).empty()) << "behind the eye";
  SceneDescription hidden = room();
  add_quad(hidden, {-2, 2.5f, -2}, {0, 0, 4}, {4, 0, 0});
  const Scene below(std::move(hidden));
  EXPECT_TRUE(lamps_in_view(Tracer(below), eye, view).empty()) << "behind a board";
}

INSTANTIATE_TEST_SUITE_P(Absorption, LampGlare, testing::Values(0, 0.3));

/// Illuminance that grows along x at the sensors of zones; even at eyes.
Measurement measured_at(const Sensors& sensors, const Scene& scene) {
  Measurement m;
  m.sensors = sensors;
  (void)scene;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const bool eye = sensors.normal[i].y == 0;
    m.irradiance.emplace_back((eye ? 1000.0f : 300 + 100 * sensors.position[i].x) / kLuminousEfficacy);
    m.relative_error.push_back(0.01f);
  }
  return m;
}

TEST(RoomReport, DoesNotKnowTheErrorOfAZoneWithoutLight) {
  const Scene scene(room());
  const Tracer tracer(scene);
  Sensors sensors;
  const Zone desk = add_zone("desk=-1,0.8,-1,1,0.8,1,0.25", tracer, sensors, 10'000);
  Measurement m = measured_at(sensors, scene);
  const auto darken = [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      m.irradiance[i] = RGB(0.0f);
      m.relative_error[i] = std::numeric_limits<float>::infinity();
    }
  };
  darken(desk.first, desk.first + 1);
  EXPECT_NEAR(zone_figures(desk, m, tracer).error, 0.01, 1e-4) << "of those with light";
  EXPECT_THAT(zone_plan(desk, m, scene), testing::Not(HasSubstr("nan")));
  darken(desk.first, desk.first + desk.count);
  EXPECT_TRUE(std::isinf(zone_figures(desk, m, tracer).error));
  EXPECT_THAT(room_report({desk}, m, {}, tracer, {}), HasSubstr("<td>unknown"));
}

/// All numbers of a path of SVG.
std::vector<double> numbers_of(const std::string& path) {
  std::vector<double> out;
  std::string word;
  for (const char c : path + " ")
    if (std::isdigit(c) || c == '.' || c == '-')
      word += c;
    else if (!word.empty())
      out.push_back(std::stod(std::exchange(word, "")));
  return out;
}

/// 300 lx + 100 lx a metre along x: each line stands where the light has its level, and is labelled so.
TEST(RoomReport, IsolinesStandWhereTheLightHasTheirLevel) {
  const Scene scene(room());
  const Tracer tracer(scene);
  Sensors sensors;
  const Zone desk = add_zone("desk=-1,0.8,-1,1,0.8,1,0.25", tracer, sensors, 10'000);
  const std::string plan = zone_plan(desk, measured_at(sensors, scene), scene);
  const double mm = 135.0 / 2;  // of a metre: the height of plans
  std::vector<double> levels;
  for (std::size_t at = plan.find("stroke=\"#7a3b00\""); at != std::string::npos;
       at = plan.find("stroke=\"#7a3b00\"", at + 1)) {
    const std::size_t start = plan.rfind("d=\"", at) + 3;
    const std::vector<double> line = numbers_of(plan.substr(start, plan.find('"', start) - start));
    const double level = 300 + 100 * (line[0] / mm - 1);
    levels.push_back(std::round(level / 10) * 10);
    EXPECT_NEAR(level, levels.back(), 0.1);
    for (std::size_t i = 0; i < line.size(); i += 2) EXPECT_NEAR(line[i], line[0], 0.02);
    EXPECT_THAT(plan, HasSubstr(">" + std::to_string(static_cast<int>(levels.back())) + "</text>"));
  }
  EXPECT_GE(levels.size(), 3u);
  EXPECT_TRUE(std::adjacent_find(levels.begin(), levels.end(), std::greater_equal<>()) == levels.end());
  // The panel, a square of 1 m in the middle.
  const std::size_t lamps = plan.rfind("d=\"", plan.find("#3f78c0")) + 3;
  const std::vector<double> outline = numbers_of(plan.substr(lamps, plan.find('"', lamps) - lamps));
  const auto [least, most] = std::minmax_element(outline.begin(), outline.end());
  EXPECT_NEAR(*least, 0.5 * mm, 0.02);
  EXPECT_NEAR(*most, 1.5 * mm, 0.02);
}

TEST(RoomReport, HasFiguresPlansAndIsWellFormed) {
  const Scene scene(room());
  const Tracer tracer(scene);
  Sensors sensors;
  std::vector<Zone> zones = {add_zone("desk <1>=-1,0.8,-1,1,0.8,1,0.25", tracer, sensors, 10'000)};
  const Measurement m = measured_at(sensors, scene);
  const ZoneFigures f = zone_figures(zones[0], m, tracer);
  EXPECT_NEAR(f.mean, 300, 0.01);
  EXPECT_NEAR(f.least, 212.5, 0.01);
  EXPECT_NEAR(f.uniformity(), 212.5 / 300, 1e-4);
  EXPECT_NEAR(f.cylindrical, 1000, 0.01);
  // The eyes' 1000 lx are nearly all background.
  EXPECT_GT(f.ugr, 2);
  EXPECT_LT(f.ugr, 10);
  const std::string page =
      room_report(zones, m, {}, tracer, {"Room", "glowworm measure a & b", {{"seed", "0"}}, {"a note"}});
  for (const char* part : {"desk &lt;1&gt;", "panel &amp; co", "a &amp; b", "<svg", "212", "UGR", "size: A4", "a note"})
    EXPECT_THAT(page, HasSubstr(part));
  // Every element ends, in order.
  std::vector<std::string> open;
  for (std::size_t at = page.find('<'); at != std::string::npos; at = page.find('<', at + 1)) {
    const std::size_t end = page.find('>', at);
    ASSERT_NE(end, std::string::npos);
    const std::string tag = page.substr(at + 1, end - at - 1);
    if (tag[0] == '!' || tag.back() == '/') continue;
    if (tag[0] != '/') {
      open.push_back(tag.substr(0, tag.find_first_of(" \n")));
    } else {
      ASSERT_FALSE(open.empty());
      EXPECT_EQ(tag.substr(1), open.back());
      open.pop_back();
    }
  }
  EXPECT_TRUE(open.empty());
  EXPECT_EQ(page.find("http://", page.find("<body>")), page.find("http://www.w3.org/2000/svg")) << "loads nothing";
}

}  // namespace
}  // namespace glowworm
