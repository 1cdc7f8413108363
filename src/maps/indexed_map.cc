#include "maps/indexed_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "core/random.h"
#include "maps/boundary.h"
#include "maps/kernel_cuts.h"
#include "maps/memory.h"

namespace glowworm {

namespace {

template <typename Factor>
LargeVector<RGB> flux_times(LargeVector<RGB> flux, const std::vector<Factor>& factors) {
  for (std::size_t i = 0; i < flux.size(); ++i) flux[i] *= factors[i];
  return flux;
}

std::unique_ptr<DensityEngine> engine_of(const IndexInputs& inputs) {
  return make_engine(inputs.engine, {.reorder = inputs.reorder});
}

/// Indexes the photons of each group of lights, with the radii of the whole map.
IndexedMap::Engines index_groups(const IndexedMap::Photons& photons, std::span<const RGB> flux,
                                 const RadiusPolicy& whole, const IndexInputs& inputs, Statistics& statistics) {
  const LightGroups& groups = *inputs.light_groups;
  const bool by_radius = whole.kind != RadiusKind::nearest && inputs.correction != BoundaryCorrection::estimates;
  if (by_radius && groups.names.size() >= GroupedMap::kLeastGroups) {
    std::vector<std::uint32_t> group_of;
    for (const std::uint32_t source : photons.sources) group_of.push_back(groups.of_source[source]);
    IndexedMap::Engines engines;
    engines.push_back(engine_of(inputs));
    engines.back()->build(photons.batch, flux, whole, statistics);
    engines.grouped = std::make_unique<const GroupedMap>(photons.batch, flux, whole, group_of);
    return engines;
  }
  std::vector<std::vector<std::uint32_t>> members(groups.names.size());
  for (std::size_t i = 0; i < photons.batch.size(); ++i) {
    const std::uint32_t photon = whole.order.empty() ? static_cast<std::uint32_t>(i) : whole.order[i];
    members[groups.of_source[photons.sources[photon]]].push_back(photon);
  }
  IndexedMap::Engines engines;
  for (const std::vector<std::uint32_t>& group : members) {
    const PhotonSample of_group = sample_of(photons.batch, flux, whole, group);
    engines.push_back(engine_of(inputs));
    engines.back()->build(of_group.photons, of_group.photons.flux, of_group.policy, statistics);
  }
  return engines;
}

}  // namespace

std::uint64_t IndexedMap::Engines::bytes(std::size_t photons) const {
  return (empty() ? 0 : front()->index_bytes(photons)) + (grouped ? GroupedMap::bytes(photons) : 0);
}

std::vector<float> scaled(std::vector<float> radii, float factor) {
  if (factor != 1)
    for (float& radius : radii) radius *= factor;
  return radii;
}

void IndexedMap::set_photons(const PhotonInputs& inputs, Photons photons) {
  clear();
  count_ = photons.batch.size();
  photons_.update(inputs, [&] { return std::move(photons); });
}

void IndexedMap::drop_photons() {
  photons_.clear();
  radii_.clear();
  correction_.clear();
}

bool IndexedMap::is_up_to_date(const IndexInputs& inputs, MoreOfMap more) const {
  return engines_.is_made_of(inputs) && (!more.narrow || narrow_.is_made_of(inputs)) &&
         (!more.sample || sample_.is_made_of(inputs)) &&
         (inputs.correction != BoundaryCorrection::estimates || query_radii_.is_made_of(inputs));
}

void IndexedMap::update(const IndexInputs& inputs, MoreOfMap more, const MapWork& work, const QueryRadii* widest) {
  {
    const PhaseTimer timer(work.statistics, Phase::build_photon_map);
    radii_.update(inputs, [&] { return measure(inputs, widest); });
    correction_.update(inputs, [&] { return correction(inputs, work); });
    if (inputs.correction == BoundaryCorrection::estimates)
      query_radii_.update(inputs, [&] { return std::make_unique<QueryRadii>(photons_->batch, policy(inputs)); });
    else
      query_radii_.clear();
  }
  engines_.update(inputs, [&] { return index(inputs, flux(), policy(inputs), work); });
  if (more.narrow)
    narrow_.update(inputs, [&] { return index_narrow(inputs, work); });
  else
    narrow_.clear();
  if (more.sample)
    sample_.update(inputs, [&] { return choose_sample(inputs, work.statistics); });
  else
    sample_.clear();
}

PhotonRadii IndexedMap::measure(const RadiusInputs& inputs, const QueryRadii* widest) const {
  const PhotonBatch& photons = photons_->batch;
  if (inputs.fixed_radius && count_ > 0)
    return {std::vector<float>(count_, inputs.radius > 0 ? inputs.radius : fixed_radius(photons, inputs.nearest)), {}};
  PhotonRadii out = measured_radii(photons, inputs.nearest);
  if (!widest) return out;
  const std::vector<float> most = widest->at(photons.position, photons.normal, photons.flux);
  for (std::size_t i = 0; i < count_; ++i)
    if (most[i] > 0) out.radii[i] = std::min(out.radii[i], most[i]);
  return out;
}

RadiusPolicy IndexedMap::policy(const KernelInputs& inputs) const {
  RadiusPolicy policy;
  policy.kernel = inputs.kernel;
  policy.k = inputs.nearest;
  policy.kind = inputs.takes_nearest ? RadiusKind::nearest : RadiusKind::per_photon;
  policy.radii = scaled(radii_->radii, inputs.radius_scale);
  policy.order = radii_->order;
  policy.cuts = correction_->cuts;
  if (policy.radii.empty()) return policy;
  // Where photons are few, the nearest may be in another part of the scene: an estimate never reaches further than the
  // largest radius that density estimation uses.
  policy.max_radius = 2 * *std::max_element(policy.radii.begin(), policy.radii.end());
  if (inputs.fixed_radius) {
    policy.kind = RadiusKind::fixed;
    policy.radius = policy.radii.front();
  }
  return policy;
}

/// Boundary factors for kernels of these radii. @param name of the work, for other processes
/// @param cuts receives the cuts of these kernels; null: not wanted
std::vector<float> IndexedMap::factors(RadiusPolicy policy, const std::string& name, std::vector<PhotonCuts>* cuts,
                                       bool on_all_surfaces, const MapWork& work) const {
  const auto found_for = [&](const std::string& round) {
    return boundary_factors(work.tracer, photons_->batch, policy, work.sides, cuts, work.shared,
                            name_ + ("-" + name + round), on_all_surfaces);
  };
  const bool is_nearest = policy.kind == RadiusKind::nearest;
  policy.kind = RadiusKind::per_photon;
  if (is_nearest) {
    // Where only part of a disc has photons, the k nearest lie further away: the part has the area of the whole disc,
    // whatever the kernel. A larger disc may again be empty in part.
    const std::vector<float> whole = policy.radii;
    const KernelShape shape = std::exchange(policy.kernel, KernelShape::box);
    // More rounds change little.
    for (int round = 0; round < 4; ++round) {
      const std::vector<float> found = found_for(fmt::format("-in-radii-{}", round));
      for (std::size_t i = 0; i < found.size(); ++i)
        policy.radii[i] = std::min(whole[i] * std::sqrt(found[i]), policy.max_radius);
    }
    policy.kernel = shape;
  }
  return found_for("");
}

IndexedMap::Correction IndexedMap::correction(const KernelInputs& inputs, const MapWork& work) const {
  Correction out;
  if (inputs.correction == BoundaryCorrection::none) return out;
  RadiusPolicy policy = this->policy(inputs);
  const bool is_nearest = policy.kind == RadiusKind::nearest,
             of_photons = inputs.correction == BoundaryCorrection::photons;
  if (of_photons)
    out.factors = factors(policy, "factors", is_nearest ? nullptr : &out.cuts, inputs.on_all_surfaces, work);
  if (of_photons && !is_nearest) return out;
  // The nearest photons may be as far away as the limit.
  if (is_nearest) policy.radii.assign(count_, policy.max_radius);
  out.cuts = kernel_cuts(work.tracer, photons_->batch, policy.radii, inputs.on_all_surfaces);
  return out;
}

LargeVector<RGB> IndexedMap::flux() const {
  const LargeVector<RGB>& flux = photons_->batch.flux;
  return correction_->factors.empty() ? flux : flux_times(flux, correction_->factors);
}

IndexedMap::Engines IndexedMap::index(const IndexInputs& inputs, const LargeVector<RGB>& flux,
                                      const RadiusPolicy& policy, const MapWork& work) const {
  if (inputs.light_groups) return index_groups(*photons_, flux, policy, inputs, work.statistics);
  Engines engines;
  engines.push_back(engine_of(inputs));
  engines.front()->build(photons_->batch, flux, policy, work.statistics);
  return engines;
}

IndexedMap::Engines IndexedMap::index_narrow(const IndexInputs& inputs, const MapWork& work) const {
  if (count_ == 0) return {};
  const PhaseTimer timer(work.statistics, Phase::build_photon_map);
  RadiusPolicy policy = this->policy(inputs);
  policy.k = std::max<std::uint32_t>(1, policy.k / 2);
  policy.radius *= kNarrow;
  for (float& radius : policy.radii) radius *= kNarrow;
  LargeVector<RGB> flux = photons_->batch.flux;
  if (!correction_->factors.empty())
    flux = flux_times(std::move(flux), factors(policy, "narrow-factors", nullptr, inputs.on_all_surfaces, work));
  return index(inputs, flux, policy, work);
}

/// One photon of each run.
PhotonSample IndexedMap::choose_sample(const KernelInputs& inputs, Statistics& statistics) const {
  const PhaseTimer timer(statistics, Phase::photon_noise);
  const std::size_t run = std::max<std::size_t>((count_ + kMostSampled - 1) / kMostSampled, 1);
  const RadiusPolicy policy = this->policy(inputs);
  std::vector<std::uint32_t> chosen = one_of_each_run(count_, run);
  if (!policy.order.empty())
    for (std::uint32_t& place : chosen) place = policy.order[place];
  PhotonSample out = sample_of(photons_->batch, flux(), policy, chosen);
  out.each = static_cast<float>(run);
  return out;
}

std::uint64_t IndexedMap::bytes() const {
  std::uint64_t bytes = correction_->cuts.size() * sizeof(PhotonCuts);
  bytes += narrow().bytes(count_);
  bytes += sample().photons.size() * (bytes_each<PhotonBatch>() + kBytesBesidePhoton);
  if (query_radii()) bytes += QueryRadii::bytes(count_);
  if (photons_.inputs()) bytes += count_ * (bytes_each<PhotonBatch>() + kBytesBesidePhoton);
  return bytes;
}

}  // namespace glowworm
