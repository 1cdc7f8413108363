#include "maps/medium_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "bsdf/measured.h"
#include "core/box.h"
#include "core/frame.h"
#include "core/parallel.h"
#include "core/random.h"
#include "scene/placed_box.h"
#include "transport/medium.h"
#include "transport/step.h"

namespace glowworm {

namespace {

/// Rays for each kernel.
constexpr std::size_t kRaysOfKernel = 8;

bool passes_any(const ColorInput& input) { return input.texture != kNone || !is_black(input.value); }
bool passes_any(const FloatInput& input) { return input.texture != kNone || input.value > 0; }

/// Whether light passes surfaces of a material.
bool is_passed(const std::vector<Material>& materials, const Material& m) {
  switch (m.kind) {
    case MaterialKind::dielectric:
    case MaterialKind::thin_dielectric:
    case MaterialKind::interface:
      return true;
    case MaterialKind::diffuse:
      return passes_any(m.transmittance);
    case MaterialKind::metallic_roughness:
      return passes_any(m.transmission) || passes_any(m.diffuse_transmission);
    case MaterialKind::mix:
      return is_passed(materials, materials[m.mix_a]) || is_passed(materials, materials[m.mix_b]);
    case MaterialKind::measured:
      return !m.measured->is_black(true);
    case MaterialKind::conductor:
    case MaterialKind::coated_diffuse:
    case MaterialKind::coated_conductor:
      return false;
  }
  return false;
}

/// The kernel's integral from the beam to a distance, which is given as a fraction of the radius.
float share_within(float distance) {
  const float u = std::min(distance * distance, 1.0f);
  return u * (2 - u);
}

/// Whether all of a ball lies within the bounds of a medium.
bool is_within_bounds(const Medium& medium, Vec3 center, float radius) {
  if (!medium.bounds) return true;
  const Vec3 reach{radius, radius, radius};
  const Box3 box = placed_box(medium.to_medium, {center - reach, center + reach});
  return medium.bounds->contains(box.min) && medium.bounds->contains(box.max);
}

/// Rays from the middle of a kernel to its end.
using KernelRays = std::array<Ray, kRaysOfKernel>;

/// Two random numbers of a kernel.
Vec2 kernel_numbers(std::size_t kernel) {
  const std::uint32_t key = hash_combine(kBoundaryStream, static_cast<std::uint32_t>(kernel));
  return {to_unit_float(hash32(key)), to_unit_float(hash_combine(key, 1))};
}

/// Angles that are stratified; neighbouring places have angles far apart.
float kernel_angle(std::size_t ray, float turn) {
  return 2 * kPi * (static_cast<float>(3 * ray % kRaysOfKernel) + turn) / kRaysOfKernel;
}

/// The photons as balls. A segment meets the disc across it, and discs of all directions fill the ball.
class Balls {
 public:
  Balls(const VolumePhotons& photons, const PhotonKernels& kernels, float scale)
      : photons_(photons), kernels_(kernels), scale_(scale) {}
  std::size_t size() const { return photons_.size(); }
  std::uint32_t medium(std::size_t i) const { return photons_.medium[i]; }
  Vec3 middle(std::size_t i) const { return photons_.position[i]; }
  float reach(std::size_t i) const { return kernels_.radii[i] * scale_; }
  bool counts(std::size_t i) const { return is_finite(middle(i)); }
  KernelRays rays(std::size_t i) const {
    const Vec2 random = kernel_numbers(i);
    KernelRays out;
    for (std::size_t n = 0; n < kRaysOfKernel; ++n) {
      const float z = 1 - 2 * (static_cast<float>(n) + random.y) / kRaysOfKernel, angle = kernel_angle(n, random.x);
      const float across = std::sqrt(std::max(1 - z * z, 0.0f));
      out[n] = {middle(i), 0, {across * std::cos(angle), across * std::sin(angle), z}, reach(i)};
    }
    return out;
  }

 private:
  const VolumePhotons& photons_;
  const PhotonKernels& kernels_;
  const float scale_;
};

/// The pieces of all beams as tubes.
class Tubes {
 public:
  Tubes(const VolumeBeams& beams, const BeamPieces& pieces, float scale)
      : beams_(beams), pieces_(pieces), scale_(scale), beam_(pieces.radii.size()) {
    parallel_for_each(beams.size(), even_grain(beams.size()), [&](std::size_t i) {
      std::fill(beam_.begin() + pieces.first[i], beam_.begin() + pieces.first[i + 1], static_cast<std::uint32_t>(i));
    });
  }
  std::size_t size() const { return beam_.size(); }
  std::uint32_t medium(std::size_t piece) const { return beams_.medium[beam_[piece]]; }
  bool counts(std::size_t piece) const { return is_finite(middle(piece)) && length(piece) > 0; }
  KernelRays rays(std::size_t piece) const {
    const Frame frame = Frame::from_normal(beams_.direction[beam_[piece]]);
    const Vec2 random = kernel_numbers(piece);
    KernelRays out;
    for (std::size_t n = 0; n < kRaysOfKernel; ++n) {
      const float angle = kernel_angle(n, random.x);
      const float at = length(piece) * (static_cast<float>(n) + random.y) / kRaysOfKernel;
      out[n] = {place(piece, at), 0, frame.s * std::cos(angle) + frame.t * std::sin(angle), radius(piece)};
    }
    return out;
  }
  float radius(std::size_t piece) const { return pieces_.radii[piece] * scale_; }
  float begin(std::size_t piece) const { return pieces_.begin(beam_[piece], piece); }
  float length(std::size_t piece) const { return pieces_.end[piece] - begin(piece); }
  Vec3 place(std::size_t piece, float distance) const {
    return beams_.origin[beam_[piece]] + beams_.direction[beam_[piece]] * (begin(piece) + distance);
  }
  Vec3 middle(std::size_t piece) const { return place(piece, 0.5f * length(piece)); }
  /// Of the ball around the tube.
  float reach(std::size_t piece) const { return std::hypot(radius(piece), 0.5f * length(piece)); }

 private:
  const VolumeBeams& beams_;
  const BeamPieces& pieces_;
  const float scale_;
  LargeArray<std::uint32_t> beam_;  // of each piece
};

/// The parts of a kernel's ray that lie in its medium.
struct RayParts {
  float radius = 0;
  std::vector<MediumSpan> parts;
  Vec3 wall{0, 0, 0};  ///< PhotonKernels::walls, where the ray leaves the medium first; 0 if it does not

  /// The share of the kernel along the ray that lies in the medium, up to a distance.
  float share(float limit) const {
    float sum = 0;
    for (const MediumSpan& part : parts)
      if (part.first < limit)
        sum += share_within(std::min(part.last, limit) / radius) - share_within(part.first / radius);
    return sum;
  }
};
using KernelParts = std::array<RayParts, kRaysOfKernel>;

/// Follows the rays of kernels through their media.
class MediumParts {
 public:
  explicit MediumParts(const Tracer& tracer) : tracer_(tracer), scene_(tracer.scene()) {
    // Surfaces that name media say what is behind them.
    for (const Material& m : scene_.materials())
      passed_.push_back(is_passed(scene_.materials(), m) || m.inside != kUnnamed || m.outside != kUnnamed);
  }

  void find(const KernelRays& rays, std::uint32_t medium, KernelParts& out) const {
    std::array<Hit, kRaysOfKernel> hits;
    tracer_.intersect(rays, hits, RayOrder::incoherent);
    for (std::size_t i = 0; i < kRaysOfKernel; ++i) follow(rays[i], hits[i], medium, out[i]);
  }

 private:
  /// @param hit the first
  void follow(const Ray& whole, Hit hit, std::uint32_t index, RayParts& out) const {
    const Medium& medium = scene_.media()[index];
    const float radius = whole.t_max;
    const MediumSpan bounds = span_in(medium, whole.origin, whole.direction, 0, radius);
    out = {radius, {}, {0, 0, 0}};
    PathState path;
    path.ray = whole;
    path.medium = {index, true};
    bool in_body = false, is_in = true;
    float from = 0;
    for (;;) {
      const float to = hit.triangle == kNone ? radius : from + hit.distance;
      const MediumSpan part{std::max(from, bounds.first), std::min(to, bounds.last)};
      if (is_in && !part.empty()) out.parts.push_back(part);
      if (is_in && bounds.last < to) set_wall(whole.direction, bounds.last, bound_normal(medium, whole), out);
      if (hit.triangle == kNone) return;
      const PathMedium before = path.medium;
      const Vec3 normal = scene_.geometry().normal(hit.triangle);
      pass_interface(scene_, path, hit);
      if (!passed_[scene_.geometry().material_of(hit.triangle)]) {
        path.medium = before;
        in_body = !in_body;
      }
      is_in = !in_body && path.medium.index == index;
      if (!is_in) set_wall(whole.direction, to, normal, out);
      path.ray.t_max = radius - to;
      if (!(path.ray.t_max > 0)) return;
      from = to;
      hit = tracer_.intersect(path.ray);
    }
  }

  /// Remembers the first tangent plane.
  static void set_wall(Vec3 direction, float distance, Vec3 normal, RayParts& out) {
    // Nearer planes cut all discs in half, too.
    constexpr float kLeastDistance = 1e-3f;
    if (dot(out.wall, out.wall) > 0) return;
    const float cosine = dot(normal, direction),
                away = std::max(std::abs(cosine) * distance, kLeastDistance * out.radius);
    out.wall = normal * (std::copysign(1.0f, cosine) / away);
  }

  /// Of the side by which a ray leaves the box of a medium.
  static Vec3 bound_normal(const Medium& medium, const Ray& ray) {
    const Transform& map = medium.to_medium;
    const Vec3 from = map.point(ray.origin), along = map.vector(ray.direction);
    int side = 0;
    float nearest = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (along[axis] == 0) continue;
      const float end = along[axis] > 0 ? medium.bounds->max[axis] : medium.bounds->min[axis];
      const float distance = (end - from[axis]) / along[axis];
      if (distance < nearest) {
        nearest = distance;
        side = axis;
      }
    }
    return normalize({map.x[side], map.y[side], map.z[side]});
  }

  const Tracer& tracer_;
  const Scene& scene_;
  std::vector<bool> passed_;  // of each material
};

using Walls = std::array<Vec3, kWallsOfKernel>;

/// The part of a ray before planes, metres; may be infinite.
float distance_to(const Walls& walls, Vec3 direction) {
  float slope = 0;
  for (const Vec3 wall : walls) slope = std::max(slope, dot(wall, direction));
  return slope > 0 ? 1 / slope : std::numeric_limits<float>::infinity();
}

/// The planes among those of the rays before which the medium lies, one after the other. A plane that leaves space
/// outside the medium adds light behind walls. What a plane cuts off of the medium is only folded back. So the first
/// error counts kRaysOfKernel times as much.
Walls best_walls(const KernelRays& rays, const KernelParts& parts) {
  Walls best{};
  float least = std::numeric_limits<float>::infinity();
  const auto try_walls = [&](const Walls& walls) {
    float leaks = 0, hides = 0;
    for (std::size_t i = 0; i < kRaysOfKernel; ++i) {
      const float radius = parts[i].radius, limit = distance_to(walls, rays[i].direction);
      const float there = parts[i].share(limit);
      leaks += share_within(limit / radius) - there;
      hides += parts[i].share(radius) - there;
    }
    const float wrong = kRaysOfKernel * leaks + hides;
    if (!(wrong < least)) return;
    least = wrong;
    best = walls;
  };
  try_walls(best);
  for (std::size_t i = 0; i < kWallsOfKernel; ++i) {
    Walls walls = best;
    for (const RayParts& ray : parts) {
      walls[i] = ray.wall;
      try_walls(walls);
    }
  }
  return best;
}

/// One over the share of the kernel before planes that lies in the medium, at most one over kLeastShare.
float factor_before(const Walls& walls, const KernelRays& rays, const KernelParts& parts) {
  float whole = 0, there = 0;
  for (std::size_t i = 0; i < kRaysOfKernel; ++i) {
    const float limit = distance_to(walls, rays[i].direction);
    whole += share_within(limit / parts[i].radius);
    there += parts[i].share(limit);
  }
  return whole / std::max(there, whole / kRaysOfKernel);
}

/// Calls correct(kernel, rays, parts) for each kernel that a boundary may cut.
template <class Kernels, class Correct>
void for_cut_kernels(const Tracer& tracer, const Kernels& kernels, const Correct& correct) {
  const MediumParts in_medium(tracer);
  parallel_for(0, kernels.size(), even_grain(kernels.size()), [&](std::size_t first, std::size_t last) {
    KernelParts parts;
    for (std::size_t i = first; i < last; ++i) {
      if (!kernels.counts(i)) continue;
      const Vec3 middle = kernels.middle(i);
      const std::uint32_t medium = kernels.medium(i);
      const float reach = kernels.reach(i);
      bool is_near = !is_within_bounds(tracer.scene().media()[medium], middle, reach);
      if (!is_near)
        tracer.visit_near(middle, reach, [&](std::uint32_t) {
          is_near = true;
          return false;
        });
      if (!is_near) continue;
      const KernelRays rays = kernels.rays(i);
      in_medium.find(rays, medium, parts);
      correct(i, rays, parts);
    }
  });
}

}  // namespace

void correct_pieces(const Tracer& tracer, const VolumeBeams& beams, float scale, BeamPieces& pieces) {
  pieces.factor.assign(pieces.radii.size(), 1.0f);
  for_cut_kernels(tracer, Tubes(beams, pieces, scale),
                  [&](std::size_t i, const KernelRays& rays, const KernelParts& parts) {
                    pieces.factor[i] = factor_before(Walls{}, rays, parts);
                  });
}

void correct_photons(const Tracer& tracer, float scale, VolumePhotons& photons, PhotonKernels& kernels) {
  for_cut_kernels(tracer, Balls(photons, kernels, scale),
                  [&](std::size_t i, const KernelRays& rays, const KernelParts& parts) {
                    kernels.walls[i] = best_walls(rays, parts);
                    photons.flux[i] *= factor_before(kernels.walls[i], rays, parts);
                  });
}

}  // namespace glowworm
