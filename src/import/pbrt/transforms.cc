#include "import/pbrt/transforms.h"

#include <cmath>

namespace glowworm {

namespace {

Vec3d three(const PbrtDirective& directive, std::size_t first) {
  return {directive.numbers[first], directive.numbers[first + 1], directive.numbers[first + 2]};
}

/// Reads sixteen numbers in pbrt's order, column by column.
std::optional<TransformDouble> from_matrix(const PbrtDirective& directive) {
  const double w = directive.numbers[15];
  if (directive.numbers[3] != 0 || directive.numbers[7] != 0 || directive.numbers[11] != 0 || w == 0) {
    directive.parameters.error("the matrix is not affine", "Every fourth number must be 0, the last one 1.");
    return std::nullopt;
  }
  const double s = 1 / w;
  return TransformDouble{three(directive, 0) * s, three(directive, 4) * s, three(directive, 8) * s,
                         three(directive, 12) * s};
}

std::optional<TransformDouble> rotation(const PbrtDirective& directive) {
  const double angle = directive.numbers[0] * M_PI / 180;
  const Vec3d axis = three(directive, 1);
  const double l = length(axis);
  if (!(l > 0) || !std::isfinite(l)) {
    directive.parameters.error("Rotate around an axis of zero length",
                               "Give an angle in degrees and an axis, as Rotate 90 0 1 0.");
    return std::nullopt;
  }
  const Vec3d a = axis * (1 / l);
  const double s = std::sin(angle), c = std::cos(angle);
  // Rodrigues' formula for the three axes.
  const auto turned = [&](Vec3d v) { return v * c + cross(a, v) * s + a * (dot(a, v) * (1 - c)); };
  return TransformDouble{turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1}), {0, 0, 0}};
}

/// The transform from the world to a camera at the first point that looks along +z at the second point, with y up. +x
/// is to the right, unlike in OpenGL: pbrt's space is left-handed.
std::optional<TransformDouble> look_at_transform(const PbrtDirective& directive) {
  const Vec3d eye = three(directive, 0), forward = three(directive, 3) - eye, up = three(directive, 6);
  const Vec3d right = cross(up, forward);
  if (!(length(right) > 0) || !is_finite(right)) {
    directive.parameters.error("LookAt: eye and target coincide, or up is parallel to the view",
                               "Give three numbers each for eye, target and up.");
    return std::nullopt;
  }
  const auto unit = [](Vec3d v) { return v * (1 / length(v)); };
  const Vec3d z = unit(forward), x = unit(cross(unit(up), z));
  return inverse(TransformDouble{x, cross(z, x), z, eye});
}

}  // namespace

bool is_invertible(const TransformDouble& t) {
  const auto d = static_cast<float>(t.determinant());
  return std::isfinite(d) && d != 0 && std::isfinite(1 / d) && is_finite(narrow(t.translation));
}

std::optional<TransformDouble> apply_transform(const PbrtDirective& directive, const TransformDouble& current) {
  std::optional<TransformDouble> change;
  if (directive.name == "Identity") return TransformDouble();
  if (directive.name == "Transform") return from_matrix(directive);
  if (directive.name == "ConcatTransform") {
    change = from_matrix(directive);
  } else if (directive.name == "Translate") {
    change = TransformDouble{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, three(directive, 0)};
  } else if (directive.name == "Scale") {
    const Vec3d s = three(directive, 0);
    change = TransformDouble{{s.x, 0, 0}, {0, s.y, 0}, {0, 0, s.z}, {0, 0, 0}};
  } else if (directive.name == "Rotate") {
    change = rotation(directive);
  } else if (directive.name == "LookAt") {
    change = look_at_transform(directive);
  }
  if (!change) return std::nullopt;
  return current * *change;
}

}  // namespace glowworm
