// Photons of a scene that moves: those of paths that are kept have the bits of paths that are traced.
#include "photon/kept_paths.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "builtin/builtin.h"
#include "core/random.h"
#include "core/warp.h"
#include "media/media_testing.h"
#include "scene/light_rig.h"
#include "scene/scene_parts.h"

namespace glowworm {
namespace {

using ScenePointer = std::shared_ptr<const Scene>;

template <typename Array>
bool have_same_bits(const Array& a, const Array& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0);
}

template <typename Batch>
bool have_same_photons(const Batch& a, const Batch& b) {
  bool same = true;
  Batch::for_arrays([&](const auto& x, const auto& y) { same = same && have_same_bits(x, y); }, a, b);
  return same;
}

PhotonPass shoot_at(const Scene& scene, KeptPaths* kept, std::uint64_t most_bytes = 1u << 30, std::uint32_t seed = 3) {
  const Tracer tracer(scene, TieRule::number);
  PhotonPassSettings settings;
  settings.photons = 60000;
  settings.seed = seed;
  settings.keep_sources = true;
  settings.kept = kept;
  if (kept) kept->begin(tracer, settings, {}, most_bytes);
  Statistics statistics;
  return trace_photons(tracer, settings, statistics);
}

/// Traces the photons of a moment with those kept of others, and anew. Returns the share of photons that were kept.
double expect_bits_of_fresh_photons(const Scene& scene, KeptPaths& kept) {
  const PhotonPass some = shoot_at(scene, &kept), all = shoot_at(scene, nullptr);
  EXPECT_TRUE(have_same_photons(some.global, all.global));
  EXPECT_TRUE(have_same_photons(some.caustic, all.caustic));
  EXPECT_TRUE(have_same_photons(some.in_media, all.in_media));
  EXPECT_TRUE(have_same_photons(some.beams, all.beams));
  EXPECT_EQ(some.stored, all.stored);
  EXPECT_EQ(some.emitted, all.emitted);
  EXPECT_EQ(some.global_source, all.global_source);
  EXPECT_EQ(some.stored_by_light, all.stored_by_light);
  EXPECT_EQ(some.used_by_light, all.used_by_light);
  return static_cast<double>(kept.kept_photons()) / static_cast<double>(some.stored);
}

/// The same for so many moments of a scene: more than the share of photons is kept after the first.
template <typename SceneAt>
void expect_kept_at_moments(std::uint32_t moments, double share, const SceneAt& scene_at) {
  KeptPaths kept;
  EXPECT_EQ(expect_bits_of_fresh_photons(scene_at(0), kept), 0);
  for (std::uint32_t moment = 1; moment < moments; ++moment)
    EXPECT_GT(expect_bits_of_fresh_photons(scene_at(moment), kept), share) << moment;
}

/// A mesh of one triangle with these corners, for instances.
std::shared_ptr<Geometry> triangle_mesh(Vec3 a, Vec3 b, Vec3 c) {
  auto mesh = std::make_shared<Geometry>();
  mesh->positions = {a, b, c};
  mesh->normals.assign(3, {0, 0, 0});
  mesh->uvs.assign(3, {0, 0});
  mesh->triangles = {{0, 1, 2}};
  mesh->material = {0};
  mesh->emission = {kNone};
  return mesh;
}

/// A scene with a board somewhere in its middle that is turned anyhow.
Scene with_board(SceneDescription d, std::uint32_t moment, std::uint32_t material = 0) {
  const Box3 box = d.geometry.bounds();
  Sampler sampler(SamplerKind::independent, 5, 0, moment);
  const Vec2 u = sampler.next2(), size = sampler.next2();
  const Vec3 size_of_all = box.diagonal(), share{0.3f + 0.4f * u.x, 0.3f + 0.4f * u.y, 0.3f + 0.4f * sampler.next1()};
  const Vec3 corner = box.min + Vec3{size_of_all.x * share.x, size_of_all.y * share.y, size_of_all.z * share.z};
  const Vec3 normal = square_to_sphere(sampler.next2());
  const Frame frame = Frame::from_normal(normal);
  const float side = 0.15f * std::min({size_of_all.x, size_of_all.y, size_of_all.z});
  add_quad(d, corner, frame.s * (side * (0.1f + size.x)), frame.t * (side * (0.1f + size.y)), material);
  return Scene(std::move(d));
}

/// The same in a built-in scene.
Scene with_board(const char* name, std::uint32_t moment) { return with_board(builtin_scene(name), moment); }

TEST(KeptPaths, HaveTheBitsOfFreshPathsWhereABoardMoves) {
  for (const char* name : {"cornell", "atrium", "ajar", "glass-sphere", "window-room"}) {
    SCOPED_TRACE(name);
    expect_kept_at_moments(6, 0.05, [&](std::uint32_t moment) { return with_board(name, moment); });
  }
}

/// A room full of a medium. @param across mean number of scatterings on a way through it
SceneDescription room_in_medium(float across, bool grid, RGB emission = {}) {
  SceneDescription d = builtin_scene("cornell");
  const Box3 box = d.geometry.bounds();
  const float sigma_t = across / length(box.diagonal());
  Medium medium;
  medium.sigma_s = RGB(0.8f, 0.7f, 0.6f) * sigma_t;
  medium.sigma_a = RGB(sigma_t) - medium.sigma_s;
  medium.g = 0.4f;
  medium.emission = emission;
  if (grid) {
    MediumGridValues values;
    values.size = {5, 4, 3};
    for (int i = 0; i < 60; ++i) values.density.push_back(static_cast<float>(i % 7) / 3);
    medium.grid = std::make_shared<const MediumGrid>(std::move(values));
    medium.bounds = box;
  }
  d.media.push_back(medium);
  d.ambient_medium = 0;
  return d;
}

TEST(KeptPaths, HaveTheBitsOfFreshPathsInMedia) {
  for (const bool grid : {false, true})
    for (const float across : {0.2f, 4.0f}) {
      SCOPED_TRACE(grid);
      SCOPED_TRACE(across);
      expect_kept_at_moments(5, 0.05, [&](std::uint32_t at) { return with_board(room_in_medium(across, grid), at); });
    }
}

TEST(KeptPaths, AllStayInAMediumWhereNothingMoves) {
  KeptPaths kept;
  expect_bits_of_fresh_photons(with_board(room_in_medium(1, true), 1), kept);
  EXPECT_EQ(expect_bits_of_fresh_photons(with_board(room_in_medium(1, true), 1), kept), 1);
}

TEST(KeptPaths, HaveTheBitsOfFreshPathsWhereMediaShine) {
  for (const bool grid : {false, true})
    expect_kept_at_moments(3, 0.05, [&](std::uint32_t at) { return with_board(room_in_medium(1, grid, RGB(2)), at); });
}

/// A room with a box of smoke that is elsewhere at each moment, and a medium around or vacuum.
/// @param names the walls name the medium around
Scene with_moving_smoke(std::uint32_t moment, bool around, bool names) {
  SceneDescription d = around ? room_in_medium(1, false) : builtin_scene("cornell");
  if (names)
    for (Material& material : d.materials) material.inside = material.outside = 0;
  const Box3 box = d.geometry.bounds();
  Medium smoke;
  smoke.sigma_s = RGB(6 / length(box.diagonal()));
  Sampler sampler(SamplerKind::independent, 8, 0, moment);
  const Vec2 u = sampler.next2();
  const Vec3 shift = (Vec3{u.x, u.y, sampler.next1()} - Vec3{0.5f, 0.5f, 0.5f}) * (0.2f * box.diagonal().x);
  const Vec3 half = box.diagonal() * 0.15f;
  add_medium_box(d, box.center() + shift - half, box.center() + shift + half, smoke);
  if (around) d.materials.back().outside = 0;
  return Scene(std::move(d));
}

TEST(KeptPaths, HaveTheBitsOfFreshPathsWhereSmokeMoves) {
  for (const bool around : {false, true})
    for (const bool names : {false, true})
      if (around || !names)
        expect_kept_at_moments(4, 0.05, [&](std::uint32_t at) { return with_moving_smoke(at, around, names); });
}

/// A foggy room with a board that names the medium around it, in which paths are that would meet it, and those of a
/// lamp that shines at it. It is below the lamp, or not.
Scene with_board_in_smoke(std::uint32_t moment) {
  SceneDescription d = room_in_medium(1, false);
  const Vec3 low = d.geometry.bounds().min, size = d.geometry.bounds().diagonal();
  d.media.push_back(d.media[0]);
  d.media[1].sigma_s = d.media[0].sigma_s * 5.0f;
  const std::uint32_t material = add_material(d, 0.5f);
  d.materials[material].inside = d.materials[material].outside = 1;
  const float x = moment % 2 == 0 ? 0.45f : 0.1f + 0.05f * static_cast<float>(moment);
  add_quad(d, low + Vec3{x * size.x, 0.3f * size.y, 0.45f * size.z}, {0, 0, 0.1f * size.z}, {0.1f * size.x, 0, 0},
           material);
  return Scene(std::move(d));
}

TEST(KeptPaths, HaveTheBitsOfFreshPathsWhereWhatMovesNamesAMedium) {
  KeptPaths kept;
  for (const std::uint32_t moment : {0u, 1u, 3u, 4u, 5u}) {
    const double share = expect_bits_of_fresh_photons(with_board_in_smoke(moment), kept);
    // In 1 and 3, it is not below the lamp.
    EXPECT_TRUE(moment == 3 ? share > 0.3 : share < 0.3) << moment << " keeps " << share;
  }
}

TEST(KeptPaths, NoneStaysInAMediumThatFillsAllSpaceWhereTheSceneBecomesLarger) {
  KeptPaths kept;
  for (const float shift : {0.0f, 0.5f}) {
    SceneDescription d = room_in_medium(1, false);
    const Box3 box = d.geometry.bounds();
    add_quad(d, box.max + Vec3{shift, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0});
    EXPECT_EQ(expect_bits_of_fresh_photons(Scene(std::move(d)), kept), 0);
  }
}

TEST(KeptPaths, AllStayWhereNothingMoves) {
  KeptPaths kept;
  expect_bits_of_fresh_photons(with_board("cornell", 1), kept);
  EXPECT_EQ(expect_bits_of_fresh_photons(with_board("cornell", 1), kept), 1);
}

TEST(KeptPaths, TheGeometryOfTheMomentBeforeCountsAsMemory) {
  const Scene scene = with_board("cornell", 1);
  const std::uint64_t geometry = SceneMoment(scene).bytes();
  EXPECT_GT(geometry, scene.geometry().triangles.size() * (3 + 1 + 1) * 4);
  KeptPaths kept;
  shoot_at(scene, &kept);
  EXPECT_GT(kept.bytes(), geometry);
  const std::uint64_t all = kept.bytes();
  shoot_at(scene, &kept, geometry - 1);
  EXPECT_EQ(kept.bytes(), 0u) << "no room";
  shoot_at(scene, &kept, (geometry + all) / 2);
  EXPECT_GT(kept.bytes(), geometry);
  EXPECT_LE(kept.bytes(), (geometry + all) / 2);
  expect_bits_of_fresh_photons(with_board("cornell", 2), kept);
}

TEST(KeptPaths, NoneStaysWhereABoardChangesItsMaterialOrMore) {
  SceneDescription d = builtin_scene("cornell");
  KeptPaths kept;
  expect_bits_of_fresh_photons(Scene(d), kept);
  d.materials[0].reflectance.value = RGB(0.3f);
  EXPECT_EQ(expect_bits_of_fresh_photons(Scene(d), kept), 0) << "another colour";
  d.geometry.begin_object("another");
  add_quad(d, {}, {0.1f, 0, 0}, {0, 0.1f, 0});
  EXPECT_EQ(expect_bits_of_fresh_photons(Scene(d), kept), 0) << "another object";
  expect_bits_of_fresh_photons(with_board("cornell", 1), kept);
  shoot_at(with_board("cornell", 1), &kept, 1u << 30, 4);
  EXPECT_EQ(kept.kept_photons(), 0u) << "another seed";
}

/// A room where a board of two triangles is elsewhere at each moment. At some, one of them has no area and is left out.
Scene with_thin_board(std::uint32_t moment) {
  SceneDescription d = builtin_scene("cornell");
  const std::size_t own = d.geometry.triangles.size();
  const Vec3 middle = d.geometry.bounds().center(), size = d.geometry.bounds().diagonal();
  d.geometry.begin_object("board");
  add_quad(d, middle + size * (0.03f * static_cast<float>(moment)), {0.1f * size.x, 0, 0}, {0, 0.1f * size.y, 0}, 0);
  if (moment % 2 == 1) {
    d.geometry.triangles.erase(d.geometry.triangles.begin() + static_cast<std::ptrdiff_t>(own));
    d.geometry.material.pop_back();
    d.geometry.emission.pop_back();
  }
  d.geometry.begin_object("far board");
  add_quad(d, middle - size * 0.3f, {0.1f * size.x, 0, 0}, {0, 0.1f * size.y, 0}, 0);
  return Scene(std::move(d));
}

TEST(KeptPaths, StayWhereAnObjectThatMovesHasOtherTriangles) { expect_kept_at_moments(5, 0.5, with_thin_board); }

/// A room with two lamps, as a rig's scene.
ScenePointer room_with_lamps() {
  SceneDescription d = builtin_scene("cornell");
  const Box3 box = d.geometry.bounds();
  Light lamp;
  lamp.name = "bulb";
  lamp.intensity = RGB(0.3f);
  lamp.position = box.center();
  d.lights.push_back(lamp);
  return std::make_shared<const Scene>(std::move(d));
}

TEST(KeptPaths, AMovedLampChangesItsOwnPhotons) {
  const ScenePointer scene = room_with_lamps();
  const LightRig rig(scene);
  std::vector<LightEdit> edits(rig.lights().size());
  for (std::size_t moved = 0; moved < edits.size(); ++moved) {
    SCOPED_TRACE(rig.lights()[moved].name);
    KeptPaths kept;
    for (std::uint32_t moment = 0; moment < 4; ++moment) {
      Sampler sampler(SamplerKind::independent, 6, 0, moment);
      edits.assign(edits.size(), {});
      edits[moved].move = square_to_sphere(sampler.next2()) * 0.05f;
      edits[moved].turn = square_to_sphere(sampler.next2()) * 0.1f;
      const ScenePointer lit = rig.edited(edits);
      SceneEdit edit{lit->emissions(), lit->lights(), lit->environment(), lit->shared_geometry(), {}, ""};
      edit.lit_as = scene->light_powers();
      const Scene now(*lit, std::move(edit));
      const double share = expect_bits_of_fresh_photons(now, kept);
      if (moment > 0) {
        EXPECT_GT(share, 0.02);
        EXPECT_LT(share, 0.98);
      }
    }
  }
}

TEST(KeptPaths, AreTracedAgainWhereThereIsNoRoom) {
  KeptPaths kept;
  const Scene scene = with_board("cornell", 1);
  const PhotonPass first = shoot_at(scene, &kept, 2'000'000), again = shoot_at(scene, &kept, 2'000'000);
  EXPECT_TRUE(have_same_photons(first.global, again.global));
  EXPECT_GT(kept.kept_photons(), 0u);
  EXPECT_LT(kept.kept_photons(), again.global.size());
  EXPECT_LE(kept.bytes(), 2'000'000u);
}

/// Sheets of one plane that overlap, in a room with a board that is elsewhere at each moment.
Scene with_sheets(std::uint32_t moment) {
  SceneDescription d = builtin_scene("cornell");
  const Box3 box = d.geometry.bounds();
  const Vec3 size = box.diagonal();
  d.geometry.meshes.push_back(triangle_mesh({0, 0, 0}, {1, 0, 0}, {0, 0, 1}));
  for (std::uint32_t i = 0; i < 60; ++i) {
    Sampler sampler(SamplerKind::independent, 9, i, 0);
    const Vec2 u = sampler.next2();
    const Vec3 corner{box.min.x + size.x * u.x, box.center().y, box.min.z + size.z * u.y};
    if (i % 2 == 0) {
      add_quad(d, corner, {0.3f * size.x, 0, 0}, {0, 0, 0.3f * size.z}, 0);
    } else {
      Transform place;
      place.translation = corner;
      d.geometry.instances.push_back({place, 0, 0, 0});
    }
  }
  Sampler sampler(SamplerKind::independent, 9, 0, moment);
  const Vec3 corner =
      box.min + Vec3{size.x * 0.5f * sampler.next1(), size.y * sampler.next1(), size.z * sampler.next1()};
  add_quad(d, corner, {0.1f * size.x, 0, 0}, {0, 0.1f * size.y, 0}, 0);
  return Scene(std::move(d));
}

TEST(KeptPaths, HaveTheBitsOfFreshPathsWhereSheetsOfOnePlaneOverlap) { expect_kept_at_moments(6, 0.5, with_sheets); }

/// A room with a spot lamp far away, and a small board that moves a little at each moment.
Scene with_far_lamp(std::uint32_t moment) {
  SceneDescription d = builtin_scene("cornell");
  const Box3 box = d.geometry.bounds();
  Light lamp;
  lamp.kind = LightKind::spot;
  lamp.position = box.center() + Vec3{0, 0, 1000 * length(box.diagonal())};
  lamp.intensity = RGB(1e8f);
  lamp.cos_inner = 1 - 2e-7f;
  lamp.cos_outer = 1 - 4e-7f;
  d.lights.push_back(lamp);
  const float shift = 1e-4f * length(box.diagonal()) * static_cast<float>(moment);
  add_quad(d, box.center() + Vec3{shift, 0, 0}, {0.1f * box.diagonal().x, 0, 0}, {0, 0.1f * box.diagonal().y, 0}, 0);
  return Scene(std::move(d));
}

TEST(KeptPaths, HaveTheBitsOfFreshPathsFromAFarLamp) {
  KeptPaths kept;
  for (std::uint32_t moment = 0; moment < 4; ++moment) expect_bits_of_fresh_photons(with_far_lamp(moment), kept);
}

/// A room where one of many boulders, which are instances of a mesh, is elsewhere at each moment.
Scene with_instances(std::uint32_t moment) {
  SceneDescription d = builtin_scene("cornell");
  const Box3 box = d.geometry.bounds();
  d.geometry.meshes.push_back(triangle_mesh({-0.05f, 0, 0}, {0.05f, 0, 0}, {0, 0.1f, 0}));
  for (std::uint32_t i = 0; i < 20; ++i) {
    Sampler sampler(SamplerKind::independent, 7, i, i == 3 ? moment : 0);
    const Vec2 u = sampler.next2();
    Transform place;
    place.translation =
        box.min + Vec3{box.diagonal().x * u.x, box.diagonal().y * u.y, box.diagonal().z * sampler.next1()};
    d.geometry.instances.push_back({place, 0, 0, 0});
  }
  return Scene(std::move(d));
}

TEST(KeptPaths, HaveTheBitsOfFreshPathsWhereInstancesMove) { expect_kept_at_moments(4, 0.5, with_instances); }

}  // namespace
}  // namespace glowworm
