#include "photon/photon_bounce.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/shading_light.h"
#include "core/warp.h"
#include "photon/material_lobes.h"
#include "scene/surface.h"
#include "transport/light_images.h"
#include "transport/step.h"

namespace glowworm {

namespace {

/// The random numbers of a bounce.
struct BounceNumbers {
  float lobe, roulette;
  Vec2 direction;
};

/// Plays Russian roulette. @param next flux before that, W
void survive_bounce(const LightPath& path, RGB next, float u, PhotonBounce& out) {
  const float kept = max_component(next) / std::max(max_component(path.throughput), 1e-30f);
  const float probability = roulette(kept, kLeastOfPhotons, 1, [u] { return u; });
  out.goes_on = probability > 0;
  if (out.goes_on) out.flux = next / probability;
}

/// Scatters a path that has hit a surface which only reflects diffusely and has no map of normals, as most have.
/// Returns false for others.
bool scatter_diffuse(const Scene& scene, const PhotonPassSettings& pass, const LightPath& path, const Hit& hit,
                     const BounceNumbers& u, PhotonBounce& out) {
  DiffuseTriangleRoom room;
  const DiffuseTriangle& triangle = scene.diffuse_triangle(hit.triangle, room);
  DiffusePoint point;
  Vec3 shading;
  if (!diffuse_point(scene, hit.triangle, hit.barycentric, point) ||
      !diffuse_shading_normal(scene, hit.triangle, hit.barycentric, point, shading))
    return false;
  const float geometric = dot(point.geometric_normal, out.back), along = dot(shading, out.back);
  const float factor =
      arrival_factor(geometric < 0 ? -along : along, std::abs(geometric), dot(shading, point.geometric_normal));
  out.position = point.position;
  out.normal = face_forward(point.geometric_normal, out.back);
  out.photon_flux = path.throughput * factor;
  // Estimates around a black texel reach over it.
  const bool may_reflect =
      pass.on_all_surfaces || (triangle.kind & DiffuseTriangle::kTextured) || !is_black(point.reflectance);
  out.leaves_photon = factor > 0 && may_reflect;
  const Vec3 local = square_to_cosine_hemisphere(u.direction);
  if (!out.leaves_photon || !(local.z > 0)) return true;
  survive_bounce(path, path.throughput * point.reflectance * factor, u.roulette, out);
  out.next = leave_surface(out.position, out.normal, triangle.offset(), Frame::from_normal(out.normal).to_world(local),
                           path.ray.time);
  return true;
}

/// Where a lamp that seemed to be at `image` seems to be after a sharp bounce, metres. @param direction of the bounce
Vec3 image_behind(Vec3 image, const PhotonBounce& bounce, Vec3 direction) {
  if (dot(direction, bounce.normal) < 0) return Vec3{std::numeric_limits<float>::infinity(), 0, 0};
  return bounce.position - direction * length(bounce.position - image);
}

/// Scatters a path with any BSDF.
void scatter_any(const Scene& scene, const PhotonPassSettings& pass, LightPath& path, const Hit& hit, BounceNumbers u,
                 PhotonBounce& out) {
  const Vec3 back = out.back;
  Vertex vertex = vertex_at(scene, path.ray, hit);
  RGB arriving = path.throughput;
  resolve_material(scene, vertex, arriving, [&] {
    // The wavelength takes a share of the number that chooses the lobe: its digits beyond the third.
    const float thousand = u.lobe * 1024;
    return thousand - std::floor(thousand);
  });
  const ShadedSurface surface = vertex.surface();
  const ArrivedPhoton arrived = surface.arrive(back, u.lobe);
  if (!(arrived.factor > 0)) return;
  out.position = vertex.point.position;
  out.normal = vertex.normal();
  out.back = arrived.back;
  out.photon_flux = arriving * arrived.factor;
  // Estimates reach over all points of a material, also those without a broad lobe: their photons are stored where
  // other points may have one.
  out.leaves_photon = pass.on_all_surfaces || vertex.has(kBroad) ||
                      may_have_lobes(scene, vertex.point, scene.geometry().material_of(hit.triangle), kBroad);
  const ScatteredRay s = surface.scatter_photon(arrived.back, u.lobe, u.direction, u.roulette);
  if (s.lobe == kSpecular)
    out.bits = s.is_null && arrived.back == back ? kNoneBroad : s.delta ? kCaustic : kCaustic | kRoughFirst;
  if (!s.valid) return;
  if (pass.discs && pass.choice != PhotonChoice::all && s.lobe == kSpecular) {
    if (!is_smooth(scene, hit.triangle, vertex)) out.bits |= kNotSmooth;
    if (!s.is_null) path.image = image_behind(path.image, out, s.direction);
  }
  survive_bounce(path, out.photon_flux * s.weight, u.roulette, out);
  out.next = leave_surface(vertex.point.position, s.side, vertex.point.offset, s.direction, vertex.time);
}

/// Ends some paths by the length that they reach.
void end_if_long(const PhotonPassSettings& pass, const LightPath& path, int bounces, PhotonBounce& out) {
  const float probability = survival_by_length(bounces);
  if (probability >= 1) return;
  const std::uint32_t key =
      Sampler::pair_key(pass.seed, hash_combine(kPhotonEndStream, pass.pass), static_cast<std::uint32_t>(bounces));
  out.goes_on = to_unit_float(hash_combine(key, path.number)) < probability;
  out.flux = out.flux / probability;
}

}  // namespace

PhotonBounce scatter_photon(const Scene& scene, const PhotonPassSettings& pass, LightPath& path, const Hit& hit,
                            int bounce) {
  PhotonBounce out;
  out.back = -path.ray.direction;
  const Vec2 choice = path.sampler.next2();
  const BounceNumbers u{choice.x, choice.y, path.sampler.next2()};
  if (!scatter_diffuse(scene, pass, path, hit, u, out)) scatter_any(scene, pass, path, hit, u, out);
  if (out.goes_on) end_if_long(pass, path, bounce + 1, out);
  return out;
}

}  // namespace glowworm
