// Emission of photons in blocks. Used by chunk_tracer.cc and benchmarks.
#pragma once
#include <cstdint>

#include "kernels/light_emission.h"
#include "photon/emission_guide.h"
#include "scene/light_sampling.h"

namespace glowworm {

/// A block of photons for the emission kernels. Photon i equals the result of sample_emission(), bit for bit, with its
/// flux times the guide's weight.
class EmissionBlock {
 public:
  static constexpr std::size_t kBlock = 128;

  /// The random numbers of photon i, and the factor on its flux.
  void set_numbers(std::size_t i, const EmissionNumbers& numbers, float guide_weight);
  /// Emits photons [0, count), count <= kBlock.
  void emit(const Scene& scene, std::size_t count);

  /// Takes the flux of a photon that cannot start after all.
  void drop(std::size_t i) {
    for (Array& channel : flux_) channel[i] = 0;
  }

  std::uint32_t light(std::size_t i) const { return light_[i]; }
  Vec3 origin(std::size_t i) const { return vector(origin_, i); }
  Vec3 direction(std::size_t i) const { return vector(direction_, i); }
  RGB flux(std::size_t i) const { return {flux_[0][i], flux_[1][i], flux_[2][i]}; }
  /// One channel of the flux of all photons.
  const float* flux_channel(int channel) const { return flux_[channel]; }

 private:
  using Array = float[kBlock + kLightEmissionPadding];
  static Vec3 vector(const Array* arrays, std::size_t i) { return {arrays[0][i], arrays[1][i], arrays[2][i]}; }
  /// How a photon is emitted: by a kernel, or by sample_emission() alone.
  enum Kind : std::uint8_t { kTriangle, kDistant, kOther, kKinds };

  Kind choose(const Scene& scene, std::size_t i);
  void set_triangles(const Scene& scene, std::size_t count);
  void set_distant(std::size_t i, Vec3 direction, RGB irradiance);
  void emit_distant(const Scene& scene, const EmissionChoices& choices);
  void emit_triangles(const EmissionChoices& choices, bool others);
  void emit_other(const Scene& scene, std::size_t i);

  alignas(64) Array choice_ = {}, place_[2] = {}, square_[2] = {}, guide_weight_ = {}, probability_ = {};
  alignas(64) Array corner_[3] = {}, edges_[6] = {}, normal_[3] = {}, offset_ = {}, distant_direction_[3] = {};
  alignas(64) Array radiance_[3] = {};  // of a distant light: irradiance
  alignas(64) Array origin_[3] = {}, direction_[3] = {}, flux_[3] = {};
  alignas(64) std::uint32_t light_[kBlock + kLightEmissionPadding] = {},
                                            two_sided_[kBlock + kLightEmissionPadding] = {};
  Kind kind_[kBlock] = {};
};

}  // namespace glowworm
