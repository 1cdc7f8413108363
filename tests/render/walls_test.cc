// Two rooms with a wall of one sheet between them: no light of one is in the other.
#include <gtest/gtest.h>

#include "render/render_testing.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

/// A box of 6 x 2.5 x 4 metres, halved at x = 0, with a lamp where x < 0. Floor and ceiling are of one piece.
SceneDescription two_rooms(bool flipped) {
  SceneDescription d;
  d.name = "rooms";
  d.materials.emplace_back();
  d.materials[0].reflectance.value = RGB(0.7f);
  add_quad(d, {-3, 0, -2}, {0, 0, 4}, {6, 0, 0});
  add_quad(d, {-3, 2.5f, -2}, {6, 0, 0}, {0, 0, 4});
  add_quad(d, {-3, 0, -2}, {0, 2.5f, 0}, {0, 0, 4});
  add_quad(d, {3, 0, -2}, {0, 0, 4}, {0, 2.5f, 0});
  add_quad(d, {-3, 0, -2}, {6, 0, 0}, {0, 2.5f, 0});
  add_quad(d, {-3, 0, 2}, {0, 2.5f, 0}, {6, 0, 0});
  // A wall of either winding.
  if (flipped)
    add_quad(d, {0, 0, -2}, {0, 0, 4}, {0, 2.5f, 0});
  else
    add_quad(d, {0, 0, -2}, {0, 2.5f, 0}, {0, 0, 4});
  add_quad(d, {-1.8f, 2.49f, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}, 0, add_emission(d, RGB(20.0f)));
  return d;
}

Camera in_dark_room() { return look_at({2.8f, 1.2f, 1.8f}, {0, 0.8f, -0.5f}, {0, 1, 0}, 75); }

class WallOf : public testing::TestWithParam<std::string> {};

TEST_P(WallOf, KeepsTheNextRoomDark) {
  for (const bool flipped : {false, true}) {
    SceneDescription d = two_rooms(flipped);
    // A mirror that makes a caustic on the floor at the wall.
    Material mirror;
    mirror.kind = MaterialKind::conductor;
    mirror.use_reflectance = true;
    mirror.reflectance.value = RGB(0.9f);
    d.materials.push_back(mirror);
    add_quad(d, {-2.5f, 0.5f, -1}, {0, 1.5f, 0}, {0, 0, 2}, 1);
    d.cameras.push_back(in_dark_room());
    const Stage stage(std::move(d));
    for (const Integrator integrator : {Integrator::gather, Integrator::photons}) {
      RenderSettings s = by_photons(12, 2, 8, 10'000, GetParam().c_str());
      s.integrator = integrator;
      EXPECT_EQ(mean(stage.render(s)).luminance(), 0) << flipped;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, WallOf, testing::Values("blocked", "forward", "reverse", "knn"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace glowworm
