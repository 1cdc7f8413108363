#include "bsdf/component.h"

#include "bsdf/fresnel.h"
#include "bsdf/measured.h"
#include "core/warp.h"

namespace glowworm::bsdf_detail {
namespace {

float reflection_pdf(const Microfacet& m, Vec3 wo, Vec3 wi) {
  const Vec3 h = reflection_half(wo, wi);
  const float o = dot(wo, h);
  return o > 0 ? m.visible_normal_pdf(wo, h) / (4 * o) : 0.0f;
}

/// The direction under the boundary for one above it, mirrored back to z > 0.
Vec3 under_boundary(Vec3 w, float eta) {
  const float x = w.x / eta, y = w.y / eta;
  return {x, y, std::sqrt(std::max(0.0f, 1 - x * x - y * y))};
}

/// Walter et al. 2007, eq. 17 for the Jacobian.
float refraction_pdf(const Component& c, Vec3 wo, Vec3 wi, Vec3 h) {
  const float o = dot(wo, h), i = dot(wi, h), denominator = c.eta * i + o;
  if (denominator == 0) return 0;
  return c.microfacet.visible_normal_pdf(wo, h) * c.eta * c.eta * std::abs(i) / (denominator * denominator);
}

/// Probability of reflection at a facet, for the cosine of wo there.
float reflection_probability(const Component& c, float cosine) {
  const float f = fresnel_dielectric(cosine, c.eta);
  const float r = f * c.reflect, t = (1 - f) * c.transmit;
  return r + t > 0 ? r / (r + t) : 1.0f;
}

float measured_pdf(const Component& c, Vec3 wo, Vec3 wi) {
  const bool passes = c.shape == Shape::measured_transmission;
  if ((wi.z < 0) != passes) return 0;
  const float albedo = c.measured->albedo(c.inside, passes, wo);
  return albedo > 0 ? c.measured->evaluate(c.inside, passes, wo, wi) * std::abs(wi.z) / albedo : 0;
}

bool sample_measured(const Component& c, Vec3 wo, Vec2 u, Vec3& wi) {
  const bool passes = c.shape == Shape::measured_transmission;
  wi = c.measured->sample(c.inside, passes, wo, u);
  if (passes) wi.z = -wi.z;
  return wi.z != 0;
}

}  // namespace

float component_pdf(const Component& c, Vec3 wo, Vec3 wi) {
  switch (c.shape) {
    case Shape::cosine_reflection:
      return cosine_hemisphere_pdf(wi.z);
    case Shape::cosine_transmission:
      return cosine_hemisphere_pdf(-wi.z);
    case Shape::uniform_reflection:
      return wi.z > 0 ? kInversePi / 2 : 0.0f;
    case Shape::rough_reflection: {
      const Vec3 o = about_normal(c, wo), i = about_normal(c, wi);
      return wi.z > 0 && o.z > 0 && i.z > 0 ? reflection_pdf(c.microfacet, o, i) : 0.0f;
    }
    case Shape::coated_reflection: {
      if (wi.z <= 0) return 0;
      // dw' / dw = cos / (eta^2 cos'), from Snell's law.
      const Vec3 o = under_boundary(wo, c.eta), i = under_boundary(wi, c.eta);
      return reflection_pdf(c.microfacet, o, i) * wi.z / (c.eta * c.eta * i.z);
    }
    case Shape::rough_straight:
      return wi.z < 0 ? reflection_pdf(c.microfacet, wo, {wi.x, wi.y, -wi.z}) : 0.0f;
    case Shape::rough_refraction: {
      if (wi.z >= 0) return 0;
      const Vec3 h = refraction_half(wo, wi, c.eta);
      return h.z > 0 ? refraction_pdf(c, wo, wi, h) : 0.0f;
    }
    case Shape::rough_dielectric: {
      if (wi.z > 0) {
        const float o = dot(wo, reflection_half(wo, wi));
        return reflection_pdf(c.microfacet, wo, wi) * reflection_probability(c, o);
      }
      if (wi.z == 0) return 0;
      const Vec3 h = refraction_half(wo, wi, c.eta);
      return h.z > 0 ? refraction_pdf(c, wo, wi, h) * (1 - reflection_probability(c, dot(wo, h))) : 0.0f;
    }
    case Shape::measured_reflection:
    case Shape::measured_transmission:
      return measured_pdf(c, wo, wi);
    case Shape::mirror:
    case Shape::refraction:
    case Shape::straight:
      break;
  }
  return 0;
}

bool component_sample(const Component& c, Vec3 wo, float u_side, Vec2 u, Vec3& wi) {
  switch (c.shape) {
    case Shape::cosine_reflection:
      wi = square_to_cosine_hemisphere(u);
      return wi.z > 0;
    case Shape::cosine_transmission:
      wi = -square_to_cosine_hemisphere(u);
      return wi.z < 0;
    case Shape::uniform_reflection: {
      const float z = 1 - u.x, r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * kPi * u.y;
      wi = {r * std::cos(phi), r * std::sin(phi), z};
      return wi.z > 0;
    }
    case Shape::rough_reflection: {
      const Vec3 o = about_normal(c, wo);
      if (o.z <= 0) return false;
      wi = normalize(reflect(o, c.microfacet.sample_visible_normal(o, u)));
      if (wi.z <= 0) return false;
      if (c.normal.z != 1) wi = Frame::from_normal(c.normal).to_world(wi);
      return wi.z > 0;
    }
    case Shape::coated_reflection: {
      const Vec3 o = under_boundary(wo, c.eta);
      const Vec3 i = normalize(reflect(o, c.microfacet.sample_visible_normal(o, u)));
      if (i.z <= 0) return false;
      const float x = i.x * c.eta, y = i.y * c.eta, z2 = 1 - x * x - y * y;
      if (z2 <= 0) return false;  // reflected back inside by the boundary
      wi = normalize({x, y, std::sqrt(z2)});
      return wi.z > 0;
    }
    case Shape::rough_straight:
      wi = normalize(reflect(wo, c.microfacet.sample_visible_normal(wo, u)));
      wi.z = -wi.z;
      return wi.z < 0;
    case Shape::rough_refraction:
      return refract(wo, c.microfacet.sample_visible_normal(wo, u), c.eta, wi) && wi.z < 0;
    case Shape::rough_dielectric: {
      const Vec3 h = c.microfacet.sample_visible_normal(wo, u);
      if (u_side < reflection_probability(c, dot(wo, h))) {
        wi = normalize(reflect(wo, h));
        return wi.z > 0;
      }
      return refract(wo, h, c.eta, wi) && wi.z < 0;
    }
    case Shape::measured_reflection:
    case Shape::measured_transmission:
      return sample_measured(c, wo, u, wi);
    case Shape::mirror:
      wi = c.normal.z == 1 ? Vec3{-wo.x, -wo.y, wo.z} : normalize(reflect(wo, c.normal));
      return wi.z > 0;
    case Shape::straight:
      wi = -wo;
      return true;
    case Shape::refraction:
      return refract(wo, {0, 0, 1}, c.eta, wi) && wi.z < 0;
  }
  return false;
}

}  // namespace glowworm::bsdf_detail
