#include "scene/medium_emission.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/frame.h"
#include "core/parallel.h"
#include "core/warp.h"

namespace glowworm {

namespace {

/// Emission at a place across the box, W sr^-1 m^-3.
RGB emission_across(const Medium& medium, Vec3 at) {
  const MediumGrid::Point factors = medium.grid ? medium.grid->at(at) : MediumGrid::Point();
  return medium.emission * factors.emission * medium.sigma_a * factors.sigma_a;
}

Vec3 place_in(const Box3& box, Vec3 u) {
  const Vec3 size = box.diagonal();
  return box.min + Vec3{u.x * size.x, u.y * size.y, u.z * size.z};
}

float volume_of(const Box3& box) {
  const Vec3 size = box.diagonal();
  return size.x * size.y * size.z;
}

/// The mean emission of a block of a grid times its share of the box. Between the centres of eight cells, values are
/// interpolated with weights that are nowhere 0: the middle of each such part has all that emits there.
RGB emission_of_block(const Medium& medium, const Box3& block) {
  const std::array<int, 3>& size = medium.grid->values().size;
  std::array<int, 3> first{}, last{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto halves = 2 * static_cast<float>(size[axis]);
    first[axis] = static_cast<int>(std::lround(block.min[static_cast<int>(axis)] * halves));
    last[axis] = static_cast<int>(std::lround(block.max[static_cast<int>(axis)] * halves));
  }
  const auto middle = [&](std::size_t axis, int half) {
    return (static_cast<float>(half) + 0.5f) / (2 * static_cast<float>(size[axis]));
  };
  RGB sum;
  for (int z = first[2]; z < last[2]; ++z)
    for (int y = first[1]; y < last[1]; ++y)
      for (int x = first[0]; x < last[0]; ++x)
        sum += emission_across(medium, {middle(0, x), middle(1, y), middle(2, z)});
  const double halves = 8.0 * static_cast<double>(medium.grid->values().cell_count());
  return sum * static_cast<float>(1 / halves);
}

/// The rate at which light from far away falls off, m^-1: the least of the channels that emit. It is the effective
/// attenuation coefficient of diffusion theory (Ishimaru, "Wave Propagation and Scattering in Random Media", 1978,
/// chapter 9), or sigma_t if that is less.
float falloff(const Medium& medium) {
  float least = std::numeric_limits<float>::infinity();
  for (int c = 0; c < 3; ++c) {
    const float a = medium.sigma_a[c], s = medium.sigma_s[c];
    if (a > 0 && medium.emission[c] > 0) least = std::min({least, a + s, std::sqrt(3 * a * (a + s * (1 - medium.g)))});
  }
  return least;
}

/// The box of the surfaces that name a medium; of all surfaces if it is flat or the medium lies outside of it, as
/// behind the surface of water in a pool whose walls name no media.
Box3 region_of(std::uint32_t medium, const std::vector<Material>& materials, const Geometry& geometry) {
  Box3 box;
  bool is_inside = false;
  for (std::uint32_t t = 0; t < geometry.triangle_count(); ++t) {
    const Material& m = materials[geometry.material_of(t)];
    if (m.inside != medium && m.outside != medium) continue;
    is_inside |= m.inside == medium;
    for (const Vec3 corner : geometry.corners(t)) box.grow(corner);
  }
  return box.empty() || (is_inside && volume_of(box) > 0) ? box : geometry.bounds();
}

}  // namespace

MediumEmission::MediumEmission(std::uint32_t index, const Medium& medium, const Box3& region, bool endless)
    : medium_(index), box_(medium.bounds.value_or(region)) {
  if (medium.bounds) to_scene_ = inverse(medium.to_medium);
  volume_ = box_.empty() ? 0 : volume_of(box_) * std::abs(to_scene_.determinant());
  if (endless && !box_.empty()) {
    radius_ = 0.5f * length(box_.diagonal());
    fade_ = 2 / falloff(medium);
    volume_ = 4 * kPi / 3 * radius_ * radius_ * radius_;
  }
  std::vector<RGB> parts;  // mean emission of each block times its share of the box
  if (medium.grid) {
    const std::array<int, 3>& blocks = medium.grid->blocks();
    parts.resize(static_cast<std::size_t>(blocks[0] * blocks[1] * blocks[2]));
    parallel_for_each(parts.size(), 64, [&](std::size_t i) {
      parts[i] = emission_of_block(medium, block(medium, static_cast<std::uint32_t>(i)));
    });
  } else {
    parts.push_back(emission_across(medium, {}));
  }
  std::vector<float> weights;
  for (const RGB& part : parts) {
    power_ += part * (4 * kPi * volume_);
    weights.push_back(luminance(part));
  }
  blocks_ = Distribution1D(weights);
  // From beyond, the ball of an endless medium gets the radiance at which emission and absorption balance.
  for (int c = 0; c < 3; ++c)
    if (medium.sigma_a[c] > 0) power_[c] += medium.emission[c] * (4 * kPi * kPi * radius_ * radius_);
}

Box3 MediumEmission::block(const Medium& medium, std::uint32_t index) const {
  if (!medium.grid) return {{0, 0, 0}, {1, 1, 1}};
  const std::array<int, 3>&blocks = medium.grid->blocks(), &size = medium.grid->values().size;
  const auto i = static_cast<int>(index);
  const std::array<int, 3> place{i % blocks[0], i / blocks[0] % blocks[1], i / (blocks[0] * blocks[1])};
  Box3 out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int first = place[axis] * medium.grid->cells_per_block();
    const int last = std::min(first + medium.grid->cells_per_block(), size[axis]);
    out.min[static_cast<int>(axis)] = static_cast<float>(first) / static_cast<float>(size[axis]);
    out.max[static_cast<int>(axis)] = static_cast<float>(last) / static_cast<float>(size[axis]);
  }
  return out;
}

MediumEmission::Start MediumEmission::sample(const Medium& medium, Vec3 u, Vec2 u_direction) const {
  if (radius_ > 0) return sample_endless(medium, u, u_direction);
  const Distribution1D::Sample chosen = blocks_.sample(u.x);
  const Box3 part = block(medium, chosen.index);
  const Vec3 at = place_in(part, {chosen.remapped, u.y, u.z});
  return {to_scene_.point(place_in(box_, at)), square_to_sphere(u_direction),
          emission_across(medium, at) * (4 * kPi * volume_ * volume_of(part) / chosen.probability)};
}

MediumEmission::Start MediumEmission::sample_endless(const Medium& medium, Vec3 u, Vec2 u_direction) const {
  const bool inside = u.x < 0.5f;
  const float left = 2 * (1 - u.x);
  const float distance = inside ? radius_ * std::cbrt(2 * u.x) : radius_ - fade_ * std::log(left);
  const float volume = inside ? volume_ : 4 * kPi * distance * distance * fade_ / left;  // per place, m^3
  const Vec3 offset = square_to_sphere({u.y, u.z}) * distance;
  Start out{box_.center() + offset, square_to_sphere(u_direction),
            emission_across(medium, {}) * (2 * 4 * kPi * volume)};
  if (!inside) aim(out, offset, u_direction);
  return out;
}

void MediumEmission::aim(Start& start, Vec3 offset, Vec2 u) const {
  // The cone that the ball subtends has 1 - cos of its half angle, written so as not to cancel.
  const float sine2 = std::min(radius_ * radius_ / length_squared(offset), 1.0f);
  const float height = sine2 / (1 + std::sqrt(1 - sine2)), share = height / 2;  // of the sphere
  const bool aims = u.x < 0.5f;
  if (aims) {
    const float h = height * 2 * u.x, across = std::sqrt(h * (2 - h)), phi = 2 * kPi * u.y;
    start.direction =
        Frame::from_normal(-normalize(offset)).to_world({across * std::cos(phi), across * std::sin(phi), 1 - h});
  } else {
    start.direction = square_to_sphere({2 * u.x - 1, u.y});
  }
  const bool in_cone =
      aims || (dot(offset, start.direction) < 0 && length_squared(cross(offset, start.direction)) < radius_ * radius_);
  // The even density over that of both ways to choose the direction.
  start.flux *= in_cone ? 2 * share / (1 + share) : 2.0f;
}

std::vector<MediumEmission> find_emissive_media(const std::vector<Medium>& media,
                                                const std::vector<Material>& materials, const Geometry& geometry,
                                                std::uint32_t ambient) {
  std::vector<MediumEmission> out;
  for (std::uint32_t i = 0; i < media.size(); ++i) {
    const Medium& m = media[i];
    if (!emits(m)) continue;
    const bool endless = i == ambient && !m.bounds;
    const Box3 region = m.bounds ? Box3() : endless ? geometry.bounds() : region_of(i, materials, geometry);
    const MediumEmission emission(i, m, region, endless);
    if (!is_black(emission.power())) out.push_back(emission);
  }
  return out;
}

}  // namespace glowworm
