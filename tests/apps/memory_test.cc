// The memory budget: memory that the process really uses beyond its scene, as measured by the system.
#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <vector>

#include "image/image.h"
#include "program.h"

namespace glowworm {
namespace {

class SlowMemoryTest : public ProgramTest {};

TEST_F(SlowMemoryTest, StaysWithinTheBudget) {
  struct Case {
    const char *scene, *engine, *memory, *size, *photons;
    bool progressive = false;
  };
  // Progressive renders shoot photons again while memory still holds what the pass before left.
  const Case cases[] = {{"builtin:cornell", "reverse", "64M", "300x300", "90k"},
                        {"builtin:atrium", "blocked", "64M", "300x300", "90k"},
                        {"builtin:cornell", "forward", "256M", "400x400", "400k"},
                        {"builtin:cornell", "blocked", "64M", "300x300", "90k", true},
                        {"builtin:cornell", "reverse", "64M", "200x200", "90k", true}};
  for (const Case& c : cases) {
    std::vector<std::string> arguments = {"render",    c.scene,     "--engine", c.engine,    "--memory",
                                          c.memory,    "--size",    c.size,     "--samples", c.progressive ? "2" : "1",
                                          "--stats",   "s.json",    "-o",       "a.exr",     "-q",
                                          "--preview", "--photons", c.photons,  "--gather",  "16"};
    if (c.progressive) arguments.push_back("--progressive");
    // The filter needs layers of light: 0.8 kB a pixel, with the copy that is written.
    if (c.memory == std::string("64M")) arguments.insert(arguments.end(), {"--filter", "off"});
    const Outcome outcome = run(arguments);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const nlohmann::json s = read_json("s.json");
    const double held = s["memory_bytes"]["peak_beside_scene"].get<double>() / (1 << 20);
    fmt::print("{:16} {:8} --memory {:>4}{}: {:7.1f} MiB beside the scene's {:.1f} (reserved {:.1f}, {} photons)\n",
               c.scene, c.engine, c.memory, c.progressive ? " --progressive" : "", held,
               s["memory_bytes"]["scene"].get<double>() / (1 << 20),
               s["memory_bytes"]["peak_reserved"].get<double>() / (1 << 20), s["settings"]["photons"].get<int>());
    EXPECT_LE(s["memory_bytes"]["peak_beside_scene"], s["memory_bytes"]["budget"])
        << c.scene << ' ' << c.engine << ' ' << c.memory << (c.progressive ? " progressive" : "");
    EXPECT_GT(held, 0);
  }
}

TEST_F(SlowMemoryTest, FilmAndPhotonsThatDoNotFitGoToDisk) {
  const std::vector<std::string> arguments = {
      "render", "builtin:cornell", "--size",   "400x300", "--samples", "2",      "--gather",    "1",     "--photons",
      "200k",   "--aov",           "position", "-q",      "--stats",   "s.json", "--precision", "float", "--resume=c"};
  std::vector<Image> images;
  for (const char* memory : {"1G", "64M"}) {
    std::vector<std::string> all = {"--memory", memory, "-o", std::string(memory) + ".exr"};
    all.insert(all.begin(), arguments.begin(), arguments.end());
    const Outcome outcome = run(all);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    images.push_back(read_image(path(std::string(memory) + ".exr")));
    std::filesystem::remove(path("c"));
    const nlohmann::json bytes = read_json("s.json")["memory_bytes"];
    EXPECT_LE(bytes["peak_beside_scene"], bytes["budget"]) << memory;
    EXPECT_EQ(bytes["on_disk"] > 100'000'000, memory == std::string("64M")) << bytes;
  }
  ASSERT_EQ(images[0].channels().size(), images[1].channels().size());
  for (std::size_t i = 0; i < images[0].channels().size(); ++i)
    EXPECT_TRUE(images[0].channels()[i].samples == images[1].channels()[i].samples) << images[0].channels()[i].name;
}

TEST_F(SlowMemoryTest, CheckpointAndFilterGoToDiskWithTheFilm) {
  const auto memory_of = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = {"render", "builtin:cornell", "--size", "800x500", "--gather", "1",     "--memory",
                                    "64M",    "--photons",       "50k",    "-q",      "-o",       "a.exr", "--stats",
                                    "s.json", "--resume=c"};
    all.insert(all.end(), more.begin(), more.end());
    const Outcome outcome = run(all);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return read_json("s.json")["memory_bytes"];
  };
  const nlohmann::json begun = memory_of({"--samples", "1"});
  const nlohmann::json continued = memory_of({"--samples", "5", "--noise", "0.001"});
  for (const nlohmann::json& bytes : {begun, continued})
    EXPECT_LE(bytes["peak_beside_scene"], bytes["budget"]) << bytes;
  // What the process holds when the render starts; the checkpoint takes 150 MB.
  EXPECT_LT(continued["scene"].get<double>(), begun["scene"].get<double>() + 64e6);
}

TEST_F(SlowMemoryTest, PhotonsOfADenseMediumStayWithinTheBudget) {
  const std::string scene = write("fog.pbrt", R"(LookAt 0 0 -5  0 0 0  0 1 0
Camera "perspective"
MakeNamedMedium "fog" "string type" "homogeneous" "rgb sigma_s" [2 2 2] "rgb sigma_a" [0.2 0.2 0.2]
WorldBegin
Material "interface"
MediumInterface "fog" ""
Shape "sphere" "float radius" 1.5
MediumInterface "fog" "fog"
LightSource "point" "point3 from" [0 0.2 0]
)");
  const auto with = [&](const char* memory) {
    return run({"render",   scene,    "--memory", memory,      "--disk", "never",    "--photons",
                "1M",       "--size", "32x32",    "--samples", "1",      "--gather", "1",
                "--filter", "off",    "-q",       "-o",        "a.exr",  "--stats",  "s.json"});
  };
  // As points, beams and their index they take 0.27 kB each.
  EXPECT_TRUE(refused(with("250M"), {"photon map", "--memory"}));
  const Outcome outcome = with("350M");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json bytes = read_json("s.json")["memory_bytes"];
  EXPECT_LE(bytes["peak_beside_scene"], bytes["budget"]) << bytes;
}

TEST_F(SlowMemoryTest, ManyLightGroupsGoToDisk) {
  std::string scene =
      "LookAt 0 3 8  0 0.8 0  0 1 0\nCamera \"perspective\"\nWorldBegin\n" +
      std::string("Shape \"trianglemesh\" \"point3 P\" [-5 0 -5 5 0 -5 5 0 5] \"integer indices\" [0 2 1]\n");
  for (int i = 0; i < 100; ++i)
    scene += fmt::format("LightSource \"point\" \"point3 from\" [{} {} 0]\n", 0.04 * i - 2, 1 + 0.02 * i);
  const Outcome outcome =
      run({"render", write("groups.pbrt", scene), "--memory", "64M", "--size", "400x300", "--samples", "1", "--gather",
           "1", "--photons", "50k", "--light-groups", "-q", "-o", "a.exr", "--stats", "s.json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read_image(path("a.exr")).channels().size(), 3u + 300u);
  const nlohmann::json bytes = read_json("s.json")["memory_bytes"];
  EXPECT_LE(bytes["peak_beside_scene"], bytes["budget"]) << bytes;
}

TEST_F(SlowMemoryTest, WhatDoesNotFitBesidePhotonsGoesToDiskWithoutBeingAsked) {
  for (const char* disk : {"auto", "always"}) {
    const Outcome outcome =
        run({"render", "builtin:window-room", "--memory", "96M", "--size", "400x300", "--samples", "1", "--gather", "1",
             "--filter", "off", "--photons", "300k", "--disk", disk, "-q", "-o", "a.exr"});
    EXPECT_EQ(outcome.status, 0) << disk << outcome.err;
  }
}

TEST_F(SlowMemoryTest, SensorsTakeMemoryOfTheBudget) {
  const std::vector<std::string> measure = {
      "measure", "builtin:cornell", "--photons", "1k", "--gather", "4", "--samples", "2", "-q", "-o", "a.csv"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = measure;
    all.insert(all.end(), more.begin(), more.end());
    return run(all);
  };
  std::string points;
  for (int i = 0; i < 200'000; ++i) points += "0.2 0.3 0.2 0 1 0\n";
  write("many.pts", points);
  EXPECT_TRUE(refused(with({"--points", "many.pts", "--memory", "64M"}), {"memory has room", "--memory"}));
  EXPECT_TRUE(refused(with({"--grid", "y=0.3,0.0005", "--memory", "64M"}), {"are possible", "--memory"}, 2));
}

TEST_F(SlowMemoryTest, TooSmallABudgetIsReported) {
  EXPECT_TRUE(refused(render("builtin:cornell", {"--memory", "4M", "--size", "256x256"}), {"memory", "--memory"}));
  EXPECT_TRUE(refused(render("builtin:cornell", {"--memory", "64M", "--photons", "1M", "--disk", "never"}),
                      {"photon map", "--memory"}));
}

}  // namespace
}  // namespace glowworm
