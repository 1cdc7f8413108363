// The blocked density engine beside other ways to look photons up, on the same photons and query points in one run;
// writes a table.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "density/engine.h"
#include "density/radius.h"
#include "kernels/simd.h"
#include "surface_cloud.h"

namespace glowworm {
namespace {

void run(const std::string& name, const PhotonBatch& photons, const RadiusPolicy& policy, const QueryPoints& points,
         int repeats) {
  const auto engine = make_engine(name);
  Statistics building;
  engine->build(photons, policy, building);
  for (int i = 0; i < repeats; ++i) {
    Statistics s;
    std::vector<RGB> radiance(points.size());
    const std::clock_t before = std::clock();
    engine->estimate(points, radiance, s);
    const double processor = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    const double reorder = s.seconds(Phase::reorder), density = s.seconds(Phase::density), all = reorder + density;
    const double operations = static_cast<double>(s.count(Counter::shader_operations));
    fmt::print(
        "{:8} build {:.3f} s, reorder {:.3f} s ({:.1f}%), density {:.3f} s, {:.1f} ns a query, k {:.1f}, used {:.1f}%, "
        "{:.3f}e9/s, processor {:.3f} s, per core second {:.3f}e9/s\n",
        name, building.seconds(Phase::build_photon_map), reorder, 100 * reorder / all, density,
        1e9 * all / static_cast<double>(points.size()), operations / static_cast<double>(points.size()),
        100 * operations / static_cast<double>(s.count(Counter::pairs_tested)), operations / all * 1e-9, processor,
        operations / processor * 1e-9);
  }
}

}  // namespace
}  // namespace glowworm

int main(int argc, char** argv) {
  using namespace glowworm;
  const std::size_t n_photons = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 2000000;
  const std::size_t n_points = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 10000000;
  const int threads = argc > 3 ? std::atoi(argv[3]) : 0;
  set_thread_count(threads);
  const bench::SurfaceCloud cloud(1);
  const PhotonBatch photons = cloud.photons(n_photons);
  const QueryPoints points = cloud.points(n_points);
  RadiusPolicy policy;
  policy.radii = per_photon_radii(photons, 50);
  fmt::print("{} photons, {} points, {}, {} threads\n", n_photons, n_points, simd_name(), thread_count());
  run("blocked", photons, policy, points, 3);
}
