// Query points in a temporary file: the same picture, and clear errors when the disk fails.
#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>

#include "image/image.h"
#include "program.h"

namespace glowworm {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class DiskTest : public ProgramTest {
 protected:
  Outcome render_by_disk(const std::string& name, const std::string& use, const std::function<void()>& prepare = {}) {
    return render("builtin:cornell",
                  {"--engine", "reverse", "--size", "128x128", "--gather", "25", "--precision", "float", "--photons",
                   "50k", "--memory", "64M", "--disk", use, "-q", "-o", name, "--stats", "s.json"},
                  prepare);
  }
};

TEST_F(DiskTest, GivesTheSamePictureToTheBit) {
  for (const char* use : {"never", "always"})
    ASSERT_EQ(render_by_disk(std::string(use) + ".exr", use).status, 0) << use;
  const nlohmann::json s = read_json("s.json");
  EXPECT_GT(s["paged"]["bytes_written"], 0);
  EXPECT_GT(s["paged"]["bytes_read"], 0);
  const Image a = read_image(path("never.exr")), b = read_image(path("always.exr"));
  for (const char* channel : {"R", "G", "B"})
    EXPECT_TRUE(std::ranges::equal(a.channel(channel), b.channel(channel))) << channel;
}

TEST_F(DiskTest, FullDiskIsReportedAndLeavesNoFiles) {
  // A limit on the size of files stands for a disk that is full: writes are cut short at it, then fail.
  const Outcome outcome = render_by_disk("a.exr", "always", [] {
    const rlimit limit{2'000'000, 2'000'000};
    setrlimit(RLIMIT_FSIZE, &limit);
  });
  EXPECT_TRUE(refused(outcome, {"temporary file", "TMPDIR"}));
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(DiskTest, UnusableTemporaryFolderIsReported) {
  for (const std::string& folder : {path("missing"), std::string("/proc")}) {
    static std::string variable;
    variable = "TMPDIR=" + folder;
    const Outcome outcome = render_by_disk("a.exr", "always", [] { putenv(variable.data()); });
    EXPECT_TRUE(refused(outcome, {folder, "temporary file", "TMPDIR"}));
    EXPECT_THAT(names(), IsEmpty());
  }
}

}  // namespace
}  // namespace glowworm
