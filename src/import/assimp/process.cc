#include "import/assimp/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <string.h>  // strerror
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "core/confine.h"
#include "core/error.h"

namespace glowworm {

namespace {

constexpr const char* kRemedy = "Open it in the program that wrote it and export it again, as glTF if possible.";

class Reading {
 public:
  Reading(const std::string& path, const std::string& program, const ChildLimits& limits, Reservation& held)
      : path_(path), program_(program), limits_(limits), held_(held) {}

  std::string run() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
      throw Error({path_}, std::string("no pipe to glowworm-assimp: ") + strerror(errno), "Close other programs.");
    const Descriptor out(ends[0]);
    Descriptor in(ends[1]);
    ChildProcess child(program_, {path_, std::to_string(limits_.memory_bytes), std::to_string(limits_.cpu_seconds)},
                       in);
    in = Descriptor();  // the child holds the only other end
    const std::string bytes = take_all(out);
    const int status = child.end();
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return bytes;
    if (WIFEXITED(status) && WEXITSTATUS(status) == static_cast<int>(ChildExit::refused))
      throw Error({path_}, "cannot be read: " + bytes, kRemedy);
    fail(describe_failure(status, program_, limits_));
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    const std::string extension = std::filesystem::path(path_).extension().string();
    throw Error({path_}, fmt::format("Assimp, which reads files of type '{}', {}", extension, what), kRemedy);
  }

  /// Reads the pipe until its other end is closed.
  std::string take_all(const Descriptor& pipe) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(limits_.clock_seconds);
    std::string bytes;
    std::vector<char> piece(std::size_t{1} << 16);
    for (;;) {
      if (!wait_to_read(pipe, end)) fail(fmt::format("did not end within {} s, its limit", limits_.clock_seconds));
      const ssize_t got = read(pipe.number(), piece.data(), piece.size());
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return bytes;
      if (bytes.size() + static_cast<std::size_t>(got) > limits_.memory_bytes)
        fail(fmt::format("hands over more than {} MB", limits_.memory_bytes / 1'000'000));
      held_.grow(static_cast<std::uint64_t>(got));
      bytes.append(piece.data(), static_cast<std::size_t>(got));
    }
  }

  const std::string& path_;
  const std::string& program_;
  const ChildLimits& limits_;
  Reservation& held_;
};

}  // namespace

std::string run_assimp(const std::string& path, const std::string& program, const ChildLimits& limits,
                       Reservation& held) {
  return Reading(path, program, limits, held).run();
}

}  // namespace glowworm
