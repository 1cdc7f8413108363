#include "maps/volume_maps.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/random.h"
#include "maps/medium_parts.h"
#include "maps/volume_blur.h"
#include "points/photon_batch.h"

namespace glowworm {

namespace {

/// Whether a medium weakens colours unequally in a grid.
bool varies_in_colour(const Medium& medium) {
  const RGB sigma_t = medium.sigma_a + medium.sigma_s;
  const bool is_grey = sigma_t.r == sigma_t.g && sigma_t.g == sigma_t.b;
  const MediumGridValues* grid = medium.grid ? &medium.grid->values() : nullptr;
  return grid && (!is_grey || !grid->sigma_a.empty() || !grid->sigma_s.empty());
}

/// Media thinner than this have beams: few photons scatter there.
constexpr double kThinMedium = 1.0 / 32;

/// Half of the diagonal of a medium's box; or of the scene's, where surfaces bound the medium. Metres.
double radius_of(const Scene& scene, const Medium& medium) {
  if (medium.bounds) return 0.5 * double{length(inverse(medium.to_medium).vector(medium.bounds->diagonal()))};
  return scene.bounds().empty() ? 0.0 : 0.5 * double{length(scene.bounds().diagonal())};
}

/// For each medium whether its photons are beams. Points have less error at equal time in all but the thinnest media:
/// a segment meets fewer of them, and finds their sum faster.
std::vector<bool> choose_beams(const Scene& scene, const VolumePhotons& points) {
  std::vector<double> sigma_t(scene.media().size()), count(sigma_t);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::uint32_t m = points.medium[i];
    const MediumPoint here = medium_point(scene.media()[m], points.position[i]);
    sigma_t[m] += double{max_component(here.sigma_a + here.sigma_s)};
    ++count[m];
  }
  std::vector<bool> out;
  for (std::size_t m = 0; m < count.size(); ++m) {
    const Medium& medium = scene.media()[m];
    const double thickness = count[m] > 0 ? sigma_t[m] / count[m] * radius_of(scene, medium) : 0.0;
    out.push_back(!varies_in_colour(medium) && thickness < kThinMedium);
  }
  return out;
}

/// The pieces of these beams.
BeamPieces chosen_pieces(const BeamPieces& all, std::span<const std::uint32_t> beams) {
  BeamPieces out;
  out.first.push_back(0);
  for (const std::uint32_t i : beams) {
    for (std::uint32_t piece = all.first[i]; piece < all.first[i + 1]; ++piece) {
      out.end.push_back(all.end[piece]);
      out.radii.push_back(all.radii[piece]);
      out.factor.push_back(all.factor[piece]);
    }
    out.first.push_back(static_cast<std::uint32_t>(out.end.size()));
  }
  return out;
}

/// The indices of photons of media for which keeps(medium) holds.
template <class Keeps>
std::vector<std::uint32_t> of_media(std::span<const std::uint32_t> medium, Keeps&& keeps) {
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < medium.size(); ++i)
    if (keeps(medium[i])) kept.push_back(i);
  return kept;
}

/// One of each run of photons, as IndexedMap::sample() has them.
struct FewPhotons {
  std::vector<std::uint32_t> indices;
  float each = 1;  ///< for how many photons each of them stands

  explicit FewPhotons(std::size_t count) {
    const std::size_t run = std::max<std::size_t>((count + IndexedMap::kMostSampled - 1) / IndexedMap::kMostSampled, 1);
    indices = one_of_each_run(count, run);
    each = static_cast<float>(run);
  }
};

/// Gives the channels of each photon random signs, and flux whose squares add up to the sum over all photons.
void sign_at_random(std::uint32_t seed, const FewPhotons& few, LargeVector<RGB>& flux) {
  const float factor = std::sqrt(few.each);
  for (std::size_t i = 0; i < flux.size(); ++i) {
    const std::uint32_t bits = hash_combine(hash_combine(seed, kPhotonSignStream), few.indices[i]);
    const auto sign = [&](int channel) { return (bits >> channel & 1) != 0 ? factor : -factor; };
    flux[i] *= RGB(sign(0), sign(1), sign(2));
  }
}

}  // namespace

/// Measures photons once, for all indices over them.
class VolumeMapsBuilder {
 public:
  VolumeMapsBuilder(const Tracer& tracer, const MediaPhotons& photons, const IndexInputs& inputs) : inputs_(inputs) {
    PhotonKernels kernels = volume_photon_kernels(photons.points, inputs.nearest);
    const std::vector<float> factors = best_radius_factors(tracer, photons, kernels);
    for (std::size_t i = 0; i < kernels.size(); ++i) kernels.radii[i] *= factors[photons.points.medium[i]];
    const std::vector<bool> beams_of = choose_beams(tracer.scene(), photons.points);
    const auto points = of_media(photons.points.medium, [&](std::uint32_t m) { return !beams_of[m]; });
    points_ = photons.points.permuted(points);
    kernels_ = kernels.permuted(points);
    correct_photons(tracer, inputs.radius_scale, points_, kernels_);
    beams_ = photons.beams.permuted(of_media(photons.beams.medium, [&](std::uint32_t m) { return beams_of[m]; }));
    pieces_ = volume_beam_pieces(beams_, inputs.nearest);
    correct_pieces(tracer, beams_, beam_scale(), pieces_);
  }

  VolumeMaps all(Statistics& statistics) const {
    VolumeMaps out;
    const LightGroups* const groups = inputs_.light_groups.get();
    for (std::size_t group = 0; group < (groups ? groups->names.size() : 1); ++group)
      add_group(points_, flux_of(points_, group), kernels_, beams_, flux_of(beams_, group), pieces_, out, statistics);
    return out;
  }

  VolumeMaps signed_sample(Statistics& statistics) const {
    const FewPhotons of_points(points_.size()), of_beams(beams_.size());
    VolumePhotons points = points_.permuted(of_points.indices);
    VolumeBeams beams = beams_.permuted(of_beams.indices);
    sign_at_random(inputs_.seed, of_points, points.flux);
    sign_at_random(inputs_.seed, of_beams, beams.flux);
    VolumeMaps out;
    add_group(points, points.flux, kernels_.permuted(of_points.indices), beams, beams.flux,
              chosen_pieces(pieces_, of_beams.indices), out, statistics);
    return out;
  }

 private:
  /// The blur of a beam has one dimension; the blur of a point has two.
  float beam_scale() const { return inputs_.radius_scale * inputs_.radius_scale; }

  /// The flux of a group's photons.
  template <class Batch>
  LargeVector<RGB> flux_of(const Batch& batch, std::size_t group) const {
    LargeVector<RGB> flux = batch.flux;
    for (std::size_t i = 0; inputs_.light_groups && i < flux.size(); ++i)
      if (inputs_.light_groups->of_source[batch.source[i]] != group) flux[i] = RGB();
    return flux;
  }

  void add_group(const VolumePhotons& points, std::span<const RGB> point_flux, const PhotonKernels& kernels,
                 const VolumeBeams& beams, std::span<const RGB> beam_flux, const BeamPieces& pieces, VolumeMaps& out,
                 Statistics& statistics) const {
    VolumeMaps::Group& group = out.groups_.emplace_back();
    group.points.build(points, point_flux, kernels, inputs_.radius_scale, statistics);
    group.beams.build(beams, beam_flux, pieces, beam_scale(), statistics);
    out.bytes_ += VolumeMap::photon_bytes(points.size()) + VolumeMap::beam_bytes(beams.size());
  }

  const IndexInputs& inputs_;
  VolumePhotons points_;
  PhotonKernels kernels_;
  VolumeBeams beams_;
  BeamPieces pieces_;
};

MediaMaps make_media_maps(const Tracer& tracer, const MediaPhotons& photons, const IndexInputs& inputs, bool sampled,
                          Statistics& statistics) {
  MediaMaps out;
  out.is_sampled = sampled;
  if (tracer.scene().media().empty()) return out;
  std::optional<VolumeMapsBuilder> builder;
  {
    const PhaseTimer timer(statistics, Phase::build_photon_map);
    builder.emplace(tracer, photons, inputs);
  }
  out.all = builder->all(statistics);
  if (!sampled) return out;
  const PhaseTimer timer(statistics, Phase::photon_noise);
  Statistics not_the_renders;
  out.signed_sample = builder->signed_sample(not_the_renders);
  return out;
}

void VolumeMaps::estimate(std::size_t group, const VolumeSegments& segments, std::span<RGB> found,
                          Statistics& statistics) const {
  const Group& of = groups_[group];
  if (!of.points.empty()) of.points.estimate(segments, found, statistics);
  if (!of.beams.empty()) of.beams.estimate(segments, found, statistics);
}

void add_light_of_media(const VolumeMaps& maps, const VolumeSegments& segments, LargeVector<RGB>& found,
                        std::vector<RGB>& target, std::span<std::vector<RGB>> groups, Statistics& statistics) {
  if (segments.size() == 0) return;
  for (std::size_t group = 0; group < maps.group_count(); ++group) {
    found.assign(segments.size(), RGB());
    maps.estimate(group, segments, found, statistics);
    const PhaseTimer timer(statistics, Phase::completion);
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const RGB light = segments.weight[i] * found[i];
      target[segments.target[i]] += light;
      if (!groups.empty()) groups[group][segments.target[i]] += light;
    }
  }
}

}  // namespace glowworm
