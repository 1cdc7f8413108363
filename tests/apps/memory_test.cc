// The memory budget: what a process really holds beside its scene, as the system counts it.
#include <fmt/format.h>

#include "program.h"

namespace glowworm {
namespace {

class SlowMemoryTest : public ProgramTest {};

TEST_F(SlowMemoryTest, BudgetIsKept) {
  struct Case {
    const char *scene, *engine, *memory, *size;
  };
  const Case cases[] = {
      {"builtin:cornell", "reverse", "64M", "300x300"}, {"builtin:atrium", "blocked", "64M", "300x300"},
      {"builtin:atrium", "reverse", "256M", "400x400"}, {"builtin:cornell", "forward", "256M", "400x400"},
      {"builtin:atrium", "blocked", "1G", "512x512"},   {"builtin:atrium", "reverse", "1G", "512x512"}};
  for (const Case& c : cases) {
    const Outcome outcome = run({"render", c.scene, "--engine", c.engine, "--memory", c.memory, "--size", c.size,
                                 "--samples", "1", "--stats", "s.json", "-o", "a.exr", "-q", "--preview"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const nlohmann::json s = read_json("s.json");
    const double held = s["memory_bytes"]["peak_beside_scene"].get<double>() / (1 << 20);
    fmt::print("{:16} {:8} --memory {:>4}: {:7.1f} MiB beside the scene's {:.1f} (reserved {:.1f}, {} photons)\n",
               c.scene, c.engine, c.memory, held, s["memory_bytes"]["scene"].get<double>() / (1 << 20),
               s["memory_bytes"]["peak_reserved"].get<double>() / (1 << 20), s["settings"]["photons"].get<int>());
    EXPECT_LE(s["memory_bytes"]["peak_beside_scene"], s["memory_bytes"]["budget"])
        << c.scene << ' ' << c.engine << ' ' << c.memory;
    EXPECT_GT(held, 0);
  }
}

TEST_F(SlowMemoryTest, TooSmallABudgetIsSaid) {
  EXPECT_TRUE(refused(render("builtin:cornell", {"--memory", "4M", "--size", "256x256"}), {"memory", "--memory"}));
  EXPECT_TRUE(refused(render("builtin:cornell", {"--memory", "64M", "--photons", "1M"}), {"photon map", "--memory"}));
}

}  // namespace
}  // namespace glowworm
