#include <cmath>

#include "builtin/atrium_parts.h"

namespace glowworm::atrium {

void add_vault(MeshBuilder& mesh, Vec3 center, float half_x, float half_z, float rise, int cells) {
  // Four quarters, each under the barrel whose axis points from the middle to its side.
  for (int quarter = 0; quarter < 4; ++quarter) {
    mesh.patch(
        [=](float s, float t) {
          const float outwards = t >= 1 ? 1 : std::sin(t * kPi / 2);
          const float across = outwards * (s <= 0 ? -1.0f : s >= 1 ? 1.0f : std::sin((s - 0.5f) * kPi));
          const float y = center.y + rise * std::sqrt(std::max(0.0f, 1 - across * across));
          const float sign = quarter < 2 ? 1.0f : -1.0f;
          return quarter % 2 == 0 ? Vec3{center.x + sign * across * half_x, y, center.z + sign * outwards * half_z}
                                  : Vec3{center.x + sign * outwards * half_x, y, center.z - sign * across * half_z};
        },
        2 * cells, cells);
  }
}

namespace {

// An arched rib under the line between two bays, across the gallery.
void add_rib(MeshBuilder& mesh, float x, float z0, float z1, int segments) {
  const float half = 0.15f, depth = 0.1f;
  const float center = 0.5f * (z0 + z1), reach = 0.5f * (z1 - z0);
  const auto point = [=](float u, float inset, float offset) {
    const float angle = kPi * u;
    return Vec3{x + offset, kVaultSpring + (kVaultRise - inset) * std::sin(angle),
                center - (reach - inset) * std::cos(angle)};
  };
  mesh.patch([&](float u, float v) { return point(v, depth, (2 * u - 1) * half); }, 1, segments);
  for (int i = 0; i < segments; ++i) {
    const float u0 = static_cast<float>(i) / static_cast<float>(segments);
    const float u1 = static_cast<float>(i + 1) / static_cast<float>(segments);
    mesh.quad(point(u0, depth, half), point(u0, -0.02f, half), point(u1, -0.02f, half), point(u1, depth, half));
    mesh.quad(point(u0, depth, -half), point(u1, depth, -half), point(u1, -0.02f, -half), point(u0, -0.02f, -half));
  }
}

void add_door(MeshBuilder& mesh, const Materials& materials, float x, float y, float wall) {
  const float half = 0.65f, height = 2.35f;
  const unsigned shown = MeshBuilder::kAllFaces & ~(MeshBuilder::kMinY | MeshBuilder::kMaxZ);
  mesh.set_material(materials.wood);
  mesh.box({x - half, y, wall - 0.05f}, {x + half, y + height, wall}, shown);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 2; ++column) {
      const float px = x - 0.55f + 0.58f * static_cast<float>(column), py = y + 0.15f + 0.73f * static_cast<float>(row);
      mesh.box({px, py, wall - 0.07f}, {px + 0.5f, py + 0.6f, wall - 0.05f},
               MeshBuilder::kAllFaces & ~MeshBuilder::kMaxZ);
    }
  mesh.set_material(materials.stone);
  mesh.box({x - half - 0.16f, y, wall - 0.12f}, {x - half, y + height, wall}, shown);
  mesh.box({x + half, y, wall - 0.12f}, {x + half + 0.16f, y + height, wall}, shown);
  mesh.box({x - half - 0.24f, y + height, wall - 0.16f}, {x + half + 0.24f, y + height + 0.2f, wall},
           MeshBuilder::kAllFaces & ~MeshBuilder::kMaxZ);
}

// A flat pilaster before the outer wall, with base and capital.
void add_pilaster(MeshBuilder& mesh, float x, float y, float height, float wall) {
  const unsigned shown = MeshBuilder::kAllFaces & ~(MeshBuilder::kMinY | MeshBuilder::kMaxZ);
  mesh.box({x - 0.22f, y, wall - 0.12f}, {x + 0.22f, y + height - 0.2f, wall}, shown & ~MeshBuilder::kMaxY);
  mesh.box({x - 0.27f, y, wall - 0.17f}, {x + 0.27f, y + 0.25f, wall}, shown);
  mesh.box({x - 0.27f, y + height - 0.2f, wall - 0.17f}, {x + 0.27f, y + height, wall},
           MeshBuilder::kAllFaces & ~MeshBuilder::kMaxZ);
}

}  // namespace

void add_lower_gallery(MeshBuilder& mesh, const Side& side, const Materials& materials, const Detail& detail) {
  const float z0 = side.z(kGalleryFace), z1 = side.z(kWallFace);
  const float end = side.half_length + (kGalleryFace - kColumnLine);
  const auto border = [&](int k) { return k == 0 ? -end : k == side.bays ? end : side.column_x(k); };
  for (int k = 0; k < side.bays; ++k) {
    const float x0 = border(k), x1 = border(k + 1);
    mesh.set_material(materials.vault);
    add_vault(mesh, {0.5f * (x0 + x1), kVaultSpring, 0.5f * (z0 + z1)}, 0.5f * (x1 - x0), 0.5f * (z1 - z0), kVaultRise,
              detail.vault_cells);
    if (k % 3 == 1) add_door(mesh, materials, 0.5f * (x0 + x1), 0, z1);
  }
  // The corner at this side's right end.
  mesh.set_material(materials.vault);
  const float half = 0.5f * (z1 - z0);
  add_vault(mesh, {end + half, kVaultSpring, 0.5f * (z0 + z1)}, half, half, kVaultRise, detail.vault_cells);
  mesh.set_material(materials.stone);
  for (int k = 0; k <= side.bays; ++k) {
    const float x = border(k);
    add_rib(mesh, x, z0, z1, 2 * detail.arch_segments);
    add_pilaster(mesh, x, 0, kVaultSpring + 0.02f, z1);
    // A corbel over the column takes the rib's other end.
    mesh.box({x - 0.2f, kVaultSpring - 0.3f, z0 - 0.1f}, {x + 0.2f, kVaultSpring + 0.02f, z0 + 0.15f});
  }
}

void add_upper_gallery(MeshBuilder& mesh, const Side& side, const Materials& materials) {
  const float z1 = side.z(kWallFace);
  const float end = side.half_length;
  const int beams = 2 * side.bays;
  for (int k = 0; k <= beams; ++k) {
    const float x = -end + 2 * end * static_cast<float>(k) / static_cast<float>(beams);
    mesh.set_material(materials.wood);
    mesh.box({x - 0.09f, kCeiling - 0.24f, side.line + 0.1f}, {x + 0.09f, kCeiling + 0.02f, z1 + 0.02f});
    mesh.set_material(materials.stone);
    if (k % 2 == 0) add_pilaster(mesh, x, kUpperFloor, kCeiling - 0.23f - kUpperFloor, z1);
    if (k % 4 == 3) add_door(mesh, materials, x, kUpperFloor, z1);
  }
}

void add_roof_tiles(MeshBuilder& mesh, const Side& side, const Materials& materials, const Detail& detail) {
  mesh.set_material(materials.roof);
  const float eave = side.z(kEave), ridge = side.z(kOutside);
  const float slope = (kRidge - kEaveTop) / (ridge - eave);
  const float length_per_z = std::sqrt(1 + slope * slope);
  const Vec3 normal = normalize(Vec3{0, 1, -slope});
  const float spacing = 0.27f, row = 0.6f / length_per_z;
  const int columns = static_cast<int>((side.half_length + (kOutside - kColumnLine)) / spacing);
  const int segments = detail.tile_segments;
  for (int c = -columns; c <= columns; ++c) {
    const float x = spacing * static_cast<float>(c);
    // On the hips a column of tiles begins where its plane of the roof does.
    const float hip = side.line + std::abs(x) - side.half_length + 0.15f;
    for (float z = eave + 0.005f; z < ridge - 0.05f; z += row) {
      if (z < hip) continue;
      const float z_end = std::min(z + row * 1.15f, ridge);
      const Vec3 low{x, kEaveTop + (z - eave) * slope, z}, high{x, kEaveTop + (z_end - eave) * slope, z_end};
      const auto rim = [&](float u, Vec3 center, float radius, float lift) {
        const float angle = kPi * u;
        return center + Vec3{radius * std::cos(angle), 0, 0} + normal * (radius * std::sin(angle) + lift);
      };
      mesh.patch(
          [&](float u, float v) {
            const Vec3 center = low * (1 - v) + high * v;
            return rim(u, center, 0.125f - 0.02f * v, -0.005f - 0.01f * v);
          },
          segments, detail.ornaments ? 4 : 1);
      std::vector<Vec3> cap;
      for (int i = segments; i >= 0; --i)
        cap.push_back(rim(static_cast<float>(i) / static_cast<float>(segments), low, 0.125f, -0.005f));
      mesh.polygon(cap);
    }
  }
}

}  // namespace glowworm::atrium
