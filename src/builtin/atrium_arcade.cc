#include <cmath>

#include "builtin/atrium_parts.h"

namespace glowworm::atrium {

namespace {

// The wall reaches this far into the abaci, metres, so that no faces coincide and no light leaks through the joint.
constexpr float kSunk = 0.02f;

// The wall of one bay above and beside a half-round arch.
struct Bay {
  float x0, x1;       // from column to column
  float radius;       // of the arch
  float spring, top;  // heights
  float front, back;  // z of the wall's faces; the front faces -z
  Vec2 arch(float u, float r) const {
    const float angle = kPi * u;
    const float center = 0.5f * (x0 + x1);
    if (u <= 0) return {center - r, spring};
    if (u >= 1) return {center + r, spring};
    return {center - r * std::cos(angle), spring + r * std::sin(angle)};
  }
};

void add_strip(MeshBuilder& mesh, const Bay& bay, Vec2 left, Vec2 right) {
  mesh.quad({left.x, left.y, bay.front}, {left.x, bay.top, bay.front}, {right.x, bay.top, bay.front},
            {right.x, right.y, bay.front});
  mesh.quad({left.x, left.y, bay.back}, {right.x, right.y, bay.back}, {right.x, bay.top, bay.back},
            {left.x, bay.top, bay.back});
}

void add_bay_wall(MeshBuilder& mesh, const Bay& bay, int segments) {
  const Vec2 left = bay.arch(0, bay.radius), right = bay.arch(1, bay.radius);
  const float foot = bay.spring - kSunk;
  add_strip(mesh, bay, {bay.x0, foot}, {left.x, foot});
  add_strip(mesh, bay, {right.x, foot}, {bay.x1, foot});
  for (int i = 0; i < segments; ++i) {
    const float step = 1.0f / static_cast<float>(segments);
    add_strip(mesh, bay, bay.arch(static_cast<float>(i) * step, bay.radius),
              bay.arch(i + 1 == segments ? 1 : static_cast<float>(i + 1) * step, bay.radius));
  }
  mesh.patch(
      [&](float u, float v) {
        const Vec2 p = bay.arch(u, bay.radius);
        return Vec3{p.x, p.y, bay.front * (1 - v) + bay.back * v};
      },
      segments, 1);
  // The short upright pieces below the springing.
  mesh.quad({left.x, foot, bay.front}, {left.x, left.y, bay.front}, {left.x, left.y, bay.back},
            {left.x, foot, bay.back});
  mesh.quad({right.x, foot, bay.back}, {right.x, right.y, bay.back}, {right.x, right.y, bay.front},
            {right.x, foot, bay.front});
}

// A raised band around the arch on the front of the wall.
void add_archivolt(MeshBuilder& mesh, const Bay& bay, int segments) {
  const float width = 0.16f, depth = 0.05f, z = bay.front - depth;
  const float outer = bay.radius + width;
  for (int i = 0; i < segments; ++i) {
    const float u0 = static_cast<float>(i) / static_cast<float>(segments);
    const float u1 = static_cast<float>(i + 1) / static_cast<float>(segments);
    const Vec2 a = bay.arch(u0, bay.radius), b = bay.arch(u0, outer), c = bay.arch(u1, outer),
               d = bay.arch(u1, bay.radius);
    mesh.quad({a.x, a.y, z}, {b.x, b.y, z}, {c.x, c.y, z}, {d.x, d.y, z});
  }
  const auto rim = [&](float u, float v, float radius) {
    const Vec2 p = bay.arch(u, radius);
    return Vec3{p.x, p.y, bay.front * (1 - v) + z * v};
  };
  mesh.patch([&](float u, float v) { return rim(u, v, outer); }, segments, 1);
  mesh.patch([&](float u, float v) { return rim(u, 1 - v, bay.radius); }, segments, 1);
  // The ends that stand on the abaci.
  for (const float u : {0.0f, 1.0f}) {
    const float x0 = std::min(bay.arch(u, bay.radius).x, bay.arch(u, outer).x);
    mesh.quad({x0, bay.spring, z}, {x0 + width, bay.spring, z}, {x0 + width, bay.spring, bay.front},
              {x0, bay.spring, bay.front});
  }
}

// Half-sunk beads along the archivolt.
void add_beads(MeshBuilder& mesh, const Bay& bay) {
  Geometry bead;
  MeshBuilder(bead).sphere({0, 0, 0}, 0.028f, 12, 8);
  const Transform side = mesh.transform();
  const int count = 40;
  for (int i = 0; i < count; ++i) {
    const Vec2 p = bay.arch((static_cast<float>(i) + 0.5f) / count, bay.radius + 0.08f);
    mesh.set_transform(side * place({p.x, p.y, bay.front - 0.055f}));
    mesh.instance(bead);
  }
  mesh.set_transform(side);
}

void add_columns(MeshBuilder& mesh, const Side& side, const Detail& detail, bool upper) {
  Geometry column;
  MeshBuilder part(column);
  if (upper)
    add_column(part, kUpperSpring - kUpperFloor - kPedestal, 0.2f, detail.column);
  else
    add_column(part, kLowerSpring, 0.27f, detail.column);
  const Transform world = mesh.transform();
  for (int k = 1; k < side.bays; ++k) {
    mesh.set_transform(world * place({side.column_x(k), upper ? kUpperFloor + kPedestal : 0, side.line}));
    mesh.instance(column);
  }
  mesh.set_transform(world);
}

}  // namespace

void add_arcade(MeshBuilder& mesh, const Side& side, const Materials& materials, const Detail& detail, bool upper) {
  mesh.set_material(materials.stone);
  add_columns(mesh, side, detail, upper);
  for (int k = 0; k < side.bays; ++k) {
    const float x0 = side.column_x(k), x1 = side.column_x(k + 1);
    const Bay bay{x0,
                  x1,
                  0.5f * (x1 - x0) - (upper ? 0.24f : 0.32f),
                  upper ? kUpperSpring : kLowerSpring,
                  upper ? kUpperTop : kLowerTop,
                  side.z(kCourtFace) + (upper ? 0.06f : 0),
                  side.z(kGalleryFace) - (upper ? 0.06f : 0)};
    mesh.set_material(materials.plaster);
    add_bay_wall(mesh, bay, detail.arch_segments);
    mesh.set_material(materials.stone);
    add_archivolt(mesh, bay, detail.arch_segments);
    if (detail.ornaments) add_beads(mesh, bay);
  }
}

void add_balustrade(MeshBuilder& mesh, const Side& side, const Materials& materials, const Detail& detail) {
  mesh.set_material(materials.stone);
  const float y = kUpperFloor, half = 0.3f, z = side.line;
  for (int k = 1; k < side.bays; ++k) {
    const float x = side.column_x(k);
    const unsigned sides = MeshBuilder::kAllFaces & ~MeshBuilder::kMinY;
    mesh.box({x - half, y, z - half}, {x + half, y + kPedestal, z + half}, sides);
    mesh.box({x - half - 0.03f, y + kPedestal - 0.14f, z - half - 0.03f},
             {x + half + 0.03f, y + kPedestal - 0.04f, z + half + 0.03f});
  }
  Geometry baluster;
  MeshBuilder part(baluster);
  add_baluster(part, 0.68f, detail.baluster);
  const Transform world = mesh.transform();
  for (int k = 0; k < side.bays; ++k) {
    // The rails end inside the pedestals and the corner piers.
    const float x0 = side.column_x(k) + half - 0.01f, x1 = side.column_x(k + 1) - half + 0.01f;
    mesh.box({x0, y, z - 0.1f}, {x1, y + 0.1f, z + 0.1f}, MeshBuilder::kMaxY | MeshBuilder::kMinZ | MeshBuilder::kMaxZ);
    mesh.box({x0, y + 0.76f, z - 0.12f}, {x1, y + 0.88f, z + 0.12f},
             MeshBuilder::kMinY | MeshBuilder::kMaxY | MeshBuilder::kMinZ | MeshBuilder::kMaxZ);
    const int count = 8;
    for (int i = 0; i < count; ++i) {
      const float t = (static_cast<float>(i) + 0.5f) / count;
      mesh.set_transform(world * place({x0 + (x1 - x0) * t, y + 0.09f, z}));
      mesh.instance(baluster);
    }
    mesh.set_transform(world);
  }
}

}  // namespace glowworm::atrium
