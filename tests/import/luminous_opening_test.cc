// Luminous openings of luminaires: what files say of them, their light near and far, and its photons.
#include "import/ies/luminous_opening.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/random.h"
#include "import/ies/luminaire.h"
#include "scene/light_power.h"
#include "scene/light_sampling.h"
#include "scene/scene_parts.h"
#include "scene/surface.h"
#include "support/temporary_folder.h"
#include "trace/tracer.h"

namespace glowworm {
namespace {

using Shape = LuminousOpening::Shape;
using testing::HasSubstr;

/// A table of type C by a function of the direction in the luminaire's axes, in steps of 2 degrees.
std::shared_ptr<const IntensityTable> table_of(const std::function<double(Vec3)>& intensity, int last = 180) {
  std::vector<float> azimuths, polar, values;
  for (int c = 0; c <= 360; c += 2) azimuths.push_back(static_cast<float>(c * M_PI / 180));
  for (int g = 0; g <= last; g += 2) polar.push_back(static_cast<float>(g * M_PI / 180));
  for (const float c : azimuths)
    for (const float g : polar)
      values.push_back(
          static_cast<float>(intensity({std::sin(g) * std::cos(c), std::sin(g) * std::sin(c), std::cos(g)})));
  return std::make_shared<const IntensityTable>(TablePole::forward, azimuths, polar, values);
}

/// The floor of 4 m with a luminaire 2 m above it that aims down: the floor has z up.
SceneDescription lit_by(std::shared_ptr<const IntensityTable> table, LuminousOpening opening) {
  SceneDescription d = floor_description();
  Light light;
  light.name = "lamp";
  light.kind = LightKind::luminaire;
  light.intensity = RGB(1 / kLuminousEfficacy);
  light.position = {0, 0, 2};
  light.direction = {0, 0, -1};
  light.right = {1, 0, 0};
  light.table = std::move(table);
  light.opening = opening;
  d.lights.push_back(light);
  add_luminous_openings(d);
  return d;
}

/// Illuminance (lx) at a place of a surface that faces `normal`, by light samples.
double light_sampled(const Scene& scene, Vec3 place, Vec3 normal, int samples = 20'000) {
  double sum = 0;
  for (int i = 0; i < samples; ++i) {
    Sampler sampler(SamplerKind::sobol, 7, 0, static_cast<std::uint32_t>(i));
    const float u_light = sampler.next1();
    const LightSample s = sample_light(scene, place, u_light, sampler.next2());
    if (s.pdf > 0) sum += double{luminance(s.radiance)} * std::max(dot(s.direction, normal), 0.0f) / s.pdf;
  }
  return sum / samples * kLuminousEfficacy;
}

/// Uneven in every direction.
double uneven(Vec3 d) { return 300 + 200 * d.x + 100 * d.y * d.y + 150 * d.z; }

std::vector<LuminousOpening> openings() {
  return {{Shape::box, {0.6f, 0.3f, 0}, 2},           {Shape::box, {0.6f, 0.3f, 0.1f}, 2},
          {Shape::cylinder, {0.4f, 0.4f, 0}, 2},      {Shape::cylinder, {0.2f, 0.2f, 0.5f}, 2},
          {Shape::cylinder, {1.2f, 0.03f, 0.03f}, 0}, {Shape::cylinder, {0.1f, 0.6f, 0.2f}, 1},
          {Shape::ellipsoid, {0.3f, 0.2f, 0.4f}, 2}};
}

std::string name_of(const LuminousOpening& o) {
  return std::to_string(static_cast<int>(o.shape)) + " " + std::to_string(o.size.x) + " x " + std::to_string(o.size.y) +
         " x " + std::to_string(o.size.z);
}

TEST(LuminousOpenings, OfATubeLightNearPlacesByTheFormula) {
  // A line of length l and of intensity I cos(a) at the angle a from its normal gives I (a + sin a cos a) / (l d) at
  // the distance d from its middle, where tan a = l / (2 d): 2280, 818 and 236 lx.
  const double length = 1.2, candela = 1000;
  LuminousOpening strip{Shape::box, {1.2f, 0.002f, 0}, 2}, tube{Shape::cylinder, {1.2f, 0.002f, 0.002f}, 0};
  const Scene flat(lit_by(table_of([&](Vec3 d) { return candela * std::max(d.z, 0.0f); }, 90), strip));
  const Scene round(lit_by(table_of([&](Vec3 d) { return candela * std::sqrt(std::max(1 - d.x * d.x, 0.0f)); }), tube));
  const double expected[] = {2279.8, 818.0, 236.1};
  int i = 0;
  for (const double distance : {0.5, 1.0, 2.0}) {
    const double a = std::atan(length / 2 / distance);
    const double lux = candela * (a + std::sin(a) * std::cos(a)) / (length * distance);
    EXPECT_NEAR(lux, expected[i++], 0.1);
    const Vec3 place{0, 0, static_cast<float>(2 - distance)};
    EXPECT_NEAR(light_sampled(flat, place, {0, 0, 1}), lux, 0.004 * lux) << distance;
    EXPECT_NEAR(light_sampled(round, place, {0, 0, 1}), lux, 0.01 * lux) << distance;
  }
}

TEST(LuminousOpenings, HaveTheIntensitiesOfTheFileFarAway) {
  const auto table = table_of(uneven);
  for (const LuminousOpening& opening : openings()) {
    const Scene scene(lit_by(table, opening));
    double power = 0;
    for (const RGB& p : scene.source_powers()) power += luminance(p) * kLuminousEfficacy;
    EXPECT_NEAR(power, table->integral(), 1e-3 * table->integral()) << name_of(opening);
    for (const Vec3 towards : {Vec3{0, 0, -1}, Vec3{1, 0.2f, -0.5f}, Vec3{-0.3f, 1, 0.4f}, Vec3{-1, -1, 2}}) {
      const Vec3 d = normalize(towards);
      constexpr float kFar = 500;
      // The luminaire's y is across its x and its aim: (0, 1, 0) here.
      const Vec3 own{d.x, d.y, -d.z};
      const double lux = light_sampled(scene, Vec3{0, 0, 2} + d * kFar, -d, 4000);
      EXPECT_NEAR(lux * kFar * kFar, table->intensity(own), 0.01 * table->intensity(own)) << name_of(opening);
    }
  }
}

TEST(LuminousOpenings, EmitPhotonsAsTheyLight) {
  for (const LuminousOpening& opening : openings()) {
    const Scene scene(lit_by(table_of(uneven), opening));
    // A square of 20 cm on the floor's level, 1.2 m beside the middle.
    constexpr float kHalf = 0.1f, kSide = 1.2f;
    constexpr int kPhotons = 100'000, kCells = 3;
    double sum = 0, squares = 0, flux = 0;
    for (int i = 0; i < kPhotons; ++i) {
      Sampler sampler(SamplerKind::independent, 5, 0, static_cast<std::uint32_t>(i));
      const float u_light = sampler.next1();
      const Vec2 u_place = sampler.next2();
      const EmittedPhoton p = sample_emission(scene, u_light, u_place, sampler.next2());
      const double lumens = luminance(p.flux) * kLuminousEfficacy;
      flux += lumens / kPhotons;
      if (!(p.direction.z < 0)) continue;
      const Vec3 at = p.origin + p.direction * (-p.origin.z / p.direction.z);
      if (std::abs(at.x - kSide) > kHalf || std::abs(at.y) > kHalf) continue;
      sum += lumens;
      squares += lumens * lumens;
    }
    EXPECT_NEAR(flux, scene.light_power().total() * kLuminousEfficacy, 2e-3 * flux) << name_of(opening);
    double lux = 0;
    for (int y = 0; y < kCells; ++y)
      for (int x = 0; x < kCells; ++x) {
        const Vec3 place{kSide + kHalf * (2 * (x + 0.5f) / kCells - 1), kHalf * (2 * (y + 0.5f) / kCells - 1), 0};
        lux += light_sampled(scene, place, {0, 0, 1}, 1000) / (kCells * kCells);
      }
    const double area = 4 * kHalf * kHalf, error = std::sqrt(squares) / kPhotons / area;
    EXPECT_NEAR(sum / kPhotons / area, lux, 4 * error + 0.002 * lux) << name_of(opening);
  }
}

TEST(LuminousOpenings, AreSeenAsTheyAreSampled) {
  for (const LuminousOpening& opening : openings()) {
    const Scene scene(lit_by(table_of(uneven), opening));
    const Tracer tracer(scene);
    const Vec3 place{0.7f, -0.3f, 0.4f};
    int seen = 0;
    for (std::uint32_t i = 0; i < 200; ++i) {
      Sampler sampler(SamplerKind::independent, 11, 0, i);
      const float u_light = sampler.next1();
      const LightSample s = sample_light(scene, place, u_light, sampler.next2());
      if (!(s.pdf > 0)) continue;
      const Hit hit = tracer.intersect({place, 0, s.direction, 100});
      if (hit.triangle == kNone || scene.emissive_index(hit.triangle) == kNone) continue;
      ++seen;
      const SurfacePoint point = surface_point(scene, hit.triangle, hit.barycentric);
      const RGB radiance = emitted_radiance(scene, point, -s.direction);
      EXPECT_NEAR(radiance.g, s.radiance.g, 1e-3f * s.radiance.g) << name_of(opening);
      EXPECT_NEAR(light_pdf(scene, place, point), s.pdf, 0.01f * s.pdf) << name_of(opening);
      EXPECT_EQ(straight_transmittance(scene, hit.triangle, hit.barycentric, s.direction), RGB(1.0f));
    }
    EXPECT_GT(seen, 100) << name_of(opening);
  }
}

TEST(LuminousOpenings, AreFlatOnTheSidesWhereFilesHaveLight) {
  const LuminousOpening panel{Shape::box, {0.6f, 0.6f, 0}, 2};
  const auto normal_of = [](const Scene& scene) { return scene.geometry().normal(scene.emissive_triangles()[0]).z; };
  const Scene down(lit_by(table_of([](Vec3 d) { return std::max(d.z, 0.0f); }), panel));
  EXPECT_FALSE(down.emissions()[0].two_sided);
  EXPECT_NEAR(normal_of(down), -1, 1e-6);
  const Scene up(lit_by(table_of([](Vec3 d) { return std::max(-d.z, 0.0f); }), panel));
  EXPECT_FALSE(up.emissions()[0].two_sided);
  EXPECT_NEAR(normal_of(up), 1, 1e-6);
  EXPECT_TRUE(Scene(lit_by(table_of(uneven), panel)).emissions()[0].two_sided);
}

TEST(LuminousOpenings, InTheCeilingsPlaneAreMetBeforeIt) {
  SceneDescription d = lit_by(table_of([](Vec3 v) { return std::max(v.z, 0.0f); }), {Shape::box, {0.6f, 0.6f, 0}, 2});
  add_quad(d, {-2, -2, 2}, {0, 4, 0}, {4, 0, 0});  // faces down
  const Scene scene(std::move(d));
  const Tracer tracer(scene);
  for (int i = 0; i < 200; ++i) {
    const auto u = static_cast<float>(i) / 200;
    const Vec3 from{3 * u - 1.5f, 1.3f * u, 0.1f}, to{0.5f * u - 0.25f, 0.2f, 2};
    Ray ray{from, 0, normalize(to - from), 100};
    Hit hit = tracer.intersect(ray);
    EXPECT_NE(scene.emissive_index(hit.triangle), kNone) << u;
    ray.t_min = hit.distance + 2 * scene.diffuse_triangle(hit.triangle).offset();
    hit = tracer.intersect(ray);
    ASSERT_NE(hit.triangle, kNone);
    EXPECT_GE(hit.triangle, scene.geometry().triangle_count() - 2) << "the ceiling is whole behind the lamp";
  }
}

TEST(LuminousOpenings, FollowTheSignsOfEachEdition) {
  struct Case {
    float width, length, height;
    int edition;
    LuminousOpening expected;
  };
  const std::vector<Case> cases = {{0, 0, 0, 2002, {Shape::box, {0, 0, 0}, 2}},
                                   {0.3f, 1.2f, 0, 1986, {Shape::box, {1.2f, 0.3f, 0}, 2}},
                                   {0.3f, 1.2f, 0.1f, 2002, {Shape::box, {1.2f, 0.3f, 0.1f}, 2}},
                                   {-0.5f, 0, 0, 1995, {Shape::cylinder, {0.5f, 0.5f, 0}, 2}},
                                   {-0.5f, 0, 0.2f, 1991, {Shape::cylinder, {0.5f, 0.5f, 0.2f}, 2}},
                                   {-0.5f, -0.5f, 0, 2002, {Shape::cylinder, {0.5f, 0.5f, 0}, 2}},
                                   {-0.5f, -0.4f, 0.2f, 2019, {Shape::cylinder, {0.4f, 0.5f, 0.2f}, 2}},
                                   {-0.5f, 0.4f, 0, 1986, {Shape::cylinder, {0.4f, 0.5f, 0}, 2}},
                                   {-0.5f, 0.4f, 0.2f, 1986, {Shape::ellipsoid, {0.4f, 0.5f, 0.2f}, 2}},
                                   {-0.5f, 0.4f, 0.2f, 1995, {Shape::cylinder, {0.4f, 0.5f, 0.2f}, 2}},
                                   {-0.5f, 0, -0.5f, 1995, {Shape::ellipsoid, {0.5f, 0.5f, 0.5f}, 2}},
                                   {0, 1.2f, -0.1f, 1995, {Shape::cylinder, {1.2f, 0.1f, 0.1f}, 0}},
                                   {1.2f, 0, -0.1f, 1995, {Shape::cylinder, {0.1f, 1.2f, 0.1f}, 1}},
                                   {-0.5f, -0.5f, -0.5f, 2002, {Shape::ellipsoid, {0.5f, 0.5f, 0.5f}, 2}},
                                   {-0.1f, 1.2f, -0.1f, 2002, {Shape::cylinder, {1.2f, 0.1f, 0.1f}, 0}},
                                   {1.2f, -0.1f, -0.1f, 2002, {Shape::cylinder, {0.1f, 1.2f, 0.1f}, 1}},
                                   {-0.5f, 0, -0.5f, 2002, {Shape::cylinder, {0, 0.5f, 0.5f}, 0}}};
  for (const Case& c : cases) {
    const LuminousOpening o = lm63_opening(c.width, c.length, c.height, c.edition);
    EXPECT_EQ(static_cast<int>(o.shape), static_cast<int>(c.expected.shape)) << name_of(c.expected) << c.edition;
    EXPECT_EQ(o.size, c.expected.size) << name_of(c.expected) << ' ' << c.edition;
    if (o.shape == Shape::cylinder) {
      EXPECT_EQ(o.axis, c.expected.axis) << name_of(c.expected);
    }
  }
}

TEST(LuminousOpenings, ComeFromTheFile) {
  const auto lm63 = [](const std::string& first, const std::string& sizes) {
    return parse_lm63(
        first + "\n[LUMCAT] X1\n[LUMINAIRE] Disc \nTILT=NONE\n2 500 1 2 1 1 " + sizes + " 1 1 12\n0 90\n0\n10 0\n",
        "a.ies");
  };
  const PhotometricFile file = lm63("IESNA:LM-63-2002", "2 -0.5 -0.5 0");
  EXPECT_EQ(file.opening.size, (Vec3{0.5f, 0.5f, 0}));
  EXPECT_EQ(file.name, "Disc");
  ASSERT_EQ(file.sets.size(), 1u);
  EXPECT_EQ(file.sets[0].flux, 1000);
  EXPECT_EQ(file.sets[0].power, 12);
  EXPECT_NEAR(lm63("IESNA91", "1 1 2 0").opening.size.x, 2 * 0.3048f, 1e-6f) << "feet";
}

class OpeningFile : public FolderTest {};

TEST_F(OpeningFile, OfEulumdatHasLampsByName) {
  const std::string head =
      "Maker\n1\n1\n1\n0\n2\n90\nreport\nDownlight\n1\nf\nd\n600\n0\n80\n200\n0\n0\n0\n0\n0\n100\n90\n1\n0\n2\n";
  std::string text = head + "1\nLED 830\n1000\nwarm\n80\n10\n1\nLED 840\n3000\ncold\n80\n25\n";
  for (int i = 0; i < 10; ++i) text += "0.5\n";
  text += "0\n0\n90\n100\n0\n";
  const PhotometricFile first = parse_eulumdat(text, "a.ldt"), named = parse_eulumdat(text, "a.ldt", "LED 840");
  EXPECT_NEAR(first.table.greatest(), 100, 1e-3f);
  EXPECT_NEAR(named.table.greatest(), 300, 1e-3f);
  EXPECT_NEAR(parse_eulumdat(text, "a.ldt", "2").table.greatest(), 300, 1e-3f);
  EXPECT_EQ(named.sets[named.set].power, 25);
  EXPECT_EQ(named.name, "Downlight");
  EXPECT_EQ(static_cast<int>(named.opening.shape), static_cast<int>(Shape::cylinder));
  EXPECT_EQ(named.opening.size, (Vec3{0.2f, 0.2f, 0}));
  EXPECT_THAT(message_of([&] { parse_eulumdat(text, "a.ldt", "LED 850"); }), HasSubstr("1 'LED 830', 2 'LED 840'"));
  write("a.ldt", text);
  const std::string place = (folder_ / "a.ldt").string() + "@1,2,3";
  const Light light = luminaire_of_text(place + ",0,0,-1,90,scale=0.5,maintenance=0.8,lamps=LED 840,opening=off");
  EXPECT_NEAR(light.intensity.g * light.table->greatest() * kLuminousEfficacy, 300 * 0.4f, 0.01f);
  EXPECT_EQ(light.opening.extent(), 0);
  EXPECT_EQ(luminaire_of_text(place).opening.extent(), 2);
  for (const char* bad : {",scale=x", ",scale=-1", ",lamps=", ",opening=no", ",dim=1", "=1"})
    EXPECT_THROW(luminaire_of_text(place + bad), Error) << bad;
}

TEST_F(OpeningFile, TiltsByTheShortestWayWithoutAJump) {
  write("c.ies", "IESNA91\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 1\n0 90\n0\n10 20\n");
  write("b.ies", "IESNA91\nTILT=NONE\n1 -1 1 2 2 2 2 0 0 0\n1 1 1\n-90 90\n0 90\n4 4\n2 2\n");
  const auto right = [&](const char* file, Vec3 aim) {
    return luminaire_of_text((folder_ / file).string() + "@0,0,0," + std::to_string(aim.x) + "," +
                             std::to_string(aim.y) + "," + std::to_string(aim.z))
        .right;
  };
  EXPECT_LT(length(right("c.ies", {0, -1, 0}) - Vec3{1, 0, 0}), 1e-6f);
  for (int i = 0; i < 8; ++i) {
    const auto turn = static_cast<float>(i * M_PI / 4);
    const Vec3 aim{0.01f * std::cos(turn), -1, 0.01f * std::sin(turn)};
    EXPECT_LT(length(right("c.ies", aim) - Vec3{1, 0, 0}), 0.011f) << "beside straight down";
  }
  EXPECT_LT(length(right("c.ies", {1, 0, 0}) - Vec3{0, 1, 0}), 1e-5f) << "C0 goes with the tilt";
  EXPECT_LT(length(right("c.ies", {0, 0, 1}) - Vec3{1, 0, 0}), 1e-5f);
  EXPECT_LT(length(right("b.ies", {1, -0.5f, 0}) - Vec3{0, 0, 1}), 1e-5f) << "floodlights stand level";
}

}  // namespace
}  // namespace glowworm
