#include "builtin/ornaments.h"

namespace glowworm {

Outline& Outline::start(float radius, float y) {
  points_.push_back({radius, y, true});
  return *this;
}

Outline& Outline::line_to(float radius, float y) {
  crease();
  points_.push_back({radius, y, true});
  return *this;
}

Outline& Outline::half_round(float height, float bulge) {
  crease();
  const MeshBuilder::ProfilePoint from = points_.back();
  for (int i = 1; i <= subdivision_; ++i) {
    const float angle = kPi * static_cast<float>(i) / static_cast<float>(subdivision_);
    const bool last = i == subdivision_;
    points_.push_back({last ? from.radius : from.radius + bulge * std::sin(angle),
                       last ? from.y + height : from.y + height / 2 * (1 - std::cos(angle)), last});
  }
  return *this;
}

Outline& Outline::swell_to(float radius, float y) {
  const MeshBuilder::ProfilePoint from = points_.back();
  for (int i = 1; i <= subdivision_; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(subdivision_);
    const float s = t * t * (3 - 2 * t);
    points_.push_back({from.radius + (radius - from.radius) * s, from.y + (y - from.y) * t, false});
  }
  return *this;
}

Outline& Outline::shaft_to(float radius, float y) {
  crease();
  const MeshBuilder::ProfilePoint from = points_.back();
  const int pieces = subdivision_ * 2;
  for (int i = 1; i <= pieces; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(pieces);
    const float entasis = 0.12f * (from.radius - radius) * std::sin(kPi * t);
    points_.push_back({from.radius + (radius - from.radius) * t * t + entasis, from.y + (y - from.y) * t, i == pieces});
  }
  return *this;
}

void add_column(MeshBuilder& mesh, float height, float radius, Fineness fineness) {
  const float r = radius, plinth = 0.4f * r, abacus = 0.4f * r;
  const float half_plinth = 1.4f * r, half_abacus = 1.25f * r;
  mesh.box({-half_plinth, 0, -half_plinth}, {half_plinth, plinth, half_plinth},
           MeshBuilder::kAllFaces & ~MeshBuilder::kMinY);
  const float top = height - abacus;
  Outline outline(fineness.along);
  outline.start(1.2f * r, plinth).torus(0.3f * r).line_to(1.15f * r, plinth + 0.35f * r);
  outline.scotia(0.25f * r).line_to(1.1f * r, plinth + 0.64f * r).torus(0.2f * r);
  outline.line_to(r, plinth + 0.88f * r).shaft_to(0.84f * r, top - 0.7f * r);
  outline.torus(0.12f * r)
      .line_to(0.84f * r, top - 0.4f * r)
      .swell_to(1.15f * r, top - 0.1f * r)
      .line_to(1.15f * r, top);
  mesh.lathe(outline.points(), fineness.around);
  mesh.box({-half_abacus, top, -half_abacus}, {half_abacus, height, half_abacus});
}

void add_baluster(MeshBuilder& mesh, float height, Fineness fineness) {
  const float h = height;
  Outline outline(fineness.along);
  outline.start(0.085f * h, 0).line_to(0.085f * h, 0.06f * h).line_to(0.05f * h, 0.08f * h).torus(0.05f * h);
  outline.swell_to(0.1f * h, 0.38f * h).swell_to(0.04f * h, 0.82f * h).line_to(0.04f * h, 0.83f * h).torus(0.05f * h);
  outline.line_to(0.085f * h, 0.94f * h).line_to(0.085f * h, h);
  mesh.lathe(outline.points(), fineness.around);
}

void add_urn(MeshBuilder& mesh, float height, Fineness fineness) {
  const float h = height;
  Outline outline(fineness.along);
  outline.start(0.24f * h, 0).line_to(0.24f * h, 0.07f * h).line_to(0.2f * h, 0.07f * h);
  outline.swell_to(0.09f * h, 0.2f * h).line_to(0.09f * h, 0.22f * h).torus(0.05f * h);
  outline.line_to(0.12f * h, 0.28f * h).swell_to(0.36f * h, 0.72f * h).swell_to(0.31f * h, 0.88f * h);
  outline.swell_to(0.4f * h, 0.98f * h).line_to(0.4f * h, h).line_to(0.36f * h, h);
  // The inside of the mouth, down to the earth in it.
  outline.line_to(0.28f * h, 0.88f * h).line_to(0, 0.86f * h);
  mesh.lathe(outline.points(), fineness.around);
}

void sweep_rectangle(MeshBuilder& mesh, std::span<const MeshBuilder::ProfilePoint> profile, float excess) {
  for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
    const MeshBuilder::ProfilePoint &a = profile[k], &b = profile[k + 1];
    const float ax = a.radius + excess, bx = b.radius + excess, az = a.radius, bz = b.radius;
    mesh.quad({-ax, a.y, az}, {ax, a.y, az}, {bx, b.y, bz}, {-bx, b.y, bz});
    mesh.quad({ax, a.y, az}, {ax, a.y, -az}, {bx, b.y, -bz}, {bx, b.y, bz});
    mesh.quad({ax, a.y, -az}, {-ax, a.y, -az}, {-bx, b.y, -bz}, {bx, b.y, -bz});
    mesh.quad({-ax, a.y, -az}, {-ax, a.y, az}, {-bx, b.y, bz}, {-bx, b.y, -bz});
  }
}

void add_curtain(MeshBuilder& mesh, float width, float height, int folds, int cells_per_fold, float phase) {
  const float thickness = 0.01f;
  const auto middle = [=](float u, float v) {
    const float angle = 2 * kPi * static_cast<float>(folds) * u + phase;
    // Gathered at the top, wider and less regular at the foot.
    const float depth = 0.035f + 0.05f * (1 - v);
    const float sway = 0.02f * std::sin(3 * angle * 0.37f + 2 * v);
    return Vec3{(u - 0.5f) * width + 0.01f * std::sin(2 * angle) * (1 - v), v * height,
                depth * std::cos(angle) + sway * (1 - v)};
  };
  const auto sheet = [=](float u, float v, float side) { return middle(u, v) + Vec3{0, 0, side * thickness / 2}; };
  const int nu = folds * cells_per_fold, nv = 2 * cells_per_fold;
  mesh.patch([&](float u, float v) { return sheet(u, v, 1); }, nu, nv);
  mesh.patch([&](float u, float v) { return sheet(1 - u, v, -1); }, nu, nv);
  mesh.patch([&](float u, float v) { return sheet(u, 1, 1 - 2 * v); }, nu, 1);
  mesh.patch([&](float u, float v) { return sheet(u, 0, 2 * v - 1); }, nu, 1);
  mesh.patch([&](float u, float v) { return sheet(1, v, 1 - 2 * u); }, 1, nv);
  mesh.patch([&](float u, float v) { return sheet(0, v, 2 * u - 1); }, 1, nv);
}

}  // namespace glowworm
