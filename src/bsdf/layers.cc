#include "bsdf/layers.h"

#include <array>

namespace glowworm::bsdf_detail {
namespace {

float square(float x) { return x * x; }

/// min(1, n.w / z) of a coat of normal n.
float seen_share(Vec3 about_coat, Vec3 w) { return std::min(1.0f, about_coat.z / w.z); }

/// The share of light from `about`, relative to the normal of a coat, that the surface does not hide where it leaves.
/// @param normal the surface's, relative to the coat's
float unhidden(Vec3 about, Vec3 facet, Vec3 normal) {
  const Vec3 wi = reflect(about, facet);
  return wi.z > 0 ? std::clamp(dot(wi, normal) / wi.z, 0.0f, 1.0f) : 0.0f;
}

/// Calls f(facet, energy) for some facets, evenly spread among those that are seen from `o`, and what they reflect.
template <class F>
void for_some_facets(const Microfacet& m, Vec3 o, F f) {
  constexpr Vec2 kPoints[8] = {{0.0625f, 0.05f}, {0.5625f, 0.15f}, {0.3125f, 0.27f}, {0.8125f, 0.39f},
                               {0.1875f, 0.52f}, {0.6875f, 0.66f}, {0.4375f, 0.8f},  {0.9375f, 0.93f}};
  const float to = 1 + m.lambda(o);
  for (const Vec2 u : kPoints) {
    const Vec3 h = m.sample_visible_normal(o, u), wi = reflect(o, h);
    if (wi.z > 0) f(h, to / (to + m.lambda(wi)));
  }
}

/// Of diffuse light, what a coat of another normal reflects: Schlick's f0 * first + f90 * second.
struct TiltedMean {
  float f0 = 0, f90 = 0;
};
TiltedMean operator*(TiltedMean a, float x) { return {a.f0 * x, a.f90 * x}; }
TiltedMean operator+(TiltedMean a, TiltedMean b) { return {a.f0 + b.f0, a.f90 + b.f90}; }

/// @param normal cosine between the normals; @param alpha 0: smooth
TiltedMean integrate_tilted(float normal, float alpha) {
  const Frame frame = Frame::from_normal({std::sqrt(std::max(0.0f, 1 - normal * normal)), 0, normal});
  const Vec3 up = frame.to_local({0, 0, 1});
  TiltedMean sum;
  constexpr int kSteps = 24;
  for (int s = 0; s < kSteps * kSteps; ++s) {
    const float cosine = std::sqrt((s / kSteps + 0.5f) / kSteps), azimuth = (s % kSteps + 0.5f) / kSteps * kPi;
    const float r = std::sqrt(1 - cosine * cosine);
    const Vec3 w{r * std::cos(azimuth), r * std::sin(azimuth), cosine}, o = frame.to_local(w);
    if (o.z <= 0) continue;
    const auto add = [&](Vec3 h, float energy) {
      const float share = seen_share(o, w) * unhidden(o, h, up) * energy / (kSteps * kSteps),
                  t = schlick_term(dot(o, h));
      sum = sum + TiltedMean{share * (1 - t), share * t};
    };
    if (alpha == 0)
      add({0, 0, 1}, 1);
    else
      for_some_facets({alpha, alpha}, o, [&](Vec3 h, float energy) { add(h, energy / 8); });
  }
  return sum;
}

TiltedMean tilted_mean(float normal, float alpha) {
  constexpr int kTilts = 17, kAlphas = 17;
  static const auto table = [] {
    std::array<std::array<TiltedMean, kTilts>, kAlphas> out;
    for (int a = 0; a < kAlphas; ++a)
      for (int i = 0; i < kTilts; ++i)
        out[a][i] = integrate_tilted(1 - square(static_cast<float>(i) / (kTilts - 1)),
                                     square(static_cast<float>(a) / (kAlphas - 1)));
    return out;
  }();
  const float x = std::sqrt(std::clamp(1 - normal, 0.0f, 1.0f)) * (kTilts - 1);
  const float y = std::sqrt(std::clamp(alpha, 0.0f, 1.0f)) * (kAlphas - 1);
  const int i = std::min(static_cast<int>(x), kTilts - 2), j = std::min(static_cast<int>(y), kAlphas - 2);
  const auto mix = [&](const auto& row) { return row[i] * (1 - (x - i)) + row[i + 1] * (x - i); };
  return mix(table[j]) * (1 - (y - j)) + mix(table[j + 1]) * (y - j);
}

}  // namespace

Layers::Layers(const View& view) {
  const Bsdf& bsdf = view.bsdf;
  refracts = bsdf.transmission_weight > 0 && bsdf.metallic < 1 && !bsdf.thin;
  inside = refracts && view.inside;
  smooth = is_smooth(bsdf.alpha_x, bsdf.alpha_y);
  lobe = bsdf.transmission_weight > 0 ? kSpecular : lobe_of_alpha(bsdf.alpha_x, bsdf.alpha_y);
  microfacet = rough(bsdf.alpha_x, bsdf.alpha_y);
  dense = std::max(relative_eta(bsdf, false), 1.001f);  // glTF has no index below 1
  eta = inside ? 1 / dense : dense;
  const RGB tinted = bsdf.specular * square((dense - 1) / (dense + 1));
  dielectric_f0 = clamp(tinted, 0, 1) * bsdf.specular_weight;
  dielectric_f90 = bsdf.specular_weight;
  metal_f0 = bsdf.diffuse;
  metallic = bsdf.metallic;
  f0 = lerp(dielectric_f0, metal_f0, metallic);
  f90 = dielectric_f90 * (1 - bsdf.metallic) + bsdf.metallic;
  const RGB dielectric = bsdf.diffuse * (1 - bsdf.metallic);
  const float through = refracts ? 0 : bsdf.diffuse_transmission;
  const float scattered = 1 - bsdf.transmission_weight;
  clear = inside ? bsdf.transmission_weight : 1;
  diffuse = dielectric * (scattered * (1 - through));
  diffuse_through = bsdf.transmission * ((1 - bsdf.metallic) * scattered * through);
  transmitted = dielectric * bsdf.transmission_weight;
  curves = schlick_curves(smooth ? Microfacet{0, 0} : microfacet);
  sheen = refracts ? RGB(0.0f) : clamp(bsdf.sheen, 0, 1);
  if (!is_black(sheen)) sheen_lobe = Sheen(bsdf.sheen_alpha);
  film_eta = bsdf.film_eta;
  film_thickness = bsdf.film_thickness;
  iridescence = film_thickness > 0 ? bsdf.iridescence : 0;
  set_coat(bsdf);
  if (iridescence > 0) set_film();
  set_means();
}

void Layers::set_coat(const Bsdf& bsdf) {
  coat = bsdf.coat;
  coat_smooth = is_smooth(bsdf.coat_alpha, bsdf.coat_alpha);
  coat_lobe = lobe_of_alpha(bsdf.coat_alpha, bsdf.coat_alpha);
  coat_microfacet = rough(bsdf.coat_alpha, bsdf.coat_alpha);
  coat_f0 = square((bsdf.coat_eta - 1) / (bsdf.coat_eta + 1));
  tilted = bsdf.coat_normal.z != 1;
  if (tilted) coat_frame = Frame::from_normal(bsdf.coat_normal);
  if (!(coat > 0)) return;
  coat_curves = schlick_curves(coat_smooth ? Microfacet{0, 0} : coat_microfacet);
  under_f0 = coat_f0;
  if (coat_smooth) return;
  // The term that reflects at normal incidence and on average what the rough coat does.
  under_f0 = coat_albedo(1);
  under_f90 =
      std::clamp(21 * (coat_f0 * coat_curves.mean_scale + coat_curves.mean_bias) - 20 * under_f0, under_f0, 1.0f);
}

void Layers::set_film() {
  if (!smooth) film_curves = fresnel_curves(microfacet);
  for (int i = 0; i < kFresnelNodes; ++i) {
    const float cosine = kFresnelCosines[i];
    film_dielectric[i] = with_film(fresnel_schlick(cosine, dielectric_f0, dielectric_f90), cosine, dielectric_f0);
    film_metal[i] = with_film(fresnel_schlick(cosine, metal_f0, 1), cosine, metal_f0);
  }
}

void Layers::set_means() {
  if (!(coat > 0) && is_black(sheen) && !(iridescence > 0)) {
    mean_left = RGB(1.0f) - dielectric_f0 * curves.mean_scale - RGB(dielectric_f90 * curves.mean_bias);
    mean_rest = smooth ? 0 : std::max(0.0f, 1 - curves.mean_scale - curves.mean_bias);
  } else {
    mean_left = RGB(0.0f);
    mean_rest = 0;
    const float mean_coat = mean_of_coat();
    const auto add = [&](Vec3 w, float weight) {
      Seen at = near(w);
      // The mean is better known than the values.
      if (!inside) at.coat = mean_coat;
      mean_left += weight * (RGB(1 - on_top(at)) - dielectric_facets(at));
      mean_rest += weight * (1 - on_top(at) - facets(at, 1.0f, 1.0f));
    };
    // Smooth facets under a tilted coat return light of any azimuth unlike.
    if (smooth && tilted && coat > 0)
      for_mean_directions(16, 2 * kPi, add);
    else
      for_mean_directions(microfacet, add);
    mean_left = clamp(mean_left, 0, 1);
    mean_rest = std::max(0.0f, mean_rest);
  }
  if (inside) mean_left = RGB(1.0f);
  rest_color = metallic * multiple_color(mean_schlick(metal_f0, 1), std::min(1.0f, mean_rest / mean_under_coat()));
}

Seen Layers::bare(Vec3 w) const {
  const Place place = smooth ? Place{w.z} : place_of(microfacet, w);
  return {place, curves.scale(place), curves.bias(place)};
}

Seen Layers::outside(Vec3 w) const {
  Seen at = bare(w);
  if (!(coat > 0)) return at;
  at.coat = coat_reflects(w);
  at.under = under_coat(w);
  at.again = coat * under_f0;
  at.again_grazing = coat * (under_f90 - under_f0);
  if (smooth) {
    // All light takes one direction: what the coat does not reflect passes.
    at.direct = at.direct_mirror = 1 - at.coat;
    if (tilted) at.direct_mirror = direct_under_coat({-w.x, -w.y, w.z});
  } else {
    at.scale_out = curves.scale_out(at.place);
    at.bias_out = curves.bias_out(at.place);
  }
  return at;
}

float Layers::coat_reflects(Vec3 w) const {
  if (!(coat > 0)) return 0;
  if (!tilted) return coat * coat_albedo(w.z);
  const Vec3 o = about_coat(w), up = coat_frame.to_local({0, 0, 1});
  if (o.z <= 0) return 0;
  float leaving = 0;
  if (coat_smooth) {
    leaving = unhidden(o, {0, 0, 1}, up);
  } else {
    float all = 0;
    for_some_facets(coat_microfacet, o, [&](Vec3 h, float energy) {
      energy *= fresnel_schlick(dot(o, h), RGB(coat_f0), 1).r;
      all += energy;
      leaving += energy * unhidden(o, h, up);
    });
    leaving = all > 0 ? leaving / all : 0.0f;
  }
  return coat * coat_albedo(o.z) * seen_share(o, w) * leaving;
}

float Layers::mean_of_coat() const {
  if (!(coat > 0)) return 0;
  if (!tilted) return coat * (coat_f0 * coat_curves.mean_scale + coat_curves.mean_bias);
  const TiltedMean mean = tilted_mean(coat_frame.n.z, coat_smooth ? 0 : coat_microfacet.alpha_x);
  return coat * (coat_f0 * mean.f0 + mean.f90);
}

/// Converts to the cosine on the thinner side, for Schlick's term, so that both sides agree. Returns true at total
/// reflection.
bool Layers::totally_reflects(float& cosine) const {
  if (eta >= 1) return false;
  const float sin2 = (1 - cosine * cosine) / (eta * eta);
  cosine = std::sqrt(std::max(0.0f, 1 - sin2));
  return sin2 >= 1;
}
RGB Layers::with_film(RGB plain, float cosine, RGB base) const {
  return iridescence > 0 ? lerp(plain, film(cosine, base), iridescence) : plain;
}
RGB Layers::fresnel(float cosine) const {
  if (clear < 1) return lerp(dielectric_fresnel(cosine) * clear, metal_fresnel(cosine), metallic);
  if (totally_reflects(cosine)) return RGB(1.0f);
  const RGB plain = fresnel_schlick(cosine, f0, f90);
  if (!(iridescence > 0)) return plain;
  return lerp(plain, lerp(film(cosine, dielectric_f0), film(cosine, metal_f0), metallic), iridescence);
}
RGB Layers::dielectric_fresnel(float cosine) const {
  if (totally_reflects(cosine)) return RGB(1.0f);
  return with_film(fresnel_schlick(cosine, dielectric_f0, dielectric_f90), cosine, dielectric_f0);
}
RGB Layers::metal_fresnel(float cosine) const {
  if (totally_reflects(cosine)) return RGB(1.0f);
  return with_film(fresnel_schlick(cosine, metal_f0, 1), cosine, metal_f0);
}
RGB Layers::reflectance(float cosine, float r) const {
  if (!(r > 0)) return fresnel(cosine);
  const RGB dielectric = dielectric_fresnel(cosine), metal = metal_fresnel(cosine);
  return lerp(dielectric * meets_again(dielectric, r), metal * meets_again(metal, r), metallic);
}

float Layers::facets(const Seen& at, float f0, float f90) const {
  float share;
  if (smooth) {
    const float f = f0 * at.scale + f90 * at.bias, returned = 1 - std::max(at.direct, at.direct_mirror);
    share = f * at.direct * at.direct_mirror * meets_again(f, returned);
  } else {
    const float a = f0 * meets_again(f0, at.again), b = f90 * meets_again(f90, at.again);
    share = (1 - at.again) * (a * at.scale + b * at.bias) - at.again_grazing * (a * at.scale_out + b * at.bias_out);
    share *= at.under;
  }
  return share * under_sheen(at.place.cosine, at.place.cosine);
}

RGB Layers::facets(const Seen& at, RGB f0, float f90, const RGB* film) const {
  if (!(iridescence > 0)) return {facets(at, f0.r, f90), facets(at, f0.g, f90), facets(at, f0.b, f90)};
  if (smooth) {
    const RGB f = with_film(fresnel_schlick(at.place.cosine, f0, f90), at.place.cosine, f0);
    const float sum = std::max(1e-6f, at.scale + at.bias);
    return {facets(at, f.r / sum, f.r / sum), facets(at, f.g / sum, f.g / sum), facets(at, f.b / sum, f.b / sum)};
  }
  RGB share(0.0f);
  for (int i = 0; i < kFresnelNodes; ++i)
    share += film[i] * meets_again(film[i], at.again) * film_curves.curve[i](at.place);
  const float passed = at.under * under_sheen(at.place.cosine, at.place.cosine);
  for (int c = 0; c < 3; ++c) {
    // Where the film's light leaves is taken to be as for Schlick's term of its ends.
    const float a = film[kFresnelNodes - 1][c], b = film[0][c], all = a * at.scale + b * at.bias;
    const float out = all > 0 ? (a * at.scale_out + b * at.bias_out) / all : 0;
    share[c] *= passed * (1 - at.again - at.again_grazing * out);
  }
  return clamp(share, 0, 1);
}

/// Share that coat and sheen reflect.
float Layers::on_top(const Seen& at) const {
  if (is_black(sheen)) return at.coat;
  const float cosine = at.place.cosine;
  const float leaving = (1 - at.again) * sheen_lobe.albedo(cosine) - at.again_grazing * sheen_lobe.albedo_out(cosine);
  return at.coat + at.under * max_component(sheen) * leaving;
}

RGB Layers::diffuse_factor(RGB left_o, RGB base) const {
  const float passed = mean_under_coat();
  const RGB total = clamp(diffuse + diffuse_through + transmitted + metal_f0 * metallic, 0, 1);
  RGB out;
  for (int c = 0; c < 3; ++c)
    out[c] = base[c] * kInversePi * over_mean(left_o[c], mean_left[c]) * passed / (1 - total[c] * (1 - passed));
  return out;
}

}  // namespace glowworm::bsdf_detail
