#include "scene/environment.h"

#include <algorithm>
#include <cmath>

#include "core/warp.h"

namespace glowworm {

namespace {

Vec3 equal_area_direction(Vec2 uv) {
  const float x = 2 * uv.x - 1, y = 2 * uv.y - 1;
  const float ax = std::abs(x), ay = std::abs(y);
  const float distance = 1 - (ax + ay);  // to the diagonal, which is the equator; positive in the upper hemisphere
  const float r = 1 - std::abs(distance);
  const float phi = (r == 0 ? 1 : (ay - ax) / r + 1) * (kPi / 4);
  const float radius = r * std::sqrt(std::max(0.0f, 2 - r * r));
  return {std::copysign(std::cos(phi) * radius, x), std::copysign(std::sin(phi) * radius, y),
          std::copysign(1 - r * r, distance)};
}

Vec2 equal_area_coordinates(Vec3 d) {
  const float ax = std::abs(d.x), ay = std::abs(d.y);
  const float r = std::sqrt(std::max(0.0f, 1 - std::abs(d.z)));
  const float phi = ax == 0 && ay == 0 ? 0.0f : std::atan2(ay, ax) * (2 * kInversePi);
  float y = phi * r, x = r - y;
  if (d.z < 0) {
    const float folded = 1 - x;
    x = 1 - y;
    y = folded;
  }
  return {(std::copysign(x, d.x) + 1) / 2, (std::copysign(y, d.y) + 1) / 2};
}

Vec3 lat_long_direction(Vec2 uv) {
  const float theta = uv.y * kPi, phi = (uv.x - 0.5f) * (2 * kPi);
  const float s = std::sin(theta);
  return {s * std::sin(phi), std::cos(theta), -s * std::cos(phi)};
}

Vec2 lat_long_coordinates(Vec3 d) {
  // By atan2 of the sine and the cosine, since acos loses the pole to rounding.
  const float theta = std::atan2(std::sqrt(d.x * d.x + d.z * d.z), d.y);
  return {std::atan2(d.x, -d.z) / (2 * kPi) + 0.5f, theta * kInversePi};
}

/// Steradians of a texel of row y: exact, so that their sum is 4 pi.
double texel_solid_angle(const Environment& e, int y) {
  if (e.mapping == EnvironmentMapping::equal_area) return 4 * M_PI / (static_cast<double>(e.width) * e.height);
  return (std::cos(M_PI * y / e.height) - std::cos(M_PI * (y + 1) / e.height)) * 2 * M_PI / e.width;
}

RGB texel(const Environment& e, Vec2 uv) {
  const int x = std::clamp(static_cast<int>(uv.x * e.width), 0, e.width - 1);
  const int y = std::clamp(static_cast<int>(uv.y * e.height), 0, e.height - 1);
  return e.pixels[static_cast<std::size_t>(y) * e.width + x];
}

}  // namespace

Vec3 environment_direction(const Environment& environment, Vec2 uv) {
  const Vec3 local =
      environment.mapping == EnvironmentMapping::lat_long ? lat_long_direction(uv) : equal_area_direction(uv);
  return normalize(environment.to_world.vector(local));
}

Vec2 environment_coordinates(const Environment& environment, Vec3 direction) {
  const Transform& m = environment.to_world;
  // The axes are orthonormal (Scene sees to it), so that the transpose is the inverse.
  const Vec3 local = {dot(direction, m.x), dot(direction, m.y), dot(direction, m.z)};
  return environment.mapping == EnvironmentMapping::lat_long ? lat_long_coordinates(local)
                                                             : equal_area_coordinates(local);
}

float environment_solid_angle(const Environment& environment, Vec2 uv) {
  if (environment.mapping == EnvironmentMapping::equal_area) return 4 * kPi;
  return 2 * kPi * kPi * std::sin(uv.y * kPi);
}

RGB radiance(const Environment& environment, Vec3 direction) {
  if (environment.pixels.empty()) return environment.scale;
  return environment.scale * texel(environment, environment_coordinates(environment, direction));
}

EnvironmentValue radiance_and_pdf(const Environment& environment, const Distribution2D& distribution, Vec3 direction) {
  if (environment.pixels.empty()) return {environment.scale, kUniformSpherePdf};
  const Vec2 uv = environment_coordinates(environment, direction);
  const float solid_angle = environment_solid_angle(environment, uv);
  return {environment.scale * texel(environment, uv), solid_angle > 0 ? distribution.pdf(uv) / solid_angle : 0.0f};
}

EnvironmentDirection sample_environment_texel(const Environment& environment, const Distribution2D& distribution,
                                              Vec2 u) {
  if (distribution.empty()) return {square_to_sphere(u), {environment.scale, kUniformSpherePdf}};
  const Distribution2D::Sample s = distribution.sample(u);
  const float solid_angle = environment_solid_angle(environment, s.point);
  const RGB& texel = environment.pixels[std::size_t{s.y} * environment.width + s.x];
  return {environment_direction(environment, s.point),
          {environment.scale * texel, solid_angle > 0 ? s.pdf / solid_angle : 0.0f}};
}

Distribution2D environment_distribution(const Environment& environment) {
  if (environment.pixels.empty()) return {};
  std::vector<float> weights(environment.pixels.size());
  for (int y = 0; y < environment.height; ++y) {
    const float solid_angle = static_cast<float>(texel_solid_angle(environment, y));
    for (int x = 0; x < environment.width; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * environment.width + x;
      weights[i] = std::max(0.0f, luminance(environment.scale * environment.pixels[i])) * solid_angle;
    }
  }
  return Distribution2D(weights, environment.width, environment.height);
}

RGB environment_integral(const Environment& environment) {
  if (environment.pixels.empty()) return environment.scale * (4 * kPi);
  double sum[3] = {0, 0, 0};
  for (int y = 0; y < environment.height; ++y) {
    const double solid_angle = texel_solid_angle(environment, y);
    for (int x = 0; x < environment.width; ++x) {
      const RGB& texel = environment.pixels[static_cast<std::size_t>(y) * environment.width + x];
      for (int c = 0; c < 3; ++c) sum[c] += solid_angle * texel[c];
    }
  }
  return environment.scale * RGB(static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2]));
}

}  // namespace glowworm
