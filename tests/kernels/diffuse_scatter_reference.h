#pragma once
#include "core/frame.h"
#include "core/offset_origin.h"
#include "core/rgb.h"
#include "core/shading_light.h"
#include "core/warp.h"
#include "kernels/diffuse_scatter.h"

namespace glowworm {

namespace {

Vec3 vector_at(const float* const* arrays, std::size_t i) { return {arrays[0][i], arrays[1][i], arrays[2][i]}; }
RGB color_at(const float* const* arrays, std::size_t i) { return {arrays[0][i], arrays[1][i], arrays[2][i]}; }
void put(float* const* arrays, std::size_t i, Vec3 v) {
  for (int axis = 0; axis < 3; ++axis) arrays[axis][i] = v[axis];
}
void put(float* const* arrays, std::size_t i, RGB c) {
  for (int channel = 0; channel < 3; ++channel) arrays[channel][i] = c[channel];
}

/// Where a path arrived.
struct Place {
  Vec3 position, geometric, shading;
};

Place place_of(const ArrivedPaths& in, std::size_t i) {
  const float u = in.barycentric[0][i], v = in.barycentric[1][i], w = 1 - u - v;
  Place place;
  place.position = vector_at(in.corner, i) + vector_at(in.edges, i) * u + vector_at(in.edges + 3, i) * v;
  place.geometric = vector_at(in.geometric, i);
  const Vec3 n = vector_at(in.vertex_normals, i) * w + vector_at(in.vertex_normals + 3, i) * u +
                 vector_at(in.vertex_normals + 6, i) * v;
  const float squared = length_squared(n);
  place.shading = squared > 1e-12f ? face_forward(n / std::sqrt(squared), place.geometric) : place.geometric;
  return place;
}

std::uint32_t scatter(const ArrivedPaths& in, const ScatteredPaths& out, std::size_t i) {
  put(out.flux, i, RGB(0.0f));
  const RGB reflectance = color_at(in.reflectance, i), flux = color_at(in.flux, i);
  if (is_black(reflectance)) return 0;
  const Place place = place_of(in, i);
  const Vec3 back = vector_at(in.back, i);
  const float geometric_in = dot(place.geometric, back), shading_in = dot(place.shading, back);
  const float factor = arrival_factor(geometric_in < 0 ? -shading_in : shading_in, std::abs(geometric_in),
                                      dot(place.shading, place.geometric));
  if (!(factor > 0)) return 0;
  const Vec3 n = face_forward(place.geometric, back);
  put(out.position, i, place.position);
  put(out.normal, i, n);
  put(out.photon_flux, i, flux * factor);

  const Vec3 local = square_to_cosine_hemisphere({in.square[0][i], in.square[1][i]});
  const Vec3 direction = Frame::from_normal(n).to_world(local);
  const RGB next = flux * reflectance * factor;
  const float survival = std::min(1.0f, max_component(next) / std::max(max_component(flux), 1e-30f));
  if (!(local.z > 0) || !(survival > 0) || in.roulette[i] >= survival) return kPhotonLeft;
  put(out.flux, i, next / survival);
  put(out.origin, i, offset_origin(place.position, n, in.offset[i]));
  put(out.direction, i, direction);
  return kPhotonLeft | kPathGoesOn;
}

}  // namespace

/// diffuse_scatter() as a plain loop over core/vec.h and core/warp.h, bit for bit.
inline void diffuse_scatter_reference(const ArrivedPaths& arrived, const ScatteredPaths& scattered) {
  for (std::size_t i = 0; i < arrived.count; ++i) scattered.outcome[i] = scatter(arrived, scattered, i);
}

}  // namespace glowworm
