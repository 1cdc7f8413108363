// Paged arrays against plain vectors, and with failing disks.
#include "density/paged_array.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "core/error.h"
#include "core/random.h"

namespace glowworm::density_tests {
namespace {

/// A folder of its own for each test, empty in the end.
class PagedArrayOnDisk : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "paged-XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override {
    EXPECT_TRUE(std::filesystem::is_empty(folder_));
    std::filesystem::remove_all(folder_);
  }
  PagedSettings settings(std::size_t blocks, std::size_t block_bytes = 1024) const {
    PagedSettings s;
    s.on_disk = true;
    s.folder = folder_;
    s.block_bytes = block_bytes;
    s.cache_blocks = blocks;
    return s;
  }

  std::string folder_;
};

/// Three numbers: blocks of 1024 bytes do not hold a whole number of them.
struct Element {
  std::uint32_t a = 0, b = 0, c = 0;
  bool operator==(const Element&) const = default;
};

void compare_with_vector(const PagedSettings& settings) {
  constexpr std::uint32_t kCount = 30011;
  PagedArray<Element> array(kCount, settings);
  std::vector<Element> expected(kCount);
  for (std::uint32_t i = 0; i < kCount; ++i) expected[i] = {i, i + 1, i + 2};
  array.write(0, expected);
  std::vector<Element> scratch(700);
  for (std::uint32_t step = 0; step < 5000; ++step) {
    const std::uint32_t i = hash_combine(1, step) % kCount;
    const std::uint32_t run = std::min(kCount - i, hash_combine(2, step) % 700);
    switch (step % 4) {
      case 0:
        array.set(i, {step, i, run});
        expected[i] = {step, i, run};
        break;
      case 1:
        ASSERT_TRUE(array.get(i) == expected[i]);
        break;
      case 2:
        for (std::uint32_t j = 0; j < run; ++j) expected[i + j] = {step, j, 7};
        array.write(i, std::span<const Element>(expected).subspan(i, run));
        break;
      case 3:
        array.read(i, std::span<Element>(scratch).first(run));
        for (std::uint32_t j = 0; j < run; ++j) ASSERT_TRUE(scratch[j] == expected[i + j]);
        break;
    }
  }
  std::vector<Element> copy;
  const std::span<const Element> all = array.view(0, kCount, copy);
  for (std::uint32_t i = 0; i < kCount; ++i) ASSERT_TRUE(all[i] == expected[i]);
}

TEST(PagedArray, IsAVectorInMemory) {
  compare_with_vector({});
  EXPECT_FALSE(PagedArray<int>(10).on_disk());
  EXPECT_EQ(PagedArray<int>(10).memory_bytes(), 40u);
  EXPECT_EQ(PagedArray<int>().size(), 0u);
}

TEST_F(PagedArrayOnDisk, IsAVectorForAnySizeOfCache) {
  for (const std::size_t blocks : {1, 2, 8, 100}) compare_with_vector(settings(blocks));
  compare_with_vector(settings(3, 7));        // blocks smaller than an element
  compare_with_vector(settings(2, 1 << 20));  // all in the cache
}

TEST_F(PagedArrayOnDisk, HasZerosWhereNothingWasWritten) {
  PagedArray<std::uint32_t> array(5000, settings(1));
  array.set(4000, 5);
  array.set(0, 6);
  EXPECT_EQ(array.get(4000), 5u);
  EXPECT_EQ(array.get(4001), 0u);
  EXPECT_EQ(array.get(2000), 0u);
}

TEST_F(PagedArrayOnDisk, CountsHitsAndBytes) {
  PagedArray<std::byte> array(4 * 1024 + 100, settings(2));
  EXPECT_EQ(array.counts().hit_rate(), 1);
  array.set(0, std::byte{1});     // miss
  array.set(1, std::byte{1});     // hit
  array.set(1024, std::byte{1});  // miss
  array.set(2048, std::byte{1});  // miss, writes block 0
  EXPECT_EQ(array.counts().bytes_written, 1024u);
  EXPECT_EQ(array.counts().bytes_read, 0u);
  array.get(1);  // miss, writes block 1, reads block 0
  EXPECT_EQ(array.counts().hits, 1u);
  EXPECT_EQ(array.counts().misses, 4u);
  EXPECT_EQ(array.counts().bytes_written, 2048u);
  EXPECT_EQ(array.counts().bytes_read, 1024u);
  EXPECT_EQ(array.counts().hit_rate(), 0.2);
  array.set(4096, std::byte{1});  // the last block, of 100 bytes; writes block 2
  array.get(0);                   // hit
  array.get(1024);                // writes block 4, reads block 1
  EXPECT_EQ(array.counts().bytes_written, 3072u + 100u);
  EXPECT_EQ(array.memory_bytes(), 2048u);
}

TEST_F(PagedArrayOnDisk, CountsEveryElementOfARun) {
  PagedArray<std::uint32_t> array(1024, settings(1));
  const std::vector<std::uint32_t> run(512, 7);
  array.write(0, run);  // two blocks of 256 elements, of each of which the first misses
  EXPECT_EQ(array.counts().misses, 2u);
  EXPECT_EQ(array.counts().hits, 510u);
  std::vector<std::uint32_t> back(100);
  array.read(200, back);  // 56 elements of the first block, which was put out by the second, and 44 of that
  EXPECT_EQ(array.counts().misses, 4u);
  EXPECT_EQ(array.counts().hits, 608u);
}

TEST_F(PagedArrayOnDisk, LeavesNoFileWhileItIsInUse) {
  PagedArray<int> array(100000, settings(1));
  for (std::size_t i = 0; i < array.size(); ++i) array.set(i, 1);
  EXPECT_GT(array.counts().bytes_written, 0u);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(PagedArrayOnDisk, RejectsAccessBeyondTheEndAndAnEmptyCache) {
  PagedArray<int> array(100, settings(1));
  EXPECT_THROW(array.get(100), Error);
  EXPECT_THROW(array.set(std::size_t{1} << 40, 1), Error);
  EXPECT_THROW(PagedArray<int>(100, settings(0)), Error);
  EXPECT_THROW(PagedArray<int>(100, settings(1, 0)), Error);
}

/// Runs a function in a child process and returns the message of the Error it ends with; "" where there is none.
template <class Function>
std::string error_in_child(const Function& function) {
  int pipe_ends[2];
  if (pipe(pipe_ends) != 0) return "no pipe";
  const pid_t child = fork();
  if (child == 0) {
    std::string message;
    try {
      function();
    } catch (const Error& error) {
      message = error.what();
    }
    const ssize_t put = write(pipe_ends[1], message.data(), message.size());
    _exit(put == static_cast<ssize_t>(message.size()) ? 0 : 1);
  }
  close(pipe_ends[1]);
  std::string message(4096, '\0');
  std::size_t size = 0;
  for (ssize_t got; (got = read(pipe_ends[0], message.data() + size, message.size() - size)) > 0;)
    size += static_cast<std::size_t>(got);
  close(pipe_ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  message.resize(size);
  return message;
}

TEST_F(PagedArrayOnDisk, ReportsAFullDisk) {
  // The limit lies within a block: the write before the failing one comes back short.
  const std::string message = error_in_child([&] {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{10 * 1024 + 300, 10 * 1024 + 300};
    setrlimit(RLIMIT_FSIZE, &limit);
    PagedArray<int> array(100000, settings(2));
    for (std::size_t i = 0; i < array.size(); ++i) array.set(i, 1);
  });
  EXPECT_NE(message.find(folder_), std::string::npos) << message;
  EXPECT_NE(message.find("TMPDIR"), std::string::npos) << message;
}

TEST_F(PagedArrayOnDisk, ReportsAnUnwritableFolder) {
  const auto expect_error = [&](const std::string& folder) {
    PagedSettings in_folder = settings(2);
    in_folder.folder = folder;
    const std::string message = error_in_child([&] {
      // Permissions do not hold for root.
      if (getuid() == 0 && setuid(65534) != 0) _exit(2);
      const PagedArray<int> array(1000, in_folder);
    });
    EXPECT_NE(message.find(folder), std::string::npos) << message;
    EXPECT_NE(message.find("TMPDIR"), std::string::npos) << message;
  };
  expect_error(folder_ + "/not there");
  expect_error("/dev/null");
  chmod(folder_.c_str(), 0);
  expect_error(folder_);
  chmod(folder_.c_str(), 0700);
}

}  // namespace
}  // namespace glowworm::density_tests
