// `render --tev` against a viewer in another language, written from tev's published protocol.
#include <array>
#include <cstdio>
#include <cstring>
#include <span>
#include <sstream>

#include "apps/program.h"
#include "image/image.h"

namespace glowworm {
namespace {

/// tests/apps/tev_viewer.py, from its start to its end.
class Viewer {
 public:
  explicit Viewer(const std::string& out)
      : pipe_(popen(("python3 '" GLOWWORM_SOURCE_DIR "/tests/apps/tev_viewer.py' '" + out + "' 2>&1").c_str(), "r")) {}
  ~Viewer() {
    if (pipe_) pclose(pipe_);
  }
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  std::string line() const {
    std::array<char, 512> text{};
    if (!pipe_ || !std::fgets(text.data(), static_cast<int>(text.size()), pipe_)) return {};
    return std::string(text.data(), std::strlen(text.data()) - 1);
  }

 private:
  std::FILE* pipe_;
};

class TevTest : public ProgramTest {};

TEST_F(TevTest, ShowsTheImageThatIsWritten) {
  const Viewer viewer(path("seen.raw"));
  const std::string port = viewer.line();
  ASSERT_FALSE(port.empty()) << "is python3 installed?";
  const Outcome outcome = render("builtin:cornell", {"--size", "48x32", "--aov", "direct,depth", "--tev",
                                                     "127.0.0.1:" + port, "--precision", "float", "-o", "written.exr"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, testing::Not(testing::HasSubstr("tev")));
  std::istringstream said(viewer.line());
  std::string name;
  int width = 0, height = 0, created = 0, updated = 0;
  said >> name >> width >> height >> created >> updated;
  EXPECT_EQ(width, 48) << said.str();
  EXPECT_EQ(height, 32);
  EXPECT_EQ(created, 1);
  EXPECT_GE(updated, 1);
  const Image written = read_image(path("written.exr"));
  const std::string seen = read(path("seen.raw"));
  std::size_t at = 0;
  int channels = 0;
  for (std::string channel; said >> channel; ++channels) {
    ASSERT_TRUE(written.has_channel(channel)) << channel;
    const std::span<const float> wanted = written.channel(channel);
    const std::size_t bytes = wanted.size() * sizeof(float);
    ASSERT_LE(at + bytes, seen.size());
    EXPECT_EQ(std::memcmp(seen.data() + at, wanted.data(), bytes), 0) << channel;
    at += bytes;
  }
  EXPECT_EQ(at, seen.size());
  EXPECT_GE(channels, 7);
}

}  // namespace
}  // namespace glowworm
