// The search alone ([HHS05], Table 1 and section 6.3): finding the photons of query points, without adding them up, by
// normal photon mapping (the program's k-nearest search, and nanoflann's) and by reverse photon mapping; beside it
// whole lookups, sums included.
//
// usage: tables_search [SCENE]... [options:LEAF,CLUSTER]...    (default: the built-in cornell and atrium, and Sponza)
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "density/knn.h"
#include "density/radius.h"
#include "density/reorder.h"
#include "density/reverse.h"
#include "density/reverse_photons.h"
#include "support/calibration.h"
#include "support/nanoflann_tree.h"
#include "support/pair_cost.h"
#include "support/recording.h"
#include "support/run_tables.h"
#include "support/table.h"

namespace glowworm::bench {
namespace {

constexpr std::uint32_t kNearest = 50;
constexpr int kRuns = 3;
// One in so many runs of neighbouring points is searched for by nearest neighbours, which take long.
constexpr std::size_t kRun = 4096, kStep = 8;

/// Every eighth run of a Hilbert order: neighbours stay neighbours.
std::vector<std::uint32_t> part_of(const std::vector<std::uint32_t>& order) {
  std::vector<std::uint32_t> part;
  for (std::size_t first = 0; first < order.size(); first += kRun * kStep)
    part.insert(part.end(), order.begin() + static_cast<std::ptrdiff_t>(first),
                order.begin() + static_cast<std::ptrdiff_t>(std::min(first + kRun, order.size())));
  return part;
}

/// Nanoseconds that a thread takes for each of so many points, when all threads work.
Spread nanoseconds(std::size_t points, const std::function<void()>& work) {
  return measure_seconds(kRuns, work).scaled(1e9 * thread_count() / static_cast<double>(points));
}

/// The k-nearest search of the knn engine, with its bound from the neighbour before.
Spread search_nearest(const Recording& recording, const std::vector<std::uint32_t>& points,
                      const RadiusPolicy& policy) {
  PhotonMap map;
  map.build(recording.photons, {});
  // As a render has it: no farther than twice the widest radius.
  const float farthest = 2 * *std::max_element(policy.radii.begin(), policy.radii.end()),
              farthest2 = farthest * farthest;
  return nanoseconds(points.size(), [&] {
    parallel_for(0, points.size(), kRun, [&](std::size_t first, std::size_t last) {
      std::vector<std::uint64_t> heap(kNearest);
      std::uint64_t tested = 0;
      Vec3 near{0, 0, 0}, near_normal{0, 0, 0};
      float radius = 0;
      for (std::size_t i = first; i < last; ++i) {
        const Vec3 x = recording.points.position[points[i]], normal = recording.points.normal[points[i]];
        const float reach = (radius + length(x - near)) * 1.0001f;
        const float limit = radius > 0 && normal == near_normal ? std::min(reach * reach, farthest2) : farthest2;
        const std::size_t count = map.nearest(x, normal, policy.min_normal_cosine, kNearest, limit, heap, tested);
        near = x;
        near_normal = normal;
        radius = count == kNearest ? std::sqrt(PhotonMap::unpack(heap[0]).distance_squared) : 0;
      }
    });
  });
}

/// nanoflann's; normals are not looked at. Photons stand along a Hilbert curve, as do the points.
Spread search_nanoflann(const Recording& recording, const std::vector<std::uint32_t>& points) {
  ReorderSettings full;
  full.depth = 21;
  const auto order = hilbert_order(recording.photons.position, bounds_of(recording.photons.position), 0, full);
  std::vector<Vec3> sorted;
  for (const std::uint32_t i : order) sorted.push_back(recording.photons.position[i]);
  const NanoflannPoints view{sorted};
  NanoflannTree tree(3, view, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  tree.buildIndex();
  return nanoseconds(points.size(), [&] {
    parallel_for(0, points.size(), kRun, [&](std::size_t first, std::size_t last) {
      std::vector<std::uint32_t> found(kNearest);
      std::vector<float> distances(kNearest);
      for (std::size_t i = first; i < last; ++i)
        tree.knnSearch(&recording.points.position[points[i]].x, kNearest, found.data(), distances.data());
    });
  });
}

/// What reverse searches did.
struct ReverseSearch {
  Spread build, search;  // of the tree over the query points, and of going over it with all photons
  ReverseCounts counts;
};

ReverseSearch search_reverse(const Recording& recording, const RadiusPolicy& policy, const ReverseOptions& options) {
  const ReversePhotonArray photons(recording.photons, policy, options.cluster_size);
  const ReversePhotons view = photons.view();
  std::vector<std::uint32_t> all(recording.points.size());
  std::iota(all.begin(), all.end(), 0u);
  const std::uint32_t leaf_size =
      options.leaf_size > 0 ? options.leaf_size : reverse_leaf_size(all.size(), photons.size());
  ReverseMemory memory;
  std::unique_ptr<const ReverseTree> tree;
  ReverseSearch result;
  const auto build = [&] {
    tree.reset();
    tree = std::make_unique<const ReverseTree>(recording.points, all, leaf_size, &memory);
  };
  build();  // so that the memory is there, as it is from the second task of a render on
  result.build = nanoseconds(all.size(), build);
  std::atomic<std::uint64_t> tested, operations, nodes;
  result.search = nanoseconds(all.size(), [&] {
    tested = operations = nodes = 0;
    parallel_for(0, tree->subtrees().size(), 1, [&](std::size_t first, std::size_t last) {
      std::vector<ReverseLeafBounds> bounds;
      std::vector<ReverseCluster> clusters;
      ReverseCounts counts;
      for (std::size_t s = first; s < last; ++s) {
        const ReverseSubtree& subtree = tree->subtrees()[s];
        ReverseSubtreeView part;
        part.nodes = tree->nodes().data();
        part.root = subtree.root;
        part.first_point = subtree.first_point;
        part.points = tree->points().data() + std::size_t{subtree.first_point} * kReverseFields;
        const Box3 box = tree->measure(subtree, part.points, bounds);
        part.bounds = bounds.data();
        clusters.clear();
        photons.visit(box, [&](const ReverseCluster& cluster) { clusters.push_back(cluster); });
        reverse_count(part, view, clusters, counts);
      }
      tested += counts.tested;
      operations += counts.operations;
      nodes += counts.nodes;
    });
  });
  result.counts.tested = tested;
  result.counts.operations = operations;
  result.counts.nodes = nodes;
  return result;
}

/// A whole lookup, reordering and sums included; the second call is timed, which finds the engine's memory there.
Spread look_up(DensityEngine& engine, const Recording& recording, const RadiusPolicy& policy) {
  Statistics statistics;
  engine.build(recording.photons, policy, statistics);
  std::vector<RGB> radiance(recording.points.size());
  const auto estimate = [&] { engine.estimate(recording.points, radiance, statistics); };
  estimate();
  return nanoseconds(recording.points.size(), estimate);
}

void add_scene(Table& table, const std::string& path, const ReverseOptions& options, double test_ns, double sum_ns) {
  RecordingSettings settings;
  settings.width = settings.height = 400;
  settings.gather = 25;
  const Recording recording = record(Stage(path), settings);
  RadiusPolicy policy = own_radii_for(recording, kNearest);
  policy.kernel = KernelShape::box;
  ReorderSettings full;
  full.depth = 21;
  const auto points = part_of(hilbert_order(recording.points.position, bounds_of(recording.points.position), 0, full));
  const Spread nearest = search_nearest(recording, points, policy), nanoflann = search_nanoflann(recording, points);
  const ReverseSearch reverse = search_reverse(recording, policy, options);
  const auto reverse_engine = make_reverse_engine(options);
  const Spread reverse_whole = look_up(*reverse_engine, recording, policy),
               blocked_whole = look_up(*make_engine("blocked"), recording, policy);
  const auto pairs = static_cast<double>(reverse.counts.operations);
  const double tests_ns =
      test_ns * static_cast<double>(reverse.counts.tested) / static_cast<double>(recording.points.size());
  table.add({short_name(path),
             options.leaf_size > 0 ? Cell(Number{double(options.leaf_size)}) : Cell("automatic"),
             Number{double(options.cluster_size)},
             Number{pairs / static_cast<double>(recording.points.size())},
             nanoflann,
             nearest,
             reverse.search,
             reverse.build,
             reverse_whole,
             blocked_whole,
             Number{nearest.median / 50},
             Number{tests_ns},
             Number{tests_ns / test_ns * sum_ns},
             Number{pairs / static_cast<double>(recording.points.size()) * sum_ns},
             Number{nearest.median / tests_ns},
             Number{nearest.median / reverse.search.median},
             Number{nanoflann.median / reverse.search.median},
             Number{nearest.median / (reverse.search.median + reverse.build.median)},
             Number{nanoflann.median / blocked_whole.median},
             Number{nearest.median / blocked_whole.median},
             Number{100 * pairs / static_cast<double>(reverse.counts.tested)},
             Number{static_cast<double>(reverse.counts.nodes) / static_cast<double>(recording.points.size())}});
}

void write_tables(const std::vector<std::string>& arguments) {
  Table table("hhs05_search", "The search alone, 500,000 photons, 4 million query points, k = 50 ([HHS05], 6.3)",
              {"scene",
               "leaf",
               "cluster",
               "k",
               "nanoflann's k nearest, ns",
               "k nearest, ns",
               "reverse search, ns",
               "reverse tree, ns",
               "reverse with sums and tree, ns",
               "blocked with sums and order, ns",
               "a fiftieth of k nearest, ns",
               "tests of the search alone, ns",
               "the same with sums, ns",
               "sums of the pairs used alone, ns",
               "k nearest over these tests",
               "k nearest over reverse search",
               "nanoflann over reverse search",
               "k nearest over search and tree",
               "nanoflann over all of blocked",
               "k nearest over all of blocked",
               "pairs used, %",
               "nodes a query point"});
  std::vector<std::string> scenes;
  std::vector<ReverseOptions> options;
  for (const std::string& argument : arguments) {
    if (!argument.starts_with("options:")) {
      scenes.push_back(argument);
      continue;
    }
    ReverseOptions& o = options.emplace_back();
    o.leaf_size = static_cast<std::uint32_t>(std::atoi(argument.c_str() + 8));
    o.cluster_size = static_cast<std::uint32_t>(std::atoi(argument.c_str() + argument.find(',') + 1));
  }
  if (scenes.empty()) scenes = table_scenes();
  if (options.empty()) options.emplace_back();
  const double test_ns = nanoseconds_of_a_test(), sum_ns = nanoseconds_of_a_sum({});
  for (const std::string& scene : scenes)
    for (const ReverseOptions& o : options) add_scene(table, scene, o, test_ns, sum_ns);
  table.note(fmt::format(
      "Tests of the search alone: as many tests of distance and normal as the search makes, at {:.3f} ns each, which "
      "is "
      "what they take where nothing is searched for and all is in the nearest cache. Where k nearest over these is "
      "below 50, no search that makes these tests is 50 times as fast.",
      test_ns));
  table.note(
      "Nanoseconds of a thread for each query point, all threads at work. Published: searching 4 to 7 times faster "
      "than normal photon mapping, up to 25 batched.");
  table.note(
      "nanoflann compares no normals. Nearest neighbours are looked for in every eighth run of 4096 points along a "
      "Hilbert curve; ordering the points is not in these columns, as it is in those of whole lookups.");
  table.write();
}

}  // namespace
}  // namespace glowworm::bench

int main(int argc, char** argv) {
  return glowworm::bench::run_tables("tables_search", [&] { glowworm::bench::write_tables({argv + 1, argv + argc}); });
}
