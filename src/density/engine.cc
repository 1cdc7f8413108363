#include "density/engine.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

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

// In order of preference.
constexpr Entry kEngines[] = {
    {{.name = "blocked"}, without_options<make_blocked_engine>},
    {{.name = "forward", .lanes = forward_lanes}, make_forward},
    {{.name = "reverse", .goes_over_photons = true}, without_options<make_reverse_engine>},
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
