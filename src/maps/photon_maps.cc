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
#include "maps/kernel_cuts.h"
#include "maps/memory.h"
#include "maps/photon_guiding.h"
#include "points/query_points.h"

namespace glowworm {

namespace {

/// Most photons from which find_patches() estimates the brightness of the scene, and the memory of each.
constexpr std::uint64_t kMaxLitPlaces = 32768, kBytesPerLitPlace = 512;
/// Memory of a photon in addition to its batch if photons are kept: radius, place in the order, factor.
constexpr std::uint64_t kBytesBesidePhoton = 2 * sizeof(float) + sizeof(std::uint32_t);
/// Most paths emitted only for the caustic map, for each gather ray of a sample of all pixels.
constexpr double kCausticPathsPerRay = 0.25;
/// Paths of a pilot round that finds where to emit them: one of so many of them, within bounds.
constexpr std::uint64_t kCausticPilotShare = 8, kMinCausticPilot = 2048, kMaxCausticPilot = 16384;
/// More of them for chosen photons, until enough of them count.
constexpr std::size_t kMostChosenPilots = 8;
/// Their least density: a rare photon of much flux would be a spot in dark parts of a caustic.
constexpr float kCausticFloor = 0.1f;
/// Photons in an estimate from the caustic map of a single pass, and at most, as multiples of k. Caustics are seen
/// directly, where noise shows more than in the global map, and blur is a few pixels.
constexpr double kCausticNearest = 2, kMostCausticNearest = 16;
/// Maps of more photons are put in the order of space before all work on them: where they lie on disk, each photon
/// would be on another page. Fewer photons keep the order in which they were traced.
constexpr std::size_t kMostUnordered = std::size_t{1} << 22;
/// Radius of a kernel of half the area.
constexpr float kNarrow = 0.70710678f;

/// Memory for the photons of a pass. Throws Error if they do not fit: fewer photons would change the picture.
std::unique_ptr<Reservation> reserve_photons(std::uint64_t photons, MemoryBudget& budget) {
  constexpr double kMegabyte = 1e6;  // the unit of --memory
  const std::uint64_t wanted = photons * kBytesPerPhoton, there = budget.available();
  if (wanted > there)
    throw MemoryError(fmt::format("the photon map takes {:.0f}M while its {} photons are traced; the memory budget has "
                                  "{:.0f}M left for it",
                                  std::ceil(static_cast<double>(wanted) / kMegabyte), photons,
                                  std::floor(static_cast<double>(there) / kMegabyte)),
                      fmt::format("Give --memory {:.0f}M or more, or --photons {} or fewer, which is another picture.",
                                  std::ceil(static_cast<double>(budget.limit() - there + wanted) / kMegabyte),
                                  there / kBytesPerPhoton));
  return std::make_unique<Reservation>(budget, "photon map", wanted);
}

template <typename Factor>
LargeVector<RGB> flux_times(LargeVector<RGB> flux, const std::vector<Factor>& factors) {
  for (std::size_t i = 0; i < flux.size(); ++i) flux[i] *= factors[i];
  return flux;
}

/// A sign for each channel.
std::vector<RGB> random_signs(std::size_t count, std::uint32_t seed) {
  const std::uint32_t key = hash_combine(seed, kPhotonSignStream);
  std::vector<RGB> signs(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t bits = hash_combine(key, static_cast<std::uint32_t>(i));
    const auto sign = [&](int channel) { return (bits >> channel & 1) != 0 ? 1.0f : -1.0f; };
    signs[i] = {sign(0), sign(1), sign(2)};
  }
  return signs;
}

std::vector<float> scaled(std::vector<float> radii, float factor) {
  if (factor != 1)
    for (float& radius : radii) radius *= factor;
  return radii;
}

}  // namespace

PhotonDiagnosis photon_diagnosis(RGB sum) { return {sum.r, sum.r > 0 ? sum.g / sum.r : 0, sum.b}; }

float progressive_radius_scale(std::uint32_t pass) {
  constexpr double alpha = 2.0 / 3.0;
  double squared = 1;
  for (std::uint32_t i = 1; i <= pass; ++i) squared *= (i + alpha) / (i + 1);
  return static_cast<float>(std::sqrt(squared));
}

std::uint64_t affordable_caustic_paths(double gather_rays) {
  return static_cast<std::uint64_t>(kCausticPathsPerRay * gather_rays);
}

void PhotonMaps::forget() {
  surface_guide_.reset();
  air_guide_.reset();
  discard();
}

/// Discards what other photons would change.
void PhotonMaps::discard() {
  *building_ = false;
  traced_ = gridded_ = patched_ = false;
  global_ = Map();
  caustic_ = Map();
  radius_grid_ = RadiusGrid();
  patches_ = BrightPatches();
  diagnosis_.reset();
  air_ = AirLight();
  reservation_.reset();
}

/// Drops the results that other settings have invalidated.
void PhotonMaps::invalidate(const PhotonMapSettings& old) {
  const PhotonMapSettings& now = settings_;
  if (old.photons != now.photons || old.photons_traced != now.photons_traced || old.seed != now.seed ||
      old.guide != now.guide || old.max_bounces != now.max_bounces || old.on_all_surfaces != now.on_all_surfaces ||
      old.light_groups != now.light_groups || old.choice != now.choice || old.in_air != now.in_air ||
      old.air_choice != now.air_choice || (caustic_paths_ > 0 && caustic_paths_ < wanted_caustic_paths()))
    forget();
  else if (old.pass != now.pass || (now.in_air && old.nearest != now.nearest))
    discard();
  const bool other_radii = old.radius_scale != now.radius_scale || old.nearest != now.nearest;
  const bool other_kind = engine_traits(old.engine).takes_nearest != engine_traits(now.engine).takes_nearest;
  for (Map* map : {&global_, &caustic_}) {
    if (other_radii || other_kind) map->cut = false;
    if (old.fixed_radius != now.fixed_radius || old.radius != now.radius || old.caustic_radius != now.caustic_radius ||
        old.nearest != now.nearest)
      map->measured = false;
    if (other_radii || old.kernel != now.kernel) {
      map->corrected = map->indexed = false;
      map->query_radii.reset();
    }
    if (old.engine != now.engine) map->query_radii.reset();
    if (old.engine != now.engine || old.reorder != now.reorder || old.narrow != now.narrow || old.signs != now.signs)
      map->indexed = false;
  }
  if (!global_.measured || other_radii) gridded_ = patched_ = false;
  if (!global_.measured || other_radii || !now.diagnosed) diagnosis_.reset();
}

bool PhotonMaps::is_done(const Map& map) const {
  if (map.count == 0) return true;
  if (settings_.correction != BoundaryCorrection::none && !map.cut) return false;
  if (settings_.correction == BoundaryCorrection::photons && !map.corrected) return false;
  if (settings_.correction == BoundaryCorrection::estimates && !map.query_radii) return false;
  return map.indexed;
}

bool PhotonMaps::is_done() const {
  return traced_ && global_.indexed && is_done(global_) && is_done(caustic_) &&
         caustic_paths_ >= wanted_caustic_paths() && (gridded_ || !settings_.secondary_gather) &&
         (patched_ || !settings_.patches) && (diagnosis_ || !settings_.diagnosed);
}

void PhotonMaps::update(const Tracer& tracer, const PhotonMapSettings& wanted, Statistics& statistics) {
  const PhotonMapSettings old = std::exchange(settings_, wanted);
  invalidate(old);
  if (is_done()) return;
  const bool photons_gone = global_.photons.size() != global_.count || caustic_.photons.size() != caustic_.count;
  if (!traced_ || photons_gone) trace(tracer, statistics);
  bring_up_global(tracer, statistics);
  bring_up_caustic(tracer, statistics);
  hold_result();
}

PhotonPassSettings PhotonMaps::pass_settings() const {
  PhotonPassSettings out;
  out.photons = std::max(settings_.photons_traced, settings_.photons);
  out.seed = settings_.seed;
  out.pass = settings_.pass;
  out.max_bounces = settings_.max_bounces;
  out.guide = settings_.guide.get();
  out.demand = settings_.demand.get();
  out.on_all_surfaces = settings_.on_all_surfaces;
  out.keep_sources = settings_.light_groups != nullptr;
  out.shared = settings_.shared;
  return out;
}

void PhotonMaps::trace(const Tracer& tracer, Statistics& statistics) {
  // What was found with these photons before stays: radii by place and bright patches, which signs would spoil.
  *building_ = traced_ = false;
  global_ = Map();
  caustic_ = Map();
  reservation_.reset();
  const PhotonPassSettings wanted = pass_settings();
  reservation_ = reserve_photons(wanted.photons, *budget_);
  pass_ = PhotonPass();
  if (settings_.in_air) trace_air(tracer, wanted, statistics);
  if (settings_.choice != PhotonChoice::all)
    pass_ = trace_chosen(tracer, settings_.choice, nullptr, statistics);
  else if (pass_.emitted == 0)
    pass_ = trace_photons(tracer, wanted, statistics);
  *building_ = true;
  if (wanted.photons > settings_.photons) {
    const PhaseTimer timer(statistics, Phase::build_photon_map);
    DensityControlSettings control;
    control.wanted = settings_.photons;
    control.seed = settings_.seed;
    pass_.global = control_density(pass_.global, control);
  }
  global_.photons = std::exchange(pass_.global, PhotonBatch());
  caustic_.photons = std::exchange(pass_.caustic, PhotonBatch());
  global_.sources = std::exchange(pass_.global_source, {});
  caustic_.sources = std::exchange(pass_.caustic_source, {});
  for (Map* map : {&global_, &caustic_}) {
    if (map->photons.size() <= kMostUnordered) continue;
    const PhaseTimer timer(statistics, Phase::build_photon_map);
    const std::vector<std::uint32_t> places = places_by_cell(map->photons.position);
    map->photons = map->photons.moved(places);
    if (!map->sources.empty()) map->sources = moved(map->sources, places);
  }
  global_.count = global_.photons.size();
  caustic_.count = first_caustic_ = caustic_.photons.size();
  caustic_paths_ = 0;
  bounds_ = global_.photons.bounds();
  traced_ = true;
}

/// Traces the photons that pass points in air. If these are all photons, the pass has those on surfaces, too.
void PhotonMaps::trace_air(const Tracer& tracer, PhotonPassSettings pass, Statistics& statistics) {
  air_.nearest =
      std::max<std::uint32_t>(1, static_cast<std::uint32_t>(std::lround(kCausticNearest * settings_.nearest)));
  air_.kernel = settings_.kernel;
  air_.radius_scale = settings_.radius_scale;
  air_.most_radius = most_air_radius(tracer.scene(), pass.photons, air_.nearest);
  const DiscTree discs = air_discs(tracer.scene(), *settings_.in_air, air_.most_radius);
  pass.discs = &discs;
  if (settings_.air_choice == PhotonChoice::all) {
    pass_ = trace_photons(tracer, pass, statistics);
    air_.segments = std::exchange(pass_.segments, {});
  } else {
    Statistics not_of_the_map;
    air_.segments = trace_chosen(tracer, settings_.air_choice, &discs, not_of_the_map).segments;
  }
}

/// Traces a pass of chosen photons, guided by pilot paths.
/// @param discs for points in air; null: photons on surfaces
PhotonPass PhotonMaps::trace_chosen(const Tracer& tracer, PhotonChoice choice, const DiscTree* discs,
                                    Statistics& statistics) {
  PhotonPassSettings wanted = pass_settings();
  wanted.choice = choice;
  wanted.discs = discs;
  wanted.demand = nullptr;
  wanted.max_emitted = wanted.photons;
  std::shared_ptr<const EmissionGuide>& guide = discs ? air_guide_ : surface_guide_;
  if (!guide) {
    wanted.pass = kPilotStream;  // a pass number that photons never use
    const std::uint64_t pilot = std::clamp(wanted.photons / kCausticPilotShare, kMinCausticPilot, kMaxCausticPilot);
    guide = std::make_shared<const EmissionGuide>(
        learn_emission(tracer, wanted, {.count = pilot, .most_in_first = kMostChosenPilots, .floor = kCausticFloor}));
  }
  wanted.guide = guide.get();
  wanted.pass = hash_combine(discs ? kAirStream : kChosenStream, settings_.pass);
  return trace_photons(tracer, wanted, statistics);
}

RadiusPolicy PhotonMaps::policy_of(const Map& map) const {
  RadiusPolicy policy;
  policy.kernel = settings_.kernel;
  policy.k = std::max<std::uint32_t>(1, map.nearest);
  policy.kind = engine_traits(settings_.engine).takes_nearest ? RadiusKind::nearest : RadiusKind::per_photon;
  policy.radii = scaled(map.radii.radii, settings_.radius_scale);
  policy.order = map.radii.order;
  policy.cuts = map.cuts;
  if (policy.radii.empty()) return policy;
  // Where photons are few, the nearest may be in another part of the scene: an estimate never reaches further than the
  // largest radius that density estimation uses.
  policy.max_radius = 2 * *std::max_element(policy.radii.begin(), policy.radii.end());
  if (settings_.fixed_radius) {
    policy.kind = RadiusKind::fixed;
    policy.radius = policy.radii.front();
  }
  return policy;
}

/// Boundary factors for kernels of these radii. @param name of the work, for other processes
/// @param cuts receives the cuts of these kernels; null: not wanted
std::vector<float> PhotonMaps::factors_of(const Map& map, RadiusPolicy policy, const char* name,
                                          std::vector<PhotonCuts>* cuts, const Tracer& tracer) const {
  const auto factors = [&](const char* round) {
    return boundary_factors(tracer, map.photons, policy, cuts, settings_.shared,
                            fmt::format("{}-{}{}", &map == &caustic_ ? "caustic" : "global", name, round));
  };
  if (policy.kind == RadiusKind::nearest) {
    // Where only part of a disc has photons, the k nearest lie further away: the part has the area of the whole disc.
    policy.kind = RadiusKind::per_photon;
    const std::vector<float> found = factors("-in-radii");
    for (std::size_t i = 0; i < found.size(); ++i) policy.radii[i] *= std::sqrt(found[i]);
  }
  policy.kind = RadiusKind::per_photon;
  return factors("");
}

/// The radius of all photons of a map, without scale.
float PhotonMaps::fixed_radius_of(const Map& map) const {
  const float given = &map == &caustic_ ? settings_.caustic_radius : settings_.radius;
  return given > 0 ? given : fixed_radius(map.photons, map.nearest);
}

/// Measures, corrects and indexes a map, unless that is done already.
void PhotonMaps::bring_up(Map& map, std::uint32_t nearest, const Tracer& tracer, Statistics& statistics) {
  if (!map.measured) {
    const PhaseTimer timer(statistics, Phase::build_photon_map);
    map.cut = map.corrected = map.indexed = false;
    map.nearest = std::max<std::uint32_t>(1, nearest);
    if (settings_.fixed_radius && map.count > 0)
      map.radii = {std::vector<float>(map.count, fixed_radius_of(map)), {}};
    else
      map.radii = measured_radii(map.photons, map.nearest);
    map.measured = true;
  }
  if (settings_.correction != BoundaryCorrection::none) correct_map(map, tracer, statistics);
  if (map.indexed) return;
  index(map, statistics);
  map.narrow.reset();
  if (settings_.narrow && map.count > 0) index_narrow(map, tracer, statistics);
}

/// Makes what a correction needs, unless that is done already.
void PhotonMaps::correct_map(Map& map, const Tracer& tracer, Statistics& statistics) const {
  const PhaseTimer timer(statistics, Phase::build_photon_map);
  const bool of_photons = settings_.correction == BoundaryCorrection::photons;
  if (of_photons && !map.corrected) {
    const RadiusPolicy policy = policy_of(map);
    const bool finds_cuts = !map.cut && policy.kind != RadiusKind::nearest;
    map.factors = factors_of(map, policy, "factors", finds_cuts ? &map.cuts : nullptr, tracer);
    map.corrected = true;
    map.cut |= finds_cuts;
    map.indexed = false;
  }
  if (!map.cut) {
    RadiusPolicy policy = policy_of(map);
    // The nearest photons may be as far away as the limit.
    if (policy.kind == RadiusKind::nearest) policy.radii.assign(map.count, policy.max_radius);
    map.cuts = kernel_cuts(tracer, map.photons, policy.radii);
    map.cut = true;
    map.indexed = false;
    map.query_radii.reset();
  }
  if (of_photons) return map.query_radii.reset();
  if (!map.query_radii) map.query_radii = std::make_unique<QueryRadii>(map.photons, policy_of(map));
  if (!map.corrected) return;
  map.factors = {};
  map.corrected = map.indexed = false;
}

void PhotonMaps::correct(const Tracer& tracer, const QueryPoints& points, std::span<RGB> radiance,
                         bool is_narrow) const {
  if (!global_.query_radii || points.size() == 0) return;
  const std::vector<float> radii = scaled(global_.query_radii->at(points, radiance), is_narrow ? kNarrow : 1);
  correct_estimates(tracer, points, radii, global_.query_radii->kernel(), radiance);
}

void PhotonMaps::index(Map& map, Statistics& statistics) const {
  map.engines.clear();
  LargeVector<RGB> flux = map.corrected ? flux_times(map.photons.flux, map.factors) : map.photons.flux;
  if (settings_.signs) flux = flux_times(std::move(flux), random_signs(map.count, settings_.seed));
  if (settings_.light_groups && !settings_.signs) {
    index_groups(map, flux, statistics);
  } else {
    map.engines.push_back(make_engine(settings_.engine, {.reorder = settings_.reorder}));
    map.engines.front()->build(map.photons, flux, policy_of(map), statistics);
  }
  map.indexed = true;
}

void PhotonMaps::index_narrow(Map& map, const Tracer& tracer, Statistics& statistics) const {
  const PhaseTimer timer(statistics, Phase::build_photon_map);
  RadiusPolicy policy = policy_of(map);
  policy.k = std::max<std::uint32_t>(1, policy.k / 2);
  policy.radius *= kNarrow;
  for (float& radius : policy.radii) radius *= kNarrow;
  LargeVector<RGB> flux = map.photons.flux;
  if (map.corrected) flux = flux_times(std::move(flux), factors_of(map, policy, "narrow-factors", nullptr, tracer));
  map.narrow = make_engine(settings_.engine, {.reorder = settings_.reorder});
  map.narrow->build(map.photons, flux, policy, statistics);
}

/// Indexes the photons of each group of lights, with the radii of the whole map.
void PhotonMaps::index_groups(Map& map, std::span<const RGB> flux, Statistics& statistics) const {
  const LightGroups& groups = *settings_.light_groups;
  const RadiusPolicy whole = policy_of(map);
  std::vector<std::vector<std::uint32_t>> members(groups.names.size());
  for (std::size_t i = 0; i < map.count; ++i) {
    const std::uint32_t photon = whole.order.empty() ? static_cast<std::uint32_t>(i) : whole.order[i];
    members[groups.of_source[map.sources[photon]]].push_back(photon);
  }
  for (const std::vector<std::uint32_t>& group : members) {
    RadiusPolicy policy = whole;
    policy.order = {};
    policy.radii.clear();
    policy.cuts.clear();
    for (std::uint32_t i = 0; i < group.size(); ++i) {
      if (!whole.radii.empty()) policy.radii.push_back(whole.radii[group[i]]);
      if (const PhotonCuts* c = cuts_of(whole.cuts, group[i])) policy.cuts.push_back({i, c->cuts});
    }
    map.engines.push_back(make_engine(settings_.engine, {.reorder = settings_.reorder}));
    map.engines.back()->build(map.photons.permuted(group), permuted(flux, group), policy, statistics);
  }
}

void PhotonMaps::bring_up_global(const Tracer& tracer, Statistics& statistics) {
  bring_up(global_, settings_.nearest, tracer, statistics);
  if (!global_.radii.radii.empty()) common_radius_ = settings_.fixed_radius ? global_.radii.radii.front() : 0;
  if ((settings_.secondary_gather || settings_.patches) && !gridded_) {
    const PhaseTimer timer(statistics, Phase::build_photon_map);
    radius_grid_ = RadiusGrid(global_.photons.position, scaled(global_.radii.radii, settings_.radius_scale));
    gridded_ = true;
  }
  if (settings_.patches && !patched_) find_patches(tracer, statistics);
  if (settings_.diagnosed && !diagnosis_) diagnose(statistics);
  if (!settings_.kept) global_.drop_photons();
}

void PhotonMaps::bring_up_caustic(const Tracer& tracer, Statistics& statistics) {
  if (caustic_.count == 0) return;
  if (caustic_paths_ < wanted_caustic_paths()) add_caustic_photons(tracer, statistics);
  // Blur and noise shrink together if radii shrink with the sixth root of the number of photons.
  const double growth = static_cast<double>(caustic_.count) / static_cast<double>(first_caustic_);
  const double nearest =
      std::min(kCausticNearest * std::pow(growth, 2.0 / 3.0), kMostCausticNearest) * settings_.nearest;
  bring_up(caustic_, static_cast<std::uint32_t>(std::lround(nearest)), tracer, statistics);
  if (!settings_.kept) caustic_.drop_photons();
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
  const auto first = static_cast<float>(caustic_.count), second = static_cast<float>(more.caustic.size());
  for (RGB& flux : caustic_.photons.flux) flux *= first / (first + second);
  for (RGB& flux : more.caustic.flux) flux *= second / (first + second);
  caustic_.photons.append(more.caustic);
  caustic_.sources.insert(caustic_.sources.end(), more.caustic_source.begin(), more.caustic_source.end());
  caustic_.count = caustic_.photons.size();
  caustic_.measured = false;
  // More paths would make no difference where these sufficed.
  const bool sufficed = more.emitted < wanted.max_emitted;
  caustic_paths_ = sufficed ? std::numeric_limits<std::uint64_t>::max() : wanted.max_emitted;
  *building_ = true;
}

std::uint64_t bright_patch_bytes(std::uint64_t photons) { return std::min(kMaxLitPlaces, photons) * kBytesPerLitPlace; }

void PhotonMaps::find_patches(const Tracer& tracer, Statistics& statistics) {
  patches_ = BrightPatches();
  patched_ = true;
  if (global_.count == 0) return;
  const PhaseTimer timer(statistics, Phase::build_photon_map);
  const std::uint64_t most = std::min<std::uint64_t>(kMaxLitPlaces, global_.count);
  const Reservation reservation(*budget_, "bright patches", bright_patch_bytes(global_.count));
  const PhotonBatch& photons = global_.photons;
  const std::size_t step = (photons.size() + most - 1) / most;
  LitPlaces places;
  QueryPoints queries;
  for (std::size_t i = 0; i < photons.size(); i += step) {
    const RGB flux = global_.corrected ? photons.flux[i] * global_.factors[i] : photons.flux[i];
    places.position.push_back(photons.position[i]);
    places.normal.push_back(photons.normal[i]);
    places.flux.push_back(luminance(flux) * static_cast<float>(step));
    queries.push_back(photons.position[i], photons.normal[i], RGB(1.0f), RGB(1.0f), 0);
  }
  std::vector<RGB> found(queries.size());
  Statistics not_the_renders;
  for (const auto& engine : global_.engines) engine->estimate(queries, found, not_the_renders);
  for (const RGB& radiance : found) places.irradiance.push_back(kPi * luminance(radiance));
  patches_ = BrightPatches(tracer, places, radius_grid_);
}

void PhotonMaps::diagnose(Statistics& statistics) {
  RadiusPolicy counting = policy_of(global_);
  counting.kind = RadiusKind::per_photon;
  // K(box) / h^2 = 1 / (pi h^2): times 1, times h, and times its inverse.
  counting.kernel = KernelShape::box;
  LargeVector<RGB> counts(global_.count);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const float h = counting.radii[i];
    counts[i] = {1, h, kPi * h * h};
  }
  std::unique_ptr<DensityEngine> engine = make_engine(kAutomaticEngine);
  engine->build(global_.photons, counts, counting, statistics);
  diagnosis_ = std::move(engine);
}

void PhotonMaps::reserve_in(MemoryBudget* budget) {
  reservation_.reset();
  budget_ = budget;
  if (budget && is_done()) hold_result();
}

/// Reserves what remains after the maps are made.
void PhotonMaps::hold_result() {
  const std::uint64_t count = global_.count + caustic_.count;
  std::uint64_t bytes = global_.engines.front()->index_bytes(count);
  for (const Map* map : {&global_, &caustic_}) {
    if (map->narrow) bytes += map->narrow->index_bytes(map->count);
    if (map->query_radii) bytes += QueryRadii::bytes(map->count);
    bytes += map->cuts.size() * sizeof(PhotonCuts);
  }
  if (diagnosis_) bytes += diagnosis_->index_bytes(global_.count);
  bytes += air_.segments.size() * sizeof(PhotonSegment);
  if (settings_.kept)
    bytes += count * (PhotonBatch::kBytesEach + kBytesBesidePhoton);
  else
    return_free_memory();
  reservation_.reset();
  reservation_ = std::make_unique<Reservation>(*budget_, "photon map", bytes);
}

}  // namespace glowworm
