
#include "builtin/atrium_parts.h"
#include "builtin/scenes.h"
#include "builtin/sky.h"

namespace glowworm {

namespace {

using namespace atrium;

Materials make_materials(SceneDescription& scene) {
  Materials m;
  m.stone = add_diffuse(scene, "limestone", {0.62f, 0.57f, 0.48f});
  m.plaster = add_diffuse(scene, "plaster", {0.70f, 0.62f, 0.50f});
  m.vault = add_diffuse(scene, "vault", {0.72f, 0.68f, 0.60f});
  m.floor_light = add_diffuse(scene, "pale stone", {0.58f, 0.54f, 0.47f});
  m.floor_dark = add_diffuse(scene, "red stone", {0.36f, 0.24f, 0.19f});
  m.court_light = add_diffuse(scene, "paving", {0.55f, 0.52f, 0.46f});
  m.court_dark = add_diffuse(scene, "dark paving", {0.32f, 0.31f, 0.30f});
  m.roof = add_diffuse(scene, "roof tile", {0.48f, 0.23f, 0.14f});
  m.wood = add_diffuse(scene, "wood", {0.24f, 0.14f, 0.08f});
  m.terracotta = add_diffuse(scene, "terracotta", {0.52f, 0.27f, 0.16f});
  m.leaves = add_diffuse(scene, "leaves", {0.10f, 0.22f, 0.06f});
  m.water = add_diffuse(scene, "pool", {0.08f, 0.16f, 0.18f});
  m.curtain[0] = add_diffuse(scene, "red curtain", {0.55f, 0.05f, 0.05f});
  m.curtain[1] = add_diffuse(scene, "green curtain", {0.07f, 0.38f, 0.12f});
  m.curtain[2] = add_diffuse(scene, "blue curtain", {0.05f, 0.12f, 0.48f});
  m.curtain[3] = add_diffuse(scene, "yellow curtain", {0.65f, 0.45f, 0.06f});
  return m;
}

// Rotates by quarter turns around the y axis, exactly.
Transform quarter_turn(int quarters) {
  switch (quarters & 3) {
    case 0:
      return {};
    case 1:
      return {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}, {0, 0, 0}};
    case 2:
      return {{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 0}};
    default:
      return {{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}, {0, 0, 0}};
  }
}

// Piers at the corners of the court, through both storeys; they hold the ends of the arcades.
void add_corner_piers(MeshBuilder& mesh, const Materials& m) {
  mesh.set_material(m.stone);
  const unsigned sides = MeshBuilder::kAllFaces & ~(MeshBuilder::kMinY | MeshBuilder::kMaxY);
  for (const float sx : {-1.0f, 1.0f})
    for (const float sz : {-1.0f, 1.0f}) {
      const float x = sx * (kColumnLine + kExcess), z = sz * kColumnLine;
      const auto block = [&](float half, float y0, float y1, unsigned faces) {
        mesh.box({x - half, y0, z - half}, {x + half, y1, z + half}, faces);
      };
      block(0.33f, 0, 4.8f, sides);
      block(0.33f, kUpperFloor, kUpperTop, sides);
      for (const float y : {0.0f, kUpperFloor}) block(0.4f, y, y + 0.3f, MeshBuilder::kAllFaces & ~MeshBuilder::kMinY);
      block(0.39f, kLowerSpring - 0.12f, kLowerSpring + 0.01f, MeshBuilder::kAllFaces);
      block(0.39f, kUpperSpring - 0.12f, kUpperSpring + 0.01f, MeshBuilder::kAllFaces);
    }
}

void add_curtains(MeshBuilder& mesh, const Side& side, const Materials& m, const Detail& detail, int first_color) {
  const Transform world = mesh.transform();
  int hung = 0;
  for (int k = 0; k < side.bays; ++k) {
    if (k % 3 == (first_color & 1)) continue;
    const float x0 = side.column_x(k) + 0.27f, x1 = side.column_x(k + 1) - 0.27f;
    // A rod from column to column, lying along x.
    mesh.set_material(m.wood);
    mesh.set_transform(world * Transform{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, {x1, 2.86f, side.line}});
    const MeshBuilder::ProfilePoint rod[] = {{0.025f, 0}, {0.025f, x1 - x0}};
    mesh.lathe(rod, 12);
    mesh.set_material(m.curtain[(first_color + hung) % 4]);
    mesh.set_transform(world * place({0.5f * (x0 + x1), 0.25f, side.line + 0.05f}));
    add_curtain(mesh, x1 - x0 - 0.3f, 2.62f, 9, detail.curtain_cells, 0.7f * static_cast<float>(k));
    ++hung;
  }
  mesh.set_transform(world);
}

// Urns with shrubs along the court and a round basin in its middle.
void add_court(MeshBuilder& mesh, const Materials& m, const Detail& detail) {
  for (int k = 0; k < 8; ++k) {
    const float x = -9.2f + 6.13f * static_cast<float>(k / 2), z = k % 2 == 0 ? -2.3f : 2.3f;
    mesh.set_transform(place({x, kCourtFloor, z}, 0.7f * static_cast<float>(k)));
    mesh.set_material(m.terracotta);
    add_urn(mesh, 1.0f, detail.urn);
    mesh.set_material(m.leaves);
    mesh.sphere({0, 1.12f, 0}, 0.36f, detail.sphere_segments, detail.sphere_segments / 2);
  }
  mesh.set_transform(place({0, kCourtFloor, 0}));
  mesh.set_material(m.stone);
  Outline basin(detail.urn.along);
  basin.start(1.5f, 0).line_to(1.5f, 0.12f).line_to(1.4f, 0.12f).swell_to(1.5f, 0.5f).torus(0.12f);
  basin.line_to(1.34f, 0.62f).line_to(1.3f, 0.45f);
  mesh.lathe(basin.points(), 2 * detail.urn.around);
  Outline jet(detail.urn.along);
  jet.start(0.22f, 0.4f).swell_to(0.12f, 0.95f).torus(0.1f).swell_to(0.6f, 1.25f).line_to(0.62f, 1.31f);
  jet.line_to(0.56f, 1.31f).line_to(0.1f, 1.2f).line_to(0, 1.2f);
  mesh.lathe(jet.points(), detail.urn.around);
  mesh.set_material(m.water);
  const MeshBuilder::ProfilePoint water[] = {{1.32f, 0.5f}, {0, 0.5f}};
  mesh.lathe(water, 2 * detail.urn.around);
  mesh.set_transform({});
}

void add_atrium(Geometry& geometry, const Materials& m, const Detail& detail) {
  MeshBuilder mesh(geometry);
  add_shell(mesh, m);
  const float tile = 0.83f / static_cast<float>(detail.tile_cuts);
  add_floor_ring(mesh, 3.35f, kWallFace, 0, tile, m.floor_light, m.floor_dark);
  add_floor_ring(mesh, 3.53f, kWallFace, kUpperFloor, tile, m.floor_light, m.floor_dark);
  add_floor(mesh, 3.05f + kExcess, 3.05f, kCourtFloor, 0.75f * tile, m.court_light, m.court_dark);
  add_corner_piers(mesh, m);
  const Side sides[2] = {{kColumnLine + kExcess, kColumnLine, 8}, {kColumnLine, kColumnLine + kExcess, 3}};
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Side& side = sides[quarter % 2];
    mesh.set_transform(quarter_turn(quarter));
    add_arcade(mesh, side, m, detail, false);
    add_arcade(mesh, side, m, detail, true);
    add_balustrade(mesh, side, m, detail);
    add_lower_gallery(mesh, side, m, detail);
    add_upper_gallery(mesh, side, m);
    add_roof_tiles(mesh, side, m, detail);
    add_curtains(mesh, side, m, detail, quarter);
  }
  mesh.set_transform({});
  add_court(mesh, m, detail);
}

SceneDescription make_atrium(const char* name, const Detail& detail) {
  SceneDescription scene;
  scene.name = name;
  add_atrium(scene.geometry, make_materials(scene), detail);
  const Vec3 to_sun = normalize(Vec3{-0.40f, 0.85f, -0.36f});
  scene.environment = clear_sky(to_sun, 2, 64);
  scene.lights.push_back(clear_sun(to_sun));
  add_camera(scene, "main", {-10.1f, 1.45f, -0.9f}, {4, 3.1f, 0.5f}, 58);
  add_camera(scene, "gallery", {-13.0f, 1.6f, -6.2f}, {4, 1.9f, -5.4f}, 58);
  add_camera(scene, "overview", {-24, 25, -11}, {-2.5f, 2.0f, -0.5f}, 48);
  set_size(scene, 960, 540);
  return scene;
}

}  // namespace

SceneDescription builtin_atrium() {
  return make_atrium("atrium", {.column = {16, 3},
                                .baluster = {8, 2},
                                .urn = {24, 4},
                                .arch_segments = 16,
                                .vault_cells = 6,
                                .curtain_cells = 6,
                                .tile_segments = 3,
                                .sphere_segments = 24,
                                .tile_cuts = 1,
                                .ornaments = false});
}

SceneDescription builtin_atrium_large() {
  return make_atrium("atrium-large", {.column = {64, 10},
                                      .baluster = {20, 6},
                                      .urn = {96, 16},
                                      .arch_segments = 48,
                                      .vault_cells = 20,
                                      .curtain_cells = 16,
                                      .tile_segments = 8,
                                      .sphere_segments = 96,
                                      .tile_cuts = 3,
                                      .ornaments = true});
}

}  // namespace glowworm
