// Seconds that each engine takes to build its map of photons, over their number. One line each: the least and the
// median of several runs.
//
// usage: build_times [SCENE [PHOTONS]]     (default: builtin:atrium 500000)
#include <fmt/format.h>

#include <string>
#include <vector>

#include "core/parallel.h"
#include "density/engine.h"
#include "density/radius.h"
#include "support/recording.h"
#include "support/table.h"

int main(int argc, char** argv) {
  using namespace glowworm;
  using namespace glowworm::bench;
  const std::string scene = argc > 1 ? argv[1] : "builtin:atrium";
  const std::uint64_t photons = argc > 2 ? std::stoull(argv[2]) : 500'000;
  constexpr int kRuns = 15;
  const Recording recording = record(Stage(scene), {photons, 8, 8, 1});
  RadiusPolicy policy;
  policy.radii = per_photon_radii(recording.photons, 50);
  for (const int threads : {1, 0}) {
    set_thread_count(threads);
    for (const std::string name : {"blocked", "forward", "single", "reverse"}) {
      const Spread s = measure_seconds(kRuns, [&] {
        Statistics unused;
        make_engine(name)->build(recording.photons, policy, unused);
      });
      fmt::print("{} of {} photons, {} threads: least {:.4f} s, median {:.4f} s\n", name, recording.photons.size(),
                 thread_count(), s.least, s.median);
    }
  }
}
