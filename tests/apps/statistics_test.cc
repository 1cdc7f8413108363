// The statistics file: all keys are present, counts are correct, and every rate is its count over its time.
#include <algorithm>
#include <cmath>

#include "points/gather_points.h"
#include "program.h"

namespace glowworm {
namespace {

using nlohmann::json;

constexpr int kSide = 32, kSamples = 2, kGather = 8;

class StatisticsTest : public ProgramTest {
 protected:
  json statistics(const std::string& scene, std::vector<std::string> more) {
    const auto has = [&](const char* word) { return std::find(more.begin(), more.end(), word) != more.end(); };
    if (!has("--samples")) more.insert(more.end(), {"--samples", "2"});
    if (!has("path")) more.insert(more.end(), {"--gather", "8"});
    more.insert(more.end(), {"--stats", "s.json", "-o", "a.exr", "-q", "--size", "32x32"});
    const Outcome outcome = render(scene, more);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return read_json("s.json");
  }
};

TEST_F(StatisticsTest, EveryKeyIsPresent) {
  const json s = statistics("builtin:cornell", {});
  const std::vector<std::string> pointers = {"/version",
                                             "/isa",
                                             "/threads",
                                             "/passes",
                                             "/mean_samples",
                                             "/tasks",
                                             "/ending",
                                             "/scene/name",
                                             "/scene/triangles",
                                             "/scene/lights",
                                             "/scene/materials",
                                             "/settings/integrator",
                                             "/settings/engine",
                                             "/settings/samples",
                                             "/settings/gather",
                                             "/settings/photons",
                                             "/settings/thinned",
                                             "/settings/radius",
                                             "/settings/nearest",
                                             "/settings/kernel",
                                             "/settings/light_samples",
                                             "/settings/width",
                                             "/settings/height",
                                             "/settings/pixel_bounds/0",
                                             "/settings/pixel_bounds/1",
                                             "/settings/pixel_bounds/2",
                                             "/settings/pixel_bounds/3",
                                             "/settings/filter",
                                             "/settings/adaptive",
                                             "/settings/camera",
                                             "/settings/seed",
                                             "/settings/memory_bytes",
                                             "/settings/disk",
                                             "/settings/prefer",
                                             "/settings/time_limit_s",
                                             "/settings/noise_target",
                                             "/settings/light_groups",
                                             "/settings/indirect_only",
                                             "/settings/progressive",
                                             "/settings/guiding",
                                             "/settings/secondary_gather",
                                             "/settings/gather_guiding",
                                             "/settings/aovs",
                                             "/lights/0/name",
                                             "/lights/0/sources",
                                             "/lights/0/photons_emitted",
                                             "/lights/0/photons_stored",
                                             "/lights/0/photons_used",
                                             "/lights/0/photons_wasted",
                                             "/time_s/total",
                                             "/time_s/load",
                                             "/time_s/build_accel",
                                             "/time_s/trace_photons",
                                             "/time_s/build_photon_map",
                                             "/time_s/photon_noise",
                                             "/time_s/trace_paths",
                                             "/time_s/camera_pass",
                                             "/time_s/gather_rays",
                                             "/time_s/reorder",
                                             "/time_s/density",
                                             "/time_s/completion",
                                             "/time_s/direct",
                                             "/time_s/filter",
                                             "/time_s/output",
                                             "/time_s/other",
                                             "/count/photons_emitted",
                                             "/count/photons_stored",
                                             "/count/photons_kept",
                                             "/count/gather_points",
                                             "/count/gather_rays",
                                             "/count/query_points",
                                             "/count/shader_operations",
                                             "/count/pairs_tested",
                                             "/count/occlusion_rays",
                                             "/count/camera_rays",
                                             "/count/packet_steps",
                                             "/count/packet_active_lanes",
                                             "/rate/gather_rays_per_s",
                                             "/rate/query_points_per_s",
                                             "/rate/shader_operations_per_s_per_core",
                                             "/mean/photons_per_query",
                                             "/mean/active_lanes",
                                             "/mean/lanes",
                                             "/paged/bytes_read",
                                             "/paged/bytes_written",
                                             "/samples_not_finite",
                                             "/memory_bytes/budget",
                                             "/memory_bytes/peak_reserved",
                                             "/memory_bytes/peak_rss",
                                             "/memory_bytes/scene",
                                             "/memory_bytes/peak_beside_scene",
                                             "/memory_bytes/unaccounted",
                                             "/memory_bytes/photon_map",
                                             "/memory_bytes/query_points",
                                             "/memory_bytes/acceleration_structure",
                                             "/memory_bytes/on_disk",
                                             "/memory_bytes/reserved"};
  for (const std::string& pointer : pointers) EXPECT_TRUE(s.contains(json::json_pointer(pointer))) << pointer;
  // The list, and docs/guide.md, name every key.
  const json flat = s.flatten();
  for (const auto& [path, value] : flat.items()) {
    if (path.starts_with("/memory_bytes/reserved") || path.starts_with("/settings/aovs")) continue;
    EXPECT_NE(std::find(pointers.begin(), pointers.end(), path), pointers.end()) << path;
  }
}

TEST_F(StatisticsTest, SceneAndSettingsAsResolved) {
  const json s = statistics("builtin:cornell", {"--seed", "3", "--threads", "1", "--aov", "depth"});
  EXPECT_EQ(s["scene"]["name"], "cornell");
  EXPECT_EQ(s["scene"]["triangles"], 38);
  EXPECT_EQ(s["scene"]["lights"], 2);
  EXPECT_EQ(s["threads"], 1);
  EXPECT_EQ(s["settings"]["seed"], 3);
  EXPECT_EQ(s["settings"]["gather"], kGather);
  EXPECT_EQ(s["settings"]["samples"], kSamples);
  EXPECT_EQ(s["settings"]["camera"], "main");
  EXPECT_EQ(s["settings"]["aovs"], json::array({"depth"}));
  EXPECT_GT(s["settings"]["nearest"], 0);
  EXPECT_EQ(s["ending"], "samples_done");
  EXPECT_EQ(s["passes"], kSamples);
}

// A closed box whose walls are all diffuse: every camera ray and every gather ray hits, and each count is known.
TEST_F(StatisticsTest, CountsOfAClosedBoxAreKnown) {
  for (const char* engine : {"knn", "blocked", "forward"}) {
    const json s = statistics("builtin:furnace-box", {"--engine", engine, "--no-secondary-gather"});
    const json& count = s["count"];
    const std::uint64_t slots = kSide * kSide * kSamples;
    // Four of five are surface samples. Rays through the corners of pixels look for edges of light, once.
    constexpr int kBlocks = kSide / CameraTask::kBlock, kCorners = CameraTask::kBlock + 1;
    EXPECT_EQ(count["camera_rays"], 5 * slots + kBlocks * kBlocks * kCorners * kCorners) << engine;
    EXPECT_EQ(count["gather_points"], slots) << engine;
    // Rays into the surface itself, which rounding may make, are not traced.
    EXPECT_LE(count["gather_rays"], slots * kGather) << engine;
    EXPECT_GE(count["gather_rays"], slots * kGather * 0.999) << engine;
    EXPECT_EQ(count["query_points"], count["gather_rays"]) << engine;
    EXPECT_GE(count["photons_stored"], 2000) << engine;
    EXPECT_GT(count["photons_emitted"], 0) << engine;
    // Albedo 0.5 everywhere: a path is stored twice on the average.
    EXPECT_NEAR(count["photons_stored"].get<double>() / count["photons_emitted"].get<double>(), 2, 0.2) << engine;
    EXPECT_LE(count["shader_operations"], count["pairs_tested"]) << engine;
    EXPECT_GT(count["occlusion_rays"], 0) << engine;
    EXPECT_LE(count["occlusion_rays"], slots * s["settings"]["light_samples"].get<std::uint64_t>()) << engine;
  }
}

TEST_F(StatisticsTest, SecondaryGatherTracesMoreRays) {
  const json with = statistics("builtin:furnace-box", {})["count"];
  const json without = statistics("builtin:furnace-box", {"--no-secondary-gather"})["count"];
  EXPECT_GT(with["gather_rays"], without["gather_rays"]);
  EXPECT_GT(with["occlusion_rays"], without["occlusion_rays"]);
}

TEST_F(StatisticsTest, NearestNeighboursAreCounted) {
  const json s = statistics("builtin:furnace-box", {"--engine", "knn", "--nearest", "10", "--no-secondary-gather"});
  // Of 2000 photons in a box, ten are found within the largest radius nearly everywhere.
  EXPECT_LE(s["mean"]["photons_per_query"], 10);
  EXPECT_GT(s["mean"]["photons_per_query"], 9);
}

TEST_F(StatisticsTest, RatesAndMeansAreTheirCountsOverTheirTimes) {
  const json s = statistics("builtin:cornell", {"--engine", "forward"});
  const json &count = s["count"], &time = s["time_s"], &rate = s["rate"];
  const auto number = [](const json& value) { return value.get<double>(); };
  const double density = number(time["density"]) + number(time["reorder"]);
  EXPECT_NEAR(number(rate["gather_rays_per_s"]), number(count["gather_rays"]) / number(time["gather_rays"]),
              1e-6 * number(rate["gather_rays_per_s"]));
  EXPECT_NEAR(number(rate["query_points_per_s"]), number(count["query_points"]) / density,
              1e-6 * number(rate["query_points_per_s"]));
  EXPECT_NEAR(number(rate["shader_operations_per_s_per_core"]),
              number(count["shader_operations"]) / density / number(s["threads"]),
              1e-6 * number(rate["shader_operations_per_s_per_core"]));
  EXPECT_NEAR(number(s["mean"]["photons_per_query"]),
              number(count["shader_operations"]) / number(count["query_points"]), 1e-9);
  EXPECT_NEAR(number(s["mean"]["active_lanes"]), number(count["packet_active_lanes"]) / number(count["packet_steps"]),
              1e-9);
  EXPECT_GT(s["mean"]["active_lanes"], 0);
}

TEST_F(StatisticsTest, ActiveLanesAreAtMostAllLanes) {
  for (const char* engine : {"forward", "blocked", "reverse"})
    for (const char* simd : {"scalar", "auto"}) {
      const json s = statistics("builtin:cornell", {"--engine", engine, "--simd", simd});
      EXPECT_GT(s["mean"]["active_lanes"], 0) << engine << ", " << simd;
      EXPECT_LE(s["mean"]["active_lanes"], s["mean"]["lanes"]) << engine << ", " << simd;
    }
}

TEST_F(StatisticsTest, PhasesAddUpToTheTotal) {
  const std::vector<std::vector<std::string>> renders = {{"--integrator", "gather"},
                                                         {"--samples", "64", "--integrator", "path"},
                                                         {"--integrator", "photons"},
                                                         {"--progressive"},
                                                         {"--noise", "20%"}};
  for (const std::vector<std::string>& options : renders) {
    const std::string integrator = options.back();
    const json s = statistics("builtin:cornell", options);
    double sum = 0;
    for (const auto& [phase, seconds] : s["time_s"].items()) {
      EXPECT_GE(seconds, 0) << phase;
      if (phase != "total") sum += seconds.get<double>();
    }
    const auto seconds = [&](const char* phase) { return s["time_s"][phase].get<double>(); };
    EXPECT_LE(sum, seconds("total") * 1.0001) << integrator;
    EXPECT_GE(sum, seconds("total") * 0.95) << integrator;
    EXPECT_EQ(seconds("trace_paths") > 0, integrator == "path");
    if (integrator == "gather") {
      EXPECT_GT(seconds("photon_noise"), 0);
    }
    EXPECT_GT(s["time_s"]["output"], 0);
    EXPECT_GT(s["time_s"]["load"], 0);
    // A busy machine lets a thread wait between phases, too: the least share of some runs is the program's.
    constexpr double kMostBetween = 0.05;
    constexpr int kMostRuns = 8;
    double between = seconds("other") / seconds("total");
    for (int run = 1; run < kMostRuns && between > kMostBetween; ++run) {
      const json again = statistics("builtin:cornell", options)["time_s"];
      between = std::min(between, again["other"].get<double>() / again["total"].get<double>());
    }
    EXPECT_LE(between, kMostBetween) << integrator << ": work has a phase of its own";
  }
}

TEST_F(StatisticsTest, MemoryIsNotOfWhoStartsTheProgram) {
  const std::vector<char> held(std::size_t{1} << 30, 1);
  const json memory = statistics("builtin:cornell", {"--photons", "2000"})["memory_bytes"];
  EXPECT_GT(memory["peak_rss"], std::size_t{1} << 20);
  EXPECT_LT(memory["peak_rss"], held.size());
  EXPECT_LT(memory["peak_beside_scene"], held.size());
}

TEST_F(StatisticsTest, MemoryIsWithinTheBudget) {
  const json s = statistics("builtin:cornell", {"--memory", "200M"});
  const json& memory = s["memory_bytes"];
  EXPECT_EQ(memory["budget"], 200'000'000);
  EXPECT_LE(memory["peak_reserved"], memory["budget"]);
  EXPECT_GT(memory["photon_map"], 2000 * 40);
  EXPECT_GT(memory["peak_rss"], memory["photon_map"]);
  std::uint64_t largest = 0;
  for (const auto& [holder, bytes] : memory["reserved"].items())
    largest = std::max<std::uint64_t>(largest, bytes.get<std::uint64_t>());
  EXPECT_LE(largest, memory["peak_reserved"]);
}

}  // namespace
}  // namespace glowworm
