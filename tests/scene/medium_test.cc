#include "scene/medium.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/random.h"
#include "scene/scene_hash.h"
#include "scene/surface.h"
#include "scene_parts.h"

namespace glowworm {
namespace {

float random(std::uint32_t& state) { return to_unit_float(state = hash32(state + 1)); }
Vec3 random_point(std::uint32_t& state) {
  const float x = random(state), y = random(state), z = random(state);
  return {x, y, z};
}

/// A medium with a grid of random values in a turned and scaled box.
Medium grid_medium(std::array<int, 3> size, bool colored) {
  MediumGridValues values;
  values.size = size;
  std::uint32_t state = 7;
  for (std::size_t i = 0; i < values.cell_count(); ++i) {
    const float x = random(state);
    values.density.push_back(x < 0.5f ? 0 : x);
    if (!colored) continue;
    values.sigma_a.emplace_back(random(state), x, 0.5f);
    values.sigma_s.emplace_back(x, 0.25f, x * x);
    values.emission.emplace_back(x);
  }
  Medium medium;
  medium.sigma_a = {0.5f, 1, 2};
  medium.sigma_s = {3, 2, 1};
  medium.emission = RGB(2.0f);
  medium.to_medium = inverse(Transform{{0, 2, 0}, {-1.5f, 0, 0.2f}, {0, 0, 3}, {1, 2, 3}});
  medium.bounds = Box3{{-1, 0, 0.5f}, {1, 2, 1.5f}};
  medium.grid = std::make_shared<const MediumGrid>(std::move(values));
  return medium;
}

TEST(Medium, GridsInterpolateBetweenTheCentresOfCells) {
  MediumGridValues values;
  values.size = {2, 1, 1};
  values.density = {1, 3};
  Medium medium;
  medium.sigma_s = RGB(2.0f);
  medium.bounds = Box3{{0, 0, 0}, {4, 1, 1}};
  medium.grid = std::make_shared<const MediumGrid>(values);
  const auto density = [&](float x) { return medium_point(medium, {x, 0.5f, 0.5f}).sigma_s.r / 2; };
  EXPECT_FLOAT_EQ(density(1), 1);
  EXPECT_FLOAT_EQ(density(2), 2);
  EXPECT_FLOAT_EQ(density(3), 3);
  EXPECT_FLOAT_EQ(density(0.5f), 0.75f);  // a quarter of a cell from the border: three quarters of it
  EXPECT_FLOAT_EQ(density(4.1f), 0);
}

/// Pieces follow one another without a gap, cover the part within the bounds, and no point has more than its majorant.
TEST(Medium, MajorantsBoundEveryPointOfARay) {
  for (const auto& size : {std::array<int, 3>{16, 9, 5}, std::array<int, 3>{1, 1, 1}, std::array<int, 3>{130, 3, 70}})
    for (const bool colored : {false, true}) {
      const Medium medium = grid_medium(size, colored);
      std::uint32_t state = 1;
      for (int ray = 0; ray < 300; ++ray) {
        const Vec3 origin = random_point(state) * 12 - Vec3{4, 4, 4};
        Vec3 direction = normalize(random_point(state) - Vec3{0.5f, 0.5f, 0.5f});
        if (ray % 3 == 0) direction = {0, ray % 2 ? 1.0f : -1.0f, 0};
        const MediumSpan span = span_in(medium, origin, direction, 0, 100);
        float at = span.first;
        for_majorants(medium, origin, direction, 0, 100, [&](float first, float last, float majorant) {
          EXPECT_EQ(first, at);
          EXPECT_LT(first, last);
          at = last;
          for (int i = 0; i < 8; ++i) {
            const MediumPoint p = medium_point(
                medium, origin + direction * (first + (last - first) * (static_cast<float>(i) + 0.5f) / 8));
            EXPECT_LE(max_component(p.sigma_a + p.sigma_s), majorant * 1.00001f);
          }
          return true;
        });
        if (!span.empty()) {
          EXPECT_NEAR(at, span.last, 1e-3f * (1 + span.last));
        }
        EXPECT_LE(at, std::max(span.first, span.last));
      }
    }
}

TEST(Medium, TheWalkEndsWhereTheVisitorDoes) {
  const Medium medium = grid_medium({64, 64, 64}, false);
  int visits = 0;
  for_majorants(medium, {1, 2, 5}, {0, 1, 0}, 0, 100, [&](float, float, float) { return ++visits < 3; });
  EXPECT_EQ(visits, 3);
}

TEST(Medium, FarScenesMoveTheirMedia) {
  SceneDescription d = floor_description();
  d.media.push_back(grid_medium({4, 4, 4}, true));
  const Vec3 there = inverse(d.media[0].to_medium).point({0.1f, 1.2f, 1});
  const Scene near(d);
  translate(d, kFarAway);
  d.media[0].to_medium = d.media[0].to_medium * Transform{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, -kFarAway};
  const Scene far(d);
  const MediumPoint a = medium_point(near.media()[0], there),
                    b = medium_point(far.media()[0], far.inside(there + kFarAway));
  EXPECT_GT(a.sigma_s.r, 0);
  EXPECT_NEAR(a.sigma_s.r, b.sigma_s.r, 0.05f);
}

TEST(Medium, InterfacesLetAllLightPass) {
  SceneDescription d = floor_description();
  d.materials[0].kind = MaterialKind::interface;
  const Scene scene(d);
  EXPECT_TRUE(scene.is_pane(0));
  for (const Vec3 w : {Vec3{0, 0, 1}, Vec3{0.6f, 0, -0.8f}, normalize(Vec3{1, 0, 1e-4f})}) {
    EXPECT_EQ(straight_transmittance(scene, 0, {0.2f, 0.2f}, w), RGB(1.0f));
    SurfacePoint point = surface_point(scene, 0, {0.2f, 0.2f});
    const BsdfSample sample = glowworm::sample(resolve_bsdf(scene, point), point.frame.to_local(w), 0.9999f,
                                               {0.5f, 0.5f}, kAllLobes, Transport::radiance);
    EXPECT_TRUE(sample.is_null);
    EXPECT_EQ(sample.weight, RGB(1.0f));
  }
}

TEST(Medium, TheHashOfASceneCoversItsMedia) {
  SceneDescription d = floor_description();
  const auto hash = [](const SceneDescription& description) {
    const Scene scene(description);
    return hash_scene(scene, scene.cameras()[0]).materials;
  };
  std::vector<std::uint64_t> hashes{hash(d)};
  d.media.push_back(grid_medium({2, 2, 2}, false));
  hashes.push_back(hash(d));
  d.ambient_medium = 0;
  hashes.push_back(hash(d));
  d.materials[0].inside = 0;
  hashes.push_back(hash(d));
  d.media[0].g = 0.5f;
  hashes.push_back(hash(d));
  d.media[0].grid = grid_medium({2, 2, 2}, true).grid;
  hashes.push_back(hash(d));
  std::sort(hashes.begin(), hashes.end());
  EXPECT_EQ(std::unique(hashes.begin(), hashes.end()), hashes.end());
}

/// What is wrong with a scene that has the medium; empty if nothing is.
std::string mistake(const std::function<void(SceneDescription&)>& change) {
  SceneDescription d = floor_description();
  d.media.emplace_back();
  d.media[0].name = "fog";
  d.media[0].sigma_s = d.media[0].sigma_a = RGB(1.0f);
  change(d);
  try {
    const Scene scene(d);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(Medium, BadNumbersAreErrorsThatNameTheMedium) {
  const auto of = [](const std::function<void(Medium&)>& change) {
    return mistake([&](SceneDescription& d) { change(d.media[0]); });
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = HUGE_VALF;
  EXPECT_EQ(of([](Medium&) {}), "");
  EXPECT_EQ(of([](Medium& m) { m.sigma_a = m.sigma_s = RGB(0.0f); }), "");
  const std::function<void(Medium&)> mistakes[] = {
      [](Medium& m) { m.sigma_a.g = -1; },
      [](Medium& m) { m.sigma_s.b = kNan; },
      [](Medium& m) { m.sigma_s.r = kInfinity; },
      [](Medium& m) {
        m.sigma_s = RGB(1e9f);
        m.sigma_a = RGB(0.0f);
      },
      [](Medium& m) { m.g = 1; },
      [](Medium& m) { m.g = -1; },
      [](Medium& m) { m.g = kNan; },
      [](Medium& m) { m.emission.r = -1; },
      [](Medium& m) { m.emission.r = kInfinity; },
      [](Medium& m) {
        m.to_medium.x = {0, 0, 0};
      },
      [](Medium& m) {
        m.bounds = Box3{{0, 0, 0}, {1, 0, 1}};
      },
      [](Medium& m) { m.bounds = Box3(); },
      [](Medium& m) {
        m.grid = grid_medium({1, 1, 1}, false).grid;
      },
  };
  for (std::size_t i = 0; i < std::size(mistakes); ++i)
    EXPECT_THAT(of(mistakes[i]), testing::HasSubstr("medium \"fog\"")) << i;
  // Strong absorption ends paths, however much the medium scatters.
  EXPECT_EQ(of([](Medium& m) { m.sigma_s = m.sigma_a = RGB(1e9f); }), "");
}

TEST(Medium, IndicesOutOfRangeAreErrors) {
  EXPECT_THAT(mistake([](SceneDescription& d) { d.ambient_medium = 1; }), testing::HasSubstr("medium 1 of 1"));
  EXPECT_THAT(mistake([](SceneDescription& d) { d.materials[0].inside = 5; }), testing::HasSubstr("medium 5 of 1"));
  EXPECT_EQ(mistake([](SceneDescription& d) { d.materials[0].outside = kNone; }), "");
}

TEST(Medium, GridsOfWrongLengthOrWithBadValuesAreErrors) {
  const auto error_of = [](MediumGridValues values) -> std::string {
    try {
      const MediumGrid grid(std::move(values));
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  MediumGridValues values;
  values.size = {2, 2, 1};
  values.density = {1, 2, 3};
  EXPECT_THAT(error_of(values), testing::HasSubstr("4 cells has 3 values of density"));
  values.density = {1, 2, -3, 4};
  EXPECT_THAT(error_of(values), testing::HasSubstr("value 3 of a grid's density is -3"));
  values.density = {1, 2, 3, 4};
  EXPECT_EQ(error_of(values), "");
  values.sigma_a = {RGB(1.0f)};
  EXPECT_THAT(error_of(values), testing::HasSubstr("1 values of sigma_a"));
  values.size = {0, 2, 1};
  EXPECT_THAT(error_of(values), testing::HasSubstr("0 x 2 x 1 cells"));
}

}  // namespace
}  // namespace glowworm
