// Disks that fail at every write, and memory refused at any place (apps/preload/refuse_calls.cc). Slow, because
// sanitizers' own allocators would interfere.
#include <stdlib.h>

#include <cerrno>
#include <chrono>
#include <sstream>

#include "film/checkpoint.h"
#include "image/image.h"
#include "program.h"

namespace glowworm {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class SlowFaultsTest : public ProgramTest {
 protected:
  using Variables = std::vector<std::pair<const char*, std::string>>;

  /// Runs the program with something refused.
  Outcome run_refused(const std::vector<std::string>& arguments, const Variables& refused) const {
    return run(arguments, [&] {
      setenv("LD_PRELOAD", GLOWWORM_REFUSE_CALLS, 1);
      for (const auto& [name, value] : refused) setenv(name, value.c_str(), 1);
    });
  }

  struct Counts {
    unsigned long calls = 0, allocations = 0;
  };
  /// How many calls and allocations a run makes that nothing is refused to.
  Counts counts_of(const std::vector<std::string>& arguments) const {
    const fs::path report = folder_.string() + "-logs/report";
    const Outcome outcome = run_refused(arguments, {{"REFUSE_REPORT", report.string()}});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::istringstream text(read(report));
    Counts counts;
    text >> counts.calls >> counts.allocations;
    return counts;
  }

  /// A scene with the texture x.png.
  std::string textured_triangle() const {
    write("a.mtl", "newmtl m\nmap_Kd x.png\n");
    return write("a.obj", "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
  }

  std::vector<std::string> tiny_render(const std::vector<std::string>& more) const {
    std::vector<std::string> all = {
        "render", "builtin:cornell", "--size", "8x8",        "--gather", "4",     "--photons", "500",  "-q", "--stats",
        "s",      "--threads",       "2",      "--resume=c", "-o",       "a.exr", "-o",        "b.png"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  /// Writes older files of all outputs but the checkpoint, which would be gone on from.
  void put_old_files() const {
    for (const std::string& name : names()) fs::remove(folder_ / name);
    for (const char* name : {"a.exr", "b.png", "s"}) write(name, "older");
  }

  bool is_old(const std::string& name) const {
    return name == "c" ? !fs::exists(folder_ / name) : read(folder_ / name) == "older";
  }

  /// Whether a file is whole, and the one that a run without faults writes.
  bool is_new(const std::string& name, const Image& exr, const Image& png) const {
    try {
      if (name == "c") return read_checkpoint(path(name)).has_value();
      if (name == "s") return read_json(name).contains("passes");
      const Image image = read_image(path(name)), &wanted = name == "a.exr" ? exr : png;
      for (std::size_t i = 0; i < wanted.channels().size(); ++i)
        if (image.channels()[i].samples != wanted.channels()[i].samples) return false;
      return true;
    } catch (const std::exception&) {
      return false;
    }
  }
};

TEST_F(SlowFaultsTest, EachFailedCallLeavesTheOldFileOrTheNewAndAllOthers) {
  const std::vector<std::string> arguments = tiny_render({"--samples", "1"});
  put_old_files();
  const unsigned long calls = counts_of(arguments).calls;
  ASSERT_GT(calls, 30u);
  ASSERT_LE(calls, 200u);
  const Image exr = read_image(path("a.exr")), png = read_image(path("b.png"));
  std::size_t losses = 0;
  for (unsigned long n = 1; n <= calls; ++n) {
    SCOPED_TRACE("call " + std::to_string(n));
    put_old_files();
    const int error = n % 2 == 0 ? ENOSPC : EIO;
    const Outcome outcome =
        run_refused(arguments, {{"REFUSE_CALL", std::to_string(n)}, {"REFUSE_ERRNO", std::to_string(error)}});
    std::size_t missing = 0;
    for (const char* name : {"a.exr", "b.png", "s", "c"}) {
      if (outcome.err.find(std::string("not written: ") + name) == std::string::npos) {
        EXPECT_TRUE(is_new(name, exr, png)) << name << "\n" << outcome.err;
        continue;
      }
      ++missing;
      // A slow machine writes checkpoints before the last one, too.
      EXPECT_TRUE(is_old(name) || (name == std::string("c") && is_new(name, exr, png))) << name;
    }
    EXPECT_LE(missing, 1u) << outcome.err;
    EXPECT_EQ(outcome.status, missing > 0 ? 1 : 0) << outcome.err;
    // A temporary file that cannot be removed is all that may be left.
    EXPECT_LE(names().size(), 5u);
    losses += missing;
  }
  EXPECT_GT(losses, 10u);
}

/// Query points go through a file here; a disk that fails under it ends the render, which keeps what it has.
TEST_F(SlowFaultsTest, ARenderThatFailsWritesTheImageSoFar) {
  const std::vector<std::string> arguments = tiny_render({"--samples", "3", "--disk", "always", "--engine", "reverse"});
  put_old_files();
  const unsigned long calls = counts_of(arguments).calls;
  std::size_t partial = 0, none = 0;
  for (unsigned long n = 1; n <= calls; ++n) {
    SCOPED_TRACE("call " + std::to_string(n));
    put_old_files();
    const Outcome outcome = run_refused(arguments, {{"REFUSE_CALL", std::to_string(n)}});
    ASSERT_TRUE(outcome.status == 0 || outcome.status == 1) << outcome.status << outcome.err;
    if (outcome.err.find("temporary file") == std::string::npos) continue;
    EXPECT_EQ(outcome.status, 1);
    if (is_old("a.exr")) {
      EXPECT_TRUE(is_old("b.png") && is_old("s") && is_old("c"));
      ++none;
      continue;
    }
    EXPECT_THAT(outcome.err, HasSubstr("the files hold the image so far"));
    const std::string passes = read_image(path("a.exr")).metadata.at("glowworm:passes");
    EXPECT_TRUE(passes == "1" || passes == "2") << passes;
    EXPECT_EQ(read_image(path("b.png")).width(), 8);
    EXPECT_EQ(read_json("s").at("ending"), "failed");
    EXPECT_EQ(std::to_string(read_checkpoint(path("c"))->passes), passes);
    ++partial;
  }
  EXPECT_GT(partial, 0u);
  EXPECT_GT(none, 0u);
}

/// Status 0, where a library does without, or 1, and a message of the program's own; never an abort.
void expect_error(const Outcome& outcome) {
  EXPECT_TRUE(outcome.status == 0 || outcome.status == 1) << outcome.status << outcome.err;
  if (outcome.status == 1) {
    EXPECT_THAT(outcome.err, HasSubstr("glowworm: error: "));
  }
  EXPECT_THAT(outcome.err, Not(HasSubstr("SSE2")));
}

TEST_F(SlowFaultsTest, RefusedMemoryIsAnError) {
  write("a.json", R"({"frames": 2, "size": [8, 8], "moves": [{"at": 1, "screenshot": "shot.exr"}]})");
  ASSERT_EQ(render("builtin:cornell", {"-o", "x.exr", "-o", "x.png", "-q"}).status, 0);
  const std::vector<std::vector<std::string>> commands = {
      tiny_render({"--samples", "1"}),
      {"render", textured_triangle(), "--size", "8x8", "--gather", "4", "--photons", "500", "-q", "--threads", "2",
       "-o", "t.png"},
      {"view", "builtin:cornell", "--photons", "500", "--script", "a.json", "--out", "frames", "--threads", "2"},
      {"compare", "x.exr", "x.png", "-o", "d.png"},
      {"info", "builtin:ajar"}};
  for (const std::vector<std::string>& arguments : commands) {
    const unsigned long allocations = counts_of(arguments).allocations;
    ASSERT_GT(allocations, 1000u);
    constexpr unsigned long kRuns = 20;
    for (unsigned long i = 0; i < kRuns; ++i) {
      // Denser at the beginning, where most kinds of work are: images take most of the allocations.
      const std::string n = std::to_string(1 + i * i * allocations / (kRuns * kRuns));
      SCOPED_TRACE(arguments[0] + ", allocation " + n);
      expect_error(run_refused(arguments, {{"REFUSE_MEMORY", n}}));
      expect_error(run_refused(arguments, {{"REFUSE_MEMORY", n}, {"REFUSE_MEMORY_TO", "1000000000"}}));
    }
  }
}

TEST_F(SlowFaultsTest, NameLookupsTimeOut) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<std::string> arguments = tiny_render({"--tev", "picture.example:14158"});
  EXPECT_TRUE(refused(run_refused(arguments, {{"REFUSE_NAMES", "1"}}), {"--tev", "no address was found in time"}));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
  // Numbers need no server.
  arguments.back() = "127.0.0.1:9";
  EXPECT_TRUE(refused(run_refused(arguments, {{"REFUSE_NAMES", "1"}}), {"--tev", "Connection refused"}));
}

TEST_F(SlowFaultsTest, EmbreeWithoutMemoryIsAnError) {
  const Outcome outcome = run_refused(tiny_render({}), {{"REFUSE_EMBREE", "1"}});
  EXPECT_TRUE(refused(outcome, {"Embree", "out of memory"}));
  EXPECT_THAT(outcome.err, Not(HasSubstr("SSE2")));
}

}  // namespace
}  // namespace glowworm
