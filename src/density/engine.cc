#include "density/engine.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/error.h"
#include "density/engines.h"

namespace glowworm {

namespace {

struct Entry {
  const char* name;
  std::unique_ptr<DensityEngine> (*make)();
};

// In order of preference.
constexpr Entry kEngines[] = {
    {"blocked", make_blocked_engine}, {"forward", make_forward_engine}, {"reverse", make_reverse_engine},
    {"single", make_single_engine},   {"knn", make_knn_engine},         {"brute", make_brute_engine},
};

}  // namespace

std::vector<std::string> engine_names() {
  std::vector<std::string> names;
  for (const Entry& entry : kEngines) names.emplace_back(entry.name);
  return names;
}

std::unique_ptr<DensityEngine> make_engine(const std::string& name) {
  for (const Entry& entry : kEngines) {
    if (name == entry.name) return entry.make();
  }
  throw Error(fmt::format("there is no density engine \"{}\"", name),
              fmt::format("choose one of: {}", fmt::join(engine_names(), ", ")));
}

}  // namespace glowworm
