#include "bake/probes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "bake_testing.h"
#include "core/error.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

/// A floor of 4 x 4 m under a sky of radiance 1, with a solid box of 1.4 x 3 x 1.4 m on it.
SceneDescription box_in_the_open() {
  SceneDescription d;
  d.materials.resize(1);
  d.materials[0].reflectance.value = RGB(0.0f);
  MeshBuilder builder(d.geometry);
  builder.box({-2, -0.2f, -2}, {2, -0.1f, 2});
  builder.box({-0.7f, -0.05f, -0.7f}, {0.7f, 3, 0.7f});
  d.environment.emplace();
  d.environment->scale = RGB(1.0f);
  return d;
}

TEST(BakeProbes, FitFunctionsOfDegreeTwoExactly) {
  // E(n) = 2 + n.y + 3 n.x n.z
  const auto function = [](Vec3 n) { return RGB(2 + n.y + 3 * n.x * n.z); };
  ProbeGrid one;
  one.position = {{0, 0, 0}};
  one.is_inside = {0};
  const PointGrid points = probe_points(one);
  std::array<RGB, kProbeDirections> measured;
  for (std::size_t i = 0; i < measured.size(); ++i) measured[i] = function(points.normal[i]);
  const ProbeLight light = fit_probe(measured);
  for (const Vec3 n : {Vec3{0.6f, 0, 0.8f}, Vec3{0, 1, 0}, normalize(Vec3{1, -2, 3})})
    EXPECT_NEAR(evaluate(light, n).g, function(n).g, 1e-4);
}

TEST(BakeProbes, HoldTheIrradianceOfAnOpenPlace) {
  const Stage stage(box_in_the_open());
  const ProbeGrid probes = make_probes(*stage.scene, *stage.tracer, 1);
  RenderSettings settings = by_path(1, 256);
  Job job(stage.scene, stage.tracer, settings, nullptr, 0, std::make_shared<const PointGrid>(probe_points(probes)));
  job.wait();
  const Film film = job.snapshot();
  EXPECT_EQ(probes.counts[0], 4);
  const nlohmann::json file = nlohmann::json::parse(probes_json(probes, pixels(film), "glowworm bake"));
  ASSERT_EQ(file["probes"].size(), probes.position.size());
  std::size_t open = 0;
  for (std::size_t i = 0; i < probes.position.size(); ++i) {
    const Vec3 p = probes.position[i];
    const bool inside = std::abs(p.x) < 0.7f && std::abs(p.z) < 0.7f;
    EXPECT_EQ(file["probes"][i].is_null(), inside);
    if (file["probes"][i].is_null()) continue;
    ProbeLight light;
    for (std::size_t k = 0; k < light.size(); ++k) light[k] = RGB(file["probes"][i][k][1].get<float>());
    // All of the sky lights a place that faces up from beside the box, but for the part behind the box.
    const float up = evaluate(light, {0, 1, 0}).g;
    open += up > 0.7f * kPi && up < 1.1f * kPi;
  }
  EXPECT_GT(open, probes.position.size() / 2);
}

TEST(BakeProbes, LieInTheCoordinatesOfTheFile) {
  SceneDescription d = box_in_the_open();
  const Stage near(d);
  translate(d, kFarAway);
  const Stage far(std::move(d));
  const ProbeGrid here = make_probes(*near.scene, *near.tracer, 1), there = make_probes(*far.scene, *far.tracer, 1);
  expect_near(narrow(there.origin), narrow(here.origin) + kFarAway, 0.1f);
  EXPECT_EQ(there.origin, far.scene->outside(there.position[0]));
  EXPECT_EQ(there.is_inside, here.is_inside);
}

TEST(BakeProbes, AreWrittenWhateverTheNameOfTheirScene) {
  ProbeGrid one;
  one.position = {{0, 0, 0}};
  one.is_inside = {0};
  const std::vector<RGB> dark(kProbeDirections);
  const nlohmann::json file = nlohmann::json::parse(probes_json(one, dark, "glowworm bake b\xfcro.pbrt"));
  EXPECT_EQ(file["command"], "glowworm bake b\xef\xbf\xbdro.pbrt") << "no UTF-8";
}

TEST(BakeProbes, RefuseTooManyProbes) {
  const Stage stage(box_in_the_open());
  EXPECT_THROW(make_probes(*stage.scene, *stage.tracer, 1e-4f), Error);
}

}  // namespace
}  // namespace glowworm
