#include "import/pbrt/motion.h"

#include <array>
#include <cmath>

#include "import/pbrt/transforms.h"

namespace glowworm {

namespace {

using Quaternion = std::array<double, 4>;  // x, y, z, w

TransformDouble transposed(const TransformDouble& m) {
  return {{m.x.x, m.y.x, m.z.x}, {m.x.y, m.y.y, m.z.y}, {m.x.z, m.y.z, m.z.z}, {0, 0, 0}};
}

TransformDouble mean(const TransformDouble& a, const TransformDouble& b, double share) {
  const auto mix = [&](Vec3d u, Vec3d v) { return u * (1 - share) + v * share; };
  return {mix(a.x, b.x), mix(a.y, b.y), mix(a.z, b.z), mix(a.translation, b.translation)};
}

/// The rotation of the linear part of an invertible transform, mirrored if that is (Shoemake and Duff, "Matrix
/// Animation and Polar Decomposition", 1992).
TransformDouble rotation_of(const TransformDouble& m) {
  constexpr int kMostSteps = 100;
  constexpr double kConverged = 1e-12;
  TransformDouble r = m;
  r.translation = {};
  for (int step = 0; step < kMostSteps; ++step) {
    const TransformDouble next = mean(r, transposed(inverse(r)), 0.5);
    const double change = length(next.x - r.x) + length(next.y - r.y) + length(next.z - r.z);
    r = next;
    if (change < kConverged) break;
  }
  return r;
}

/// The unit quaternion of a rotation.
Quaternion quaternion_of(const TransformDouble& r) {
  const double trace = r.x.x + r.y.y + r.z.z;
  Quaternion q{};
  if (trace > 0) {
    q = {r.y.z - r.z.y, r.z.x - r.x.z, r.x.y - r.y.x, 1 + trace};
  } else {
    // By the largest of x, y and z.
    const Vec3d* const axes[3] = {&r.x, &r.y, &r.z};
    int i = r.y.y > r.x.x ? 1 : 0;
    if (r.z.z > (*axes[i])[i]) i = 2;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const auto entry = [&](int row, int column) { return (*axes[column])[row]; };
    const auto at = [&](int axis) -> double& { return q[static_cast<std::size_t>(axis)]; };
    at(i) = 1 + entry(i, i) - entry(j, j) - entry(k, k);
    at(j) = entry(i, j) + entry(j, i);
    at(k) = entry(i, k) + entry(k, i);
    q[3] = entry(k, j) - entry(j, k);
  }
  double squared = 0;
  for (const double v : q) squared += v * v;
  for (double& v : q) v /= std::sqrt(squared);
  return q;
}

TransformDouble rotation_by(const Quaternion& q) {
  const double x = q[0], y = q[1], z = q[2], w = q[3];
  return {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
          {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
          {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)},
          {0, 0, 0}};
}

Quaternion slerp(const Quaternion& a, Quaternion b, double share) {
  double cosine = 0;
  for (std::size_t i = 0; i < 4; ++i) cosine += a[i] * b[i];
  if (cosine < 0)
    for (double& v : b) v = -v;
  const double angle = std::acos(std::min(std::abs(cosine), 1.0)), sine = std::sin(angle);
  const bool near = sine < 1e-9;
  const double of_a = near ? 1 - share : std::sin((1 - share) * angle) / sine;
  const double of_b = near ? share : std::sin(share * angle) / sine;
  Quaternion out{};
  for (std::size_t i = 0; i < 4; ++i) out[i] = of_a * a[i] + of_b * b[i];
  return out;
}

/// A transform as rotation after scale, without its translation.
struct Decomposed {
  Quaternion rotation;
  TransformDouble scale;
};

Decomposed decompose(const TransformDouble& m) {
  TransformDouble linear = m, r = rotation_of(m);
  linear.translation = {};
  // The scale takes the mirroring.
  if (r.determinant() < 0) r = {-r.x, -r.y, -r.z, {0, 0, 0}};
  return {quaternion_of(r), inverse(r) * linear};
}

}  // namespace

bool PbrtTransforms::moves() const {
  return !(start.x == end.x && start.y == end.y && start.z == end.z && start.translation == end.translation);
}

std::optional<TransformDouble> between(const PbrtTransforms& ends, double share) {
  if (!ends.moves() || share <= 0) return ends.start;
  if (share >= 1) return ends.end;
  if (!is_invertible(ends.start) || !is_invertible(ends.end)) return std::nullopt;
  const Decomposed a = decompose(ends.start), b = decompose(ends.end);
  TransformDouble out = rotation_by(slerp(a.rotation, b.rotation, share)) * mean(a.scale, b.scale, share);
  out.translation = ends.start.translation * (1 - share) + ends.end.translation * share;
  return out;
}

}  // namespace glowworm
