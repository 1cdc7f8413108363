#include "transport/medium.h"

#include <bit>

#include "core/random.h"
#include "scene/surface.h"
#include "transport/step.h"

namespace glowworm {

namespace {

/// Random numbers for the way through a medium, as many as it takes.
class MediumNumbers {
 public:
  /// @param first the first two, in [0, 1)
  MediumNumbers(const Ray& ray, Vec2 first) : first_(first) {
    const Vec3 o = ray.origin, d = ray.direction;
    for (const float value : {o.x, o.y, o.z, d.x, d.y, d.z, first.x, first.y})
      key_ = hash_combine(key_, std::bit_cast<std::uint32_t>(value));
  }
  float next() {
    const std::uint32_t n = count_++;
    return n == 0 ? first_.x : n == 1 ? first_.y : to_unit_float(hash_combine(key_, n));
  }

 private:
  std::uint32_t key_ = 0, count_ = 0;
  Vec2 first_;
};

/// Transmittance below which ratio tracking ends paths at random.
constexpr float kLeastTransmittance = 0.1f;

const Material& material_of(const Scene& scene, std::uint32_t triangle) {
  return scene.materials()[scene.geometry().material_of(triangle)];
}

/// The medium that a surface names on the side to which `direction` points: an index, kNone or kUnnamed.
std::uint32_t named_medium(const Scene& scene, std::uint32_t triangle, Vec3 direction) {
  const Material& m = material_of(scene, triangle);
  return dot(direction, scene.diffuse_triangle(triangle).normal) > 0 ? m.outside : m.inside;
}

/// Shares of the channels in the choice of one.
RGB shares(RGB throughput) {
  const float sum = throughput.r + throughput.g + throughput.b;
  return sum > 0 ? throughput / sum : RGB(1.0f / 3);
}

MediumSample sample_homogeneous(const Medium& medium, MediumSpan span, RGB throughput, Vec2 u) {
  const RGB sigma_t = medium.sigma_a + medium.sigma_s;
  const int channel = choose_channel(throughput, u.x);
  const float free = -std::log1p(-u.y) / sigma_t[channel], length = span.last - span.first;
  MediumSample out;
  const RGB passed = transmittance(sigma_t, length), stopped = opacity(sigma_t, length);
  for (int c = 0; c < 3; ++c)
    if (medium.sigma_a[c] > 0) out.emitted[c] = medium.emission[c] * medium.sigma_a[c] * stopped[c] / sigma_t[c];
  if (is_black(medium.sigma_s)) {
    out.weight = passed;
    return out;
  }
  out.scatters = free < length;
  if (out.scatters) {
    out.distance = span.first + free;
    const RGB left = transmittance(sigma_t, free);
    out.weight = medium.sigma_s * left / mean_over_channels(throughput, sigma_t * left);
  } else {
    out.weight = passed / mean_over_channels(throughput, passed);
  }
  return out;
}

}  // namespace

RGB transmittance(RGB sigma_t, float distance) {
  const auto channel = [distance](float sigma) { return sigma > 0 ? std::exp(-sigma * distance) : 1.0f; };
  return {channel(sigma_t.r), channel(sigma_t.g), channel(sigma_t.b)};
}

RGB opacity(RGB sigma_t, float distance) {
  const auto channel = [distance](float sigma) { return sigma > 0 ? -std::expm1(-sigma * distance) : 0.0f; };
  return {channel(sigma_t.r), channel(sigma_t.g), channel(sigma_t.b)};
}

bool is_interface(const Scene& scene, std::uint32_t triangle) {
  return material_of(scene, triangle).kind == MaterialKind::interface &&
         scene.geometry().emission_of(triangle) == kNone;
}

PathMedium medium_behind(const Scene& scene, PathMedium before, std::uint32_t triangle, Vec3 direction) {
  if (const std::uint32_t near = named_medium(scene, triangle, direction); near != kUnnamed) return {near, true};
  if (named_medium(scene, triangle, -direction) != kUnnamed) return {scene.ambient_medium(), false};
  return {before.index, false};
}

MediumSides media_at(const Scene& scene, PathMedium arrived, std::uint32_t triangle, Vec3 wo) {
  return {medium_behind(scene, arrived, triangle, wo), medium_behind(scene, arrived, triangle, -wo)};
}

PathMedium medium_until(const Scene& scene, PathMedium start, std::uint32_t triangle, Vec3 direction) {
  if (start.named || triangle == kNone) return start;
  const std::uint32_t near = named_medium(scene, triangle, -direction);
  return near == kUnnamed ? start : PathMedium{near, true};
}

PathMedium medium_at_start(const Tracer& tracer, Vec3 position, Vec3 direction) {
  const Scene& scene = tracer.scene();
  PathState path;
  path.ray = {position, 0, direction, std::numeric_limits<float>::infinity()};
  int bodies = 0;  // that the ray is in, but its start is not
  for (;;) {
    const Hit hit = tracer.intersect(path.ray);
    if (hit.triangle == kNone) return {scene.ambient_medium(), false};
    const std::uint32_t near = named_medium(scene, hit.triangle, -direction),
                        far = named_medium(scene, hit.triangle, direction);
    if (near == kUnnamed && far != kUnnamed) ++bodies;
    if (near != kUnnamed && bodies == 0) return {near, false};
    if (near != kUnnamed && far == kUnnamed) --bodies;
    pass_interface(scene, path, hit);
  }
}

PathMedium camera_medium(const Tracer& tracer, const Camera& camera) {
  if (tracer.scene().media().empty()) return {};
  return medium_at_start(tracer, camera.to_world.translation, normalize(camera.to_world.z));
}

void pass_interface(const Scene& scene, PathState& path, const Hit& hit) {
  const SurfacePoint point = surface_point(scene, hit.triangle, hit.barycentric);
  const Vec3 direction = path.ray.direction;
  path.medium = medium_behind(scene, path.medium, hit.triangle, direction);
  path.ray = leave_surface(point.position, face_forward(point.geometric_normal, direction), point.offset, direction,
                           path.ray.time);
}

int choose_channel(RGB throughput, float& u) {
  const RGB share = shares(throughput);
  int channel = 0;
  while (channel < 2 && u >= share[channel]) u -= share[channel++];
  while (!(share[channel] > 0)) --channel;  // rounding may lead past the last
  u = std::min(u / share[channel], kBelowOne);
  return channel;
}

float mean_over_channels(RGB throughput, RGB values) {
  const RGB share = shares(throughput);
  return share.r * values.r + share.g * values.g + share.b * values.b;
}

MediumSample sample_medium(const Medium& medium, const Ray& ray, float length, RGB throughput, Vec2 u) {
  const MediumSpan span = span_in(medium, ray.origin, ray.direction, 0, length);
  if (span.empty()) return {};
  if (is_homogeneous(medium)) return sample_homogeneous(medium, span, throughput, u);
  MediumNumbers numbers(ray, u);
  MediumSample out;
  for_majorants(medium, ray.origin, ray.direction, span.first, span.last, [&](float at, float end, float majorant) {
    if (!(majorant > 0)) return true;
    for (;;) {
      at -= std::log1p(-numbers.next()) / majorant;
      if (!(at < end)) return true;
      const MediumPoint here = medium_point(medium, ray.origin + ray.direction * at);
      out.emitted += out.weight * here.emission / majorant;
      const RGB sigma_t = here.sigma_a + here.sigma_s;
      const float real = std::min(mean_over_channels(throughput * out.weight, sigma_t) / majorant, 1.0f);
      if (numbers.next() < real) {
        out.weight *= here.sigma_s / (majorant * real);
        out.distance = at;
        out.scatters = true;
        return false;
      }
      out.weight *= (RGB(majorant) - sigma_t) / (majorant * (1 - real));
    }
  });
  return out;
}

MediumPoint mean_along(const Medium& medium, const Ray& ray, float first, float length) {
  constexpr float kNode = 0.21132487f;  // (1 - 3^-0.5) / 2
  const auto at = [&](float share) {
    return medium_point(medium, ray.origin + ray.direction * (first + share * length));
  };
  const MediumPoint a = at(kNode), b = at(1 - kNode);
  return {(a.sigma_a + b.sigma_a) * 0.5f, (a.sigma_s + b.sigma_s) * 0.5f, (a.emission + b.emission) * 0.5f};
}

RGB transmittance(const Medium& medium, const Ray& ray, float length) {
  RGB passed(1.0f);
  for_even_pieces(medium, ray, length, [&](float first, float last, const MediumPoint& here) {
    passed *= transmittance(here.sigma_a + here.sigma_s, last - first);
  });
  return passed;
}

RGB estimate_transmittance(const Medium& medium, const Ray& ray, float length, Vec2 random) {
  if (is_homogeneous(medium)) return transmittance(medium, ray, length);
  MediumNumbers numbers(ray, random);
  for (int given = 0; given < 2; ++given) (void)numbers.next();  // the ray may depend on these
  RGB passed(1.0f);
  for_majorants(medium, ray.origin, ray.direction, 0, length, [&](float at, float end, float majorant) {
    if (!(majorant > 0)) return true;
    for (;;) {
      at -= std::log1p(-numbers.next()) / majorant;
      if (!(at < end)) return true;
      const MediumPoint here = medium_point(medium, ray.origin + ray.direction * at);
      passed *= RGB(1.0f) - (here.sigma_a + here.sigma_s) / majorant;
      const float most = max_component(passed);
      if (!(most < kLeastTransmittance)) continue;
      const float survival = roulette(most, kLeastTransmittance, 1, [&] { return numbers.next(); });
      if (!(survival > 0)) {
        passed = RGB(0.0f);
        return false;
      }
      passed *= 1 / survival;
    }
  });
  return passed;
}

}  // namespace glowworm
