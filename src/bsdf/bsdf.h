// BSDFs: how a surface scatters light at one point. One set of functions serves every kind; there is no virtual call.
//
// Directions are unit vectors in shading coordinates: +z is the shading normal on the outside of the surface; wo and wi
// both point away from the surface. Reflecting surfaces act alike on both sides; dielectrics tell inside (z < 0) from
// outside.
#pragma once
#include <cstdint>
#include <span>

#include "core/rgb.h"
#include "core/vec.h"

namespace glowworm {

class MeasuredBsdf;

/// Sets of lobes, as bits. "Specular" lobes are too narrow for density estimation and gathering: perfectly smooth
/// surfaces, and rough ones with a GGX alpha under kSpecularAlpha; paths continue through them. Photon maps are looked
/// up for the broad lobes.
using Lobes = std::uint8_t;
inline constexpr Lobes kDiffuseReflection = 1;
inline constexpr Lobes kDiffuseTransmission = 2;
inline constexpr Lobes kGlossy = 4;  ///< GGX reflection with alpha >= kSpecularAlpha, or reflection by a matrix
/// Smooth, or GGX with alpha < kSpecularAlpha; and all lobes that transmit through their facets, however rough: photons
/// are compared by the side of arrival, so an estimate on one side of glass cannot count photons of the other.
inline constexpr Lobes kSpecular = 8;
inline constexpr Lobes kDiffuse = kDiffuseReflection | kDiffuseTransmission;
inline constexpr Lobes kBroad = kDiffuse | kGlossy;
inline constexpr Lobes kAllLobes = kBroad | kSpecular;

/// GGX alpha below which a lobe counts as specular.
inline constexpr float kSpecularAlpha = 0.08f;
/// GGX alpha below which a lobe is treated as perfectly smooth (a Dirac delta).
inline constexpr float kSmoothAlpha = 1e-3f;

enum class BsdfKind : std::uint8_t {
  lambertian,  ///< diffuse reflection and transmission
  conductor,
  dielectric,
  thin_dielectric,
  coated_diffuse,
  coated_conductor,
  metallic_roughness,
  measured,
};

/// A material resolved at a point: only numbers, so that arrays of it can be evaluated in batches. Every index of
/// refraction is relative: the inside's (z < 0) over the outside's. Colours are in [0, 1]. GGX alphas are alphas, not
/// "roughness" (glTF's alpha is roughness squared; pbrt's is remapped if the file says so). Each kind reads only these
/// fields:
/// - lambertian: diffuse, transmission.
/// - conductor: alpha_x, alpha_y; with use_reflectance: specular (F0 of Schlick's approximation), otherwise eta, k.
///   pbrt-v4 converts a "reflectance" r to eta = 1, k = 2 sqrt(r / (1 - r)); to match its images, do the same.
/// - dielectric: eta.r, alpha_x, alpha_y, specular and transmission (tints of the two; 1 for plain glass).
/// - thin_dielectric: eta.r (of the pane over both sides), specular (tint), transmission (of a passage of the pane's
///   inside at normal incidence). Always smooth.
/// - coated_diffuse: diffuse (the base's own albedo), coat_eta, alpha_x, alpha_y (of the coat), coat_thickness,
///   coat_bounces.
/// - coated_conductor: coat_eta, coat_alpha, coat_thickness, coat_bounces; alpha_x, alpha_y and use_reflectance,
///   specular, eta, k of the base, as for a conductor, relative to the OUTSIDE, not to the coat.
/// - metallic_roughness: diffuse (base colour, not reduced by metallic), metallic, alpha_x, alpha_y, eta.r, specular
///   (KHR specular colour), specular_weight (KHR specular factor), coat (clearcoat factor), coat_alpha, coat_eta,
///   coat_normal, transmission_weight, thin, dispersion, sheen, sheen_alpha, iridescence, film_eta, film_thickness,
///   diffuse_transmission, transmission (its colour). The base colour tints transmitted light.
/// - measured: measured, whose x axis lies along the shading frame's s.
struct Bsdf {
  BsdfKind kind = BsdfKind::lambertian;
  bool thin = false;               ///< transmission does not bend rays
  RGB diffuse{0.0f};               ///< diffuse reflectance, or base colour
  RGB transmission{0.0f};          ///< diffuse transmittance, or tint of specular transmission
  RGB specular{0.0f};              ///< F0 of a conductor by reflectance, or tint of a dielectric's reflection
  RGB eta{1.5f}, k{0.0f};          ///< complex index of a conductor; eta.r: index of a dielectric
  bool use_reflectance = false;    ///< a conductor's Fresnel term is Schlick's of specular
  float alpha_x = 0, alpha_y = 0;  ///< GGX alpha along the shading frame's s and t; both < kSmoothAlpha: smooth
  float coat_alpha = 0;            ///< GGX alpha of the coat
  float coat = 0;                  ///< share of the surface that has the coat
  float coat_eta = 1.5f;           ///< index of the coat over the outside's
  float coat_thickness = 0;  ///< optical depth of the coat along the normal, pbrt-v4's "thickness" (default 0.01): it
                             ///< absorbs exp(-thickness / cos) at each passage
  std::uint8_t coat_bounces = 0;  ///< maximum number of reflections at the base under a coat; 0: unlimited. pbrt-v4's
                                  ///< random walk of "maxdepth" steps has (maxdepth + 1) / 2, by default 5
  float metallic = 0, transmission_weight = 0;
  float specular_weight = 1;
  RGB sheen{0.0f};
  float sheen_alpha = 0;                   ///< exponent of the Charlie distribution: 1 / sheen_alpha
  float iridescence = 0;                   ///< share of the surface that has a thin film
  float film_eta = 1.3f;                   ///< index of the film
  float film_thickness = 0;                ///< nm
  float diffuse_transmission = 0;          ///< share of the diffuse light that is transmitted
  Vec3 coat_normal{0, 0, 1};               ///< of the clearcoat, in shading coordinates
  float dispersion = 0;                    ///< 20 over the Abbe number (choose_wavelength())
  const MeasuredBsdf* measured = nullptr;  ///< of the scene's material, which outlives this
};

/// The lobes of the BSDF.
Lobes lobes(const Bsdf& bsdf);

/// Whether the BSDF is diffuse reflection only, which the engines treat inline.
inline bool is_lambertian(const Bsdf& bsdf) {
  return bsdf.kind == BsdfKind::lambertian && bsdf.transmission.r == 0 && bsdf.transmission.g == 0 &&
         bsdf.transmission.b == 0;
}

/// f_r (or f_t) of the given lobes in sr^-1, without the cosine; Dirac deltas count as zero. It applies to radiance
/// scattered from wi to wo: refracted radiance is scaled by the square of the index of wo's side over wi's.
/// Otherwise, and with wo and wi exchanged after division by the squared index of wo's side, f is symmetric.
RGB evaluate(const Bsdf& bsdf, Vec3 wo, Vec3 wi, Lobes lobes);

/// The density per steradian with which sample() chooses wi among the given lobes; deltas count as zero.
float pdf(const Bsdf& bsdf, Vec3 wo, Vec3 wi, Lobes lobes);

/// Whether a path carries radiance (from the eye) or flux (photons): refraction scales radiance by the square of the
/// relative index (Veach 1997, section 5.2).
enum class Transport : std::uint8_t { radiance, flux };

struct BsdfSample {
  Vec3 wi;
  RGB weight;      ///< f |cos(wi)| / pdf; for a delta, its coefficient over the probability of choosing it
  float pdf = 0;   ///< per steradian, of all given lobes; for a delta, the probability of choosing it
  Lobes lobe = 0;  ///< the chosen lobe: one bit
  bool delta = false;
  bool is_null = false;  ///< wi is -wo: passed through a pane
  bool valid = false;    ///< false if nothing is scattered: the path ends
};

/// Samples a direction in approximate proportion to the BSDF times the cosine.
/// @param u_lobe chooses the lobe; @param u the direction in it; all in [0, 1)
BsdfSample sample(const Bsdf& bsdf, Vec3 wo, float u_lobe, Vec2 u, Lobes lobes, Transport transport);

/// Share of the light from wo that the given lobes scatter (directional albedo), exact or approximate: it chooses
/// between lobes and decides Russian roulette. It is > 0 wherever the lobes are not black.
RGB albedo(const Bsdf& bsdf, Vec3 wo, Lobes lobes);

/// Lobes that a path takes.
struct LobeChoice {
  Lobes lobes = 0;        ///< kDiffuse, kGlossy or kSpecular; 0: the surface is black
  float probability = 0;  ///< of this choice
};
/// Chooses lobes in proportion to their albedos. @param u in [0, 1)
LobeChoice choose_lobes(const Bsdf& bsdf, Vec3 wo, float u);

/// Share of the light from -wo that reaches the viewer at wo straight through the surface, as through a pane of glass.
RGB straight_transmittance(const Bsdf& bsdf, Vec3 wo);

/// Reduces a dispersive BSDF to one of three wavelengths, which represent red, green and blue; does nothing to others.
/// A path that has only one colour left keeps it. The indices follow KHR_materials_dispersion: eta -/+ (eta - 1)
/// dispersion / 40 for red and blue.
/// @param u in [0, 1), chooses; @return factor on the path's throughput
RGB choose_wavelength(Bsdf& bsdf, RGB throughput, float u);

/// Batch form of evaluate() for the engines: out[i] = f_r(bsdf, wo, wi[i]) of the given lobes.
void evaluate_batch(const Bsdf& bsdf, Vec3 wo, std::span<const Vec3> wi, Lobes lobes, std::span<RGB> out);

}  // namespace glowworm
