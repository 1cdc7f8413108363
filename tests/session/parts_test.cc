// The parts of a session separately: cameras, lights, history, filter, pace, false colours and scripts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/frame.h"
#include "core/memory_budget.h"
#include "core/parallel.h"
#include "core/random.h"
#include "scene/light_rig.h"
#include "session/camera_control.h"
#include "session/frame_sums.h"
#include "session/history.h"
#include "session/pace.h"
#include "session/preview_filter.h"
#include "session/session_testing.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

constexpr Vec3 kUp{0, 1, 0};

Camera test_camera() { return look_at({1, 2, 5}, {0, 0.5f, 0}, kUp, 50); }

TEST(CameraControl, OrbitKeepsThePivotInTheMiddle) {
  const Camera camera = test_camera();
  const Vec3 pivot = camera.to_world.translation + forward(camera) * 4;
  for (const Vec2 turn : {Vec2{0.5f, 0}, Vec2{0, 0.3f}, Vec2{-2, -0.4f}, Vec2{0, 10}, Vec2{0, -10}}) {
    const Camera moved = orbit(camera, 4, kUp, turn.x, turn.y);
    EXPECT_NEAR(length(pivot - moved.to_world.translation), 4, 1e-4f);
    EXPECT_NEAR(dot(normalize(pivot - moved.to_world.translation), forward(moved)), 1, 1e-5f);
    EXPECT_GE(moved.to_world.y.y, 0) << "never over the pole";
    EXPECT_NEAR(moved.to_world.determinant(), camera.to_world.determinant(), 1e-4f);
  }
}

TEST(CameraControl, LookStaysInPlace) {
  const Camera camera = test_camera(), moved = look(camera, kUp, 0.4f, 0.2f);
  EXPECT_LT(length(moved.to_world.translation - camera.to_world.translation), 1e-6f);
  EXPECT_GT(forward(moved).y, forward(camera).y);
}

TEST(CameraControl, FlyGoesAlongItsOwnAxes) {
  const Camera camera = test_camera(), moved = fly(camera, {0, 0, 2});
  EXPECT_LT(length(moved.to_world.translation - camera.to_world.translation - forward(camera) * 2), 1e-5f);
}

TEST(CameraControl, PlacedCameraHasEyeAndTarget) {
  Camera mirrored = test_camera();
  mirrored.to_world.x = -mirrored.to_world.x;
  for (const Camera& base : {test_camera(), mirrored}) {
    const Camera camera = placed(base, {3, 1, 0}, {0, 1, 0}, kUp);
    EXPECT_LT(length(forward(camera) - Vec3{-1, 0, 0}), 1e-6f);
    EXPECT_GT(camera.to_world.determinant() * base.to_world.determinant(), 0);
    // Placing a camera where it is changes nothing.
    const Transform& m = base.to_world;
    const Camera same = placed(base, m.translation, m.translation + m.z, m.y);
    EXPECT_LT(length(same.to_world.x - m.x) + length(same.to_world.y - m.y) + length(same.to_world.z - m.z), 1e-5f);
  }
  EXPECT_THROW(placed(test_camera(), {0, 0, 0}, {0, 0, 0}, kUp), Error);
  EXPECT_THROW(placed(test_camera(), {0, 0, 0}, {0, 2, 0}, kUp), Error);
}

TEST(CameraControl, ProjectUndoesUnproject) {
  Camera windowed = test_camera(), flat = test_camera(), scaled_axes = test_camera();
  windowed.window[0] = -0.5f, windowed.window[1] = 1, windowed.window[2] = -0.3f, windowed.window[3] = 0.9f;
  flat.kind = CameraKind::orthographic;
  flat.half_extent = 2;
  scaled_axes.to_world.x *= -2;
  for (const Camera& camera : {test_camera(), windowed, flat, scaled_axes})
    for (const Vec2 film : {Vec2{10, 20}, Vec2{160, 120}, Vec2{300, 3}}) {
      const Vec3 point = unproject(camera, film, 320, 240, 3);
      const Projection p = project(camera, point, 320, 240);
      EXPECT_NEAR(p.film.x, film.x, 2e-3f);
      EXPECT_NEAR(p.film.y, film.y, 2e-3f);
      EXPECT_NEAR(p.depth, 3, 1e-4f);
    }
  EXPECT_LE(project(test_camera(), {2, 4, 10}, 320, 240).depth, 0) << "behind";
}

TEST(CameraControl, NearestUpIsTheUpAxisOfTheFile) {
  EXPECT_EQ(nearest_up(test_camera()), kUp);
  EXPECT_EQ(nearest_up(look_at({0, 5, 1}, {0, 0, 0}, {0, 0, 1}, 40)), (Vec3{0, 0, 1}));
}

TEST(LightRig, ListsAndFindsLights) {
  const LightRig cornell(test_scene("cornell")), atrium(test_scene("atrium"));
  ASSERT_EQ(cornell.lights().size(), 1u);
  EXPECT_EQ(cornell.lights()[0].kind, RigLightKind::area);
  EXPECT_GT(cornell.lights()[0].center.y, 0);
  EXPECT_EQ(atrium.lights()[atrium.find("sun")].kind, RigLightKind::directional);
  EXPECT_EQ(cornell.find("0"), 0u);
  try {
    atrium.find("moon");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("'moon'"), HasSubstr("sun")));
  }
}

TEST(LightRig, SharesGeometryUnlessALightMoves) {
  const auto scene = test_scene("cornell");
  const LightRig rig(scene);
  std::vector<LightEdit> edits(1);
  EXPECT_EQ(rig.edited(edits), scene);
  edits[0].scale = 3;
  const auto brighter = rig.edited(edits);
  EXPECT_EQ(brighter->shared_geometry(), scene->shared_geometry());
  EXPECT_NEAR(brighter->light_power().total() / scene->light_power().total(), 3, 1e-5);
  edits[0].move = {0, -0.1f, 0};
  const auto moved = rig.edited(edits);
  EXPECT_NE(moved->shared_geometry(), scene->shared_geometry());
  EXPECT_EQ(moved->geometry().triangle_count(), scene->geometry().triangle_count());
  edits[0].on = false;
  EXPECT_EQ(rig.edited(edits)->light_power().total(), 0);
}

TEST(LightRig, MovesAllThatVerticesHave) {
  SceneDescription d = builtin_scene("cornell");
  Geometry& g = d.geometry;
  g.second_uvs.assign(g.positions.size(), {0.5f, 0.5f});
  g.colors.assign(g.positions.size(), {RGB(0.5f), 1});
  const LightRig rig(std::make_shared<const Scene>(std::move(d)));
  std::vector<LightEdit> edits(rig.lights().size());
  edits[0].move = {0.1f, 0, 0};
  const std::shared_ptr<const Scene> edited = rig.edited(edits);
  const Geometry& moved = edited->geometry();
  EXPECT_EQ(moved.second_uvs.size(), moved.positions.size());
  ASSERT_EQ(moved.colors.size(), moved.positions.size());
  EXPECT_EQ(moved.colors.back().color, RGB(0.5f));
}

TEST(LightRig, TurnsTheSun) {
  const LightRig rig(test_scene("atrium"));
  const std::size_t sun = rig.find("sun");
  const Vec3 from = rig.lights()[sun].direction, to = sun_direction({1.0f, 0.5f}, kUp);
  std::vector<LightEdit> edits(rig.lights().size());
  edits[sun].turn = rotation_between(from, to);
  const auto scene = rig.edited(edits);
  EXPECT_LT(length(scene->lights()[rig.lights()[sun].index].direction - to), 1e-5f);
  const SunAngles angles = sun_angles(to, kUp);
  EXPECT_NEAR(angles.azimuth, 1, 1e-5f);
  EXPECT_NEAR(angles.elevation, 0.5f, 1e-5f);
}

TEST(LightRig, RotationBetweenOpposites) {
  const Vec3 a = normalize(Vec3{1, 2, -3});
  EXPECT_LT(length(rotate(a, rotation_between(a, -a)) + a), 1e-5f);
  EXPECT_EQ(rotation_between(a, a), (Vec3{0, 0, 0}));
}

TEST(LightEditText, ReadsWhatItWrites) {
  LightEdit edit;
  edit.on = false;
  edit.scale = 0.3f;
  edit.move = {1.5f, -2e-5f, 0};
  edit.turn = {0, 0.1f, 3};
  const auto [name, read] = parse_light_edit(light_edit_text("lamp, left", edit));
  EXPECT_EQ(name, "lamp, left");
  EXPECT_EQ(read, edit);
  for (const char* bad : {"lamp", ",off", "lamp,scale=-1", "lamp,scale=x", "lamp,move=1:2", "lamp,move=1:2:nan", ""})
    EXPECT_THROW(parse_light_edit(bad), Error) << bad;
}

/// A picture of a plain plane that faces the camera.
ViewImage plane_image(const Camera& camera, int width, int height, RGB light) {
  ViewImage image;
  image.camera = camera;
  image.width = width;
  image.height = height;
  const auto pixels = static_cast<std::size_t>(width * height);
  image.light.assign(pixels, light);
  image.albedo.assign(pixels, RGB(0.5f));
  image.normal.assign(pixels, {0, 0, 1});
  image.depth.resize(pixels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const CameraRay ray = generate_ray(camera, {x + 0.5f, y + 0.5f}, width, height, {0.5f, 0.5f});
      image.depth[static_cast<std::size_t>(y * width + x)] = -ray.origin.z / ray.direction.z;
    }
  image.find_positions();
  return image;
}

Camera facing(float x, float z) { return look_at({x, 0, z}, {x, 0, 0}, kUp, 40); }

TEST(History, LeavesNoGhostForLongerThanHalfASecond) {
  for (const double frame_seconds : {1 / 60.0, 1 / 15.0, 0.2}) {
    History history;
    // A second of light, then none.
    for (double t = 0; t < 1; t += frame_seconds) {
      ViewImage bright = plane_image(facing(0, 3), 16, 16, RGB(1.0f));
      history.blend(bright, 1, frame_seconds);
    }
    ViewImage dark;
    for (double t = 0; t < History::kLifetime; t += frame_seconds) {
      dark = plane_image(facing(0, 3), 16, 16, RGB(0.0f));
      history.blend(dark, 1, frame_seconds);
    }
    for (const RGB& light : dark.light) EXPECT_LE(light.r, History::kRest * 1.01);
  }
}

TEST(History, AveragesNoiseWhereTheCameraMoves) {
  History history;
  double alone = 0, mixed = 0;
  for (int frame = 0; frame < 8; ++frame) {
    ViewImage image = plane_image(facing(0.03f * static_cast<float>(frame), 3), 48, 48, RGB());
    for (std::size_t i = 0; i < image.size(); ++i) {
      Sampler sampler(SamplerKind::independent, 7, static_cast<std::uint32_t>(frame), static_cast<std::uint32_t>(i));
      image.light[i] = RGB(2 * sampler.next1());
    }
    const std::vector<RGB> noisy = image.light;
    history.blend(image, 1, 1.0 / 30);
    alone = mixed = 0;
    for (std::size_t i = 0; i < image.size(); ++i) {
      alone += (noisy[i].r - 1) * (noisy[i].r - 1);
      mixed += (image.light[i].r - 1) * (image.light[i].r - 1);
    }
  }
  EXPECT_LT(mixed, 0.3 * alone);
}

TEST(History, RejectsOtherSurfaces) {
  History history;
  ViewImage first = plane_image(facing(0, 3), 16, 16, RGB(1.0f));
  history.blend(first, 1, 0);
  // The same pixels show a surface half a metre nearer; then one that is turned; then nothing at all.
  ViewImage nearer = plane_image(facing(0, 3), 16, 16, RGB(0.0f));
  for (float& depth : nearer.depth) depth -= 0.5f;
  ViewImage turned = plane_image(facing(0, 3), 16, 16, RGB(0.0f));
  for (Vec3& normal : turned.normal) normal = normalize(Vec3{1, 0, 1});
  ViewImage nothing = plane_image(facing(0, 3), 16, 16, RGB(0.0f));
  for (float& depth : nothing.depth) depth = std::numeric_limits<float>::infinity();
  for (ViewImage* image : {&nearer, &turned, &nothing}) {
    image->find_positions();
    History copy = history;
    copy.blend(*image, 1, 1.0 / 30);
    for (const RGB& light : image->light) EXPECT_EQ(light.r, 0);
  }
}

TEST(History, FollowsASurfaceToWhereItIsNow) {
  History history;
  const auto paint = [](ViewImage& image) {
    for (std::size_t i = 0; i < image.size(); ++i) image.light[i] = RGB(image.position[i].x > 0 ? 1.0f : 0.0f);
  };
  ViewImage first = plane_image(facing(0, 3), 64, 64, RGB());
  paint(first);
  history.blend(first, 1000, 0);
  // What is new is grey; what was seen before shows where its edge went.
  ViewImage second = plane_image(facing(0.4f, 2.5f), 64, 64, RGB(0.5f));
  history.blend(second, 1, 1e-6);
  int right = 0, all = 0;
  for (std::size_t i = 0; i < second.size(); ++i) {
    if (std::abs(second.position[i].x) < 0.1f || second.position[i].x > 0.9f) continue;
    ++all;
    right += std::abs(second.light[i].r - (second.position[i].x > 0 ? 1.0f : 0.0f)) < 0.02f;
  }
  EXPECT_GT(all, 2000);
  EXPECT_GT(right, all * 95 / 100);
}

/// Passes of pixels with a light for each part, and noise in what is gathered.
FrameSums sums_of(LightPart part, std::uint32_t passes, MemoryBudget& budget) {
  constexpr int kWidth = 24, kHeight = 16;
  FrameSums sums(budget);
  for (std::uint32_t sample = 0; sample < passes; ++sample) {
    PassResult pass;
    pass.radiance.resize(kWidth * kHeight);
    pass.first_hit.resize(kWidth * kHeight, false);
    for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) {
      pass.radiance.emitted[i] = RGB(8);
      pass.radiance.direct[i] = RGB(1);
      pass.radiance.indirect[i] = RGB(1 + 2 * Sampler(SamplerKind::independent, 3, sample, i).next1());
      pass.radiance.caustic[i] = RGB(4);
      pass.first_hit.albedo[i] = RGB(0.5f);
      pass.first_hit.normal[i] = {0, 0, 2};
      pass.first_hit.depth[i] = 3;
    }
    sums.add(std::move(pass), kWidth, kHeight, part);
  }
  return sums;
}

TEST(FrameSums, ShowTheirPartOfTheLight) {
  MemoryBudget budget(1 << 20);
  const double wanted[] = {15, 1, 2, 4};
  for (int part = 0; part < 4; ++part)
    for (const bool filtered : {false, true}) {
      const FrameSums sums = sums_of(static_cast<LightPart>(part), 16, budget);
      const ViewImage image = sums.image(test_camera(), static_cast<LightPart>(part), 0.5f, filtered);
      double mean = 0;
      for (const RGB& light : image.light) mean += luminance(light) / static_cast<double>(image.size());
      EXPECT_NEAR(mean, 0.5 * wanted[part], 0.02) << part;
      EXPECT_EQ(image.normal[5], (Vec3{0, 0, 1}));
      EXPECT_EQ(image.depth[5], 3);
    }
}

TEST(FrameSums, StayWithinTheirBudget) {
  MemoryBudget budget(1 << 20), small(1000);
  EXPECT_THROW(sums_of(LightPart::all, 1, small), Error);
  FrameSums sums = sums_of(LightPart::all, 1, budget);
  EXPECT_LT(budget.available(), std::uint64_t{1} << 20);
  sums.clear();
  EXPECT_EQ(budget.available(), std::uint64_t{1} << 20);
}

/// A person who moves the view does not wait for the filter.
TEST(FrameSums, FilterStopsWhenInterrupted) {
  MemoryBudget budget(1 << 20);
  const FrameSums sums = sums_of(LightPart::all, 2, budget);
  Interrupt interrupt;
  const CancellationScope scope(interrupt);
  EXPECT_NO_THROW(sums.image(test_camera(), LightPart::all, 1, true));
  interrupt.request();
  EXPECT_THROW(sums.image(test_camera(), LightPart::all, 1, true), Cancelled);
}

TEST(PreviewFilter, SmoothsNoiseAndKeepsEdges) {
  ViewImage image = plane_image(facing(0, 3), 48, 48, RGB());
  for (std::size_t i = 0; i < image.size(); ++i) {
    const bool left = image.position[i].x < 0;
    image.albedo[i] = left ? RGB(0.8f) : RGB(0.2f);
    Sampler sampler(SamplerKind::independent, 3, 0, static_cast<std::uint32_t>(i));
    image.light[i] = image.albedo[i] * (0.7f + 0.6f * sampler.next1());
  }
  ViewImage filtered = image;
  filter_preview(filtered);
  double before = 0, after = 0;
  for (std::size_t i = 0; i < image.size(); ++i) {
    const double wanted = image.albedo[i].r;
    before += std::pow((image.light[i].r - wanted) / wanted, 2);
    after += std::pow((filtered.light[i].r - wanted) / wanted, 2);
  }
  EXPECT_LT(after, 0.1 * before);
}

TEST(Pace, PlansFramesThatFit) {
  Pace pace;
  FrameWork work;
  work.pixels = 100'000;
  work.camera_seconds = 0.02;
  work.gather_rays = 1'000'000;
  work.gather_seconds = 0.2;
  work.photons = 100'000;
  work.photon_seconds = 0.1;
  for (int i = 0; i < 20; ++i) pace.learn(work);
  const auto seconds = [&](const FrameEffort& e, std::uint64_t pixels, bool photons) {
    const double count = static_cast<double>(pixels) * e.scale * e.scale;
    return count * (2e-7 + 2e-7 * e.gather) + (photons ? static_cast<double>(e.photons) * 1e-6 : 0.0);
  };
  for (const std::uint64_t pixels : {10'000u, 65'536u, 262'144u})
    for (const std::uint32_t gather : {0u, 1u, 16u, 100u})
      for (const bool photons : {false, true}) {
        const FrameEffort effort = pace.plan(pixels, gather, 500'000, photons, 1.0 / 15);
        EXPECT_LE(seconds(effort, pixels, photons), 1.0 / 15) << pixels << " " << gather << " " << photons;
        EXPECT_LE(effort.gather, gather);
        EXPECT_LE(effort.scale, 1);
      }
  // Nothing is given up without need.
  const FrameEffort easy = pace.plan(10'000, 4, 500'000, false, 1);
  EXPECT_EQ(easy.scale, 1);
  EXPECT_EQ(easy.gather, 4u);
  EXPECT_EQ(easy.photons, 500'000u);
}

}  // namespace
}  // namespace glowworm
