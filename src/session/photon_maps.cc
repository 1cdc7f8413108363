#include "session/photon_maps.h"

#include <algorithm>
#include <span>
#include <utility>

#include "core/parallel.h"
#include "render/photon_policy.h"

namespace glowworm {

namespace {

/// Photons carry other values instead of their flux while it lives, also where building an index is left half done.
class BorrowedFlux {
 public:
  BorrowedFlux(PhotonBatch& photons, LargeVector<RGB> values) : photons_(photons), own_(std::move(values)) {
    std::swap(photons_.flux, own_);
  }
  ~BorrowedFlux() { std::swap(photons_.flux, own_); }
  BorrowedFlux(const BorrowedFlux&) = delete;
  BorrowedFlux& operator=(const BorrowedFlux&) = delete;

 private:
  PhotonBatch& photons_;
  LargeVector<RGB> own_;
};

/// Builds an engine over photons whose flux is multiplied by factors, if there are any.
std::unique_ptr<DensityEngine> build(const std::string& name, PhotonBatch& photons, std::span<const float> factors,
                                     const RadiusPolicy& policy, Statistics& statistics) {
  std::unique_ptr<DensityEngine> engine = make_engine(name);
  if (factors.empty()) {
    engine->build(photons, policy, statistics);
    return engine;
  }
  LargeVector<RGB> flux = photons.flux;
  for (std::size_t i = 0; i < flux.size(); ++i) flux[i] *= factors[i];
  const BorrowedFlux multiplied(photons, std::move(flux));
  engine->build(photons, policy, statistics);
  return engine;
}

std::vector<float> scaled(std::vector<float> radii, float factor) {
  if (factor != 1)
    for (float& radius : radii) radius *= factor;
  return radii;
}

/// The policy for an engine over photons of these radii.
RadiusPolicy policy_of(const PhotonRadii& radii, const PhotonMapSettings& settings, std::uint32_t nearest) {
  RadiusPolicy policy =
      photon_policy(scaled(radii.radii, settings.radius_scale), settings.engine, settings.kernel, nearest);
  policy.order = radii.order;
  return policy;
}

}  // namespace

PhotonDiagnosis photon_diagnosis(RGB sum) { return {sum.r, sum.r > 0 ? sum.g / sum.r : 0, sum.b}; }

void PhotonMaps::forget() {
  traced_ = measured_ = corrected_ = indexed_ = gridded_ = false;
  diagnosis_.reset();
}

std::uint64_t PhotonMaps::bytes() const {
  return (pass_.global.size() + pass_.caustic.size()) * (PhotonBatch::kBytesEach + sizeof(float));
}

void PhotonMaps::update(const Tracer& tracer, const PhotonMapSettings& wanted, const Interrupt& interrupt,
                        Statistics& statistics) {
  const PhotonMapSettings old = std::exchange(settings_, wanted);
  if (old.photons != wanted.photons || old.seed != wanted.seed || old.pass != wanted.pass || old.guide != wanted.guide)
    forget();
  if (old.nearest != wanted.nearest) measured_ = false;
  const bool same_radii = measured_ && old.radius_scale == wanted.radius_scale;
  if (!same_radii) gridded_ = false;
  if (!same_radii || old.kernel != wanted.kernel) corrected_ = false;
  if (!same_radii || old.kernel != wanted.kernel || old.engine != wanted.engine || old.corrected != wanted.corrected)
    indexed_ = false;
  if (!same_radii || !wanted.diagnosed) diagnosis_.reset();
  interrupt.check();
  const CancellationScope scope(interrupt.flag());
  if (!traced_) trace(tracer, statistics);
  if (!measured_) measure(statistics);
  if (wanted.corrected && !corrected_) correct(tracer, statistics);
  if (!indexed_) index(statistics);
  if (wanted.corners && !gridded_) lay_grid(statistics);
  if (wanted.diagnosed && !diagnosis_) diagnose(statistics);
}

void PhotonMaps::trace(const Tracer& tracer, Statistics& statistics) {
  measured_ = false;
  PhotonPassSettings wanted;
  wanted.photons = settings_.photons;
  wanted.seed = settings_.seed;
  wanted.pass = settings_.pass;
  wanted.guide = settings_.guide.get();
  pass_ = trace_photons(tracer, wanted, statistics);
  traced_ = true;
}

void PhotonMaps::measure(Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::build_photon_map);
  corrected_ = indexed_ = gridded_ = false;
  radii_ = measured_radii(pass_.global, std::max<std::uint32_t>(1, settings_.nearest));
  caustic_radii_ = measured_radii(pass_.caustic, caustic_nearest(settings_.nearest));
  measured_ = true;
}

RadiusPolicy PhotonMaps::global_policy() const { return policy_of(radii_, settings_, settings_.nearest); }

RadiusPolicy PhotonMaps::caustic_policy() const {
  return policy_of(caustic_radii_, settings_, caustic_nearest(settings_.nearest));
}

void PhotonMaps::correct(const Tracer& tracer, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::build_photon_map);
  factors_ = edge_factors(tracer, pass_.global, global_policy());
  caustic_factors_ = edge_factors(tracer, pass_.caustic, caustic_policy());
  corrected_ = true;
}

void PhotonMaps::index(Statistics& statistics) {
  const std::span<const float> none;
  engine_ = build(settings_.engine, pass_.global, settings_.corrected ? std::span<const float>(factors_) : none,
                  global_policy(), statistics);
  caustic_engine_.reset();
  if (pass_.caustic.size() > 0)
    caustic_engine_ =
        build(settings_.engine, pass_.caustic, settings_.corrected ? std::span<const float>(caustic_factors_) : none,
              caustic_policy(), statistics);
  indexed_ = true;
}

void PhotonMaps::lay_grid(Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::build_photon_map);
  radius_grid_ = RadiusGrid(pass_.global.position, scaled(radii_.radii, settings_.radius_scale));
  gridded_ = true;
}

void PhotonMaps::diagnose(Statistics& statistics) {
  RadiusPolicy counting = global_policy();
  counting.kind = RadiusKind::per_photon;
  // K(box) / h^2 = 1 / (pi h^2): times 1, times h, and times what makes it 1.
  counting.kernel = KernelShape::box;
  LargeVector<RGB> counts(pass_.global.size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const float h = counting.radii[i];
    counts[i] = {1, h, kPi * h * h};
  }
  const BorrowedFlux counted(pass_.global, std::move(counts));
  std::unique_ptr<DensityEngine> engine = make_engine(kAutomaticEngine);
  engine->build(pass_.global, counting, statistics);
  diagnosis_ = std::move(engine);
}

}  // namespace glowworm
