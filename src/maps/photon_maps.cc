#include "maps/photon_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "density/density_control.h"
#include "maps/boundary.h"
#include "maps/memory.h"
#include "maps/photon_guiding.h"
#include "photon/kept_paths.h"
#include "points/query_points.h"

namespace glowworm {

namespace {

/// Most photons from which find_patches() estimates the brightness of the scene, and the memory of each.
constexpr std::uint64_t kMaxLitPlaces = 32768, kBytesPerLitPlace = 512;
/// Paths of a pilot round that finds where to emit them: one of so many of them, within bounds.
constexpr std::uint64_t kCausticPilotShare = 8, kMinCausticPilot = 2048, kMaxCausticPilot = 16384;
/// Their least density: a rare photon of much flux would be a spot in dark parts of a caustic.
constexpr float kCausticFloor = 0.1f;
/// Photons in an estimate from the caustic map of a single pass, and at most, as multiples of k. Caustics are seen
/// directly, where noise shows more than in the global map, and blur is a few pixels.
constexpr double kCausticNearest = 2, kMostCausticNearest = 16;
/// Largest radius of a caustic photon, as a multiple of the radius of the nearest photon of the global map. A disc of
/// that size holds about 4 k photons of all light, and faint caustics add little to their noise. Wider discs would blur
/// faint caustics far into places that they do not reach.
constexpr float kMaxCausticOverGlobal = 2;

/// What the memory of light paths is reserved as.
constexpr const char* kKeptPaths = "kept light paths";

/// Memory for the photons of a pass. Throws Error if they do not fit: fewer photons would change the picture.
std::unique_ptr<Reservation> reserve_photons(std::uint64_t photons, bool media, bool narrow, MemoryBudget& budget) {
  constexpr double kMegabyte = 1e6;  // the unit of --memory
  const std::uint64_t each = bytes_per_photon(media, narrow), wanted = photons * each, there = budget.available();
  if (wanted > there)
    throw MemoryError(
        fmt::format("the photon map takes {:.0f}M while its {} photons are traced; the memory budget has "
                    "{:.0f}M left for it",
                    std::ceil(static_cast<double>(wanted) / kMegabyte), photons,
                    std::floor(static_cast<double>(there) / kMegabyte)),
        fmt::format("Give --memory {:.0f}M or more, or --photons {} or fewer, which is another picture.",
                    std::ceil(static_cast<double>(budget.limit() - there + wanted) / kMegabyte), there / each));
  return std::make_unique<Reservation>(budget, "photon map", wanted);
}

/// Chosen photons for points in air, of `photons` for the whole scene. A guide sends most of them past the points, so a
/// fifth of many photons for each point lies closer together than a picture's photons do without a guide.
std::uint64_t photons_past(std::uint64_t points, std::uint64_t photons) {
  constexpr std::uint64_t kEnough = 100'000, kShares = 5;
  return std::min(photons, std::max(kEnough, photons / kShares) * std::min(points, kShares));
}

/// Photons in an estimate from a caustic map, which grows by this factor with the number of its photons.
std::uint32_t caustic_estimate(std::uint32_t nearest, double growth) {
  // Blur and noise shrink together if radii shrink with the sixth root of the number of photons.
  const double photons = std::min(kCausticNearest * std::pow(growth, 2.0 / 3.0), kMostCausticNearest) * nearest;
  return std::max<std::uint32_t>(1, static_cast<std::uint32_t>(std::lround(photons)));
}

}  // namespace

PhotonDiagnosis photon_diagnosis(RGB sum) { return {sum.r, sum.r > 0 ? sum.g / sum.r : 0, sum.b}; }

float progressive_radius_scale(std::uint32_t pass) {
  constexpr double alpha = 2.0 / 3.0;
  double squared = 1;
  for (std::uint32_t i = 1; i <= pass; ++i) squared *= (i + alpha) / (i + 1);
  return static_cast<float>(std::sqrt(squared));
}

// One path for four gather rays of a sample of all pixels.
std::uint64_t affordable_caustic_paths(double gather_rays) { return static_cast<std::uint64_t>(gather_rays / 4); }

void PhotonMaps::forget() {
  *building_ = false;
  caustic_paths_ = 0;
  for (IndexedMap* map : {&global_, &caustic_}) map->clear();
  for (auto* guide : {&surface_guide_, &air_guide_}) guide->clear();
  lit_sides_.clear();
  media_photons_.clear();
  media_maps_.clear();
  radius_grid_.clear();
  patches_.clear();
  diagnosis_.clear();
  air_ = AirLight();
  reservation_.reset();
}

PhotonInputs PhotonMaps::photon_inputs(const IndexedMap& map) const {
  PhotonInputs inputs = settings_;
  if (settings_.in_air) inputs.nearest_in_air = caustic_estimate(settings_.nearest, 1);
  inputs.caustic_paths = &map == &caustic_ ? caustic_paths_ : 0;
  return inputs;
}

IndexInputs PhotonMaps::inputs_of(const IndexedMap& map) const {
  const bool is_caustic = &map == &caustic_;
  IndexInputs inputs = settings_;
  static_cast<PhotonInputs&>(inputs) = photon_inputs(map);
  inputs.nearest = std::max<std::uint32_t>(1, is_caustic ? caustic_nearest() : settings_.nearest);
  if (is_caustic) inputs.radius = settings_.caustic_radius;
  if (!inputs.fixed_radius) inputs.radius = 0;
  inputs.takes_nearest = engine_traits(inputs.engine).takes_nearest;
  // A moving view makes no correction, but one that is made stays.
  const KernelInputs* made = map.inputs();
  if (inputs.correction != BoundaryCorrection::none || !made) return inputs;
  inputs.correction = made->correction;
  if (!(*made == inputs)) inputs.correction = BoundaryCorrection::none;
  return inputs;
}

bool PhotonMaps::is_done() const {
  const IndexInputs global = inputs_of(global_);
  return global_.is_up_to_date(global, {settings_.narrow, settings_.sampled}) && media_maps_.is_made_of(global) &&
         (media_maps_->is_sampled || !settings_.sampled) &&
         (caustic_.count() == 0 ||
          caustic_.is_up_to_date(inputs_of(caustic_), {settings_.narrow_caustic, settings_.sampled})) &&
         caustic_paths_ >= wanted_caustic_paths() && (radius_grid_.is_made_of(global) || !finds_radii()) &&
         (patches_.is_made_of(global) || !settings_.patches) && (diagnosis_.is_made_of(global) || !settings_.diagnosed);
}

void PhotonMaps::update(const Tracer& tracer, const PhotonMapSettings& wanted, Statistics& statistics) {
  settings_ = wanted;
  air_.kernel = settings_.kernel;
  air_.radius_scale = settings_.radius_scale;
  air_.extrapolates = settings_.air_extrapolates;
  if (is_done()) return;
  // Photons of more paths would replace photons of fewer paths, which have changed the flux of the others.
  const bool has_too_few = caustic_paths_ > 0 && caustic_paths_ < wanted_caustic_paths();
  if (has_too_few || !global_.has_photons(photon_inputs(global_)) || !caustic_.has_photons(photon_inputs(caustic_)))
    trace(tracer, statistics);
  bring_up_sides(tracer, statistics);
  const MapWork work{tracer, *lit_sides_, settings_.shared, statistics};
  bring_up_caustic(work, bring_up_global(work).get());
  bring_up_media(work);
  hold_result();
}

PhotonPassSettings PhotonMaps::pass_settings() const {
  PhotonPassSettings out;
  out.photons = settings_.photons;
  out.seed = settings_.seed;
  out.pass = settings_.pass;
  out.max_bounces = settings_.max_bounces;
  out.guide = settings_.guide.get();
  out.importance = settings_.importance.get();
  out.on_all_surfaces = settings_.on_all_surfaces;
  out.keep_sources = settings_.light_groups != nullptr;
  out.shared = settings_.shared;
  return out;
}

void PhotonMaps::trace(const Tracer& tracer, Statistics& statistics) {
  *building_ = false;
  caustic_paths_ = 0;
  global_.clear();
  caustic_.clear();
  lit_sides_.clear();
  media_photons_.clear();
  media_maps_.clear();
  // What was found with these photons before stays: radii by place and bright patches.
  const IndexInputs inputs = inputs_of(global_);
  radius_grid_.keep_if(inputs);
  patches_.keep_if(inputs);
  diagnosis_.keep_if(inputs);
  air_.segments = {};
  reservation_.reset();
  const PhotonPassSettings wanted = pass_settings();
  reservation_ = reserve_photons(wanted.photons, !tracer.scene().media().empty(), settings_.narrow, *budget_);
  pass_ = PhotonPass();
  {
    // Pilots, and photons that pass sensors, are part of this phase, too.
    const PhaseTimer timer(statistics, Phase::trace_photons);
    if (settings_.in_air) trace_air(tracer, wanted, statistics);
    if (settings_.choice != PhotonChoice::all)
      pass_ = trace_chosen(tracer, settings_.choice, nullptr, statistics);
    else if (pass_.emitted == 0)
      pass_ = trace_all(tracer, wanted, statistics);
  }
  *building_ = true;
  if (settings_.thinned > 0) {
    const PhaseTimer timer(statistics, Phase::build_photon_map);
    DensityControlSettings control;
    control.wanted = settings_.thinned;
    control.seed = settings_.seed;
    pass_.global = control_density(pass_.global, control);
  }
  IndexedMap::Photons global{std::move(pass_.global), std::move(pass_.global_source)};
  IndexedMap::Photons caustic{std::move(pass_.caustic), std::move(pass_.caustic_source)};
  for (IndexedMap::Photons* photons : {&global, &caustic}) {
    // Larger maps are sorted in space before all work on them: on disk, neighbouring photons would lie on different
    // pages.
    if (photons->batch.size() <= std::size_t{1} << 22) continue;
    const PhaseTimer timer(statistics, Phase::build_photon_map);
    const std::vector<std::uint32_t> places = places_by_cell(photons->batch.position);
    photons->batch = photons->batch.moved(places);
    if (!photons->sources.empty()) photons->sources = moved(photons->sources, places);
  }
  media_photons_.update(inputs, [&] { return MediaPhotons{std::move(pass_.in_media), std::move(pass_.beams)}; });
  first_caustic_ = caustic.batch.size();
  bounds_ = global.batch.bounds();
  global_.set_photons(inputs, std::move(global));
  caustic_.set_photons(photon_inputs(caustic_), std::move(caustic));
}

/// Traces a pass of all photons, but for light paths that are kept from another moment of the scene.
PhotonPass PhotonMaps::trace_all(const Tracer& tracer, PhotonPassSettings pass, Statistics& statistics) {
  if (settings_.most_kept_bytes == 0 || pass.shared) return trace_photons(tracer, pass, statistics);
  kept_room_.reset();
  const std::uint64_t room = std::min(settings_.most_kept_bytes, budget_->available());
  kept_room_ = std::make_unique<Reservation>(*budget_, kKeptPaths, room);
  if (!kept_paths_) kept_paths_ = std::make_shared<KeptPaths>();
  kept_paths_->begin(tracer, pass, {settings_.guide, settings_.importance}, room);
  pass.kept = kept_paths_.get();
  PhotonPass out = trace_photons(tracer, pass, statistics);
  kept_room_.reset();
  kept_room_ = std::make_unique<Reservation>(*budget_, kKeptPaths, kept_paths_->bytes());
  return out;
}

/// Traces the photons that pass points in air. If these are all photons, the pass has those on surfaces, too.
void PhotonMaps::trace_air(const Tracer& tracer, PhotonPassSettings pass, Statistics& statistics) {
  air_.nearest = photon_inputs(global_).nearest_in_air;
  if (settings_.air_choice != PhotonChoice::all)
    pass.photons = photons_past(settings_.in_air->position.size(), pass.photons);
  air_.most_radius = most_air_radius(tracer.scene(), pass.photons, air_.nearest);
  const DiscTree discs = air_discs(tracer.scene(), *settings_.in_air, air_.most_radius);
  pass.discs = &discs;
  if (!air_.images) air_.images = std::make_shared<const LightImages>(LightImages::of_lights(tracer.scene()));
  if (settings_.air_choice == PhotonChoice::all) {
    pass_ = trace_photons(tracer, pass, statistics);
    air_.segments = std::exchange(pass_.segments, {});
  } else {
    Statistics not_of_the_map;
    air_.segments = trace_chosen(tracer, settings_.air_choice, &discs, not_of_the_map).segments;
  }
  // A guide may bring more photons to the points.
  const double growth =
      static_cast<double>(air_.segments.size()) / even_air_photons(discs.discs().size(), air_.nearest);
  air_.nearest = caustic_estimate(settings_.nearest, std::max(growth, 1.0));
}

/// Traces a pass of chosen photons, guided by pilot paths.
/// @param discs for points in air; null: photons on surfaces
PhotonPass PhotonMaps::trace_chosen(const Tracer& tracer, PhotonChoice choice, const DiscTree* discs,
                                    Statistics& statistics) {
  PhotonPassSettings wanted = pass_settings();
  if (discs) wanted.photons = photons_past(settings_.in_air->position.size(), wanted.photons);
  wanted.choice = choice;
  wanted.discs = discs;
  wanted.images = air_.images.get();
  wanted.importance = nullptr;
  wanted.max_emitted = wanted.photons;
  const auto learn = [&] {
    wanted.pass = kPilotStream;  // a pass number that photons never use
    const std::uint64_t pilot = std::clamp(wanted.photons / kCausticPilotShare, kMinCausticPilot, kMaxCausticPilot);
    // The first round has up to 8 times as many paths, until enough of them leave chosen photons.
    return std::make_shared<const EmissionGuide>(
        learn_emission(tracer, wanted, {.count = pilot, .most_in_first = 8, .floor = kCausticFloor}));
  };
  wanted.guide = (discs ? air_guide_ : surface_guide_).update(settings_, learn).get();
  wanted.pass = hash_combine(discs ? kAirStream : kChosenStream, settings_.pass);
  return trace_photons(tracer, wanted, statistics);
}

void PhotonMaps::correct(const Tracer& tracer, const QueryPoints& points, std::span<RGB> radiance,
                         bool is_narrow) const {
  const QueryRadii* found = global_.query_radii();
  if (!found || points.size() == 0) return;
  const std::vector<float> radii =
      scaled(found->at(points.position, points.normal, radiance), is_narrow ? IndexedMap::kNarrow : 1);
  correct_estimates(tracer, points, radii, found->kernel(), *lit_sides_, radiance, settings_.on_all_surfaces);
}

/// Finds them by all photons, but in maps of chosen ones.
void PhotonMaps::bring_up_sides(const Tracer& tracer, Statistics& statistics) {
  if (inputs_of(global_).correction == BoundaryCorrection::none) return;
  const PhaseTimer timer(statistics, Phase::build_photon_map);
  const IndexedMap& map = settings_.choice == PhotonChoice::all ? global_ : caustic_;
  lit_sides_.update(photon_inputs(global_), [&] { return LitSides(tracer, map.photons().batch); });
}

std::unique_ptr<const QueryRadii> PhotonMaps::bring_up_global(const MapWork& work) {
  const IndexInputs inputs = inputs_of(global_);
  global_.update(inputs, {settings_.narrow, settings_.sampled}, work);
  const std::vector<float>& radii = global_.radii().radii;
  common_radius_ = settings_.fixed_radius && !radii.empty() ? radii.front() : 0;
  if (finds_radii()) {
    const PhaseTimer timer(work.statistics, Phase::build_photon_map);
    radius_grid_.update(
        inputs, [&] { return RadiusGrid(global_.photons().batch.position, scaled(radii, settings_.radius_scale)); });
    if (settings_.patches) patches_.update(inputs, [&] { return find_patches(work.tracer); });
  }
  std::unique_ptr<const QueryRadii> widest_caustics;
  if (caustic_.count() > 0 && !settings_.fixed_radius) {
    const PhaseTimer timer(work.statistics, Phase::build_photon_map);
    RadiusPolicy policy;
    policy.kind = RadiusKind::per_photon;
    policy.radii = scaled(radii, kMaxCausticOverGlobal);
    widest_caustics = std::make_unique<const QueryRadii>(global_.photons().batch, policy);
  }
  if (settings_.diagnosed)
    diagnosis_.update(inputs, [&] { return diagnose(inputs, work.statistics); });
  else
    diagnosis_.clear();
  if (!settings_.kept) global_.drop_photons();
  return widest_caustics;
}

void PhotonMaps::bring_up_caustic(const MapWork& work, const QueryRadii* widest) {
  if (caustic_.count() == 0) return;
  if (caustic_paths_ < wanted_caustic_paths()) add_caustic_photons(work.tracer, work.statistics);
  caustic_.update(inputs_of(caustic_), {settings_.narrow_caustic, settings_.sampled}, work, widest);
  if (!settings_.kept) caustic_.drop_photons();
}

void PhotonMaps::bring_up_media(const MapWork& work) {
  const IndexInputs inputs = inputs_of(global_);
  if (settings_.sampled && !media_maps_->is_sampled) media_maps_.clear();
  media_maps_.update(inputs, [&] {
    return make_media_maps(work.tracer, *media_photons_, inputs, settings_.sampled, work.statistics);
  });
  if (!settings_.kept) media_photons_.clear();
}

/// Photons in an estimate from the caustic map.
std::uint32_t PhotonMaps::caustic_nearest() const {
  return caustic_estimate(settings_.nearest, static_cast<double>(caustic_.count()) /
                                                 static_cast<double>(std::max<std::size_t>(first_caustic_, 1)));
}

/// Paths to emit for the caustic map alone.
std::uint64_t PhotonMaps::wanted_caustic_paths() const {
  // As many photons as the global map has are enough, and fit into the memory that was reserved to trace it.
  const bool is_small = first_caustic_ > 0 && first_caustic_ < settings_.photons;
  const std::uint64_t paths = settings_.more_caustic_paths;
  return is_small && paths >= kCausticPilotShare * kMinCausticPilot ? paths : 0;
}

void PhotonMaps::add_caustic_photons(const Tracer& tracer, Statistics& statistics) {
  const PhaseTimer timer(statistics, Phase::trace_photons);
  *building_ = false;
  PhotonPassSettings wanted = pass_settings();
  wanted.choice = PhotonChoice::caustic;
  wanted.photons = settings_.photons - first_caustic_;
  wanted.max_emitted = wanted_caustic_paths();
  wanted.pass = kPilotStream;  // a pass number that photons never use
  const std::uint64_t pilot = std::min(wanted.max_emitted / kCausticPilotShare, kMaxCausticPilot);
  const EmissionGuide guide =
      learn_emission(tracer, wanted, {.count = pilot, .most_in_first = 1, .most_rounds = 4, .floor = kCausticFloor});
  wanted.guide = &guide;
  wanted.pass = settings_.pass + 1;
  Statistics not_of_the_global_map;
  PhotonPass more = trace_photons(tracer, wanted, not_of_the_global_map);
  // Each pass weighs as much as it has photons.
  IndexedMap::Photons photons = caustic_.photons();
  const auto first = static_cast<float>(caustic_.count()), second = static_cast<float>(more.caustic.size());
  for (RGB& flux : photons.batch.flux) flux *= first / (first + second);
  for (RGB& flux : more.caustic.flux) flux *= second / (first + second);
  photons.batch.append(more.caustic);
  photons.sources.insert(photons.sources.end(), more.caustic_source.begin(), more.caustic_source.end());
  // More paths would make no difference where these sufficed.
  const bool sufficed = more.emitted < wanted.max_emitted;
  caustic_paths_ = sufficed ? std::numeric_limits<std::uint64_t>::max() : wanted.max_emitted;
  caustic_.set_photons(photon_inputs(caustic_), std::move(photons));
  *building_ = true;
}

std::uint64_t bytes_per_photon(bool media, bool narrow) {
  // The global and the caustic map, and beside them one's corrected flux, policy and index, and its narrow ones.
  const std::uint64_t map = bytes_each<PhotonBatch>() + kBytesBesidePhoton,
                      index = map + sizeof(RGB) + 2 * sizeof(float), on_surface = 2 * map + (narrow ? 2 : 1) * index;
  if (!media) return on_surface;
  // Points and beams as traced, and the points with their kernels; the flux of a group of lights, the index, and what
  // sorts it: two lists, places and the keys along a curve.
  const std::uint64_t of_index = sizeof(RGB) +
                                 VolumeMap::photon_bytes(kVolumeBlock * kVolumeBlock) / (kVolumeBlock * kVolumeBlock) +
                                 2 * sizeof(std::uint32_t) + sizeof(Vec3) + sizeof(std::uint64_t);
  const std::uint64_t in_medium =
      2 * bytes_each<VolumePhotons>() + bytes_each<VolumeBeams>() + bytes_each<PhotonKernels>() + of_index;
  return std::max(on_surface, in_medium);
}

std::uint64_t bright_patch_bytes(std::uint64_t photons) { return std::min(kMaxLitPlaces, photons) * kBytesPerLitPlace; }

BrightPatches PhotonMaps::find_patches(const Tracer& tracer) const {
  if (global_.count() == 0) return {};
  const std::uint64_t most = std::min<std::uint64_t>(kMaxLitPlaces, global_.count());
  const Reservation reservation(*budget_, "bright patches", bright_patch_bytes(global_.count()));
  const PhotonBatch& photons = global_.photons().batch;
  const LargeVector<RGB> flux = global_.flux();
  const std::size_t step = (photons.size() + most - 1) / most;
  LitPlaces places;
  QueryPoints queries;
  for (std::size_t i = 0; i < photons.size(); i += step) {
    places.position.push_back(photons.position[i]);
    places.normal.push_back(photons.normal[i]);
    places.flux.push_back(luminance(flux[i]) * static_cast<float>(step));
    queries.push_back(photons.position[i], photons.normal[i], RGB(1.0f), RGB(1.0f), 0);
  }
  std::vector<RGB> found(queries.size());
  Statistics not_the_renders;
  for (const auto& engine : engines()) engine->estimate(queries, found, not_the_renders);
  for (const RGB& radiance : found) places.irradiance.push_back(kPi * luminance(radiance));
  return BrightPatches(tracer, places, *radius_grid_);
}

std::unique_ptr<DensityEngine> PhotonMaps::diagnose(const KernelInputs& inputs, Statistics& statistics) const {
  RadiusPolicy counting = global_.policy(inputs);
  counting.kind = RadiusKind::per_photon;
  // K(box) / h^2 = 1 / (pi h^2): times 1, times h, and times its inverse.
  counting.kernel = KernelShape::box;
  LargeVector<RGB> counts(global_.count());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const float h = counting.radii[i];
    counts[i] = {1, h, kPi * h * h};
  }
  std::unique_ptr<DensityEngine> engine = make_engine(kAutomaticEngine);
  engine->build(global_.photons().batch, counts, counting, statistics);
  return engine;
}

void PhotonMaps::reserve_in(MemoryBudget* budget) {
  reservation_.reset();
  kept_room_.reset();
  budget_ = budget;
  if (budget && kept_paths_) {
    if (kept_paths_->bytes() > budget->available()) kept_paths_->clear();
    kept_room_ = std::make_unique<Reservation>(*budget, kKeptPaths, kept_paths_->bytes());
  }
  if (budget && is_done()) hold_result();
}

/// Reserves what remains after the maps are made.
void PhotonMaps::hold_result() {
  std::uint64_t bytes = global_.bytes() + caustic_.bytes() + air_.segments.size() * sizeof(PhotonSegment);
  bytes += lit_sides_->bytes() + engines().bytes(global_.count() + caustic_.count());
  bytes += in_media().bytes() + signed_media().bytes() + media_photons_->points.size() * bytes_each<VolumePhotons>() +
           media_photons_->beams.size() * bytes_each<VolumeBeams>();
  if (diagnosis()) bytes += diagnosis()->index_bytes(global_.count());
  if (!settings_.kept) return_free_memory();
  reservation_.reset();
  reservation_ = std::make_unique<Reservation>(*budget_, "photon map", bytes);
}

}  // namespace glowworm
