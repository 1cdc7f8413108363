#include "density/engine.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/error.h"
#include "density/engines.h"
#include "density/forward.h"

namespace glowworm {

namespace {

struct Entry {
  EngineTraits traits;
  std::unique_ptr<DensityEngine> (*make)(const EngineOptions&);
};

template <std::unique_ptr<DensityEngine> (*make)()>
std::unique_ptr<DensityEngine> without_options(const EngineOptions&) {
  return make();
}

std::unique_ptr<DensityEngine> make_forward(const EngineOptions& options) {
  if (options.reorder == 0) return make_forward_engine();
  return make_forward_engine({0, {ReorderMethod::octree, options.reorder, kAutomaticDepth}});
}

/// An engine for whole kernels, beside the blocked engine for kernels that end at walls.
class EngineWithCuts final : public DensityEngine {
 public:
  explicit EngineWithCuts(std::unique_ptr<DensityEngine> whole) : whole_(std::move(whole)) {}

  std::string name() const override { return whole_->name(); }

  std::uint64_t index_bytes(std::size_t photons) const override {
    return whole_->index_bytes(photons) + (cut_ ? cut_->index_bytes(cut_photons_) : 0);
  }

  void build(const PhotonBatch& photons, std::span<const RGB> flux, const RadiusPolicy& policy,
             Statistics& statistics) override {
    cut_.reset();
    if (policy.cuts.empty()) return whole_->build(photons, flux, policy, statistics);
    RadiusPolicy others = policy, near_walls = policy;
    if (policy.kind == RadiusKind::fixed) others.radii.assign(photons.size(), policy.radius);
    others.kind = near_walls.kind = RadiusKind::per_photon;
    others.cuts.clear();
    near_walls.order = {};
    near_walls.radii.clear();
    std::vector<std::uint32_t> members;
    for (PhotonCuts& c : near_walls.cuts) {
      near_walls.radii.push_back(others.radii[c.photon]);
      others.radii[c.photon] = 0;  // Without a radius a photon counts nowhere.
      members.push_back(c.photon);
      c.photon = static_cast<std::uint32_t>(members.size()) - 1;
    }
    cut_photons_ = members.size();
    cut_ = make_blocked_engine();
    cut_->build(photons.permuted(members), permuted(flux, members), near_walls, statistics);
    whole_->build(photons, flux, others, statistics);
  }

  void estimate(const QueryPoints& points, std::span<RGB> radiance, Statistics& statistics) const override {
    whole_->estimate(points, radiance, statistics);
    if (!cut_) return;
    Statistics same_points;
    cut_->estimate(points, radiance, same_points);
    for (const Counter counter : {Counter::pairs_tested, Counter::shader_operations})
      statistics.add(counter, same_points.count(counter));
    statistics.add_time(Phase::density, same_points.seconds(Phase::density) + same_points.seconds(Phase::reorder));
  }

 private:
  std::unique_ptr<DensityEngine> whole_, cut_;
  std::size_t cut_photons_ = 0;
};

template <std::unique_ptr<DensityEngine> (*make)(const EngineOptions&)>
std::unique_ptr<DensityEngine> with_cuts(const EngineOptions& options) {
  return std::make_unique<EngineWithCuts>(make(options));
}

// In order of preference.
constexpr Entry kEngines[] = {
    {{.name = "blocked"}, without_options<make_blocked_engine>},
    {{.name = "forward", .lanes = forward_lanes}, with_cuts<make_forward>},
    {{.name = "reverse", .goes_over_photons = true}, with_cuts<without_options<make_reverse_engine>>},
    {{.name = "knn", .takes_nearest = true}, without_options<make_knn_engine>},
    {{.name = "brute", .for_tests = true}, without_options<make_brute_engine>},
};

const Entry& entry(const std::string& name) {
  const std::string known = name == "auto" ? kAutomaticEngine : name;
  for (const Entry& e : kEngines)
    if (known == e.traits.name) return e;
  throw Error(fmt::format("there is no density engine \"{}\"", name),
              fmt::format("Choose one of: {}", fmt::join(engine_names(), ", ")));
}

}  // namespace

const PhotonCuts* cuts_of(std::span<const PhotonCuts> cuts, std::uint32_t photon) {
  const auto found = std::lower_bound(cuts.begin(), cuts.end(), photon,
                                      [](const PhotonCuts& a, std::uint32_t number) { return a.photon < number; });
  return found != cuts.end() && found->photon == photon ? &*found : nullptr;
}

const EngineTraits& engine_traits(const std::string& name) { return entry(name).traits; }

std::vector<std::string> engine_names() {
  std::vector<std::string> names;
  for (const Entry& e : kEngines) names.emplace_back(e.traits.name);
  return names;
}

std::unique_ptr<DensityEngine> make_engine(const std::string& name, const EngineOptions& options) {
  return entry(name).make(options);
}

}  // namespace glowworm
