#include "core/input_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "core/error.h"
#include "support/temporary_folder.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

class InputFile : public FolderTest {
 protected:
  static std::string message_of(const std::string& path) {
    try {
      read_input_file(path);
    } catch (const Error& error) {
      return error.what();
    }
    return "read";
  }
};

TEST_F(InputFile, IsReadWhole) {
  const std::string path = folder_ / "a", bytes("a\0b\r\n\xff", 6);
  std::ofstream(path, std::ios::binary) << bytes;
  EXPECT_EQ(read_input_file(path), bytes);
  std::ofstream(path, std::ios::binary | std::ios::trunc).flush();
  EXPECT_EQ(read_input_file(path), "");
}

TEST_F(InputFile, IsARegularFile) {
  const std::string fifo = folder_ / "fifo", link = folder_ / "link";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  ASSERT_EQ(symlink(fifo.c_str(), link.c_str()), 0);
  EXPECT_THAT(message_of(fifo), HasSubstr("fifo: is not a regular file"));
  EXPECT_THAT(message_of(link), HasSubstr("link: is not a regular file"));
  EXPECT_THAT(message_of("/dev/zero"), HasSubstr("is not a regular file"));
  EXPECT_THAT(message_of(folder_), HasSubstr("is a folder"));
  EXPECT_THAT(message_of(folder_ / "gone"), HasSubstr("no such file"));
  EXPECT_THROW(check_input_file(fifo), Error);
}

TEST_F(InputFile, IsRecordedByAllRecordsOfItsThread) {
  const std::string path = folder_ / "a", other = folder_ / "b";
  std::ofstream(path, std::ios::binary) << "x";
  std::ofstream(other, std::ios::binary) << "x";
  const InputRecord outer;
  read_input_file(path);
  {
    const InputRecord inner;
    read_input_file(other);
    std::thread([&] { read_input_file(path); }).join();
    EXPECT_THAT(inner.names(), testing::ElementsAre(other));
  }
  EXPECT_THAT(outer.names(), testing::ElementsAre(path, other));
}

TEST_F(InputFile, IsOutsideWhereverItsRealPathIs) {
  std::filesystem::create_directories(folder_ / "room" / "sub");
  std::ofstream(folder_ / "secret") << "x";
  std::filesystem::create_symlink("../secret", folder_ / "room" / "link");
  std::filesystem::create_symlink("room/a.gltf", folder_ / "shortcut.gltf");
  const std::string scene = folder_ / "room" / "a.gltf";
  std::ofstream(scene, std::ios::binary) << "x";
  EXPECT_FALSE(is_outside(folder_ / "room" / "sub" / "x.png", scene));
  EXPECT_FALSE(is_outside(folder_ / "room" / "sub" / ".." / "x.png", scene));
  EXPECT_TRUE(is_outside(folder_ / "room" / ".." / "secret", scene));
  EXPECT_TRUE(is_outside(folder_ / "room" / "link", scene));
  EXPECT_TRUE(is_outside(folder_ / "room2" / "x.png", scene));
  EXPECT_TRUE(is_outside("/etc/passwd", scene));
  EXPECT_FALSE(is_outside(folder_ / "room" / "x.png", folder_ / "shortcut.gltf"));
  EXPECT_FALSE(is_outside("x.png", "a.gltf"));
  EXPECT_TRUE(is_outside("../x.png", "a.gltf"));
}

TEST_F(InputFile, FitsIntoMemory) {
  const std::string path = folder_ / "sparse";
  std::ofstream(path, std::ios::binary) << "x";
  std::error_code error;
  std::filesystem::resize_file(path, std::uintmax_t{1} << 42, error);
  if (error) GTEST_SKIP() << "no sparse files here";
  EXPECT_THAT(message_of(path), HasSubstr("larger than the machine's memory"));
}

}  // namespace
}  // namespace glowworm
