#include <cmath>

#include "builtin/atrium_parts.h"

namespace glowworm::atrium {

namespace {

// Even subdivision of [a, b].
std::vector<float> cuts(float a, float b, float size) {
  const int count = std::max(1, static_cast<int>(std::lround((b - a) / size)));
  std::vector<float> out;
  for (int i = 0; i <= count; ++i)
    out.push_back(i == count ? b : a + (b - a) * static_cast<float>(i) / static_cast<float>(count));
  return out;
}

std::vector<float> joined(const std::vector<float>& a, const std::vector<float>& b, const std::vector<float>& c) {
  std::vector<float> out = a;
  out.insert(out.end(), b.begin() + 1, b.end());
  out.insert(out.end(), c.begin() + 1, c.end());
  return out;
}

// Tiles between the lines xs and zs in a checkerboard of two colours, except inside the hole.
void add_tiles(MeshBuilder& mesh, const std::vector<float>& xs, const std::vector<float>& zs, float y, float hole_x,
               float hole_z, std::uint32_t light, std::uint32_t dark) {
  for (std::size_t j = 0; j + 1 < zs.size(); ++j)
    for (std::size_t i = 0; i + 1 < xs.size(); ++i) {
      const float x = 0.5f * (xs[i] + xs[i + 1]), z = 0.5f * (zs[j] + zs[j + 1]);
      if (std::abs(x) < hole_x && std::abs(z) < hole_z) continue;
      mesh.set_material((i + j) % 2 == 0 ? light : dark);
      mesh.quad({xs[i], y, zs[j + 1]}, {xs[i + 1], y, zs[j + 1]}, {xs[i + 1], y, zs[j]}, {xs[i], y, zs[j]});
    }
}

using Profile = std::vector<MeshBuilder::ProfilePoint>;

}  // namespace

void add_floor_ring(MeshBuilder& mesh, float inner, float outer, float y, float size, std::uint32_t light,
                    std::uint32_t dark) {
  const auto lines = [&](float excess) {
    const float a = inner + excess, b = outer + excess;
    return joined(cuts(-b, -a, size), cuts(-a, a, size), cuts(a, b, size));
  };
  add_tiles(mesh, lines(kExcess), lines(0), y, inner + kExcess, inner, light, dark);
}

void add_floor(MeshBuilder& mesh, float half_x, float half_z, float y, float size, std::uint32_t light,
               std::uint32_t dark) {
  add_tiles(mesh, cuts(-half_x, half_x, size), cuts(-half_z, half_z, size), y, 0, 0, light, dark);
}

void add_shell(MeshBuilder& mesh, const Materials& materials) {
  // Outlines that meet a wall end inside it, so that joints are tight and no faces coincide.
  const Profile steps = {{3.35f, 0}, {3.35f, -0.15f}, {3.05f, -0.15f}, {3.05f, kCourtFloor}};
  const Profile course = {{3.53f, kUpperFloor}, {3.53f, 4.97f}, {3.56f, 4.93f}, {3.56f, 4.86f},
                          {3.6f, 4.83f},        {3.6f, 4.74f},  {3.66f, 4.7f}};
  const Profile cornice = {{kEave, kEaveTop}, {kEave, 9.9f},  {3.26f, 9.84f}, {3.26f, 9.78f},
                           {3.42f, 9.66f},    {3.42f, 9.58f}, {3.5f, 9.54f},  {3.56f, 9.46f},
                           {3.56f, 9.38f},    {3.64f, 9.34f}, {3.64f, 9.28f}, {3.75f, 9.24f}};
  mesh.set_material(materials.stone);
  for (const Profile& profile : {steps, course, cornice}) sweep_rectangle(mesh, profile, kExcess);

  const Profile lower_wall = {{kWallFace, 4.9f}, {kWallFace, 0}};
  const Profile upper_wall = {{kWallFace, kCeiling}, {kWallFace, kUpperFloor}};
  const Profile ceiling = {{kColumnLine, kCeiling}, {kWallFace, kCeiling}};
  // Hides the vaults' backs from the floor above and closes the space over them.
  const Profile slab = {{kColumnLine, 4.9f}, {kWallFace, 4.9f}};
  const Profile outside = {{kOutside, -0.6f}, {kOutside, kRidge}};
  mesh.set_material(materials.plaster);
  for (const Profile& profile : {lower_wall, upper_wall, ceiling, slab, outside})
    sweep_rectangle(mesh, profile, kExcess);
  mesh.box({-kOutside - kExcess, -0.6f, -kOutside}, {kOutside + kExcess, 0, kOutside}, MeshBuilder::kMinY);

  const Profile roof = {{kOutside, kRidge}, {kEave, kEaveTop}};
  mesh.set_material(materials.roof);
  sweep_rectangle(mesh, roof, kExcess);
  // Skirting along the walls of both galleries.
  mesh.set_material(materials.stone);
  for (const float y : {0.0f, kUpperFloor}) {
    const Profile skirting = {{kWallFace, y + 0.18f}, {7.46f, y + 0.16f}, {7.46f, y}};
    sweep_rectangle(mesh, skirting, kExcess);
  }
}

}  // namespace glowworm::atrium
