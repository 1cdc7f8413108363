// Parts that share their photons through a folder.
#include <fmt/format.h>
#include <signal.h>

#include <atomic>
#include <memory>
#include <thread>

#include "image/image.h"
#include "program.h"

namespace glowworm {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr int kParts = 3;

class ShareTest : public ProgramTest {
 protected:
  static std::vector<std::string> cornell(const std::vector<std::string>& more) {
    std::vector<std::string> all = {"render", "builtin:cornell", "--size", "24x16",       "--gather",
                                    "4",      "--samples",       "3",      "--precision", "float"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  static std::vector<std::string> part(int number, const char* photons = "20k") {
    return cornell({"--photons", photons, "--share", "folder", "-v", "--part", std::to_string(number) + "/3", "-o",
                    std::to_string(number) + ".part"});
  }

  /// Merges the parts, and compares them with the undivided render.
  void expect_bits_of_the_whole(const char* photons = "20k") const {
    ASSERT_EQ(run(cornell({"--photons", photons, "-o", "whole.exr"})).status, 0);
    const Outcome merged = run({"merge", "3.part", "1.part", "2.part", "--precision", "float", "-o", "merged.exr"});
    ASSERT_EQ(merged.status, 0) << merged.err;
    const Image a = read_image(path("whole.exr")), b = read_image(path("merged.exr"));
    for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(a.channels()[i].samples == b.channels()[i].samples) << i;
  }

  /// Files of the shared folder with this ending.
  std::vector<fs::path> shared(const std::string& ending) const {
    std::vector<fs::path> out;
    if (!fs::exists(path("folder"))) return out;
    for (const auto& entry : fs::recursive_directory_iterator(path("folder")))
      if (entry.path().extension() == ending) out.push_back(entry.path());
    return out;
  }
};

TEST_F(ShareTest, PartsInTurnTraceOnce) {
  for (const int number : {2, 1, 3}) {
    const Outcome outcome = run(part(number));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, Not(HasSubstr("warning: folder")));
    if (number == 2)
      EXPECT_THAT(outcome.err, HasSubstr(" pieces made, 0 read"));
    else
      EXPECT_THAT(outcome.err, HasSubstr(": 0 pieces made, "));
  }
  expect_bits_of_the_whole();
  EXPECT_TRUE(shared(".claim").empty());
  // Files of other renders have other names.
  const std::size_t files = shared(".share").size();
  EXPECT_GT(files, 0u);
  for (const char* other : {"--seed", "--nearest"}) {
    std::vector<std::string> arguments = part(1);
    arguments.insert(arguments.end(), {other, "7"});
    EXPECT_THAT(run(arguments).err, HasSubstr(" pieces made, 0 read")) << other;
  }
  EXPECT_GT(shared(".share").size(), 2 * files);
}

TEST_F(ShareTest, PartsAtOnceHaveTheBitsOfTheWhole) {
  {
    std::vector<std::unique_ptr<Running>> running;
    for (int number = 1; number <= kParts; ++number)
      running.push_back(std::make_unique<Running>(folder_, part(number, "200k")));
    for (const auto& program : running) EXPECT_EQ(program->wait().status, 0);
  }
  expect_bits_of_the_whole("200k");
}

TEST_F(ShareTest, DamagedFilesAreTracedAgain) {
  ASSERT_EQ(run(part(1)).status, 0);
  std::size_t damaged = 0;
  for (const fs::path& file : shared(".share")) fs::resize_file(file, fs::file_size(file) * damaged++ / 30);
  const Outcome outcome = run(part(2));
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.err, HasSubstr(" is damaged"));
  EXPECT_THAT(outcome.err, HasSubstr(fmt::format("{} pieces made, 0 read", damaged)));
  EXPECT_THAT(run(part(3)).err, Not(HasSubstr(" is damaged")));
  expect_bits_of_the_whole();
}

TEST_F(ShareTest, AFolderThatCannotBeMadeIsAWarning) {
  write("folder", "a file");
  for (int number = 1; number <= kParts; ++number) {
    const Outcome outcome = run(part(number));
    EXPECT_EQ(outcome.status, 0);
    EXPECT_THAT(outcome.err, HasSubstr("warning: folder/"));
  }
  expect_bits_of_the_whole();
}

TEST_F(ShareTest, BakesShareToo) {
  const auto bake = [&](const char* number) {
    const Outcome outcome =
        run({"bake", "builtin:cornell", "--atlas", "64", "--samples", "2", "--photons", "20k", "-v", "--share",
             "folder", "--part", number + std::string("/2"), "-o", number + std::string(".part")});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.err;
  };
  EXPECT_THAT(bake("1"), HasSubstr(" pieces made, 0 read"));
  EXPECT_THAT(bake("2"), HasSubstr(": 0 pieces made, "));
}

/// Waits for the end of claims.
class SlowShareTest : public ShareTest {
 protected:
  /// Whether there is a claim, and not what it is for.
  bool is_any_piece_missing() const {
    for (fs::path file : shared(".claim"))
      if (!fs::exists(file.replace_extension("share"))) return true;
    return false;
  }
};

TEST_F(SlowShareTest, APartKilledWhileItTracesIsReplaced) {
  {
    Running program(folder_, part(1, "400k"));
    ASSERT_TRUE(wait_until([&] { return !shared(".share").empty() && is_any_piece_missing(); }, 60));
    program.send(SIGKILL);
    EXPECT_EQ(program.wait().status, 128 + SIGKILL);
  }
  for (const int number : {2, 3, 1}) ASSERT_EQ(run(part(number, "400k")).status, 0);
  expect_bits_of_the_whole("400k");
  EXPECT_FALSE(is_any_piece_missing());
}

TEST_F(SlowShareTest, WaitingIsToldAndInterrupted) {
  ASSERT_EQ(run(part(1)).status, 0);
  const fs::path file = shared(".share").front();
  const fs::path claim = fs::path(file).replace_extension("claim");
  fs::rename(file, claim);
  // Another process that lives.
  std::atomic<bool> ended = false;
  std::thread other([&] {
    for (; !ended; std::this_thread::sleep_for(std::chrono::milliseconds(100)))
      fs::last_write_time(claim, fs::file_time_type::clock::now());
  });
  Running program(folder_, part(2));
  EXPECT_TRUE(program.wait_for_text("waiting for photons", 60));
  program.send(SIGINT);
  EXPECT_EQ(program.wait().status, 130);
  ended = true;
  other.join();
  EXPECT_TRUE(fs::exists(claim));
}

}  // namespace
}  // namespace glowworm
