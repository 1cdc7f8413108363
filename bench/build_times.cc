// Seconds that the map of photons takes, over their number: of each engine's index, and of what comes before it. One
// line each: the least and the median of several runs.
//
// usage: build_times [SCENE [PHOTONS [PART...]]]     (default: builtin:atrium 500000, all parts)
//   PART: an engine (its build()), `radii` (per_photon_radii()), `grid` (RadiusGrid), or `map`: radii and the index of
//   `blocked`, all that a session does anew when light moves
#include <fmt/format.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "density/engine.h"
#include "density/radius.h"
#include "gather/radius_grid.h"
#include "support/recording.h"
#include "support/table.h"

namespace {

using namespace glowworm;

constexpr std::uint32_t kNearest = 50;

void build(const std::string& engine, const PhotonBatch& photons, const RadiusPolicy& policy) {
  Statistics unused;
  make_engine(engine)->build(photons, policy, unused);
}

/// Does one part once.
void run(const std::string& part, const PhotonBatch& photons, const RadiusPolicy& policy) {
  if (part == "radii") {
    per_photon_radii(photons, kNearest);
  } else if (part == "grid") {
    RadiusGrid(photons.position, policy.radii);
  } else if (part == "map") {
    PhotonRadii found = measured_radii(photons, kNearest);
    RadiusPolicy own;
    own.radii = std::move(found.radii);
    own.order = found.order;
    build("blocked", photons, own);
  } else {
    build(part, photons, policy);
  }
}

}  // namespace

int main(int argc, char** argv) {
  using namespace glowworm::bench;
  const std::string scene = argc > 1 ? argv[1] : "builtin:atrium";
  const std::uint64_t photons = argc > 2 ? std::stoull(argv[2]) : 500'000;
  std::vector<std::string> parts(argv + std::min(argc, 3), argv + argc);
  if (parts.empty()) parts = {"blocked", "forward", "single", "reverse", "radii", "grid", "map"};
  constexpr int kRuns = 15;
  const Recording recording = record(Stage(scene), {photons, 8, 8, 1});
  RadiusPolicy policy;
  policy.radii = per_photon_radii(recording.photons, kNearest);
  for (const int threads : {1, 0}) {
    set_thread_count(threads);
    for (const std::string& part : parts) {
      const Spread s = measure_seconds(kRuns, [&] { run(part, recording.photons, policy); });
      fmt::print("{} of {} photons, {} threads: least {:.4f} s, median {:.4f} s\n", part, recording.photons.size(),
                 thread_count(), s.least, s.median);
    }
  }
}
