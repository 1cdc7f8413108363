#include "builtin/ajar_parts.h"

#include <algorithm>
#include <cmath>

#include "builtin/ornaments.h"
#include "core/random.h"

namespace glowworm::ajar {

namespace {

constexpr unsigned kStanding = MeshBuilder::kAllFaces & ~MeshBuilder::kMinY;

// Adds a shape at another place of the current transform.
template <class Add>
void at(MeshBuilder& mesh, Vec3 offset, float angle, const Add& add) {
  const Transform world = mesh.transform();
  mesh.set_transform(world * place(offset, angle));
  add();
  mesh.set_transform(world);
}

}  // namespace

void add_table(MeshBuilder& mesh, std::uint32_t wood) {
  mesh.set_material(wood);
  mesh.box({-0.75f, 0.72f, -0.45f}, {0.75f, 0.76f, 0.45f});
  mesh.box({-0.66f, 0.63f, -0.38f}, {0.66f, 0.725f, -0.36f});
  mesh.box({-0.66f, 0.63f, 0.36f}, {0.66f, 0.725f, 0.38f});
  mesh.box({-0.69f, 0.63f, -0.35f}, {-0.67f, 0.725f, 0.35f});
  mesh.box({0.67f, 0.63f, -0.35f}, {0.69f, 0.725f, 0.35f});
  Outline leg(6);
  leg.start(0.022f, 0).swell_to(0.034f, 0.06f).swell_to(0.018f, 0.14f).line_to(0.018f, 0.15f).torus(0.02f);
  leg.swell_to(0.036f, 0.42f).swell_to(0.02f, 0.52f).line_to(0.02f, 0.53f).torus(0.025f).line_to(0.034f, 0.56f);
  leg.line_to(0.034f, 0.725f);
  for (const float x : {-0.67f, 0.67f})
    for (const float z : {-0.37f, 0.37f}) at(mesh, {x, 0, z}, 0, [&] { mesh.lathe(leg.points(), 24); });
}

void add_chair(MeshBuilder& mesh, std::uint32_t wood, std::uint32_t seat) {
  mesh.set_material(wood);
  for (const float x : {-0.19f, 0.19f}) {
    mesh.box({x - 0.02f, 0, -0.21f}, {x + 0.02f, 0.44f, -0.17f}, kStanding);
    mesh.box({x - 0.02f, 0, 0.17f}, {x + 0.02f, 0.98f, 0.21f}, kStanding);
    mesh.box({x - 0.012f, 0.2f, -0.175f}, {x + 0.012f, 0.225f, 0.175f});
  }
  mesh.box({-0.215f, 0.43f, -0.225f}, {0.215f, 0.455f, 0.165f});
  for (const float y : {0.62f, 0.76f, 0.9f}) {
    // Slats that bend backwards.
    const auto slat = [=](float u, float v, float z) {
      const float x = (u - 0.5f) * 0.35f;
      return Vec3{x, y - 0.03f + 0.06f * v, z + 0.02f - 0.4f * (0.031f - x * x)};
    };
    mesh.patch([&](float u, float v) { return slat(u, v, 0.198f); }, 8, 1);
    mesh.patch([&](float u, float v) { return slat(1 - u, v, 0.182f); }, 8, 1);
    mesh.patch([&](float u, float v) { return slat(u, 1, 0.198f - 0.016f * v); }, 8, 1);
    mesh.patch([&](float u, float v) { return slat(u, 0, 0.182f + 0.016f * v); }, 8, 1);
  }
  mesh.set_material(seat);
  mesh.patch(
      [](float u, float v) {
        const float x = 2 * u - 1, z = 1 - 2 * v;
        const float rise = (1 - x * x * x * x) * (1 - z * z * z * z);
        return Vec3{0.2f * x, 0.454f + 0.04f * std::sqrt(rise), 0.185f * z - 0.03f};
      },
      16, 16);
}

namespace {

void add_book_row(MeshBuilder& mesh, float x0, float x1, float y, std::span<const std::uint32_t> books,
                  std::uint32_t seed) {
  float x = x0;
  for (std::uint32_t i = 0;; ++i) {
    const std::uint32_t h = hash_combine(seed, i);
    const float width = 0.018f + 0.035f * to_unit_float(h), height = 0.2f + 0.1f * to_unit_float(hash32(h));
    const float depth = 0.16f + 0.07f * to_unit_float(hash32(h + 1));
    if (x + width > x1) return;
    if (h % 9 == 0) {  // a gap
      x += 0.06f;
      continue;
    }
    mesh.set_material(books[h % books.size()]);
    mesh.box({x, y, 0.04f}, {x + width, y + height, 0.04f + depth}, kStanding);
    x += width + 0.0015f;
  }
}

}  // namespace

void add_bookcase(MeshBuilder& mesh, std::uint32_t wood, std::span<const std::uint32_t> books) {
  const float half = 0.65f, height = 1.9f, depth = 0.32f, board = 0.025f;
  mesh.set_material(wood);
  mesh.box({-half, 0, 0.005f}, {-half + board, height, depth}, kStanding);
  mesh.box({half - board, 0, 0.005f}, {half, height, depth}, kStanding);
  mesh.box({-half + 0.01f, 0, 0.008f}, {half - 0.01f, height - 0.01f, 0.02f}, kStanding);
  for (int k = 0; k < 5; ++k) {
    const float y = 0.06f + 0.36f * static_cast<float>(k);
    mesh.set_material(wood);
    mesh.box({-half + 0.01f, y, 0.015f}, {half - 0.01f, y + board, depth - 0.01f});
    add_book_row(mesh, -half + board + 0.005f, half - board - 0.005f, y + board, books,
                 static_cast<std::uint32_t>(k) + 17);
  }
  mesh.set_material(wood);
  mesh.box({-half - 0.02f, height, 0.003f}, {half + 0.02f, height + 0.03f, depth + 0.02f});
}

void add_teapot(MeshBuilder& mesh, float size) {
  const float s = size;
  Outline body(8);
  body.start(0.3f * s, 0).line_to(0.32f * s, 0.03f * s).swell_to(0.62f * s, 0.38f * s).swell_to(0.36f * s, 0.74f * s);
  body.line_to(0.38f * s, 0.77f * s).line_to(0.34f * s, 0.78f * s).swell_to(0.1f * s, 0.88f * s);
  body.line_to(0.06f * s, 0.9f * s).swell_to(0.1f * s, 0.96f * s).swell_to(0.02f * s, 1.0f * s).line_to(0, 1.0f * s);
  mesh.lathe(body.points(), 48);
  const auto spout = [s](float t) { return Vec3{(0.45f + 0.55f * t) * s, (0.32f + 0.1f * t + 0.34f * t * t) * s, 0}; };
  mesh.tube(
      spout, [s](float t) { return t >= 1 ? 0 : (0.13f - 0.08f * t) * s; }, {0, 0, 1}, 20, 16);
  const auto handle = [s](float t) {
    const float angle = kPi * (0.5f + t);
    return Vec3{(-0.45f + 0.42f * std::cos(angle)) * s, (0.42f + 0.24f * std::sin(angle)) * s, 0};
  };
  mesh.tube(
      handle, [s](float) { return 0.045f * s; }, {0, 0, 1}, 16, 24);
}

void add_cup(MeshBuilder& mesh) {
  Outline cup(6);
  cup.start(0.022f, 0).line_to(0.024f, 0.006f).swell_to(0.042f, 0.06f).line_to(0.039f, 0.06f);
  cup.swell_to(0.02f, 0.012f).line_to(0, 0.01f);
  mesh.lathe(cup.points(), 32);
  const auto handle = [](float t) {
    const float angle = kPi * (0.5f - t);
    return Vec3{0.034f + 0.025f * std::cos(angle), 0.034f + 0.017f * std::sin(angle), 0};
  };
  mesh.tube(
      handle, [](float) { return 0.004f; }, {0, 0, 1}, 10, 14);
}

void add_plate(MeshBuilder& mesh) {
  Outline plate(6);
  plate.start(0.05f, 0).line_to(0.055f, 0.004f).swell_to(0.11f, 0.022f).line_to(0.108f, 0.025f);
  plate.swell_to(0.06f, 0.008f).line_to(0, 0.007f);
  mesh.lathe(plate.points(), 40);
}

void add_floor_lamp(MeshBuilder& mesh, std::uint32_t metal, std::uint32_t shade) {
  mesh.set_material(metal);
  Outline stand(6);
  stand.start(0.16f, 0).line_to(0.16f, 0.02f).swell_to(0.015f, 0.07f).line_to(0.012f, 0.09f).line_to(0.012f, 1.5f);
  stand.line_to(0.03f, 1.52f).line_to(0.03f, 1.56f).line_to(0, 1.57f);
  mesh.lathe(stand.points(), 32);
  mesh.set_material(shade);
  const MeshBuilder::ProfilePoint cone[] = {
      {0.25f, 1.42f, true}, {0.253f, 1.42f, true}, {0.133f, 1.78f, true}, {0.13f, 1.78f, true}, {0.25f, 1.42f, true}};
  mesh.lathe(cone, 48);
}

void add_picture(MeshBuilder& mesh, std::uint32_t frame, std::span<const std::uint32_t> colors) {
  const float w = 0.55f, h = 0.38f, rim = 0.05f;
  mesh.set_material(frame);
  mesh.box({-w, -h, 0.005f}, {-w + rim, h, 0.035f});
  mesh.box({w - rim, -h, 0.005f}, {w, h, 0.035f});
  mesh.box({-w + rim, h - rim, 0.006f}, {w - rim, h, 0.034f},
           MeshBuilder::kAllFaces & ~MeshBuilder::kMinX & ~MeshBuilder::kMaxX);
  mesh.box({-w + rim, -h, 0.006f}, {w - rim, -h + rim, 0.034f},
           MeshBuilder::kAllFaces & ~MeshBuilder::kMinX & ~MeshBuilder::kMaxX);
  const int columns = 9, rows = 6;
  const float dx = 2 * (w - rim) / columns, dy = 2 * (h - rim) / rows;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const std::uint32_t key =
          hash_combine(static_cast<std::uint32_t>(i / 2 + j / 3), static_cast<std::uint32_t>(i * j / 3));
      mesh.set_material(colors[key % colors.size()]);
      const float x = -w + rim + dx * static_cast<float>(i), y = -h + rim + dy * static_cast<float>(j);
      mesh.quad({x, y, 0.015f}, {x + dx, y, 0.015f}, {x + dx, y + dy, 0.015f}, {x, y + dy, 0.015f});
    }
}

void add_door_leaf(MeshBuilder& mesh, float width, float height, std::uint32_t paint, std::uint32_t metal) {
  mesh.set_material(paint);
  mesh.box({-width, 0.006f, -0.02f}, {0, height, 0.02f});
  for (int row = 0; row < 3; ++row) {
    const float y0 = 0.15f + 0.62f * static_cast<float>(row);
    for (int column = 0; column < 2; ++column) {
      const float x0 = -width + 0.1f + (width - 0.15f) / 2 * static_cast<float>(column);
      const float x1 = x0 + (width - 0.25f) / 2;
      mesh.box({x0, y0, 0.02f}, {x1, y0 + 0.5f, 0.028f}, MeshBuilder::kAllFaces & ~MeshBuilder::kMinZ);
      mesh.box({x0, y0, -0.028f}, {x1, y0 + 0.5f, -0.02f}, MeshBuilder::kAllFaces & ~MeshBuilder::kMaxZ);
    }
  }
  mesh.set_material(metal);
  for (const float side : {-1.0f, 1.0f}) {
    const auto lever = [&](float t) {
      // A neck out of the leaf, a quarter turn, and the lever along the leaf.
      const float turn = std::clamp((t - 0.25f) / 0.35f, 0.0f, 1.0f) * kPi / 2, r = 0.03f;
      const float out = 0.015f + 0.03f * std::min(t / 0.25f, 1.0f) + r * std::sin(turn);
      const float aside = r * (1 - std::cos(turn)) + 0.09f * std::max(0.0f, (t - 0.6f) / 0.4f);
      return Vec3{-width + 0.07f + aside, 1.02f, side * out};
    };
    mesh.tube(
        lever, [](float t) { return t >= 1 ? 0 : 0.009f; }, {0, 1, 0}, 12, 24);
  }
}

}  // namespace glowworm::ajar
