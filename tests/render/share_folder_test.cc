// Work divided through a folder: claims, damaged files, folders that cannot be written.
#include "share/share_folder.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/parallel.h"
#include "film/packed_file.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::size_t kPieceCount = 6;
constexpr ShareFolder::Times kQuick{0.02, 0.4, 0.01};

class ShareFolderTest : public FolderTest {
 protected:
  static std::vector<std::byte> content(std::size_t piece) {
    return std::vector<std::byte>(1000 * piece, static_cast<std::byte>(piece + 1));
  }

  /// What one process does: divides the work, checks what it takes, and returns the pieces that it has made.
  static std::vector<std::size_t> divide(ShareFolder& share, double seconds_each = 0) {
    std::vector<std::size_t> made;
    std::size_t next = 0;
    share.divide(
        "work", kPieceCount,
        [&](std::size_t piece) {
          made.push_back(piece);
          std::this_thread::sleep_for(std::chrono::duration<double>(seconds_each));
          return content(piece);
        },
        [&](std::size_t piece, std::span<const std::byte> bytes) {
          EXPECT_EQ(piece, next++);
          EXPECT_TRUE(std::vector(bytes.begin(), bytes.end()) == content(piece)) << piece;
        });
    EXPECT_EQ(next, kPieceCount);
    return made;
  }
  std::vector<std::size_t> divide_alone(const char* key = "key") const {
    ShareFolder share(folder_, key, kQuick);
    return divide(share);
  }

  fs::path file_of(std::size_t piece, const char* ending, const char* key = "key") const {
    return ShareFolder(folder_, key, kQuick).folder() + "/work." + std::to_string(piece + 1) + "-of-6." + ending;
  }
  static std::string read(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
};

TEST_F(ShareFolderTest, TheFirstMakesAllAndTheNextReads) {
  EXPECT_EQ(divide_alone().size(), kPieceCount);
  EXPECT_THAT(divide_alone(), IsEmpty());
  EXPECT_EQ(divide_alone("other key").size(), kPieceCount);
  // Neither claims nor temporary files stay.
  for (const auto& entry : fs::recursive_directory_iterator(folder_))
    EXPECT_TRUE(entry.is_directory() || entry.path().extension() == ".share") << entry.path();
}

TEST_F(ShareFolderTest, ProcessesAtOnceMakeEachPieceOnce) {
  std::vector<std::size_t> made;
  std::mutex mutex;
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i)
    threads.emplace_back([&] {
      ShareFolder share(folder_, "key", kQuick);
      const std::vector<std::size_t> own = divide(share, 0.05);
      EXPECT_FALSE(own.empty());
      EXPECT_EQ(share.made() + share.read(), kPieceCount);
      const std::lock_guard lock(mutex);
      made.insert(made.end(), own.begin(), own.end());
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(made, testing::UnorderedElementsAre(0, 1, 2, 3, 4, 5));
}

TEST_F(ShareFolderTest, AClaimThatDoesNotChangeIsTakenOver) {
  const fs::path claim = file_of(3, "claim");
  std::ofstream(claim).put('\n');
  // A clock far ahead: only change counts.
  fs::last_write_time(claim, fs::file_time_type::clock::now() + std::chrono::hours(1));
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(divide_alone().size(), kPieceCount);
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(400));
  EXPECT_FALSE(fs::exists(claim));
}

TEST_F(ShareFolderTest, AClaimThatChangesIsWaitedFor) {
  const fs::path claim = file_of(3, "claim");
  std::ofstream(claim).put('\n');
  const auto now = fs::file_time_type::clock::now();
  ShareFolder share(folder_, "key", kQuick);
  std::vector<std::size_t> made;
  std::thread waiting([&] { made = divide(share); });
  // A clock far behind.
  for (int i = 0; i < 100; ++i) {
    fs::last_write_time(claim, now - std::chrono::hours(2) + std::chrono::milliseconds(i));
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(share.is_waiting());
  EXPECT_FALSE(fs::exists(file_of(3, "share")));
  EXPECT_TRUE(fs::exists(file_of(5, "share")));
  fs::remove(claim);
  waiting.join();
  EXPECT_EQ(made.back(), 3u);
  EXPECT_FALSE(share.is_waiting());
}

TEST_F(ShareFolderTest, WaitingEndsWhenInterrupted) {
  std::ofstream(file_of(0, "claim")).put('\n');
  ShareFolder share(folder_, "key", {0.02, 1000, 0.01});
  Interrupt interrupt;
  std::thread other([&] {
    while (!share.is_waiting()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    interrupt.request();
  });
  const CancellationScope scope(interrupt);
  EXPECT_THROW(divide(share), Cancelled);
  other.join();
}

TEST_F(ShareFolderTest, AFailedPieceLeavesNoClaim) {
  ShareFolder share(folder_, "key", kQuick);
  const auto fail = [](std::size_t) -> std::vector<std::byte> { throw Error("no memory"); };
  EXPECT_THROW(share.divide("work", 1, fail, [](std::size_t, std::span<const std::byte>) {}), Error);
  EXPECT_TRUE(fs::is_empty(share.folder()));
}

/// Makes a file say that its piece has 2^62 bytes.
void forge_size(const fs::path& path) {
  FileKind kind{};
  std::ifstream old(path, std::ios::binary);
  old.read(kind.data(), kind.size());
  old.seekg(0);
  const std::string title = read_header(old, kind, fs::file_size(path)).value();
  AtomicFile file(path.string());
  write_header(file, kind, title);
  PackedWriter packed(file);
  const std::uint64_t size = std::uint64_t{1} << 62;
  packed.write(std::as_bytes(std::span(&size, 1)));
  packed.finish();
  file.commit();
}

TEST_F(ShareFolderTest, DamagedFilesAreMadeAgain) {
  divide_alone("other key");
  const std::vector<std::pair<const char*, std::function<void(const fs::path&)>>> damages = {
      {"empty", [](const fs::path& file) { fs::resize_file(file, 0); }},
      {"cut", [](const fs::path& file) { fs::resize_file(file, fs::file_size(file) - 1); }},
      {"longer", [](const fs::path& file) { std::ofstream(file, std::ios::app).put('x'); }},
      {"changed",
       [](const fs::path& file) {
         std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(-30, std::ios::end).put('x');
       }},
      {"of forged size", forge_size},
      {"of another render",
       [&](const fs::path& file) {
         fs::copy_file(file_of(3, "share", "other key"), file, fs::copy_options::overwrite_existing);
       }},
      {"of another piece",
       [&](const fs::path& file) { fs::copy_file(file_of(2, "share"), file, fs::copy_options::overwrite_existing); }},
  };
  for (const auto& [name, damage] : damages) {
    SCOPED_TRACE(name);
    divide_alone();
    const fs::path file = file_of(3, "share");
    const std::string before = read(file);
    damage(file);
    testing::internal::CaptureStderr();
    EXPECT_THAT(divide_alone(), testing::ElementsAre(3));
    EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr(file.string() + " is damaged"));
    EXPECT_EQ(read(file), before);
  }
}

TEST_F(ShareFolderTest, WhatIsNoFileNeitherBlocksNorEndsTheRender) {
  for (const char* ending : {"share", "claim"}) {
    const fs::path pipe = file_of(1, ending), folder = file_of(4, ending);
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    fs::create_directories(folder / "x");
    testing::internal::CaptureStderr();
    EXPECT_FALSE(divide_alone().empty());
    const std::string errors = testing::internal::GetCapturedStderr();
    EXPECT_THAT(errors, HasSubstr("The render goes on")) << ending;
    fs::remove_all(folder_);
  }
}

TEST_F(ShareFolderTest, AFolderThatCannotBeWrittenIsOneWarning) {
  fs::remove(folder_);
  std::ofstream(folder_).put('\n');
  testing::internal::CaptureStderr();
  EXPECT_EQ(divide_alone().size(), kPieceCount);
  const std::string errors = testing::internal::GetCapturedStderr();
  EXPECT_THAT(errors, HasSubstr(folder_.string()));
  EXPECT_EQ(errors.find("warning"), errors.rfind("warning")) << errors;
}

TEST_F(ShareFolderTest, WhatIsThereIsReadEvenIfTheFolderGoes) {
  divide_alone();
  ShareFolder share(folder_, "key", kQuick);
  fs::remove(file_of(5, "share"));
  testing::internal::CaptureStderr();
  std::size_t made = 0;
  share.divide(
      "work", kPieceCount,
      [&](std::size_t piece) {
        ++made;
        fs::remove_all(folder_);
        return content(piece);
      },
      [](std::size_t, std::span<const std::byte>) {});
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("The render goes on"));
  EXPECT_EQ(made, 1u);
}

}  // namespace
}  // namespace glowworm
