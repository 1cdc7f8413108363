// The layers of a metallic-roughness material, and how they share the light (metallic_roughness.cc). Internal to the
// BSDFs.
#pragma once
#include "bsdf/component.h"
#include "bsdf/fresnel.h"
#include "bsdf/multiple.h"
#include "bsdf/sheen.h"
#include "bsdf/tables.h"

namespace glowworm::bsdf_detail {

/// What the layers need of a direction above them.
struct Seen {
  Place place;
  float scale, bias;                    ///< of SchlickCurves
  float scale_out = 0, bias_out = 0;    ///< the same, of rough facets under a coat
  float coat = 0;                       ///< share that the coat reflects
  float under = 1;                      ///< share that passes the coat, to and from all layers but smooth facets
  float again = 0, again_grazing = 0;   ///< 1 - under is again + again_grazing * Schlick's term
  float direct = 1, direct_mirror = 1;  ///< of smooth facets: shares that pass, of the direction and its mirror image
};

/// The material for one viewer.
struct Layers {
  bool refracts, inside, smooth, coat_smooth;
  Lobes lobe, coat_lobe;
  Microfacet microfacet, coat_microfacet;
  float eta;    // far side over near side
  float dense;  // inside over outside
  RGB f0;       // of the specular layer, a mix of dielectric and metal
  float f90;
  RGB dielectric_f0;
  float dielectric_f90;
  float clear;               // share of the dielectric's facets that reflect: inside, only those that transmit, too
  RGB diffuse, transmitted;  // shares of base colour that are reflected diffusely and transmitted
  RGB diffuse_through;       // share of the diffuse light that leaves on the other side
  float coat, coat_f0;       // no viewer inside sees the coat, but its light passes it
  bool tilted;               // the coat has another normal
  Frame coat_frame;
  float under_f0 = 0, under_f90 = 1;  // Schlick's term by which the coat weakens rough facets
  SchlickCurves curves, coat_curves;
  RGB sheen;
  Sheen sheen_lobe;
  float iridescence, film_eta, film_thickness;
  FresnelCurves film_curves;
  RGB film_dielectric[kFresnelNodes], film_metal[kFresnelNodes];  // dielectric_fresnel() and metal_fresnel() at nodes
  RGB metal_f0;
  float metallic;
  RGB mean_left;    // mean over directions of D
  float mean_rest;  // of W
  RGB rest_color;   // share of W that the metal reflects, times metallic

  explicit Layers(const View& view);

  /// A direction above, outside.
  Seen outside(Vec3 w) const;
  /// A direction on the viewer's side: inside, no layer is above the facets.
  Seen near(Vec3 w) const { return inside ? bare(w) : outside(w); }

  /// The direction relative to the coat's normal; z <= 0 if the coat is not visible.
  Vec3 about_coat(Vec3 w) const { return tilted ? coat_frame.to_local(w) : w; }
  /// Reflectance of a film on a base of this reflectance at normal incidence, seen from the thinner side.
  RGB film(float cosine, RGB base) const { return film_reflectance(cosine, film_eta, film_thickness, base); }
  RGB fresnel(float cosine) const;
  RGB dielectric_fresnel(float cosine) const;
  RGB metal_fresnel(float cosine) const;
  /// fresnel() of light that meets the facet again, of which the coat returns r.
  RGB reflectance(float cosine, float r) const;
  /// Share transmitted, not reflected, at a facet.
  RGB passed(float cosine) const { return transmitted * (RGB(1.0f) - dielectric_fresnel(cosine)); }

  /// Factor on a facet's reflection of this reflectance for light that meets it again, of which the coat returns r.
  static float meets_again(float fresnel, float r) { return 1 / std::max(1e-6f, 1 - fresnel * r); }
  static RGB meets_again(RGB f, float r) { return {meets_again(f.r, r), meets_again(f.g, r), meets_again(f.b, r)}; }
  /// The same for light that passes the facet: of a pane both sides return it.
  RGB passes_again(RGB f, float r) const { return meets_again(f, r) * (refracts ? 1 : 1 / (1 - r)); }

  /// Share of light between two directions that passes the sheen.
  float under_sheen(float cosine_o, float cosine_i) const {
    if (is_black(sheen)) return 1;
    return 1 - max_component(sheen) * std::max(sheen_lobe.albedo(cosine_o), sheen_lobe.albedo(cosine_i));
  }
  float coat_albedo(float cosine) const { return coat_f0 * coat_curves.scale({cosine}) + coat_curves.bias({cosine}); }
  /// Share of light to or from an outside direction that passes the coat: Seen::under and Seen::direct.
  float under_coat(Vec3 w) const { return 1 - coat * fresnel_schlick(w.z, RGB(under_f0), under_f90).r; }
  float direct_under_coat(Vec3 w) const { return 1 - coat_reflects(w); }
  /// Mean share of light that passes the coat.
  float mean_under_coat() const { return inside ? 1 : 1 - coat * mean_schlick(RGB(under_f0), under_f90).r; }

  /// Share of the light from a direction that facets of Schlick's Fresnel term reflect, under coat and sheen.
  float facets(const Seen& at, float f0, float f90) const;
  /// The same of the facets of a dielectric and a metal, with their film.
  RGB dielectric_facets(const Seen& at) const { return facets(at, dielectric_f0, dielectric_f90, film_dielectric); }
  RGB metal_facets(const Seen& at) const { return facets(at, metal_f0, 1, film_metal); }
  /// D and W.
  RGB left(const Seen& at) const {
    return inside ? RGB(1.0f) : clamp(RGB(1 - on_top(at)) - dielectric_facets(at), 0, 1);
  }
  float rest(const Seen& at) const { return std::max(0.0f, 1 - on_top(at) - facets(at, 1.0f, 1.0f)); }

  /// f over D(wi) of a diffuse base of this albedo. The coat returns some of the light from all that is under it.
  RGB diffuse_factor(RGB left_o, RGB base) const;
  /// f over W(wi) of light that meets the metal more than once.
  RGB rest_factor(float rest_o) const { return rest_color * (kInversePi * over_mean(rest_o, mean_rest)); }

 private:
  void set_coat(const Bsdf& bsdf);
  void set_film();
  void set_means();
  Seen bare(Vec3 w) const;
  bool totally_reflects(float& cosine) const;
  RGB with_film(RGB plain, float cosine, RGB base) const;
  float coat_reflects(Vec3 w) const;
  float mean_of_coat() const;
  RGB facets(const Seen& at, RGB f0, float f90, const RGB* film) const;
  float on_top(const Seen& at) const;
};

}  // namespace glowworm::bsdf_detail
