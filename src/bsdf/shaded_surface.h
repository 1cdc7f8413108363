// Scattering by surfaces whose shading normal is not their own: one rule for paths from the eye, light samples and
// photons.
//
// A BSDF is defined about the shading normal, while the geometric normal decides which side a direction lies on. Where
// the two disagree nothing is lost:
// - A viewer's direction that lies behind the shading normal, seen from the viewer's side of the surface, is mirrored
//   in the shading plane. So the BSDF knows the side of the surface that the viewer is on.
// - A direction that the BSDF scatters light from, and that lies on the wrong side of the surface, is mirrored in the
//   surface. So reflected light stays out of an opaque surface, and refracted light passes glass.
// Both mirror images keep solid angles: what a surface reflects of a uniform light is the albedo of its BSDF. Two
// directions of the BSDF may come to the same direction in the world; values and densities are sums over the two.
//
// Photons follow the adjoint of that (Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, section
// 5.3): the factor |wo.Ns| |wi.Ng| / (|wo.Ng| |wi.Ns|) of its equation 5.19, with a sum over the mirror images in the
// place of each of the two quotients.
#pragma once
#include "bsdf/bsdf.h"
#include "core/frame.h"
#include "core/shading_light.h"

namespace glowworm {

/// A direction in which a surface scatters, in world space.
struct ScatteredRay {
  Vec3 direction;  ///< unit
  Vec3 side;       ///< the geometric normal, on the side where the direction leaves
  RGB weight;      ///< as BsdfSample::weight
  float pdf = 0;   ///< per steradian; for a delta, the probability of choosing it
  Lobes lobe = 0;  ///< the lobe that was chosen: one bit
  bool delta = false;
  bool valid = false;  ///< false where nothing is scattered: the path ends
};

/// A photon's way to a surface.
struct ArrivedPhoton {
  Vec3 back;  ///< unit, world space, as the BSDF sees it: towards where the photon came from, or its mirror image
  float factor = 0;  ///< on the flux of the photon (arrival_factor()); 0: nothing of it is scattered
};

/// A BSDF at a place of a surface. Directions are unit vectors in world space that point away from the surface.
class ShadedSurface {
 public:
  /// @param frame shading frame; @param normal unit, geometric, of either side; both must outlive the surface
  ShadedSurface(const Bsdf& bsdf, const Frame& frame, Vec3 normal)
      : bsdf_(bsdf), frame_(frame), normal_(face_forward(normal, frame.n)), cosine_(dot(normal_, frame.n)) {}

  /// The viewer's direction as the BSDF sees it.
  Vec3 seen_from(Vec3 wo) const {
    const float shading = dot(wo, frame_.n);
    return shading * dot(wo, normal_) < 0 ? wo - frame_.n * (2 * shading) : wo;
  }
  /// The same in shading coordinates: what the functions of bsdf.h take for wo.
  Vec3 local_view(Vec3 wo) const { return frame_.to_local(seen_from(wo)); }

  /// albedo() of bsdf.h.
  RGB albedo(Vec3 wo, Lobes lobes) const { return glowworm::albedo(bsdf_, local_view(wo), lobes); }
  /// Radiance towards wo for radiance 1 from wi, per steradian: f with its cosine. Deltas count as zero.
  RGB evaluate(Vec3 wo, Vec3 wi, Lobes lobes) const;
  /// The density per steradian with which sample() gives wi; deltas count as zero.
  float pdf(Vec3 wo, Vec3 wi, Lobes lobes) const;
  /// Chooses where light towards wo comes from. Numbers as those of sample() in bsdf.h.
  ScatteredRay sample(Vec3 wo, float u_lobe, Vec2 u, Lobes lobes) const;

  /// What arrives of a photon from direction `back`. Where the BSDF may see it from two directions, chooses one.
  /// @param u in [0, 1); becomes another such number, independent of the choice
  ArrivedPhoton arrive(Vec3 back, float& u) const;
  /// Chooses where such a photon goes on, by all lobes; the weight is a factor on ArrivedPhoton::factor. It may exceed
  /// 1: Russian roulette cannot even it out. The pdf is not filled in.
  /// @param u_mirror in [0, 1); becomes another such number
  ScatteredRay scatter_photon(Vec3 back, float u_lobe, Vec2 u, float& u_mirror) const;

 private:
  /// Calls f(wi in shading coordinates) for each direction about the shading normal that comes to wi in the world.
  template <typename F>
  void for_each_source(Vec3 wi, F&& f) const;

  const Bsdf& bsdf_;
  const Frame& frame_;
  Vec3 normal_;   // geometric, on the side of the shading normal
  float cosine_;  // between the normals
};

}  // namespace glowworm
