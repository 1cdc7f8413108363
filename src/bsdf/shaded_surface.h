// Scattering by surfaces whose shading and geometric normals differ: one rule for paths from the eye, light samples and
// photons.
//
// A BSDF is defined relative to the shading normal, but the geometric normal determines the side of a direction. If the
// two disagree, no light is lost:
// - A viewer's direction that is behind the shading normal, but on the viewer's side of the surface, is mirrored in the
//   shading plane. The BSDF then sees the correct side of the surface.
// - A scattered direction on the wrong side of the surface is mirrored in the surface. Reflected light then stays
// outside
//   an opaque surface, and refracted light passes through glass.
// Both mirror images preserve solid angles: of uniform light, a surface reflects the albedo of its BSDF. Two directions
// of the BSDF may map to the same direction in the world; values and densities are sums over the two.
//
// Photons use the adjoint of that (Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, section
// 5.3): the factor |wo.Ns| |wi.Ng| / (|wo.Ng| |wi.Ns|) of its equation 5.19, with each of the two quotients replaced by
// a sum over the mirror images.
#pragma once
#include "bsdf/bsdf.h"
#include "core/frame.h"
#include "core/shading_light.h"

namespace glowworm {

/// A sampled direction in world space.
struct ScatteredRay {
  Vec3 direction;  ///< unit
  Vec3 side;       ///< the geometric normal, on the side of the direction
  RGB weight;      ///< as BsdfSample::weight
  float pdf = 0;   ///< per steradian; for a delta, the probability of choosing it
  Lobes lobe = 0;  ///< the chosen lobe: one bit
  bool delta = false;
  bool is_null = false;  ///< onwards through a pane, without bending
  bool valid = false;    ///< false if nothing is scattered: the path ends
};

/// Arrival of a photon at a surface.
struct ArrivedPhoton {
  Vec3 back;         ///< unit, world space: towards the photon's origin, or the mirror image that the BSDF uses
  float factor = 0;  ///< on the flux of the photon (arrival_factor()); 0: it ends here
};

/// A BSDF at a point of a surface. Directions are unit vectors in world space that point away from the surface.
class ShadedSurface {
 public:
  /// @param frame shading frame; @param normal unit, geometric, of either side; both must outlive the surface
  ShadedSurface(const Bsdf& bsdf, const Frame& frame, Vec3 normal)
      : bsdf_(bsdf), frame_(frame), normal_(face_forward(normal, frame.n)), cosine_(dot(normal_, frame.n)) {}

  /// The viewer's direction that the BSDF uses.
  Vec3 seen_from(Vec3 wo) const { return is_behind(wo) ? wo - frame_.n * (2 * dot(wo, frame_.n)) : wo; }
  /// The same in shading coordinates: wo for the functions of bsdf.h.
  Vec3 local_view(Vec3 wo) const { return frame_.to_local(seen_from(wo)); }

  /// albedo() of bsdf.h.
  RGB albedo(Vec3 wo, Lobes lobes) const { return glowworm::albedo(bsdf_, local_view(wo), lobes); }
  /// choose_lobes() of bsdf.h.
  LobeChoice choose_lobes(Vec3 wo, float u) const { return glowworm::choose_lobes(bsdf_, local_view(wo), u); }
  /// Radiance towards wo for radiance 1 from wi, per steradian: f with its cosine. Deltas count as zero.
  RGB evaluate(Vec3 wo, Vec3 wi, Lobes lobes) const;
  /// The density per steradian with which sample() chooses wi; deltas count as zero.
  float pdf(Vec3 wo, Vec3 wi, Lobes lobes) const;
  /// Share of the light from -wo that reaches the viewer at wo straight through the surface.
  RGB straight_transmittance(Vec3 wo) const;
  /// Samples a direction from which light towards wo arrives. Random numbers as for sample() in bsdf.h.
  ScatteredRay sample(Vec3 wo, float u_lobe, Vec2 u, Lobes lobes) const;

  /// Arrival of a photon from direction `back`. If two directions of the BSDF are possible, chooses one.
  /// @param u in [0, 1); becomes another such number, independent of the choice
  ArrivedPhoton arrive(Vec3 back, float& u) const;
  /// Samples the direction in which such a photon continues, over all lobes; the weight multiplies
  /// ArrivedPhoton::factor. It may exceed 1, which Russian roulette cannot compensate. Does not fill in the pdf.
  /// @param u_mirror in [0, 1); becomes another such number
  ScatteredRay scatter_photon(Vec3 back, float u_lobe, Vec2 u, float& u_mirror) const;

 private:
  /// Whether a direction lies on different sides of the shading plane and of the surface.
  bool is_behind(Vec3 w) const { return dot(w, frame_.n) * dot(w, normal_) < 0; }
  /// Calls f(wi in shading coordinates) for each direction of the BSDF that maps to wi in the world.
  template <typename F>
  void for_each_source(Vec3 wi, F&& f) const;

  const Bsdf& bsdf_;
  const Frame& frame_;
  Vec3 normal_;   // geometric, on the side of the shading normal
  float cosine_;  // between the normals
};

}  // namespace glowworm
