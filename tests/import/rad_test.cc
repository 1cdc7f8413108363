// Scenes of Radiance.
#include <cmath>
#include <map>

#include "bsdf/bsdf.h"
#include "import/scene_changes.h"
#include "render/render_testing.h"
#include "scene/environment.h"
#include "scene/surface.h"
#include "test_files.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

constexpr const char* kGrey = "void plastic grey 0 0 5 .5 .5 .5 0 0\n";

class RadTest : public FileTest {
 protected:
  SceneDescription load(const std::string& text) { return load_scene(write("a.rad", text)); }
  std::string refusal(const std::string& text) { return message_of(write("a.rad", text)); }
  static double area_of(const Geometry& g) {
    double sum = 0;
    for (std::uint32_t t = 0; t < g.triangle_count(); ++t) sum += g.area(t);
    return sum;
  }
  /// The area that faces away from the point, less that which faces it, over all of it.
  static double outward_of(const Geometry& g, Vec3 point) {
    double sum = 0;
    for (std::uint32_t t = 0; t < g.triangle_count(); ++t)
      sum += dot(g.normal(t), g.positions[g.triangles[t][0]] - point) > 0 ? g.area(t) : -g.area(t);
    return sum / area_of(g);
  }
};

/// A material's albedo for a viewer at an angle from the normal.
RGB albedo_of(const SceneDescription& d, float cosine, Lobes lobes) {
  const Scene scene(d);
  SurfacePoint point = surface_point(scene, 0, {0.3f, 0.3f});
  const Bsdf bsdf = resolve_bsdf(scene, point);
  return albedo(bsdf, {std::sqrt(1 - cosine * cosine), 0, cosine}, lobes);
}

TEST_F(RadTest, PrimitivesHaveTheirAreasAndFaceTheirWay) {
  struct Case {
    const char* text;
    double area;
    Vec3 inside;  // of axes with y up
    double outward;
  };
  const double slant = std::hypot(2, 1);
  const Case cases[] = {
      {"grey polygon p 0 0 12 0 0 1 2 0 1 2 3 1 0 3 1", 6, {1, 0, -1}, 1},
      {"grey sphere s 0 0 4 1 2 3 2", 16 * M_PI, {1, 3, -2}, 1},
      {"grey bubble s 0 0 4 1 2 3 2", 16 * M_PI, {1, 3, -2}, -1},
      {"grey sphere s 0 0 4 1 2 3 -2", 16 * M_PI, {1, 3, -2}, -1},
      {"grey cylinder c 0 0 7 0 0 0 3 0 0 .5", 3 * M_PI, {1.5f, 0, 0}, 1},
      {"grey tube c 0 0 7 0 0 0 3 0 0 .5", 3 * M_PI, {1.5f, 0, 0}, -1},
      {"grey cone c 0 0 8 0 0 0 0 2 0 2 1", 3 * slant * M_PI, {0, 0, -1}, 1},
      {"grey cone c 0 0 8 0 0 0 0 2 0 0 1", slant * M_PI, {0, 0, -1.9f}, 1},
      {"grey cup c 0 0 8 0 0 0 0 2 0 2 1", 3 * slant * M_PI, {0, 0, -1}, -1},
      {"grey ring r 0 0 8 0 0 1 0 0 -2 1 3", 8 * M_PI, {0, 2, 0}, 1},
      {"grey ring r 0 0 8 0 0 1 0 0 1 2 0", 4 * M_PI, {0, 0, 0}, 1},
      {"grey polygon hole 0 0 30 0 0 0 4 0 0 4 4 0 0 4 0 0 0 0 1 1 0 1 3 0 3 3 0 3 1 0 1 1 0", 12, {1, -1, -1}, 1},
  };
  for (const Case& c : cases) {
    const auto d = load(std::string(kGrey) + c.text);
    EXPECT_NEAR(area_of(d.geometry) / c.area, 1, 2e-5) << c.text;
    EXPECT_NEAR(outward_of(d.geometry, c.inside), c.outward, 1e-6) << c.text;
    EXPECT_TRUE(d.z_up);
  }
}

TEST_F(RadTest, BoxesAreClosedAndFaceOutwards) {
  struct Case {
    const char* text;
    double area, outward;
  };
  const double edge = std::sqrt(2) * 0.5;
  const Case cases[] = {
      {"!genbox grey b 2 3 4", 52, 1},
      {"!genbox grey b 2 3 4 -i", 52, -1},
      {"!genbox grey b 2 3 4 -b .5", 22 + 4 * edge * 6 + 8 * std::sqrt(3) / 4 * edge * edge, 1},
      // Whole cylinders and spheres stand at edges and corners; parts of them are inside.
      {"!genbox grey b 2 3 4 -r .5", 22 + 4 * M_PI * 6 + 8 * M_PI, 0},
  };
  for (const Case& c : cases) {
    const auto d = load(std::string(kGrey) + c.text + "\n");
    EXPECT_NEAR(area_of(d.geometry) / c.area, 1, 2e-5) << c.text;
    if (c.outward != 0) {
      EXPECT_NEAR(outward_of(d.geometry, {1, 2, -1.5f}), c.outward, 1e-6) << c.text;
    }
  }
}

TEST_F(RadTest, MaterialsHaveTheAlbedosOfTheManual) {
  constexpr Lobes kReflected = kDiffuseReflection | kGlossy;
  const auto at = [&](const std::string& material, float cosine, Lobes lobes) {
    return albedo_of(load("void " + material + "\nm polygon p 0 0 9 0 0 0 1 0 0 0 1 0\n"), cosine, lobes);
  };
  const auto expect = [&](const std::string& material, Lobes lobes, RGB wanted, float cosine = 0.8f) {
    const RGB found = at(material, cosine, lobes);
    // Of rough lobes a twentieth meets a second facet, and then the diffuse base.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], wanted[c], 0.006) << material << " channel " << c;
  };
  expect("plastic m 0 0 5 .2 .4 .6 0 0", kAllLobes, {0.2f, 0.4f, 0.6f});
  expect("plastic m 0 0 5 .2 .4 .6 .1 .2", kDiffuseReflection, RGB(0.2f, 0.4f, 0.6f) * 0.9f);
  expect("plastic m 0 0 5 0 0 0 .1 .2", kReflected, RGB(0.1f), 0.95f);
  expect("plastic m 0 0 5 0 0 0 .05 0", kSpecular, RGB(0.05f), 1);
  expect("metal m 0 0 5 .8 .6 .4 .7 0", kSpecular, RGB(0.8f, 0.6f, 0.4f) * 0.7f, 1);
  expect("metal m 0 0 5 .8 .6 .4 .7 .2", kDiffuseReflection, RGB(0.8f, 0.6f, 0.4f) * 0.3f);
  expect("trans m 0 0 7 .8 .6 .4 0 0 .5 0", kDiffuseTransmission, RGB(0.8f, 0.6f, 0.4f) * 0.5f);
  expect("trans m 0 0 7 .8 .6 .4 0 0 .5 0", kDiffuseReflection, RGB(0.8f, 0.6f, 0.4f) * 0.5f);
  expect("trans m 0 0 7 .8 .8 .8 .1 .1 .5 .4", kDiffuseTransmission, RGB(0.8f * 0.9f * 0.5f * 0.6f));
  expect("trans m 0 0 7 .8 .8 .8 .1 .1 .5 .4", kDiffuseReflection, RGB(0.8f * 0.9f * 0.5f));
  expect("trans m 0 0 7 .8 .8 .8 .01 0 .5 .4", kSpecular, RGB(0.01f + 0.8f * 0.99f * 0.5f * 0.4f), 1);
  expect("mirror m 0 0 3 .9 .9 .9", kAllLobes, RGB(0.9f), 0.2f);
  expect("mirror m 0 0 3 .9 .6 .3", kSpecular, {0.9f, 0.6f, 0.3f}, 1);
  expect("metal2 m 4 0 0 1 . 0 6 .8 .6 .4 .7 .1 .4", kDiffuseReflection, RGB(0.8f, 0.6f, 0.4f) * 0.3f);
}

/// Transmittance and reflectance by the formulas of glass.c and the manual: transmissivity 0.96 of plain glass is a
/// transmittance of 0.88.
TEST_F(RadTest, GlassHasTheTransmittanceOfItsTransmissivity) {
  const auto d = load("void glass m 0 0 3 .96 .96 .96\nm polygon p 0 0 9 0 0 0 1 0 0 0 1 0\n");
  const Scene scene(d);
  const float tau = straight_transmittance(scene, 0, {0.3f, 0.3f}, {0, 1, 0}).r;
  const double tn = (std::sqrt(0.8402528435 + 0.0072522239 * tau * tau) - 0.9166530661) / 0.0036261119 / tau;
  EXPECT_NEAR(tn, 0.96, 1e-4) << "the manual's formula from transmittance to transmissivity";
}

TEST_F(RadTest, SolidGlassAbsorbsByTheMetre) {
  const auto d = load(
      "void dielectric d 0 0 5 .5 .7 1 1.5 0\nvoid interface i 0 0 8 .5 .7 1 1.5 1 1 1 1.33\n"
      "d sphere s 0 0 4 0 0 0 1\ni sphere t 0 0 4 5 0 0 1\n");
  ASSERT_EQ(d.media.size(), 2u);
  EXPECT_FLOAT_EQ(d.media[0].sigma_a.r, std::log(2.0f));
  EXPECT_EQ(d.materials[0].inside, 0u);
  EXPECT_FLOAT_EQ(d.materials[1].ior, 1.5f / 1.33f);
  EXPECT_EQ(d.materials[1].outside, kNone);
  const Scene checked(d);
}

TEST_F(RadTest, ModifiersAliasesAndPatterns) {
  const auto d = load(
      "# comment\nvoid colorpict wood 7 red green blue wood.hdr . pic_u pic_v 0 1 1\n"
      "wood plastic table 0 0 5 .5 .5 .5 0 0\nvoid alias same table\ninherit alias other same\n"
      "table texfunc bumps 4 a b c . 0 0\nbumps polygon a 0 0 9 0 0 0 1 0 0 0 1 0\n"
      "other polygon \"b c\" 0 0 9 0 0 0 1 0 0 0 1 0\nvoid plastic table 0 0 5 .1 .1 .1 0 0\n"
      "table polygon d 0 0 9 0 0 0 1 0 0 0 1 0\nvoid polygon unseen 0 0 9 0 0 0 1 0 0 0 1 0\n");
  ASSERT_EQ(d.geometry.triangle_count(), 3u);
  EXPECT_EQ(d.geometry.material[0], d.geometry.material[1]);
  EXPECT_FLOAT_EQ(d.materials[d.geometry.material[2]].reflectance.value.r, 0.1f) << "the last definition counts";
  EXPECT_EQ(d.geometry.objects[1].name, "b c");
  EXPECT_THAT(d.notes, HasNote("colorpict 'wood' is not read"));
  EXPECT_THAT(d.notes, HasNote("texfunc 'bumps'"));
  EXPECT_THAT(d.notes, HasNote("surface without a material"));
}

TEST_F(RadTest, MixturesOfConstantSharesAndWithVoid) {
  const auto d = load(
      "void plastic red 0 0 5 .9 0 0 0 0\nvoid plastic blue 0 0 5 0 0 .9 0 0\n"
      "void mixfunc both 4 red blue .25 . 0 0\nvoid mixfunc fabric 4 void red .3 . 0 0\n"
      "void mixpict logo 5 red blue grey a.hdr . 0 0\n"
      "both polygon a 0 0 9 0 0 0 1 0 0 0 1 0\nfabric polygon b 0 0 9 0 0 0 1 0 0 0 1 0\n"
      "logo polygon c 0 0 9 0 0 0 1 0 0 0 1 0\n");
  const auto material = [&](std::size_t t) { return d.materials[d.geometry.material[t]]; };
  EXPECT_FLOAT_EQ(d.materials[material(0).mix_b].reflectance.value.r, 0.9f);
  EXPECT_FLOAT_EQ(material(0).mix_amount.value, 0.25f);
  EXPECT_FLOAT_EQ(material(1).alpha.value, 0.7f);
  EXPECT_FLOAT_EQ(material(2).mix_amount.value, 0.5f);
  EXPECT_THAT(d.notes, HasNote("mixpict 'logo'"));
}

TEST_F(RadTest, WhatIsNotSupportedIsNamed) {
  const auto d = load(
      "void BRTDfunc b 10 0 0 0 0 0 0 0 0 0 . 0 9 .1 .1 .1 .2 .2 .2 .3 .3 .3\n"
      "void antimatter hole 0 0 0\nb polygon p 0 0 9 0 0 0 1 0 0 0 1 0\n");
  EXPECT_FLOAT_EQ(d.materials[0].transmittance.value.g, 0.3f);
  EXPECT_THAT(d.notes, HasNote("material 'b' of type BRTDfunc is not supported: diffuse"));
  EXPECT_THAT(d.notes, HasNote("material 'hole' of type antimatter"));
}

TEST_F(RadTest, LightsShineForwardAndIllumsShowWhatTheyStandFor) {
  const auto d =
      load(std::string(kGrey) +
           "void light l 0 0 3 10 20 30\nvoid glow g 0 0 4 1 1 1 0\nvoid illum i 1 grey 0 3 5 5 5\n"
           "void illum j 0 0 3 5 5 5\nl polygon a 0 0 9 0 0 1 1 0 1 0 1 1\ng polygon b 0 0 9 0 0 0 1 0 0 0 1 0\n"
           "i polygon c 0 0 9 0 0 2 1 0 2 0 1 2\nj polygon d 0 0 9 0 0 2 1 0 2 0 1 2\n");
  ASSERT_EQ(d.geometry.triangle_count(), 3u);
  EXPECT_FLOAT_EQ(d.emissions.at(d.geometry.emission[0]).radiance.value.g, 20);
  EXPECT_FALSE(d.emissions[0].two_sided);
  EXPECT_EQ(d.geometry.emission[2], kNone);
  EXPECT_EQ(d.materials[d.geometry.material[2]].name, "grey");
}

TEST_F(RadTest, SpotlightsHaveTheIntensityOfTheirSurfaces) {
  const auto d = load(std::string(kGrey) +
                      "void spotlight s 0 0 7 100 100 100 60 0 0 -1\n"
                      "s ring r 0 0 8 1 2 3 0 0 -1 0 .1\ngrey polygon p 0 0 9 0 0 0 1 0 0 0 1 0\n");
  ASSERT_EQ(d.lights.size(), 1u);
  EXPECT_NEAR(d.lights[0].intensity.r, 100 * M_PI * 0.01, 1e-4);
  EXPECT_NEAR(d.lights[0].cos_outer, std::cos(M_PI / 6), 1e-6);
  EXPECT_NEAR(length(d.lights[0].position - Vec3{1, 3, -2}), 0, 1e-5);
  EXPECT_NEAR(d.lights[0].direction.y, -1, 1e-6);
}

/// Photons of a spotlight begin before its surface, whatever its shape, and reach the floor.
TEST_F(RadTest, SpotlightsAreNotShadedByTheirSurfaces) {
  for (const char* shape :
       {"ring r 0 0 8 1 2 3 0 0 -1 0 .1", "sphere r 0 0 4 1 2 3 .1", "polygon r 0 0 9 1 2 3 1 2.1 3 1.1 2 3.05"}) {
    const auto d = load(std::string(kGrey) + "void spotlight s 0 0 7 100 100 100 60 0 0 -1\ns " + shape +
                        "\ngrey polygon p 0 0 12 -9 -9 0 9 -9 0 9 9 0 -9 9 0\n");
    ASSERT_EQ(d.lights.size(), 1u) << shape;
    const Scene scene(d);
    const Tracer tracer(scene);
    for (const float tilt : {-0.5f, 0.0f, 0.5f}) {
      Ray ray;
      ray.origin = scene.lights()[0].position;
      ray.direction = normalize(Vec3{tilt, -1, tilt / 3});
      ray.t_max = std::numeric_limits<float>::infinity();
      const Hit hit = tracer.intersect(ray);
      ASSERT_NE(hit.triangle, kNone) << shape;
      EXPECT_GT(hit.distance, 2) << shape;
    }
  }
}

TEST_F(RadTest, SkiesOfGenskyAndGendaylit) {
  const std::string glows =
      "skyfunc glow skyglow 0 0 4 .9 .9 1.15 0\nskyglow source sky 0 0 4 0 0 1 180\n"
      "skyfunc glow groundglow 0 0 4 1.4 .9 .6 0\ngroundglow source ground 0 0 4 0 0 -1 180\n";
  const auto with = [&](const std::string& sky) {
    return load(std::string(kGrey) + "grey polygon p 0 0 9 0 0 0 1 0 0 0 1 0\n" + sky + glows);
  };
  const auto clear = with("void brightfunc skyfunc 2 skybr skybright.cal 0 7 1 20 10 2.5 .6 0 .8\n");
  ASSERT_TRUE(clear.environment.has_value());
  const Vec3 up = normalize({0.3f, 0.8f, -0.2f});
  const double gamma = std::acos(double{up.x} * 0.6 + double{up.y} * 0.8);
  const double wanted = 20 * (0.91 + 10 * std::exp(-3 * gamma) + 0.45 * std::pow(std::cos(gamma), 2)) *
                        (1 - std::exp(-0.32 / up.y)) / 2.5;
  EXPECT_NEAR(radiance(*clear.environment, up).r / (0.9 * wanted), 1, 1e-4);
  const double ground = 10 * luminance(RGB(1.4f, 0.9f, 0.6f));
  EXPECT_NEAR(luminance(radiance(*clear.environment, {0, -1, 0})) / ground, 1, 1e-4);
  const auto overcast = with("void brightfunc skyfunc 2 skybr skybright.cal 0 3 2 30 10\n");
  EXPECT_NEAR(radiance(*overcast.environment, {0, 1, 0}).r / (0.9 * 30), 1, 1e-4);
  EXPECT_NEAR(radiance(*overcast.environment, {0.8f, 0.6f, 0}).r / (0.9 * 30 * 2.2 / 3), 1, 1e-4);
  const auto perez = with("void brightfunc skyfunc 2 skybright perezlum.cal 0 10 5 4 1.1 -.3 2.5 -2 .4 0 .6 .8\n");
  const double c = double{up.z} * -0.6 + double{up.y} * 0.8;
  const double by_perez = 5 * (1 + 1.1 * std::exp(-0.3 / up.y)) * (1 + 2.5 * std::exp(-2 * std::acos(c)) + 0.4 * c * c);
  EXPECT_NEAR(radiance(*perez.environment, up).r / (0.9 * by_perez), 1, 1e-4);
}

TEST_F(RadTest, TheSunIsALightFarAway) {
  const auto d = load(std::string(kGrey) +
                      "grey polygon p 0 0 9 0 0 0 1 0 0 0 1 0\nvoid light solar 0 0 3 1e6 1e6 1e6\n"
                      "solar source sun 0 0 4 0 -1 1 .533\n");
  ASSERT_EQ(d.lights.size(), 1u);
  EXPECT_NEAR(d.lights[0].intensity.r, 1e6 * M_PI * std::pow(std::sin(0.2665 * M_PI / 180), 2), 1e-2);
  EXPECT_NEAR(length(d.lights[0].direction - normalize({0, -1, -1})), 0, 1e-6) << "the sun is in the south";
}

TEST_F(RadTest, XformPlacesTurnsAndRepeats) {
  write("part.rad", "m polygon p 0 0 9 1 0 0 2 0 0 1 1 0\n");
  write("args", "# three\n-t 0 0 1\n\nxform -t 0 0 2\n!xform -rx 90 -t 0 0 3\n");
  const std::string mats = "void plastic m 0 0 5 .5 .5 .5 0 0\nvoid plastic n 0 0 5 .2 .2 .2 0 0\n";
  const auto corner = [&](const std::string& line, std::size_t t = 0) {
    const auto d = load(mats + line + "\n");
    const Vec3 p = z_up_from_y_up(d.geometry.positions.at(d.geometry.triangles.at(t)[0]));
    return std::vector<double>{std::round(p.x * 1e4) / 1e4 + 0.0, std::round(p.y * 1e4) / 1e4 + 0.0,
                               std::round(p.z * 1e4) / 1e4 + 0.0};
  };
  using V = std::vector<double>;
  EXPECT_EQ(corner("!xform -t 1 2 3 part.rad"), (V{2, 2, 3}));
  EXPECT_EQ(corner("!xform -rz 90 part.rad"), (V{0, 1, 0}));
  EXPECT_EQ(corner("!xform -ry 90 part.rad"), (V{0, 0, -1}));
  EXPECT_EQ(corner("!xform -rz 90 -rx 90 part.rad"), (V{0, 0, 1}));
  EXPECT_EQ(corner("!xform -s 2 -t 1 0 0 part.rad"), (V{3, 0, 0}));
  EXPECT_EQ(corner("!xform -t 1 0 0 -i 3 -t 0 1 0 -i 1 -s 2 part.rad"), (V{4, 6, 0}));
  EXPECT_EQ(corner("!xform -rz 90 \\\n part.rad"), (V{0, 1, 0})) << "lines continue";
  EXPECT_EQ(corner("!cat part.rad | xform -t 0 0 1 | xform -s 2"), (V{2, 0, 2}));
  EXPECT_EQ(corner("!xform -f args part.rad", 2), (V{1, 0, 3}));
  const auto grid = load(mats + "!xform -n row -m n -a 3 -t 2 0 0 -a 4 -t 0 5 0 -i 1 -t 0 0 1 part.rad\n");
  ASSERT_EQ(grid.geometry.triangle_count(), 12u);
  EXPECT_EQ(grid.geometry.objects[0].name, "row.p");
  EXPECT_FLOAT_EQ(grid.materials[grid.geometry.material[0]].reflectance.value.r, 0.2f);
  const Box3 box = grid.geometry.bounds();
  EXPECT_NEAR(length(box.min - Vec3{1, 1, -16}) + length(box.max - Vec3{6, 1, 0}), 0, 1e-4);
  for (const char* line : {"!xform -mx part.rad", "!xform -rx 20 part.rad"})
    EXPECT_GT(load(mats + line + "\n").geometry.normal(0).y, 0.9f) << line << ": mirrors keep the front";
  EXPECT_LT(load(mats + "!xform -I part.rad\n").geometry.normal(0).y, -0.9f);
}

/// Areas, and their moments with normals and places, by the colour of a material, and whether it shines.
std::map<std::pair<float, bool>, std::vector<double>> moments_of(const SceneDescription& d) {
  std::map<std::pair<float, bool>, std::vector<double>> out;
  const Geometry g = d.geometry.expanded();
  for (std::uint32_t t = 0; t < g.triangle_count(); ++t) {
    const bool shines = g.emission[t] != kNone;
    std::vector<double>& sums = out[{d.materials[g.material[t]].reflectance.value.r, shines}];
    sums.resize(13);
    const auto& [a, b, c] = g.corners(t);
    const Vec3 middle = (a + b + c) / 3, normal = g.normal(t);
    const double area = g.area(t);
    sums[0] += area;
    for (int i = 0; i < 3; ++i) {
      sums[1 + static_cast<std::size_t>(i)] += area * middle[i];
      for (int j = 0; j < 3; ++j) sums[4 + static_cast<std::size_t>(3 * i + j)] += area * normal[i] * middle[j];
    }
  }
  return out;
}

TEST_F(RadTest, CopiesOfAFileAreInstances) {
  const std::string part =
      "void plastic own 0 0 5 .2 .2 .2 0 0\nvoid light lamp 0 0 3 1 1 1\nown sphere s 0 0 4 1 0 0 .5\n"
      "grey bubble b 0 0 4 1 2 0 .25\nlamp polygon l 0 0 9 0 0 1 1 0 1 0 2 1\n!xform -t 0 0 3 below.rad\n";
  const std::string below =
      "!genbox grey b 1 2 3 -r .2\nvoid plastic own 0 0 5 .3 .3 .3 0 0\nown sphere t 0 0 4 0 0 0 1\n";
  const std::vector<std::string> places = {"-t 1 0 0",  "-rz 30 -t 3 0 0", "-mx -t 0 9 0", "-s 2 -ry 70", "-I -t 0 0 7",
                                           "-I -rx 20", "-m own -t 8 8 8", "-m own",       "-t 1 0 0"};
  std::string shared = kGrey, apart = kGrey;
  write("part.rad", part);
  write("below.rad", below);
  for (std::size_t i = 0; i < 2 * places.size(); ++i) {
    const std::string number = std::to_string(i), place = places[i / 2] + (i % 2 == 0 ? "" : " -t 5 0 20");
    write("below" + number + ".rad", below);
    write("part" + number + ".rad", part.substr(0, part.rfind("below")) + "below" + number + ".rad\n");
    shared += "!xform -n c" + number + " " + place + " part.rad\n";
    apart += "!xform -n c" + number + " " + place + " part" + number + ".rad\n";
    // From here on the names of the part mean something else.
    if (i == 6)
      for (std::string* text : {&shared, &apart}) *text += "void plastic grey 0 0 5 .9 .9 .9 0 0\n";
  }
  const SceneDescription kept = load(shared), expanded = load(apart);
  EXPECT_GT(kept.geometry.instances.size(), 12u);
  EXPECT_TRUE(expanded.geometry.instances.empty());
  const auto own = moments_of(kept), wanted = moments_of(expanded);
  ASSERT_EQ(own.size(), wanted.size());
  for (const auto& [key, sums] : wanted) {
    SCOPED_TRACE(testing::Message() << key.first << (key.second ? " shines" : ""));
    ASSERT_TRUE(own.contains(key));
    for (std::size_t i = 0; i < sums.size(); ++i) EXPECT_NEAR(own.at(key)[i], sums[i], 1e-5 * sums[0] * 30) << i;
  }
}

/// Names that a file does not use may change between its copies; those that it uses may not.
TEST_F(RadTest, CopiesAreInstancesWhateverTheNamesAround) {
  write("ball.rad", "grey sphere s 0 0 4 1 0 0 .5\n");
  const auto meshes = [&](const std::string& name) {
    std::string text = kGrey;
    for (int i = 0; i < 6; ++i) {
      const std::string number = std::to_string(i), part = "part" + number + ".rad";
      write(part, "void plastic " + name + " 0 0 5 ." + number + " .2 .2 0 0\n" + name +
                      " polygon p 0 0 9 0 0 0 1 0 0 0 1 0\n!xform -t 0 0 1 ball.rad\n!xform -t 0 0 2 ball.rad\n");
      text += "!xform -t " + number + " 0 0 " + part + "\n";
    }
    return load(text).geometry.meshes.size();
  };
  EXPECT_EQ(meshes("own"), 1u);
  EXPECT_EQ(meshes("grey"), 6u);
}

TEST_F(RadTest, CopiesTakeTheMemoryOfThree) {
  write("ball.rad", "grey sphere s 0 0 4 1 0 0 .5\n");
  const auto stored = [&](const std::string& line) {
    const SceneDescription d = load(kGrey + line);
    std::size_t count = d.geometry.triangles.size();
    for (const auto& mesh : d.geometry.meshes) count += mesh->triangles.size();
    return count;
  };
  const std::size_t one = stored("!xform ball.rad\n");
  EXPECT_EQ(stored("!xform -a 1000 -t 2 0 0 ball.rad\n"), 2 * one);
  EXPECT_EQ(stored("!xform -a 500 -t 2 0 0 -a 2 -mx ball.rad\n"), 3 * one);
}

TEST_F(RadTest, FilesFarAwayKeepTheirDigits) {
  const auto d = load(std::string(kGrey) + "!genbox grey b .1 .1 .1 | xform -t 5e6 3e6 100\n");
  EXPECT_NEAR(area_of(d.geometry), 0.06, 1e-6);
}

TEST_F(RadTest, NoOtherCommandIsRun) {
  for (const char* line :
       {"!rm -rf x", "!gensky 6 21 12", "!genrev m n", "!xform a.rad; rm x", "!xform `rm x`", "!xform $(rm x)",
        "!cat a > b", "!rm x | xform", "!/bin/xform a", "!genbox m n 1 1 1 | rm x"})
    EXPECT_THAT(refusal(std::string(kGrey) + "\n" + line + "\n"),
                testing::AllOf(HasSubstr("a.rad:3"), HasSubstr(line + 1)))
        << line;
}

TEST_F(RadTest, BadInputsAreRefusedWithTheirPlace) {
  write("loop.rad", "!xform loop.rad\n");
  write("two.rad", "!xform three.rad\n");
  write("three.rad", "\n!xform two.rad\n");
  write("args", "-f args\n");
  struct Case {
    const char *text, *message;
  };
  const Case cases[] = {
      {"red polygon p 0 0 9 0 0 0 1 0 0 0 1 0", "a.rad:2: modifier 'red' is not defined"},
      {"void alias a b", "a.rad:2: modifier 'b' is not defined"},
      {"void alias a a", "modifier 'a' is not defined"},
      {"grey polygon p 0 0 8 0 0 0 1 0 0 0 1", "a.rad:2: polygon 'p' has 8 numbers"},
      {"grey polygon p 0 0 9 0 0 0 1 0 0 0 1", "the file ends where a number is expected"},
      {"grey polygon p\n0\n0\n9 0 0 x 1 0 0 0 1 0", "a.rad:5: 'x' is not a number"},
      {"grey polygon p 0 0 9 0 0 1e99 1 0 0 0 1 0", "'1e99' is not a number"},
      {"grey polygon p 0 0 1e30", "is not the count of numbers"},
      {"grey box p 0 0 0", "'box' is not a type of Radiance"},
      {"grey sphere s 0 0 4 0 0 0 0", "has a radius of 0"},
      {"grey cone s 0 0 8 0 0 0 0 0 0 1 1", "has no axis"},
      {"void plastic p 0 0 3 1 1 1", "plastic 'p' has 3 numbers\n  Expected: 5."},
      {"grey instance i 1 a.oct 0 0", "needs a compiled file"},
      {"grey mesh i 1 a.rtm 0 0", "obj2rad"},
      {"!xform loop.rad", "loop.rad:1: 'loop.rad' includes itself"},
      {"!xform two.rad", "three.rad:2: 'two.rad' includes itself"},
      {"!xform a.rad", "a.rad:2: 'a.rad' includes itself"},
      {"!xform none.rad", "none.rad: no such file"},
      {"!xform -t 1 0", "lacks its argument"},
      {"!xform -q 1 loop.rad", "xform has no option -q"},
      {"!xform -s 0 loop.rad", "without size"},
      {"!xform -f args", "too deeply"},
      {"!xform -a 1e12 loop.rad", "'loop.rad' includes itself"},
      {"!genbox grey b 1 1", "genbox lacks arguments"},
      {"!genbox grey b 1 1 1 -b .6", "at most half"},
      {"!genbox '!rm x' b 1 1 1", "is no name"},
      {"void glow g 0 0 4 1 1 1 0 g source s 0 0 4 1 0 0 180", "neither upwards nor downwards"},
      {"grey source s 0 0 4 1 0 0 0", "no direction, or no angle"},
      {"\"open", "a quotation mark is not closed"},
  };
  for (const Case& c : cases) EXPECT_THAT(refusal(std::string(kGrey) + c.text + "\n"), HasSubstr(c.message)) << c.text;
}

TEST_F(RadTest, HugeArraysEndByTheBudget) {
  ImportOptions options;
  options.budget = loading_budget(std::uint64_t{4} << 20);
  const std::string file =
      write("a.rad", std::string(kGrey) + "!genbox grey b 1 1 1 | xform -a 1e9 -t 1 0 0 -a 1e9 -t 0 1 0\n");
  try {
    load_scene(file, options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("memory"));
  }
}

TEST_F(RadTest, UpIsZUnlessTheUserSaysOtherwise) {
  SceneChanges changes;
  const auto lowest = [&] {
    auto d = load(std::string(kGrey) + "!genbox grey b 1 2 3 | xform -t 0 0 5\n");
    change_scene(d, changes, loading_budget());
    return std::pair(d.z_up, d.geometry.bounds().min);
  };
  EXPECT_EQ(lowest(), (std::pair(true, Vec3{0, 5, -2})));
  changes.metres_per_unit = 2;
  EXPECT_EQ(lowest(), (std::pair(true, Vec3{0, 10, -4})));
  changes.z_up = false;
  EXPECT_EQ(lowest(), (std::pair(false, Vec3{0, 0, 10})));
}

TEST_F(RadTest, ViewsBecomeCameras) {
  write("a.vf",
        "# views\nrvu -vtv -vp 1 2 3 -vd 0 1 0 -vu 0 0 1 -vh 60 -vv 40 -vo 0 -va 0 -vs 0 -vl 0\n"
        "rvu -vta -vp 0 0 1 -vd 1 0 0 -vh 180 -vv 180\nview= up -vth -vd 0 0 1 -vu 0 1 0 -vh 180 -vv 180\n"
        "rvu -vtl -vp 0 0 9 -vd 0 0 -1 -vu 0 1 0 -vh 8 -vv 6\n");
  SceneChanges changes;
  changes.view_file = path("a.vf");
  auto d = load(std::string(kGrey) + "!genbox grey b 1 2 3\n");
  change_scene(d, changes, loading_budget());
  ASSERT_EQ(d.cameras.size(), 4u);
  EXPECT_EQ(d.cameras[0].name, "view 1");
  EXPECT_EQ(d.cameras[0].to_world.translation, (Vec3{1, 3, -2}));
  EXPECT_NEAR(d.cameras[0].half_extent, std::tan(20 * M_PI / 180), 1e-6);
  EXPECT_EQ(d.cameras[1].kind, CameraKind::fisheye);
  EXPECT_EQ(d.cameras[2].kind, CameraKind::hemispherical);
  EXPECT_EQ(d.cameras[3].kind, CameraKind::orthographic);
  EXPECT_NEAR(d.cameras[3].half_extent, 3, 1e-6);
  write("a.vf", "rvu -vtv -vd 0 1 0\nrvu -vts -vd 0 1 0\n");
  EXPECT_THROW(change_scene(d, changes, loading_budget()), Error);
  write("a.vf", "rvu -vtv -vd 0 1 0 -vs .5\n");
  EXPECT_THROW(change_scene(d, changes, loading_budget()), Error);
}

/// A room with a lamp, a box and a coat of plastic, written for both.
TEST_F(RadTest, ARoomIsThatOfPbrt) {
  auto rad = load(
      "void plastic wall 0 0 5 .7 .6 .5 0 0\nvoid plastic box 0 0 5 .2 .3 .6 0 0\nvoid light lamp 0 0 3 10 10 10\n"
      "!genbox wall room 4 3 2.5 -i\n!genbox box b 1 1 1 | xform -rz 30 -t 2 1 0\n"
      "lamp polygon l 0 0 12 1.5 1 2.49 1.5 2 2.49 2.5 2 2.49 2.5 1 2.49\n");
  auto pbrt = load_scene(
      write("a.pbrt",
            "WorldBegin\nMaterial \"diffuse\" \"rgb reflectance\" [.7 .6 .5]\n"
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0 4 0 0 4 3 0 0 3 0 0 0 2.5 4 0 2.5 4 3 2.5 0 3 2.5] "
            "\"integer indices\" [0 1 2 0 2 3 4 6 5 4 7 6 0 5 1 0 4 5 1 6 2 1 5 6 2 7 3 2 6 7 3 4 0 3 7 4]\n"
            "AttributeBegin\nMaterial \"diffuse\" \"rgb reflectance\" [.2 .3 .6]\nTranslate 2 1 0\n"
            "Rotate 30 0 0 1\nShape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 "
            "0 1 1] \"integer indices\" [0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 "
            "7]\nAttributeEnd\nAttributeBegin\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n"
            "AreaLightSource \"diffuse\" \"rgb L\" [10 10 10]\nShape \"trianglemesh\" \"point3 P\" [1.5 1 "
            "2.49 1.5 2 2.49 2.5 2 2.49 2.5 1 2.49] \"integer indices\" [0 1 2 0 2 3]\nAttributeEnd\n"));
  SceneChanges changes;
  changes.look_at = parse_look_at("0.3,0.3,1.8,3,2,0.5");
  change_scene(rad, changes, loading_budget());
  changes.z_up = true;
  change_scene(pbrt, changes, loading_budget());
  EXPECT_NEAR(area_of(rad.geometry) / area_of(pbrt.geometry), 1, 1e-5);
  const Mean a = mean(Stage(std::move(rad)).render(by_path(24, 64)));
  const Mean b = mean(Stage(std::move(pbrt)).render(by_path(24, 64)));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a.value[c] / b.value[c], 1, 0.02) << "channel " << c;
}

}  // namespace
}  // namespace glowworm
