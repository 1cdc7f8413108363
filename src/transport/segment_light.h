// Light of lamps that a homogeneous medium scatters along a straight piece of a path, by places that are sampled by
// the angle under which the lamp sees them (equiangular sampling: Kulla and Fajardo, "Importance Sampling Techniques
// for Path Tracing in Participating Media", 2012), weighted against places that are sampled by transmittance.
#pragma once
#include <cstdint>

#include "transport/light_connection.h"

namespace glowworm {

/// A sample of light that a segment scatters.
struct SegmentLight {
  LightSample sample;          ///< its pdf is that of the place, too, where that is sampled by the angle: per metre
  MediumVertex vertex;         ///< the place
  float distance = 0;          ///< along the segment, metres
  float by_place = 0;          ///< density of a light sample of the place, per steradian
  float by_transmittance = 0;  ///< density by which the transmittance samples the place, per metre
  RGB weight{0.0f};  ///< transmittance to the place times sigma_s; over its density if the transmittance sampled it
};

/// A straight piece of a path in a medium, which samples light of lamps.
class LitSegment {
 public:
  LitSegment() = default;
  /// @param path at its ray's start, which is that of the segment
  /// @param always the transmittance samples a place within the segment; otherwise a path may pass the segment
  LitSegment(const Medium& medium, const PathState& path, float length, bool always = false);

  /// Whether sample() samples places: in homogeneous media that scatter.
  bool samples() const { return medium_ && is_homogeneous(*medium_) && !is_black(medium_->sigma_s); }
  /// Samples a lamp and a place on the segment; a pdf of 0: none.
  SegmentLight sample(const Scene& scene, Vec2 u_lamp, Vec2 u_place) const;
  /// Samples a lamp, and a place by the transmittance, in any medium; a pdf of 0: none. Use it with `always`.
  SegmentLight sample_by_transmittance(const Scene& scene, Vec2 u_lamp, Vec2 u_place) const;
  /// The density of sample() over the density of light samples at places that the transmittance samples.
  /// @param source counted as in Scene::light_power() @param distance of the place @param lamp point of the lamp
  float ratio(const Scene& scene, std::uint32_t source, float distance, Vec3 lamp) const;

 private:
  Vec3 at(float distance) const { return ray_.origin + ray_.direction * distance; }
  RGB density_of_places(float distance) const;
  float transmittance_pdf(float distance) const;
  RGB reaching(float distance) const;
  MediumVertex vertex_at(float distance) const;

  const Medium* medium_ = nullptr;  // null: the segment is not in a medium
  bool always_ = false;
  Ray ray_{};
  PathMedium inside_{};
  RGB throughput_{1.0f};
  MediumSpan span_{};
  Vec3 middle_{};  // where lamps are chosen
};

}  // namespace glowworm
