#include "scene/environment.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/rgb.h"
#include "core/warp.h"
#include "scene/environment_bytes.h"

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

/// Integral over the sphere of the bilinear weight of a texel in row y, steradians. The integrals add up to 4 pi. In
/// lat_long, it is the integral of sin(theta) times a tent over two rows; the tent's upper half is constant in the
/// first row, and its lower half in the last row.
double texel_solid_angle(const Environment& e, int y) {
  if (e.mapping == EnvironmentMapping::equal_area) return 4 * M_PI / (static_cast<double>(e.width) * e.height);
  const double row = M_PI / e.height, around = 2 * M_PI / e.width;
  if (e.height == 1) return 2 * around;
  if (y == 0 || y == e.height - 1) return (1 - (std::sin(1.5 * row) - std::sin(0.5 * row)) / row) * around;
  return 2 * std::sin((y + 0.5) * row) * (1 - std::cos(row)) / row * around;
}

/// Wraps a point up to half the image beyond its edges to the same place on the sphere. Lat_long wraps around
/// horizontally, and repeats its first and last rows at the poles. The edges of equal_area meet themselves, rotated by
/// half a turn.
Vec2 wrapped(EnvironmentMapping mapping, Vec2 uv) {
  if (mapping == EnvironmentMapping::lat_long) {
    uv.x -= std::floor(uv.x);
    return {uv.x, uv.y < 0 ? -uv.y : uv.y > 1 ? 2 - uv.y : uv.y};
  }
  if (uv.x < 0 || uv.x > 1) uv = {(uv.x < 0 ? 0 : 2) - uv.x, 1 - uv.y};
  if (uv.y < 0 || uv.y > 1) uv = {1 - uv.x, (uv.y < 0 ? 0 : 2) - uv.y};
  return uv;
}

/// The same for a texel up to one beyond the edges.
std::array<int, 2> wrapped_texel(const Environment& e, int x, int y) {
  if (e.mapping == EnvironmentMapping::lat_long)
    return {x < 0 ? x + e.width : x >= e.width ? x - e.width : x, std::clamp(y, 0, e.height - 1)};
  if (x < 0 || x >= e.width) x = x < 0 ? 0 : e.width - 1, y = e.height - 1 - y;
  if (y < 0 || y >= e.height) y = y < 0 ? 0 : e.height - 1, x = e.width - 1 - x;
  return {x, y};
}

/// Calls use(x, y, weight) for the four texels of bilinear interpolation at uv; the weights add up to 1.
template <typename Use>
void for_texels_around(const Environment& e, Vec2 uv, const Use& use) {
  const float u = uv.x * static_cast<float>(e.width) - 0.5f, v = uv.y * static_cast<float>(e.height) - 0.5f;
  const int x = std::clamp(static_cast<int>(std::floor(u)), -1, e.width - 1);
  const int y = std::clamp(static_cast<int>(std::floor(v)), -1, e.height - 1);
  const float fx = u - static_cast<float>(x), fy = v - static_cast<float>(y);
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const auto [tx, ty] = wrapped_texel(e, x + i, y + j);
      use(tx, ty, (i == 0 ? 1 - fx : fx) * (j == 0 ? 1 - fy : fy));
    }
}

const RGB& texel(const Environment& e, int x, int y) { return e.pixels[static_cast<std::size_t>(y) * e.width + x]; }

/// Radiance at a point of the image, and the density per steradian with which sample_environment_direction() samples
/// it.
EnvironmentValue value_at(const Environment& e, const Distribution2D& distribution, Vec2 uv) {
  RGB sum;
  float density = 0;
  for_texels_around(e, uv, [&](int x, int y, float weight) {
    sum += texel(e, x, y) * weight;
    density += distribution.pdf({(static_cast<float>(x) + 0.5f) / static_cast<float>(e.width),
                                 (static_cast<float>(y) + 0.5f) / static_cast<float>(e.height)}) *
               weight;
  });
  const float solid_angle = environment_solid_angle(e, uv);
  return {e.scale * sum, solid_angle > 0 ? density / solid_angle : 0.0f};
}

/// In the space of the image. The axes are orthonormal (Scene ensures it), so the transpose is the inverse.
Vec3 local_direction(const Environment& e, Vec3 direction) {
  const Transform& m = e.to_world;
  return {dot(direction, m.x), dot(direction, m.y), dot(direction, m.z)};
}

/// The value of a direction of world space, which stands at uv of the image.
EnvironmentValue value_at(const Environment& e, const Distribution2D& distribution, Vec2 uv, Vec3 direction) {
  EnvironmentValue value = value_at(e, distribution, uv);
  if (e.sky) value.radiance = e.scale * sky_radiance(*e.sky, local_direction(e, direction));
  return value;
}

/// Samples a number in [-1, 1] with density 1 - |x|. @param u in [0, 1)
float square_to_tent(float u) { return u < 0.5f ? std::sqrt(2 * u) - 1 : 1 - std::sqrt(2 * (1 - u)); }

/// Samples a point of the image with the bilinearly interpolated density of the texels: a texel by the distribution,
/// then a position around its centre by the tent of its bilinear weight.
Vec2 sampled_point(const Environment& e, const Distribution2D& distribution, Vec2 u) {
  const Distribution2D::Sample s = distribution.sample(u);
  const auto place = [](std::uint32_t texel, int size, float point) {
    const float inside = std::clamp(point * static_cast<float>(size) - static_cast<float>(texel), 0.0f, 1.0f);
    return (static_cast<float>(texel) + 0.5f + square_to_tent(inside)) / static_cast<float>(size);
  };
  return wrapped(e.mapping, {place(s.x, e.width, s.point.x), place(s.y, e.height, s.point.y)});
}

}  // namespace

Vec3 environment_direction(const Environment& environment, Vec2 uv) {
  const Vec3 local =
      environment.mapping == EnvironmentMapping::lat_long ? lat_long_direction(uv) : equal_area_direction(uv);
  return normalize(environment.to_world.vector(local));
}

Vec2 environment_coordinates(const Environment& environment, Vec3 direction) {
  const Vec3 local = local_direction(environment, direction);
  return environment.mapping == EnvironmentMapping::lat_long ? lat_long_coordinates(local)
                                                             : equal_area_coordinates(local);
}

float environment_solid_angle(const Environment& environment, Vec2 uv) {
  if (environment.mapping == EnvironmentMapping::equal_area) return 4 * kPi;
  return 2 * kPi * kPi * std::sin(uv.y * kPi);
}

RGB radiance(const Environment& environment, Vec3 direction) {
  if (environment.sky)
    return environment.scale * sky_radiance(*environment.sky, local_direction(environment, direction));
  if (environment.pixels.empty()) return environment.scale;
  RGB sum;
  for_texels_around(environment, environment_coordinates(environment, direction),
                    [&](int x, int y, float weight) { sum += texel(environment, x, y) * weight; });
  return environment.scale * sum;
}

EnvironmentValue radiance_and_pdf(const Environment& environment, const Distribution2D& distribution, Vec3 direction) {
  if (environment.pixels.empty()) return {environment.scale, kUniformSpherePdf};
  return value_at(environment, distribution, environment_coordinates(environment, direction), direction);
}

Vec3 sample_environment_direction(const Environment& environment, const Distribution2D& distribution, Vec2 u) {
  if (distribution.empty()) return square_to_sphere(u);
  return environment_direction(environment, sampled_point(environment, distribution, u));
}

EnvironmentDirection sample_environment(const Environment& environment, const Distribution2D& distribution, Vec2 u) {
  if (distribution.empty()) return {square_to_sphere(u), {environment.scale, kUniformSpherePdf}};
  const Vec2 uv = sampled_point(environment, distribution, u);
  const Vec3 direction = environment_direction(environment, uv);
  return {direction, value_at(environment, distribution, uv, direction)};
}

std::uint64_t environment_bytes(std::uint64_t texels) {
  constexpr std::uint64_t kOfDistribution = sizeof(double) + sizeof(std::uint32_t);  // Distribution1D, of each weight
  return texels * (sizeof(RGB) + sizeof(float) + kOfDistribution);
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

Environment sum_of(const Environment& a, const Environment& b) {
  if (b.pixels.size() > a.pixels.size()) return sum_of(b, a);
  Environment out = a;
  if (out.name.empty()) out.name = b.name;
  if (a.pixels.empty()) {
    out.scale += b.scale;
    return out;
  }
  // The mean of b over each pixel. Those of b are larger, but their edges lie anywhere.
  constexpr int kParts = 3;
  out.scale = RGB(1.0f);
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      RGB sum;
      for (int j = 0; j < kParts; ++j)
        for (int i = 0; i < kParts; ++i)
          sum +=
              radiance(b, environment_direction(a, {(static_cast<float>(x) + (static_cast<float>(i) + 0.5f) / kParts) /
                                                        static_cast<float>(a.width),
                                                    (static_cast<float>(y) + (static_cast<float>(j) + 0.5f) / kParts) /
                                                        static_cast<float>(a.height)}));
      out.pixels[static_cast<std::size_t>(y) * a.width + x] = a.scale * texel(a, x, y) + sum / (kParts * kParts);
    }
  return out;
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
