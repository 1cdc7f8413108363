#include "maps/volume_maps.h"

#include <algorithm>
#include <utility>

#include "core/random.h"

namespace glowworm {

namespace {

/// Whether a medium weakens colours unequally in a grid.
bool varies_in_colour(const Medium& medium) {
  const RGB sigma_t = medium.sigma_a + medium.sigma_s;
  const bool is_grey = sigma_t.r == sigma_t.g && sigma_t.g == sigma_t.b;
  const MediumGridValues* grid = medium.grid ? &medium.grid->values() : nullptr;
  return grid && (!is_grey || !grid->sigma_a.empty() || !grid->sigma_s.empty());
}

/// For each medium whether its photons are beams.
std::vector<bool> choose_beams(const Scene& scene, const VolumePhotons& points, std::span<const float> radii) {
  std::vector<double> radius(scene.media().size()), count(radius);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::uint32_t m = points.medium[i];
    const MediumPoint here = medium_point(scene.media()[m], points.position[i]);
    const float sigma_t = max_component(here.sigma_a + here.sigma_s);
    radius[m] += static_cast<double>(radii[i]) * static_cast<double>(sigma_t);
    ++count[m];
  }
  std::vector<bool> out;
  for (std::size_t m = 0; m < radius.size(); ++m)
    out.push_back(!varies_in_colour(scene.media()[m]) && radius[m] <= count[m]);
  return out;
}

/// The photons of media for which keeps(medium) holds.
template <class Batch, class Keeps>
Batch chosen(const Batch& all, Keeps&& keeps) {
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < all.size(); ++i)
    if (keeps(all.medium[i])) kept.push_back(i);
  Batch out;
  Batch::for_arrays(
      [&](auto& to, const auto& from) {
        to.reserve(kept.size());
        for (const std::uint32_t i : kept) to.push_back(from[i]);
      },
      out, all);
  return out;
}

/// A sign for each channel of a photon.
RGB random_signs(std::uint32_t seed, std::size_t photon) {
  const std::uint32_t bits = hash_combine(hash_combine(seed, kPhotonSignStream), static_cast<std::uint32_t>(photon));
  const auto sign = [&](int channel) { return (bits >> channel & 1) != 0 ? 1.0f : -1.0f; };
  return {sign(0), sign(1), sign(2)};
}

/// What an index sums: the flux of a group's photons, or with random signs.
template <class Batch>
LargeVector<RGB> flux_of(const Batch& batch, std::size_t group, const IndexInputs& inputs, VolumeFlux kind) {
  LargeVector<RGB> flux = batch.flux;
  if (kind == VolumeFlux::signed_at_random) {
    for (std::size_t i = 0; i < flux.size(); ++i) flux[i] *= random_signs(inputs.seed, i);
    return flux;
  }
  for (std::size_t i = 0; inputs.light_groups && i < flux.size(); ++i)
    if (inputs.light_groups->of_source[batch.source[i]] != group) flux[i] = RGB();
  return flux;
}

}  // namespace

VolumeMaps::VolumeMaps(const Scene& scene, MediaPhotons photons, const IndexInputs& inputs, VolumeFlux flux,
                       Statistics& statistics) {
  const std::vector<bool> beams_of =
      choose_beams(scene, photons.points, volume_photon_radii(photons.points, inputs.nearest));
  const VolumePhotons points = chosen(photons.points, [&](std::uint32_t m) { return !beams_of[m]; });
  const VolumeBeams beams = chosen(photons.beams, [&](std::uint32_t m) { return beams_of[m]; });
  photons = {};
  const std::vector<float> radii = volume_photon_radii(points, inputs.nearest);
  const BeamPieces pieces = volume_beam_pieces(beams, inputs.nearest);
  groups_.resize(inputs.light_groups && flux == VolumeFlux::plain ? inputs.light_groups->names.size() : 1);
  for (std::size_t group = 0; group < groups_.size(); ++group) {
    groups_[group].points.build(points, flux_of(points, group, inputs, flux), radii, inputs.radius_scale, statistics);
    // The blur of a beam has one dimension, that of a point two.
    groups_[group].beams.build(beams, flux_of(beams, group, inputs, flux), pieces,
                               inputs.radius_scale * inputs.radius_scale, statistics);
    bytes_ += VolumeMap::photon_bytes(points.size()) + VolumeMap::beam_bytes(beams.size());
  }
}

void VolumeMaps::estimate(std::size_t group, const VolumeSegments& segments, std::span<RGB> found,
                          Statistics& statistics) const {
  const Group& of = groups_[group];
  if (!of.points.empty()) of.points.estimate(segments, found, statistics);
  if (!of.beams.empty()) of.beams.estimate(segments, found, statistics);
}

}  // namespace glowworm
