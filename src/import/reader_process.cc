#include "import/reader_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <string.h>  // strerror
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <system_error>

#include "core/confine.h"
#include "core/error.h"

namespace glowworm {

namespace {

/// Maximum memory of the process for a file, bytes: what programs and libraries take, and what a file of that size can
/// become. A damaged one may ask for any amount.
std::uint64_t memory_limit(const MemoryBudget& budget, std::uint64_t file_bytes) {
  constexpr std::uint64_t kOfProgram = std::uint64_t{1} << 30;
  constexpr std::uint64_t kMostExpansion = 1032;  // of deflate, by which some formats are compressed
  const std::uint64_t half = physical_memory_bytes() / 2;
  const std::uint64_t most = kOfProgram + std::min(file_bytes, half / kMostExpansion) * kMostExpansion;
  return std::min({most, half, budget.limit() > 0 ? budget.limit() : half});
}

class Reading {
 public:
  Reading(const ReaderProgram& program, const std::string& path, const ChildLimits& limits, Reservation& held)
      : reader_(program),
        program_(program.path.empty() ? find_companion(program.name) : program.path),
        path_(path),
        limits_(limits),
        held_(held) {}

  std::string run(const std::vector<std::string>& more_arguments) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0)
      throw Error({path_}, fmt::format("no pipe to {}: {}", reader_.name, strerror(errno)), "Close other programs.");
    const Descriptor out(ends[0]);
    Descriptor in(ends[1]);
    std::vector<std::string> arguments{path_, std::to_string(limits_.memory_bytes),
                                       std::to_string(limits_.cpu_seconds)};
    arguments.insert(arguments.end(), more_arguments.begin(), more_arguments.end());
    ChildProcess child(program_, std::move(arguments), in);
    in = Descriptor();  // the child holds the only other end
    const std::string bytes = take_all(out);
    const int status = child.end();
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return bytes;
    if (WIFEXITED(status) && WEXITSTATUS(status) == static_cast<int>(ChildExit::refused))
      throw Error({path_}, "cannot be read: " + bytes, reader_.remedy);
    fail(describe_failure(status, program_, limits_));
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    const std::string extension = std::filesystem::path(path_).extension().string();
    throw Error({path_}, fmt::format("{}, which reads files of type '{}', {}", reader_.library, extension, what),
                reader_.remedy);
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

  const ReaderProgram& reader_;
  const std::string program_;
  const std::string& path_;
  const ChildLimits& limits_;
  Reservation& held_;
};

}  // namespace

ChildLimits limits_for(const std::string& file, const MemoryBudget& budget, ChildLimits given) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  const std::uint64_t bytes = error ? 0 : size, mebibytes = std::min<std::uint64_t>(bytes >> 20, 100000);
  if (given.memory_bytes == 0) given.memory_bytes = memory_limit(budget, bytes);
  if (given.cpu_seconds == 0) given.cpu_seconds = 60 + 2 * static_cast<unsigned>(mebibytes);
  if (given.clock_seconds == 0) given.clock_seconds = 10 * given.cpu_seconds;
  return given;
}

std::string run_reader(const ReaderProgram& program, const std::string& file,
                       const std::vector<std::string>& more_arguments, const ChildLimits& limits, Reservation& held) {
  return Reading(program, file, limits, held).run(more_arguments);
}

}  // namespace glowworm
