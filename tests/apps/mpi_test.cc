// One picture by the ranks of mpirun.
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "film/checkpoint.h"
#include "image/image.h"
#include "program.h"
#include "share/ranks.h"

namespace glowworm {
namespace {

namespace fs = std::filesystem;

class SlowMpiTest : public ProgramTest {
 protected:
  static std::vector<std::string> arguments(const std::vector<std::string>& more) {
    std::vector<std::string> all = {"render",    "builtin:atrium", "--size", "48x40",  "--gather",    "4",
                                    "--photons", "2000",           "--aov",  "direct", "--precision", "float"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  /// What turns a run of the program into a run by mpirun.
  static std::function<void()> by_ranks(int count, const std::vector<std::string>& arguments) {
    std::vector<std::string> words = {"mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none",
                                      "-n",     std::to_string(count), GLOWWORM_PROGRAM};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return [words]() mutable {
      static std::vector<char*> pointers;
      for (std::string& word : words) pointers.push_back(word.data());
      pointers.push_back(nullptr);
      execvp(pointers[0], pointers.data());
    };
  }

  Outcome run_ranks(int count, const std::vector<std::string>& more) const {
    const std::vector<std::string> all = arguments(more);
    return run(all, by_ranks(count, all));
  }

  /// The process of a rank that runs in this test's folder; 0 where there is none.
  pid_t process_of_rank(int rank) const {
    const std::string wanted = "OMPI_COMM_WORLD_RANK=" + std::to_string(rank);
    for (const fs::directory_entry& entry : fs::directory_iterator("/proc")) {
      const pid_t process = std::atoi(entry.path().filename().c_str());
      std::error_code error;
      if (process <= 0 || fs::read_symlink(entry.path() / "cwd", error) != folder_ || error) continue;
      if (read(entry.path() / "environ").find(wanted + '\0') != std::string::npos) return process;
    }
    return 0;
  }

  /// Sends a signal to rank 1 of a run as soon as its checkpoint has samples.
  void signal_rank_1(int signal) const {
    ASSERT_TRUE(wait_for_file("a.checkpoint", 60));
    ASSERT_TRUE(wait_until([&] { return read_checkpoint(path("a.checkpoint"))->passes > 0; }, 60));
    const pid_t rank = process_of_rank(1);
    ASSERT_GT(rank, 0);
    ASSERT_EQ(kill(rank, signal), 0);
  }

  void expect_same_pixels(const std::string& a, const std::string& b, std::size_t channels = 6) const {
    const Image one = read_image(path(a)), other = read_image(path(b));
    ASSERT_EQ(one.channels().size(), channels);
    ASSERT_EQ(other.channels().size(), channels);
    for (std::size_t i = 0; i < one.channels().size(); ++i)
      EXPECT_TRUE(one.channels()[i].samples == other.channels()[i].samples) << one.channels()[i].name;
  }
};

TEST_F(SlowMpiTest, RanksRenderFramesOfASequence) {
  const std::vector<std::string> turn = {"--samples", "1", "--turntable", "3"};
  std::vector<std::string> alone = turn, shared = turn;
  alone.insert(alone.end(), {"-o", "alone#.exr"});
  shared.insert(shared.end(), {"-o", "shared#.exr"});
  ASSERT_EQ(run(arguments(alone)).status, 0);
  const Outcome outcome = run_ranks(2, shared);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err.find("warning"), std::string::npos) << outcome.err;
  for (const char* number : {"0", "1", "2"})
    expect_same_pixels(std::string("alone") + number + ".exr", std::string("shared") + number + ".exr");
}

constexpr const char* kMovingLamp = R"(LookAt 0 2 6  0 0 0  0 1 0
Camera "perspective" "float fov" 40 "float shutterclose" 1
WorldBegin
Material "diffuse"
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 0 -4  -4 0 4  4 0 4  4 0 -4]
AreaLightSource "diffuse" "rgb L" [4 4 4] "bool twosided" true
ActiveTransform EndTime Translate 1 0 0 ActiveTransform All
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-.5 1 0  .5 1 0  .5 2 0  -.5 2 0]
)";

/// In one scene a lamp moves, in the other the camera alone.
TEST_F(SlowMpiTest, RanksDivideAPictureWithMotionBlur) {
  std::ofstream(path("lamp.pbrt")) << kMovingLamp;
  std::ofstream(path("camera.pbrt")) << R"(ActiveTransform EndTime Translate 0.3 0 0 ActiveTransform All
LookAt 0 2 6  0 0 0  0 1 0
Camera "perspective" "float fov" 40 "float shutterclose" 1
WorldBegin
AreaLightSource "diffuse" "rgb L" [4 4 4]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-4 0 -4  -4 0 4  4 0 4  4 0 -4]
)";
  using V = std::vector<std::string>;
  // Slices of six and seven samples; films of more than six do not hold all ids.
  V all = arguments({"--samples", "200", "--aov", "direct,object-id", "--stats", "a.json", "-o", ""});
  for (const char* scene : {"lamp.pbrt", "camera.pbrt"}) {
    all[1] = scene;
    all.back() = "alone.exr";
    ASSERT_EQ(run(all).status, 0);
    all.back() = "shared.exr";
    for (const int count : {2, 3}) {
      const Outcome outcome = run(all, by_ranks(count, all));
      ASSERT_EQ(outcome.status, 0) << outcome.err;
      EXPECT_EQ(outcome.err.find("warning"), std::string::npos) << outcome.err;
      EXPECT_EQ(outcome.err.find("wrote shared.exr"), outcome.err.rfind("wrote shared.exr"));
      expect_same_pixels("shared.exr", "alone.exr", 7);
      const nlohmann::json statistics = read_json("a.json");
      EXPECT_GT(statistics.at("tasks"), 1);
      ASSERT_EQ(statistics.at("lights").size(), 1u);
      EXPECT_GT(statistics.at("lights")[0].at("photons_emitted"), 1000);
      // Photons of the other lamp meet nothing.
      if (scene == std::string("lamp.pbrt")) {
        EXPECT_GT(statistics.at("lights")[0].at("photons_stored"), 1000);
        EXPECT_GT(statistics.at("memory_bytes").at("photon_map"), 1000);
      }
    }
    V still = all;
    still.insert(still.end(), {"--shutter", "0", std::string("--resume=") + scene + ".checkpoint"});
    EXPECT_EQ(run(still, by_ranks(2, still)).status, 0);
  }
  for (const auto& [shutter, remedy] :
       {std::pair{V{}, "give --shutter 0"}, std::pair{V{"--shutter", "1"}, "Leave out --shutter"}})
    for (const V& other : {V{"--resume"}, V{"--part", "1/2"}, V{"--noise", "1%"}, V{"--time", "1m"}}) {
      V more = all;
      more.insert(more.end(), shutter.begin(), shutter.end());
      more.insert(more.end(), other.begin(), other.end());
      const Outcome outcome = run(more, by_ranks(2, more));
      EXPECT_NE(outcome.status, 0);
      EXPECT_THAT(outcome.err, testing::HasSubstr("no motion blur: "));
      EXPECT_THAT(outcome.err, testing::HasSubstr(other.front()));
      EXPECT_THAT(outcome.err, testing::HasSubstr(remedy));
    }
}

TEST_F(SlowMpiTest, ARankThatIsInterruptedWhileItLearnsLeavesTheOthersToFinish) {
  std::ofstream(path("lamp.pbrt")) << kMovingLamp;
  std::vector<std::string> all = arguments({"--samples", "2", "--photons", "2M", "--threads", "1", "-o", "a.exr"});
  all[1] = "lamp.pbrt";
  all.erase(std::find(all.begin(), all.end(), "--photons"), std::find(all.begin(), all.end(), "--aov"));
  Running program(folder_, all, by_ranks(2, all));
  ASSERT_TRUE(program.wait_for_text(" ranks, kernels by", 60));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const pid_t rank = process_of_rank(1);
  ASSERT_GT(rank, 0);
  ASSERT_EQ(kill(rank, SIGINT), 0);
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, testing::HasSubstr("wrote a.exr"));
  for (const char* text : {"interrupted", "not answered"})
    EXPECT_THAT(outcome.err, testing::Not(testing::HasSubstr(text)));
}

TEST_F(SlowMpiTest, AnyNumberOfRanksAndThreadsGivesTheSameBits) {
  ASSERT_EQ(run(arguments({"--samples", "4", "-o", "alone.exr"})).status, 0);
  for (const auto& [count, threads] : {std::pair(1, "2"), {2, "1"}, {3, "2"}, {5, "1"}}) {
    fs::remove(path("shared.exr"));
    const Outcome outcome = run_ranks(count, {"--samples", "4", "--threads", threads, "-o", "shared.exr"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err.find("warning"), std::string::npos) << outcome.err;  // no rank was lost
    // Only rank 0 speaks.
    EXPECT_EQ(outcome.err.find("wrote shared.exr"), outcome.err.rfind("wrote shared.exr"));
    EXPECT_EQ(outcome.err.find(" ranks, kernels by") != std::string::npos, count > 1) << outcome.err;
    expect_same_pixels("shared.exr", "alone.exr");
  }
}

TEST_F(SlowMpiTest, AfterAKilledRankTheRenderGoesOnFromItsCheckpoint) {
  // Tiles are at different samples where ranks end, so the number of all samples stays.
  const std::string samples = "300";
  const std::vector<std::string> shared =
      arguments({"--samples", samples, "--threads", "1", "-o", "a.exr", "--resume=a.checkpoint"});
  {
    Running program(folder_, shared, by_ranks(3, shared));
    ASSERT_NO_FATAL_FAILURE(signal_rank_1(SIGKILL));
    EXPECT_NE(program.wait().status, 0);
  }
  // The other ranks have ended, too.
  EXPECT_TRUE(wait_until([&] { return process_of_rank(0) == 0 && process_of_rank(2) == 0; }, 60));
  EXPECT_LT(read_checkpoint(path("a.checkpoint"))->passes, 300u);
  ASSERT_EQ(run_ranks(2, {"--samples", samples, "-o", "a.exr", "--resume=a.checkpoint"}).status, 0);
  ASSERT_EQ(run(arguments({"--samples", samples, "-o", "alone.exr"})).status, 0);
  expect_same_pixels("a.exr", "alone.exr");
}

TEST_F(SlowMpiTest, RanksContinueWithTheNumbersOfACheckpoint) {
  ASSERT_EQ(run(arguments({"--samples", "4", "-o", "alone.exr"})).status, 0);
  ASSERT_EQ(run(arguments({"--samples", "2", "-o", "a.exr", "--resume"})).status, 0);
  // By default there are more gather rays.
  std::vector<std::string> more = arguments({"--samples", "4", "--time", "10m", "-o", "a.exr", "--resume"});
  const auto gather = std::find(more.begin(), more.end(), "--gather");
  more.erase(gather, gather + 2);
  const Outcome outcome = run(more, by_ranks(2, more));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  expect_same_pixels("a.exr", "alone.exr");
}

TEST_F(SlowMpiTest, AStoppedRankIsNamedAndThePictureIsFinished) {
  const std::string samples = "300";
  const std::vector<std::string> shared =
      arguments({"--samples", samples, "--threads", "1", "-o", "a.exr", "--resume=a.checkpoint"});
  Running program(folder_, shared, by_ranks(3, shared));
  ASSERT_NO_FATAL_FAILURE(signal_rank_1(SIGSTOP));
  char host[256] = {};
  ASSERT_EQ(gethostname(host, sizeof host), 0);
  EXPECT_TRUE(program.wait_for_text("rank 1 on " + std::string(host) + " has not answered for 60 s", 120));
  EXPECT_TRUE(program.wait_for_text("wrote a.exr", 60));
  for (const int rank : {0, 1, 2}) EXPECT_TRUE(wait_until([&] { return process_of_rank(rank) == 0; }, 60)) << rank;
  // Open MPI's mpirun may wait for ever although its ranks have ended.
  program.send(SIGKILL);
  program.wait();
  ASSERT_EQ(run(arguments({"--samples", samples, "-o", "alone.exr"})).status, 0);
  expect_same_pixels("a.exr", "alone.exr");
}

/// Rank 1 stops in the middle of a large message, and rank 0 must not wait for the rest of it. The test starts itself
/// by mpirun.
TEST_F(SlowMpiTest, AMessageThatNeverEndsHoldsNobodyUp) {
  if (launched_count() == 1) {
    const std::string self = fs::read_symlink("/proc/self/exe");
    const Outcome outcome = run({}, [&] {
      execlp("timeout", "timeout", "60", "mpirun", "--allow-run-as-root", "--oversubscribe", "--mca", "btl", "tcp,self",
             "-n", "2", self.c_str(), "--gtest_filter=*AMessageThatNeverEnds*", nullptr);
    });
    EXPECT_THAT(outcome.out + outcome.err, testing::HasSubstr("rank 0 has no whole message"));
    return;
  }
  const std::unique_ptr<Ranks> ranks = join_ranks();
  if (ranks->rank() == 1) {
    std::vector<std::byte> bytes(std::size_t{1} << 30);
    const std::jthread stop([] {
      std::this_thread::sleep_for(std::chrono::milliseconds(30));
      raise(SIGSTOP);
    });
    ranks->send(0, std::move(bytes), 60);
  } else {
    fputs(ranks->receive(3) ? "rank 0 has a message\n" : "rank 0 has no whole message\n", stderr);
    ranks->abort(1);
  }
}

TEST_F(SlowMpiTest, AnErrorOfAllRanksIsToldOnceAndEndsThem) {
  const Outcome outcome = run_ranks(2, {"--camera", "none", "-o", "a.exr"});
  EXPECT_NE(outcome.status, 0);
  EXPECT_THAT(outcome.err, testing::HasSubstr("none"));
  EXPECT_EQ(outcome.err.find("rank 1:"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace glowworm
