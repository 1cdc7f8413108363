// Files appear whole or not at all, however the program ends.
#include "core/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <vector>

#include "core/error.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

namespace fs = std::filesystem;

class AtomicFileTest : public FolderTest {
 protected:
  static std::string content(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
  }
};

TEST_F(AtomicFileTest, AppearsWithItsContentAtCommitOnly) {
  AtomicFile file(path("a.json"));
  file.write("{\"a\":");
  file.write(" 1}");
  EXPECT_FALSE(fs::exists(path("a.json")));
  file.commit();
  EXPECT_EQ(content(path("a.json")), "{\"a\": 1}");
  EXPECT_THAT(names(), testing::ElementsAre("a.json"));
}

TEST_F(AtomicFileTest, WithoutCommitTheOldFileStays) {
  write_file(path("a"), "old");
  {
    AtomicFile file(path("a"));
    file.write("new");
  }
  EXPECT_EQ(content(path("a")), "old");
  EXPECT_THAT(names(), testing::ElementsAre("a"));
}

TEST_F(AtomicFileTest, ReplacesAndKeepsTheMode) {
  write_file(path("a"), "old");
  fs::permissions(path("a"), fs::perms::owner_read | fs::perms::owner_write);
  write_file(path("a"), "new");
  EXPECT_EQ(content(path("a")), "new");
  EXPECT_EQ(fs::status(path("a")).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(AtomicFileTest, NewFileHasTheModeOfTheUmask) {
  const mode_t old = umask(027);
  write_file(path("a"), "x");
  umask(old);
  struct stat info {};
  ASSERT_EQ(stat(path("a").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07777, 0640u);
}

TEST_F(AtomicFileTest, FollowsASymbolicLink) {
  write_file(path("real"), "old");
  fs::create_symlink("real", path("link"));
  write_file(path("link"), "new");
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(content(path("real")), "new");
}

TEST_F(AtomicFileTest, FollowsLinksToAFileThatDoesNotExistYet) {
  fs::create_directory(path("far"));
  fs::create_symlink("far/second", path("first"));
  fs::create_symlink("../real", path("far/second"));
  write_file(path("first"), "new");
  EXPECT_TRUE(fs::is_symlink(path("first")));
  EXPECT_TRUE(fs::is_symlink(path("far/second")));
  EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(path("real"))));
  EXPECT_EQ(content(path("real")), "new");
  fs::create_symlink(folder_ / "absolute", path("third"));
  write_file(path("third"), "whole path");
  EXPECT_EQ(content(path("absolute")), "whole path");
}

TEST_F(AtomicFileTest, UnresolvableLinksAreErrors) {
  fs::create_symlink("missing/file", path("away"));
  EXPECT_THAT(message_of([&] { write_file(path("away"), "x"); }), testing::HasSubstr(path("missing")));
  fs::create_symlink("b", path("a"));
  fs::create_symlink("a", path("b"));
  EXPECT_THAT(message_of([&] { write_file(path("a"), "x"); }), testing::HasSubstr("circle"));
  EXPECT_TRUE(fs::is_symlink(path("a")) && fs::is_symlink(path("b")));
}

TEST_F(AtomicFileTest, DropsSpecialBitsOfTheModeThatItKeeps) {
  write_file(path("a"), "old");
  ASSERT_EQ(chmod(path("a").c_str(), 06751), 0);
  write_file(path("a"), "new");
  struct stat info {};
  ASSERT_EQ(stat(path("a").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07777, 0751u);
}

TEST_F(AtomicFileTest, IdentifiesAFileByAllItsNames) {
  const auto same = [&](const std::string& a, const std::string& b) {
    return output_identity(path(a)) == output_identity(path(b));
  };
  fs::create_directory(path("folder"));
  fs::create_directory_symlink("folder", path("other"));
  EXPECT_TRUE(same("folder/new", "other/../folder/./new"));
  EXPECT_FALSE(same("folder/new", "folder/newer"));
  fs::create_symlink("folder/new", path("link"));
  EXPECT_TRUE(same("link", "other/new"));
  EXPECT_TRUE(same("none/new", "./none/new"));
  EXPECT_EQ(output_identity("none/new"), output_identity("./none/new"));
  write_file(path("folder/new"), "x");
  EXPECT_TRUE(same("link", "other/new"));
  fs::create_hard_link(path("folder/new"), path("hard"));
  EXPECT_TRUE(same("link", "hard"));
  EXPECT_EQ(output_identity("/dev/null"), "");
}

TEST_F(AtomicFileTest, DistinguishesAFullDiskFromAMistake) {
  EXPECT_THROW(write_file("/dev/full", "x"), DiskError);
  try {
    write_file(path("none/a"), "x");
    FAIL();
  } catch (const DiskError&) {
    FAIL() << "a folder that is missing is no fault of the disk";
  } catch (const Error&) {
  }
}

TEST_F(AtomicFileTest, AcceptsTheLongestName) {
  const std::string name(255, 'n');
  write_file(path(name), "x");
  EXPECT_THAT(names(), testing::ElementsAre(name));
  EXPECT_THAT(message_of([&] { write_file(path(name + "n"), "x"); }), testing::HasSubstr("shorter"));
}

TEST_F(AtomicFileTest, MissingFolderIsNamedWithItsRemedy) {
  const std::string message = message_of([&] { write_file(path("no/such/a.json"), "x"); });
  EXPECT_THAT(message, testing::HasSubstr(path("no/such/a.json")));
  EXPECT_THAT(message, testing::HasSubstr("Create the folder \"" + path("no/such") + "\""));
  EXPECT_TRUE(names().empty());
}

TEST_F(AtomicFileTest, AFolderIsAnError) {
  EXPECT_THAT(message_of([&] { write_file(folder_.string(), "x"); }), testing::HasSubstr("folder"));
  EXPECT_THAT(message_of([&] { write_file("", "x"); }), testing::HasSubstr("empty"));
}

TEST_F(AtomicFileTest, DevicesAreWrittenToAndNeverReplaced) {
  write_file("/dev/null", "x");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_THAT(message_of([] { write_file("/dev/full", "x"); }), testing::HasSubstr("Free space"));
}

// Runs `work` in a child process; returns its wait status.
int status_of_child(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    work();
    _exit(99);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

TEST_F(AtomicFileTest, UnwritableFolderIsAnError) {
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
  const int status = status_of_child([&] {
    // Rights do not bind the superuser; the child becomes nobody.
    if (getuid() == 0 && setuid(65534) != 0) _exit(2);
    const std::string message = message_of([&] { write_file(path("a"), "x"); });
    _exit(message.find("writable") != std::string::npos ? 0 : 1);
  });
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_TRUE(names().empty());
}

TEST_F(AtomicFileTest, AFullDiskLeavesTheOldFileAndNothingElse) {
  write_file(path("a"), "old");
  const int status = status_of_child([&] {
    remove_temporary_files_at_signals();  // ignores SIGXFSZ, so that the limit below acts as a disk that fills up
    const rlimit limit{4096, 4096};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(2);
    const std::string message = message_of([&] { write_file(path("a"), std::string(100000, 'x')); });
    _exit(message.find("ulimit") != std::string::npos ? 0 : 1);
  });
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(content(path("a")), "old");
  EXPECT_THAT(names(), testing::ElementsAre("a"));
}

TEST_F(AtomicFileTest, SignalsRemoveTheTemporaryAndKeepTheirStatus) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    const int status = status_of_child([&] {
      signal(number, SIG_DFL);
      remove_temporary_files_at_signals();
      AtomicFile first(path("a")), second(path("b"));
      first.write("x");
      if (names().size() != 2) _exit(2);
      raise(number);
    });
    EXPECT_TRUE(WIFSIGNALED(status)) << number;
    EXPECT_EQ(WTERMSIG(status), number);
    EXPECT_TRUE(names().empty()) << number;
  }
}

TEST_F(AtomicFileTest, AChildDoesNotRemoveWhatItsParentWrites) {
  AtomicFile file(path("a"));
  status_of_child([] {
    remove_temporary_files();
    _exit(0);
  });
  file.write("x");
  file.commit();
  EXPECT_EQ(content(path("a")), "x");
}

TEST_F(AtomicFileTest, RegisterEntriesAreReused) {
  for (int i = 0; i < 1000; ++i) write_file(path("a"), std::to_string(i));
  EXPECT_EQ(content(path("a")), "999");
  remove_temporary_files();
  EXPECT_THAT(names(), testing::ElementsAre("a"));
}

}  // namespace
}  // namespace glowworm
