#include "session/photon_maps.h"

#include <algorithm>
#include <span>
#include <utility>

#include "core/parallel.h"
#include "density/boundary.h"
#include "density/radius.h"

namespace glowworm {

namespace {

/// Photon passes of this many photons and more are traced in parts, so that a session need not wait for the whole.
constexpr std::uint64_t kPhotonsInParts = 200'000;
constexpr std::uint32_t kParts = 8;
/// Caustics are sharp: their estimate catches fewer photons.
constexpr std::uint32_t kCausticShare = 2;

std::uint32_t part_count(std::uint64_t photons) { return photons >= kPhotonsInParts ? kParts : 1; }

void append_scaled(PhotonBatch& sum, PhotonBatch& part, float factor) {
  for (RGB& flux : part.flux) flux *= factor;
  sum.append(part);
}

/// Factors of correction for the photons, until it is interrupted.
std::vector<float> factors_of(const Tracer& tracer, const PhotonBatch& photons, const RadiusPolicy& policy,
                              const Interrupt& interrupt) {
  const CancellationScope scope(interrupt.flag());
  return boundary_factors(tracer, photons, policy);
}

/// Builds an engine over photons whose flux is multiplied by factors, if there are any.
std::unique_ptr<DensityEngine> build(const std::string& name, PhotonBatch& photons, std::span<const float> factors,
                                     const RadiusPolicy& policy, Statistics& statistics) {
  std::unique_ptr<DensityEngine> engine = make_engine(name);
  if (factors.empty()) {
    engine->build(photons, policy, statistics);
    return engine;
  }
  std::vector<RGB> flux = photons.flux;
  for (std::size_t i = 0; i < flux.size(); ++i) flux[i] *= factors[i];
  std::swap(flux, photons.flux);
  engine->build(photons, policy, statistics);
  std::swap(flux, photons.flux);
  return engine;
}

}  // namespace

PhotonDiagnosis photon_diagnosis(RGB sum) { return {sum.r, sum.r > 0 ? sum.g / sum.r : 0, sum.b}; }

void PhotonMaps::forget() {
  traced_ = measured_ = corrected_ = indexed_ = false;
  diagnosis_.reset();
  parts_.clear();
}

std::uint64_t PhotonMaps::bytes() const {
  return (pass_.global.size() + pass_.caustic.size()) * (PhotonBatch::kBytesEach + sizeof(float));
}

void PhotonMaps::update(const Tracer& tracer, const PhotonMapSettings& wanted, const Interrupt& interrupt,
                        Statistics& statistics) {
  const PhotonMapSettings old = std::exchange(settings_, wanted);
  if (old.photons != wanted.photons || old.seed != wanted.seed || old.pass != wanted.pass) forget();
  if (old.nearest != wanted.nearest) measured_ = false;
  const bool same_radii = measured_ && old.radius_scale == wanted.radius_scale;
  if (!same_radii || old.kernel != wanted.kernel) corrected_ = false;
  if (!same_radii || old.kernel != wanted.kernel || old.engine != wanted.engine || old.corrected != wanted.corrected)
    indexed_ = false;
  if (!same_radii || !wanted.diagnosed) diagnosis_.reset();
  if (!traced_) trace(tracer, interrupt, statistics);
  if (!measured_) measure(interrupt, statistics);
  if (wanted.corrected && !corrected_) correct(tracer, interrupt, statistics);
  if (!indexed_) index(interrupt, statistics);
  if (wanted.diagnosed && !diagnosis_) diagnose(statistics);
}

void PhotonMaps::trace(const Tracer& tracer, const Interrupt& interrupt, Statistics& statistics) {
  measured_ = false;
  const std::uint32_t parts = part_count(settings_.photons);
  while (parts_.size() < parts) {
    interrupt.check();
    PhotonPassSettings part;
    part.photons = settings_.photons / parts;
    part.seed = settings_.seed;
    part.pass = settings_.pass * kParts + static_cast<std::uint32_t>(parts_.size());
    parts_.push_back(trace_photons(tracer, part, statistics));
  }
  const PhaseTimer timer(statistics, Phase::trace_photons);
  pass_ = {};
  for (const PhotonPass& part : parts_) pass_.emitted += part.emitted;
  for (PhotonPass& part : parts_) {
    // Each part is an estimate of its own; together they count by the paths emitted.
    const auto share = static_cast<float>(static_cast<double>(part.emitted) /
                                          static_cast<double>(std::max<std::uint64_t>(pass_.emitted, 1)));
    append_scaled(pass_.global, part.global, share);
    append_scaled(pass_.caustic, part.caustic, share);
  }
  parts_.clear();
  traced_ = true;
}

void PhotonMaps::measure(const Interrupt& interrupt, Statistics& statistics) {
  interrupt.check();
  const PhaseTimer timer(statistics, Phase::build_photon_map);
  corrected_ = indexed_ = false;
  const std::uint32_t k = std::max<std::uint32_t>(1, settings_.nearest);
  radii_ = empty() ? std::vector<float>() : per_photon_radii(pass_.global, k);
  caustic_radii_ = pass_.caustic.size() == 0
                       ? std::vector<float>()
                       : per_photon_radii(pass_.caustic, std::max<std::uint32_t>(1, k / kCausticShare));
  measured_ = true;
}

RadiusPolicy PhotonMaps::policy(const std::vector<float>& radii, std::uint32_t k) const {
  RadiusPolicy policy;
  policy.kernel = settings_.kernel;
  policy.k = std::max<std::uint32_t>(1, k);
  policy.kind = settings_.engine == "knn" ? RadiusKind::nearest : RadiusKind::per_photon;
  policy.radii = radii;
  for (float& radius : policy.radii) radius *= settings_.radius_scale;
  if (!radii.empty()) policy.max_radius = 2 * *std::max_element(policy.radii.begin(), policy.radii.end());
  return policy;
}

void PhotonMaps::correct(const Tracer& tracer, const Interrupt& interrupt, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::build_photon_map);
  factors_ = factors_of(tracer, pass_.global, policy(radii_, settings_.nearest), interrupt);
  caustic_factors_ = factors_of(tracer, pass_.caustic, policy(caustic_radii_, settings_.nearest), interrupt);
  corrected_ = true;
}

void PhotonMaps::index(const Interrupt& interrupt, Statistics& statistics) {
  interrupt.check();
  const std::span<const float> none;
  const RadiusPolicy global = policy(radii_, settings_.nearest);
  engine_ = build(settings_.engine, pass_.global, settings_.corrected ? std::span<const float>(factors_) : none, global,
                  statistics);
  radius_grid_ = RadiusGrid(pass_.global.position, global.radii);
  caustic_engine_.reset();
  if (pass_.caustic.size() > 0)
    caustic_engine_ =
        build(settings_.engine, pass_.caustic, settings_.corrected ? std::span<const float>(caustic_factors_) : none,
              policy(caustic_radii_, settings_.nearest / kCausticShare), statistics);
  indexed_ = true;
}

void PhotonMaps::diagnose(Statistics& statistics) {
  RadiusPolicy counting = policy(radii_, settings_.nearest);
  counting.kind = RadiusKind::per_photon;
  // K(box) / h^2 = 1 / (pi h^2): times 1, times h, and times what makes it 1.
  counting.kernel = KernelShape::box;
  std::vector<RGB> counts(pass_.global.size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const float h = counting.radii[i];
    counts[i] = {1, h, kPi * h * h};
  }
  std::swap(counts, pass_.global.flux);
  diagnosis_ = make_engine("blocked");
  diagnosis_->build(pass_.global, counting, statistics);
  std::swap(counts, pass_.global.flux);
}

}  // namespace glowworm
