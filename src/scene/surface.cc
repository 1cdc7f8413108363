#include "scene/surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "core/random.h"
#include "scene/light_power.h"

namespace glowworm {

namespace {

std::uint32_t hash_point(std::uint32_t seed, Vec3 p) {
  seed = hash_combine(seed, std::bit_cast<std::uint32_t>(p.x));
  seed = hash_combine(seed, std::bit_cast<std::uint32_t>(p.y));
  return hash_combine(seed, std::bit_cast<std::uint32_t>(p.z));
}

/// Texture coordinates of the second and third vertex from the first.
std::pair<Vec2, Vec2> uv_edges(const StoredTriangle& stored) {
  const auto& [a, b, c] = stored.mesh->triangles[stored.index];
  const std::vector<Vec2>& uvs = stored.mesh->uvs;
  return {uvs[b] - uvs[a], uvs[c] - uvs[a]};
}

/// Derivatives of the position by the texture coordinates; `valid` is false if these do not span the triangle.
struct TextureTangents {
  Vec3 du, dv;
  bool valid = false;
};

TextureTangents texture_tangents(const Geometry& g, std::uint32_t triangle) {
  const StoredTriangle stored = g.stored(triangle);
  const auto [ab, ac] = uv_edges(stored);
  const float determinant = ab.x * ac.y - ab.y * ac.x;
  if (determinant == 0) return {};
  const auto [a, b, c] = Geometry::corners(stored);
  const Vec3 e1 = b - a, e2 = c - a;
  const float scale = 1 / determinant;
  TextureTangents out{(e1 * ac.y - e2 * ab.y) * scale, (e2 * ab.x - e1 * ac.x) * scale, true};
  out.valid = is_finite(out.du) && is_finite(out.dv);
  return out;
}

/// The frame around the unit vector n whose s is the component of `tangent` perpendicular to n; any frame if that is
/// zero.
Frame frame_along(Vec3 n, Vec3 tangent) {
  const Vec3 across = tangent - n * dot(n, tangent);
  const float squared = length_squared(across);
  if (!(squared > 1e-12f * length_squared(tangent)) || !std::isfinite(squared)) return Frame::from_normal(n);
  const Vec3 s = across / std::sqrt(squared);
  return {s, cross(n, s), n};
}

/// Gives the frame a new normal, with s close to the old one. Ignores a normal on the other geometric side.
void turn_to(SurfacePoint& point, Vec3 n) {
  const float squared = length_squared(n);
  if (!(squared > 0) || !std::isfinite(squared) || dot(n, point.geometric_normal) <= 0) return;
  point.frame = frame_along(n / std::sqrt(squared), point.frame.s);
}

/// 1, or -1 if texture coordinates are mirrored. Maps use it; the frame itself stays right-handed.
float handedness(const Scene& scene, const SurfacePoint& point) {
  const TextureTangents tangents = texture_tangents(scene.geometry(), point.triangle);
  return tangents.valid && dot(tangents.dv, point.frame.t) < 0 ? -1.0f : 1.0f;
}

/// The normal of a map in the world, not unit.
Vec3 mapped_normal(const Scene& scene, const ColorInput& map, float scale, const SurfacePoint& point) {
  const RGB c = evaluate(scene.textures(), map, point.texture);
  return point.frame.to_world({(2 * c.r - 1) * scale, (2 * c.g - 1) * scale * handedness(scene, point), 2 * c.b - 1});
}

/// The clearcoat's normal at a point before any map is applied.
Vec3 coat_normal(const Scene& scene, const Material& m, const SurfacePoint& point) {
  if (m.coat_normal_map.texture == kNone) return point.frame.n;
  const Vec3 n = mapped_normal(scene, m.coat_normal_map, m.coat_normal_scale, point);
  const float l = length(n);
  return l > 0 && std::isfinite(l) && dot(n, point.geometric_normal) > 0 ? n / l : point.frame.n;
}

/// Makes a lobe longer along a direction (KHR_materials_anisotropy), which becomes the frame's s.
void apply_anisotropy(const Scene& scene, const Material& m, SurfacePoint& point, Bsdf& bsdf) {
  const float strength = std::clamp(evaluate(scene.textures(), m.anisotropy, point.texture), 0.0f, 1.0f);
  if (!(strength > 0)) return;
  float x = std::cos(m.anisotropy_rotation), y = std::sin(m.anisotropy_rotation);
  if (m.anisotropy_direction.texture != kNone) {
    const RGB c = evaluate(scene.textures(), m.anisotropy_direction, point.texture);
    const float u = 2 * c.r - 1, v = 2 * c.g - 1, cosine = x, sine = y;
    x = cosine * u - sine * v;
    y = sine * u + cosine * v;
  }
  const Vec3 along = point.frame.s * x + point.frame.t * (y * handedness(scene, point));
  point.frame = frame_along(point.frame.n, along);
  bsdf.alpha_x += (1 - bsdf.alpha_x) * strength * strength;
}

/// Blinn, "Simulation of Wrinkled Surfaces", SIGGRAPH 1978, with forward differences in texture space.
void apply_bump(const Scene& scene, const Material& m, SurfacePoint& point) {
  const TextureTangents tangents = texture_tangents(scene.geometry(), point.triangle);
  if (!tangents.valid) return;
  constexpr float step = 0.0005f;
  const float here = evaluate(scene.textures(), m.bump, point.texture);
  const auto slope = [&](Vec2 by) {
    TexturePoint there = point.texture;
    there.uv = there.uv + by;
    return (evaluate(scene.textures(), m.bump, there) - here) / step;
  };
  const float by_u = slope({step, 0}), by_v = slope({0, step});
  const Vec3 n = point.frame.n;
  const Vec3 du = tangents.du - n * dot(n, tangents.du), dv = tangents.dv - n * dot(n, tangents.dv);
  turn_to(point, face_forward(cross(du + n * by_u, dv + n * by_v), n));
}

/// Interpolates the vertices' normals, on the side of the geometric one, which replaces a missing one.
Vec3 interpolated_normal(const Geometry& g, std::uint32_t triangle, Vec2 barycentric, Vec3 geometric_normal) {
  const auto [a, b, c] = g.corner_normals(triangle);
  const float u = barycentric.x, v = barycentric.y, w = 1 - u - v;
  const Vec3 n = a * w + b * u + c * v;
  const float squared = length_squared(n);
  return squared > 1e-12f ? face_forward(n / std::sqrt(squared), geometric_normal) : geometric_normal;
}

/// Follows mixed materials to an unmixed one, with a random number that depends on the position.
std::uint32_t unmixed(const Scene& scene, std::uint32_t material, const SurfacePoint& point) {
  while (scene.materials()[material].kind == MaterialKind::mix) {
    const Material& m = scene.materials()[material];
    const float amount = evaluate(scene.textures(), m.mix_amount, point.texture);
    material = to_unit_float(hash_point(material, point.position)) < amount ? m.mix_b : m.mix_a;
  }
  return material;
}

float unit(float x) { return std::clamp(x, 0.0f, 1.0f); }

/// The layers of metallic_roughness that few materials have.
void set_rare_layers(const std::vector<TextureNode>& textures, const Material& m, const TexturePoint& at, Bsdf& out) {
  out.dispersion = out.transmission_weight > 0 && !m.thin ? m.dispersion : 0;
  if (!is_black(m.sheen.value)) {
    const float roughness = unit(evaluate(textures, m.sheen_roughness, at));
    out.sheen = clamp(evaluate(textures, m.sheen, at), 0, 1);
    out.sheen_alpha = roughness * roughness;
  }
  if (m.iridescence.value > 0) {
    out.iridescence = unit(evaluate(textures, m.iridescence, at));
    out.film_eta = m.iridescence_ior;
    out.film_thickness = m.least_film + evaluate(textures, m.film, at);
  }
  if (m.diffuse_transmission.value > 0) {
    out.diffuse_transmission = unit(evaluate(textures, m.diffuse_transmission, at));
    out.transmission = clamp(evaluate(textures, m.transmittance, at), 0, 1);
  }
}

/// The layers of metallic_roughness, without its base colour and roughness.
void set_metallic_roughness(const std::vector<TextureNode>& textures, const Material& m, const TexturePoint& at,
                            Bsdf& out) {
  out.kind = BsdfKind::metallic_roughness;
  out.specular = evaluate(textures, m.specular_color, at);
  out.specular_weight = unit(evaluate(textures, m.specular, at));
  out.eta = RGB(m.ior);
  out.metallic = unit(evaluate(textures, m.metallic, at));
  out.transmission_weight = unit(evaluate(textures, m.transmission, at));
  out.coat = unit(evaluate(textures, m.clearcoat, at));
  out.coat_alpha = unit(evaluate(textures, m.coat_roughness, at));
  set_rare_layers(textures, m, at, out);
}

/// Puts a clear coat over the whole surface. @param alpha its roughness
void set_coat(const Material& m, float alpha, Bsdf& out) {
  out.coat = 1;
  out.coat_eta = m.ior;
  out.coat_alpha = alpha;
  out.coat_thickness = m.coat_thickness;
  out.coat_bounces = m.coat_bounces;
}

/// Evaluates the inputs of the material; `m` is not a mix.
Bsdf bsdf_of(const std::vector<TextureNode>& textures, const Material& m, const TexturePoint& at) {
  Bsdf out;
  const RGB reflectance = clamp(evaluate(textures, m.reflectance, at), 0, 1);
  if (m.kind == MaterialKind::diffuse) {
    out.diffuse = reflectance;
    out.transmission = clamp(evaluate(textures, m.transmittance, at), 0, 1);
    return out;
  }
  out.alpha_x = unit(evaluate(textures, m.roughness_u, at));
  out.alpha_y = unit(evaluate(textures, m.roughness_v, at));
  out.use_reflectance = m.use_reflectance;
  out.thin = m.thin;
  switch (m.kind) {
    case MaterialKind::conductor:
    case MaterialKind::coated_conductor:
      out.kind = m.kind == MaterialKind::conductor ? BsdfKind::conductor : BsdfKind::coated_conductor;
      out.eta = m.eta;
      out.k = m.k;
      out.specular = reflectance;
      if (m.kind == MaterialKind::coated_conductor) set_coat(m, unit(evaluate(textures, m.coat_roughness, at)), out);
      break;
    case MaterialKind::dielectric:
    case MaterialKind::thin_dielectric:
      out.kind = m.kind == MaterialKind::dielectric ? BsdfKind::dielectric : BsdfKind::thin_dielectric;
      out.eta = RGB(m.ior);
      out.specular = reflectance;
      out.transmission = clamp(evaluate(textures, m.transmittance, at), 0, 1);
      break;
    case MaterialKind::coated_diffuse:
      out.kind = BsdfKind::coated_diffuse;
      out.diffuse = reflectance;
      out.specular = RGB(1.0f);
      out.eta = RGB(m.ior);
      set_coat(m, std::sqrt(out.alpha_x * out.alpha_y), out);
      break;
    case MaterialKind::metallic_roughness:
      out.diffuse = reflectance;
      set_metallic_roughness(textures, m, at, out);
      break;
    case MaterialKind::interface:  // a pane of nothing
      out.kind = BsdfKind::thin_dielectric;
      out.eta = RGB(1.0f);
      out.specular = RGB(0.0f);
      out.transmission = RGB(1.0f);
      break;
    case MaterialKind::measured:
      out.kind = BsdfKind::measured;
      out.measured = m.measured.get();
      break;
    case MaterialKind::diffuse:
    case MaterialKind::mix:
      break;
  }
  return out;
}

/// What a present surface passes straight on: of mixed materials the mean, since the same ray may be asked for again.
RGB passed_where_present(const Scene& scene, SurfacePoint point, Vec3 direction) {
  const Material& m = scene.materials()[point.material];
  if (m.kind == MaterialKind::mix) {
    const float amount = unit(evaluate(scene.textures(), m.mix_amount, point.texture));
    const auto part = [&](std::uint32_t material) {
      SurfacePoint of_part = point;
      of_part.material = material;
      return passed_where_present(scene, of_part, direction);
    };
    return part(m.mix_a) * (1 - amount) + part(m.mix_b) * amount;
  }
  const Bsdf bsdf = resolve_bsdf(scene, point);
  return shaded(point, bsdf).straight_transmittance(-direction);
}

}  // namespace

SurfacePoint surface_point(const Scene& scene, std::uint32_t triangle, Vec2 barycentric) {
  const Geometry& g = scene.geometry();
  const float u = barycentric.x, v = barycentric.y;
  DiffuseTriangleRoom room;
  const DiffuseTriangle& placed = scene.diffuse_triangle(triangle, room);
  SurfacePoint point;
  point.position = placed.corner + placed.edge[0] * u + placed.edge[1] * v;
  point.geometric_normal = placed.normal;
  point.offset = placed.offset();
  point.texture = texture_point(g, triangle, barycentric);
  point.triangle = triangle;
  point.material = g.material_of(triangle);

  const Vec3 n = interpolated_normal(g, triangle, barycentric, point.geometric_normal);
  const auto [ab, ac] = uv_edges(g.stored(triangle));
  const float determinant = ab.x * ac.y - ab.y * ac.x;
  const Vec3 along_u = (placed.edge[0] * ac.y - placed.edge[1] * ab.y) * std::copysign(1.0f, determinant);
  point.frame = determinant == 0 ? Frame::from_normal(n) : frame_along(n, along_u);
  return point;
}

RGB diffuse_reflectance(const Scene& scene, std::uint32_t triangle, Vec2 barycentric) {
  const Geometry& g = scene.geometry();
  const Material& m = scene.materials()[g.material_of(triangle)];
  return clamp(evaluate(scene.textures(), m.reflectance, texture_point(g, triangle, barycentric)), 0, 1);
}

bool diffuse_shading_normal(const Scene& scene, std::uint32_t triangle, Vec2 barycentric, const DiffusePoint& point,
                            Vec3& normal) {
  DiffuseTriangleRoom room;
  const std::uint16_t kind = scene.diffuse_triangle(triangle, room).kind;
  normal = kind & DiffuseTriangle::kSmooth
               ? interpolated_normal(scene.geometry(), triangle, barycentric, point.geometric_normal)
               : point.geometric_normal;
  return !(kind & DiffuseTriangle::kMapped);
}

Bsdf resolve_bsdf(const Scene& scene, SurfacePoint& point) {
  if (scene.materials()[point.material].kind == MaterialKind::mix)
    point.material = unmixed(scene, point.material, point);
  const Material& m = scene.materials()[point.material];
  const bool has_maps = m.normal_map.texture != kNone || m.bump.texture != kNone;
  const bool has_coat = m.clearcoat.value > 0 && (has_maps || m.coat_normal_map.texture != kNone);
  const Vec3 of_coat = has_coat ? coat_normal(scene, m, point) : Vec3{0, 0, 1};
  if (m.normal_map.texture != kNone) turn_to(point, mapped_normal(scene, m.normal_map, m.normal_scale, point));
  if (m.bump.texture != kNone) apply_bump(scene, m, point);
  Bsdf bsdf = bsdf_of(scene.textures(), m, point.texture);
  if (m.anisotropy.value > 0) apply_anisotropy(scene, m, point, bsdf);
  if (m.kind == MaterialKind::measured) {
    // x of its space lies across up: to the right as seen from the front.
    const Vec3 n = point.frame.n, across = cross(m.measured_up, n);
    const bool stands = length_squared(across) > 1e-6f * length_squared(m.measured_up);
    point.frame = frame_along(n, stands ? across : cross(Vec3{0, 0, -1}, n));
  }
  if (has_coat && dot(of_coat, point.frame.n) < 0.99999f) bsdf.coat_normal = point.frame.to_local(of_coat);
  return bsdf;
}

RGB emitted_radiance(const Scene& scene, const SurfacePoint& point, Vec3 wo) {
  const std::uint32_t index = scene.geometry().emission_of(point.triangle);
  if (index == kNone) return RGB(0.0f);
  const Emission& emission = scene.emissions()[index];
  if (!emission.two_sided && dot(point.geometric_normal, wo) <= 0) return RGB(0.0f);
  return evaluate(scene.textures(), emission.radiance, point.texture) * relative_radiance(emission, wo);
}

RGB straight_transmittance(const Scene& scene, std::uint32_t triangle, Vec2 barycentric, Vec3 direction) {
  const SurfacePoint point = surface_point(scene, triangle, barycentric);
  const float present = coverage(scene, triangle, point.texture);
  return RGB(1 - present) + passed_where_present(scene, point, direction) * present;
}

float coverage(const Scene& scene, std::uint32_t triangle, const TexturePoint& at) {
  const std::uint32_t material = scene.geometry().material_of(triangle);
  if (!scene.has_alpha(material)) return 1;
  const Material& m = scene.materials()[material];
  const float alpha = evaluate(scene.textures(), m.alpha, at);
  if (m.alpha_cutoff >= 0) return alpha >= m.alpha_cutoff ? 1.0f : 0.0f;
  return alpha > 0 ? std::min(alpha, 1.0f) : 0.0f;
}

bool is_present(float coverage, std::uint32_t triangle, Vec3 ray_origin, Vec3 ray_direction) {
  if (coverage == 0 || coverage == 1) return coverage == 1;
  return to_unit_float(hash_point(hash_point(hash32(triangle), ray_origin), ray_direction)) < coverage;
}

}  // namespace glowworm
