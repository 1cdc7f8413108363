#include "render/photon_renderer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "density/density_control.h"
#include "density/query_store.h"
#include "density/radius.h"
#include "gather/direct_light.h"
#include "gather/final_gather.h"
#include "render/photon_policy.h"
#include "render/scheduler.h"

namespace glowworm {

namespace {

/// Memory for the cache of a file with query points.
constexpr std::uint64_t kLeastCache = std::uint64_t{1} << 20, kMostCache = std::uint64_t{64} << 20;

/// Photons at which it is looked how bright the scene is, at most, and what each takes meanwhile.
constexpr std::uint64_t kMostLitPlaces = 32768, kBytesPerLitPlace = 512;

/// Passes of photons that a caustic map is made of at most.
constexpr std::uint64_t kMostCausticPasses = 8;
/// Photons of the caustic map that are enough, as a share of those of the global map.
constexpr double kCausticShare = 0.5;
/// Photons that are traced for the caustic map alone, at most, for each gather ray of a sample of all pixels: so they
/// take a small part of a render of kUsualSamples.
constexpr double kCausticPhotonsPerRay = 2;
/// A render with less time than that, in seconds, goes on to its first image.
constexpr double kLeastTimeForCaustics = 30;

/// Passes that bring enough caustic photons if each brings so many.
std::uint64_t caustic_passes(const RenderSettings& settings, std::size_t each) {
  if (each == 0 || settings.progressive || settings.indirect_only) return 1;
  if (settings.time_limit_s > 0 && settings.time_limit_s < kLeastTimeForCaustics) return 1;
  const double rays = static_cast<double>(settings.width) * settings.height * std::max(settings.gather, 1u);
  const auto affordable =
      static_cast<std::uint64_t>(kCausticPhotonsPerRay * rays / static_cast<double>(settings.photons_traced));
  const auto enough =
      static_cast<std::uint64_t>(kCausticShare * static_cast<double>(settings.photons) / static_cast<double>(each));
  return std::clamp<std::uint64_t>(std::min(enough, 1 + affordable), 1, kMostCausticPasses);
}

/// Makes up for what the kernels lose over edges.
void correct_boundaries(const Tracer& tracer, PhotonBatch& photons, const RadiusPolicy& policy) {
  const std::vector<float> factors = edge_factors(tracer, photons, policy);
  for (std::size_t i = 0; i < photons.size(); ++i) photons.flux[i] *= factors[i];
}

RadiusPolicy make_policy(const PhotonBatch& photons, const RenderSettings& settings, const std::string& engine,
                         std::uint32_t k, float radius_scale) {
  std::vector<float> radii;
  if (settings.fixed_radius && photons.size() > 0) {
    radii.assign(photons.size(), fixed_radius(photons, k) * radius_scale);
  } else {
    radii = per_photon_radii(photons, k);
    for (float& radius : radii) radius *= radius_scale;
  }
  RadiusPolicy policy = photon_policy(std::move(radii), engine, settings.kernel, k);
  if (settings.fixed_radius && photons.size() > 0) {
    policy.kind = RadiusKind::fixed;
    policy.radius = policy.radii.front();
  }
  return policy;
}

}  // namespace

PhotonRenderer::PhotonRenderer(const Tracer& tracer, const RenderSettings& settings, MemoryBudget& budget,
                               Statistics& statistics)
    : tracer_(tracer), settings_(settings), budget_(budget), statistics_(statistics) {}

PhotonRenderer::~PhotonRenderer() = default;

std::string PhotonRenderer::engine() const { return engine_ ? engine_->name() : settings_.engine; }

std::uint64_t PhotonRenderer::photon_bytes() const { return photon_count_ * (PhotonBatch::kBytesEach + sizeof(float)); }

void PhotonRenderer::shoot_photons(std::uint32_t pass, float radius_scale) {
  // Photons may take all memory that tasks have left.
  queries_ = QueryPoints();
  corners_ = QueryPoints();
  found_ = LargeVector<RGB>();
  photon_reservation_.reset();
  photon_reservation_ =
      std::make_unique<Reservation>(budget_, "photon map", settings_.photons_traced * kBytesPerPhoton);
  PhotonPassSettings wanted;
  wanted.photons = settings_.photons_traced;
  wanted.seed = settings_.seed;
  wanted.pass = pass;
  // A photon's path goes on by two bounces: where its flux is looked up, and at the gather point.
  wanted.max_bounces = std::max(1, settings_.max_bounces - 1);
  if (settings_.guiding && !guiding_) {
    const PhaseTimer timer(statistics_, Phase::trace_photons);
    guiding_ = std::make_unique<PhotonGuiding>(guide_photons(tracer_, settings_));
  }
  if (guiding_) {
    wanted.guide = &guiding_->guide;
    wanted.demand = &guiding_->demand;
  }
  pass_ = trace_photons(tracer_, wanted, statistics_);
  add(light_photons_, photons_by_light(tracer_.scene(), pass_));
  if (settings_.photons_traced > settings_.photons) {
    const PhaseTimer timer(statistics_, Phase::build_photon_map);
    DensityControlSettings control;
    control.wanted = settings_.photons;
    control.seed = settings_.seed;
    pass_.global = control_density(pass_.global, control);
  }
  const std::string name = settings_.engine;
  engine_ = make_engine(settings_.engine, {.reorder = settings_.reorder});
  const RadiusPolicy policy = make_policy(pass_.global, settings_, name, settings_.nearest, radius_scale);
  if (settings_.boundary_correction) {
    const PhaseTimer timer(statistics_, Phase::build_photon_map);
    correct_boundaries(tracer_, pass_.global, policy);
  }
  engine_->build(pass_.global, policy, statistics_);
  radii_ = RadiusGrid(pass_.global.position, policy.radii);
  find_bright_patches();
  photon_bounds_ = pass_.global.bounds();
  photon_count_ = pass_.global.size();
  pass_.global = PhotonBatch();
  build_caustic_map(wanted, radius_scale);
  hold_engines_only();
}

void PhotonRenderer::build_caustic_map(const PhotonPassSettings& first, float radius_scale) {
  caustic_engine_.reset();
  const std::size_t few = pass_.caustic.size();
  if (few == 0) return;
  add_caustic_photons(first);
  // The same blur with less noise: where caustics are bright their photons are many without that.
  const double growth = static_cast<double>(pass_.caustic.size()) / static_cast<double>(few);
  const auto k = static_cast<std::uint32_t>(std::lround(growth * caustic_nearest(settings_.nearest)));
  caustic_engine_ = make_engine(settings_.engine, {.reorder = settings_.reorder});
  const RadiusPolicy policy = make_policy(pass_.caustic, settings_, settings_.engine, k, radius_scale);
  if (settings_.boundary_correction) correct_boundaries(tracer_, pass_.caustic, policy);
  caustic_engine_->build(pass_.caustic, policy, statistics_);
  photon_count_ += pass_.caustic.size();
}

void PhotonRenderer::add_caustic_photons(PhotonPassSettings settings) {
  const std::uint64_t passes = caustic_passes(settings_, pass_.caustic.size());
  if (passes == 1) return;
  const PhaseTimer timer(statistics_, Phase::trace_photons);
  Statistics not_of_the_global_map;
  for (settings.pass = 1; settings.pass < passes; ++settings.pass)
    pass_.caustic.append(trace_photons(tracer_, settings, not_of_the_global_map).caustic);
  for (RGB& flux : pass_.caustic.flux) flux *= 1 / static_cast<float>(passes);
}

void PhotonRenderer::find_bright_patches() {
  bright_ = BrightPatches();
  if (!settings_.gather_guiding || pass_.global.size() == 0) return;
  const PhaseTimer timer(statistics_, Phase::build_photon_map);
  const std::uint64_t most = std::min(kMostLitPlaces, budget_.available() / 8 / kBytesPerLitPlace);
  if (most == 0) return;
  const Reservation reservation(budget_, "bright patches", most * kBytesPerLitPlace);
  const std::size_t step = (pass_.global.size() + most - 1) / most;
  LitPlaces places;
  QueryPoints queries;
  for (std::size_t i = 0; i < pass_.global.size(); i += step) {
    places.position.push_back(pass_.global.position[i]);
    places.normal.push_back(pass_.global.normal[i]);
    places.flux.push_back(luminance(pass_.global.flux[i]) * static_cast<float>(step));
    queries.push_back(pass_.global.position[i], pass_.global.normal[i], RGB(1.0f), RGB(1.0f), 0);
  }
  std::vector<RGB> found(queries.size());
  Statistics not_the_renders;
  engine_->estimate(queries, found, not_the_renders);
  for (const RGB& radiance : found) places.irradiance.push_back(kPi * luminance(radiance));
  bright_ = BrightPatches(tracer_, places, radii_);
}

void PhotonRenderer::hold_engines_only() {
  const std::uint64_t held = engine_->plan(0, photon_count_, 0).bytes;
  pass_.caustic = PhotonBatch();
  return_free_memory();
  photon_reservation_.reset();
  photon_reservation_ = std::make_unique<Reservation>(budget_, "photon map", held);
}

void PhotonRenderer::render(const Camera& camera, const CameraTask& task, SlotRadiance& radiance, FirstHit& first_hit) {
  const Reservation reservation(budget_, "camera samples", task.slot_count() * kBytesPerSlot);
  CameraPassSettings camera_settings;
  camera_settings.width = settings_.width;
  camera_settings.height = settings_.height;
  camera_settings.seed = settings_.seed;
  const GatherPoints points = camera_pass(tracer_, camera, task, camera_settings, radiance, first_hit, statistics_);
  if (settings_.integrator == Integrator::photons) {
    look_up(gather_points_as_queries(points), *engine_, radiance.indirect);
    return;
  }
  if (!settings_.indirect_only)
    add_direct_light(tracer_, points, settings_.seed, settings_.light_samples, settings_.gather, radiance, statistics_);
  if (!settings_.indirect_only && caustic_engine_)
    look_up(gather_points_as_queries(points), *caustic_engine_, radiance.caustic);
  gather(points, radiance);
}

void PhotonRenderer::gather(const GatherPoints& points, SlotRadiance& radiance) {
  FinalGatherSettings gather_settings;
  gather_settings.rays = settings_.gather;
  gather_settings.seed = settings_.seed;
  gather_settings.light_samples = settings_.indirect_only ? 0 : settings_.light_samples;
  gather_settings.radii = settings_.secondary_gather ? &radii_ : nullptr;
  gather_settings.bright = &bright_;
  gather_settings.patch_samples = usual_patch_samples(settings_.gather);
  const std::size_t rays_each = settings_.gather + (bright_.empty() ? 0 : gather_settings.patch_samples);
  const Reservation rays(budget_, "rays", kBytesPerThread * static_cast<std::uint64_t>(settings_.threads));
  const DensityEngine* caustics = settings_.secondary_gather ? caustic_engine_.get() : nullptr;
  // A ray that gathers again asks both maps.
  const std::uint64_t bytes_each = kBytesPerQuery * (caustics ? 2 : 1);
  const std::uint64_t room = budget_.available() / bytes_each;
  const std::size_t queries_at_once = static_cast<std::size_t>(std::min<std::uint64_t>(queries_at_once_, room));
  const std::size_t step = std::max<std::size_t>(1, queries_at_once / rays_each);
  const auto trace = [&](std::size_t first) {
    final_gather(tracer_, points, first, std::min(first + step, points.size()), gather_settings, radiance,
                 {queries_, caustics ? &corners_ : nullptr}, statistics_);
    if (caustics) look_up(corners_, *caustics, radiance.indirect);
  };
  const Reservation reservation(budget_, "query points", std::min(step, points.size()) * rays_each * bytes_each);
  if (!by_disk_) {
    for (std::size_t first = 0; first < points.size(); first += step) {
      trace(first);
      look_up(queries_, *engine_, radiance.indirect);
    }
    return;
  }
  const std::uint64_t cache_bytes = std::clamp(budget_.available() / 2, kLeastCache, kMostCache);
  const Reservation cache(budget_, "disk cache", cache_bytes);
  // A ray that ends on a translucent sheet gives two.
  QueryStore store(photon_bounds_, 2 * points.size() * rays_each, cache_bytes);
  for (std::size_t first = 0; first < points.size(); first += step) {
    trace(first);
    const PhaseTimer timer(statistics_, Phase::reorder);
    store.append(queries_);
  }
  queries_ = QueryPoints();
  store.visit(queries_at_once, [&](const QueryPoints& run) { look_up(run, *engine_, radiance.indirect); });
  paged_ += store.counts();
}

void PhotonRenderer::look_up(const QueryPoints& queries, const DensityEngine& engine, std::vector<RGB>& target) {
  found_.assign(queries.size(), RGB());
  query_bytes_ = std::max<std::uint64_t>(query_bytes_, queries.size() * (QueryPoints::kBytesEach + sizeof(RGB)));
  engine.estimate(queries, found_, statistics_);
  complete(queries, found_, target, statistics_);
}

}  // namespace glowworm
