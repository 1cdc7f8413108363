#include "import/assimp/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>  // strsignal, sigabbrev_np
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "import/assimp/hand_over.h"

namespace glowworm {

namespace {

constexpr const char* kProgram = "glowworm-assimp";
constexpr const char* kLibexec = "libexec/glowworm";
constexpr const char* kRemedy = "Open it in the program that wrote it and export it again, as glTF if possible.";
constexpr int kHandOver = 3;               ///< file descriptor of the pipe in the process
constexpr int kPatienceMilliseconds = 50;  ///< interval between checks of the clock and of cancellation

/// Both ends of a pipe.
class Pipe {
 public:
  explicit Pipe(const std::string& path) {
    if (pipe2(ends_, O_CLOEXEC) != 0) {
      throw Error({path}, std::string("no pipe to glowworm-assimp: ") + strerror(errno), "Close other programs.");
    }
  }
  ~Pipe() {
    close_end(0);
    close_end(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  int end(int which) const { return ends_[which]; }
  void close_end(int which) {
    if (ends_[which] >= 0) close(std::exchange(ends_[which], -1));
  }

 private:
  int ends_[2] = {-1, -1};
};

/// A child process. The destructor ends it and waits for it.
class Child {
 public:
  Child(const std::string& path, const ReaderProcess& process, int pipe) {
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    for (const int standard : {0, 1, 2}) {
      posix_spawn_file_actions_addopen(&files, standard, "/dev/null", standard == 0 ? O_RDONLY : O_WRONLY, 0);
    }
    posix_spawn_file_actions_adddup2(&files, pipe, kHandOver);
    std::string words[] = {process.program, path, std::to_string(kHandOver), std::to_string(process.memory_bytes),
                           std::to_string(process.cpu_seconds)};
    char* arguments[] = {words[0].data(), words[1].data(), words[2].data(), words[3].data(), words[4].data(), nullptr};
    const int error = posix_spawn(&id_, process.program.c_str(), &files, nullptr, arguments, environ);
    posix_spawn_file_actions_destroy(&files);
    if (error != 0) {
      throw Error(
          {path},
          fmt::format("the program {}, which reads it, cannot be started: {}", process.program, strerror(error)),
          fmt::format("Put {} into the folder of the program.", kProgram));
    }
  }
  ~Child() {
    if (id_ >= 0) end();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Ends the process and returns its status as waitpid() does. A process that is already exiting keeps its exit
  /// status.
  int end() {
    int status = 0;
    kill(id_, SIGKILL);
    while (waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    id_ = -1;
    return status;
  }

 private:
  pid_t id_ = -1;
};

/// The file that holds the code at an address, as the system knows it: dladdr() gives the name by which a program was
/// called, which may be relative to the working folder. Empty if there is none.
std::filesystem::path file_of_code(std::uintptr_t address) {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {  // proc(5): first-last permissions offset device inode path
    char* end = nullptr;
    const std::uintptr_t first = std::strtoull(line.c_str(), &end, 16), last = std::strtoull(end + 1, nullptr, 16);
    const std::size_t path = line.find('/');
    if (first <= address && address < last && path != std::string::npos) return line.substr(path);
  }
  return {};
}

class Reading {
 public:
  Reading(const std::string& path, const ReaderProcess& process, Reservation& held)
      : path_(path), process_(process), held_(held) {}

  std::string run() {
    Pipe pipe(path_);
    Child child(path_, process_, pipe.end(1));
    pipe.close_end(1);
    const std::string bytes = take_all(pipe.end(0));
    const int status = child.end();
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return bytes;
    if (WIFSIGNALED(status)) fail_by_signal(WTERMSIG(status));
    fail_by_status(WEXITSTATUS(status), bytes);
  }

 private:
  using Clock = std::chrono::steady_clock;

  [[noreturn]] void fail(const std::string& what) const {
    const std::string extension = std::filesystem::path(path_).extension().string();
    throw Error({path_}, fmt::format("Assimp, which reads files of type '{}', {}", extension, what), kRemedy);
  }

  [[noreturn]] void fail_by_signal(int number) const {
    if (number == SIGXCPU) {
      fail(fmt::format("was stopped after {} s of processor time, its limit", process_.cpu_seconds));
    }
    if (number == SIGKILL) fail("was killed, perhaps by the system for lack of memory");
    const char* name = sigabbrev_np(number);
    fail(fmt::format("crashed on this file (SIG{}): the file is damaged or malicious", name ? name : "?"));
  }

  [[noreturn]] void fail_by_status(int status, const std::string& reason) const {
    if (status == static_cast<int>(ForeignExit::out_of_memory)) {
      fail(fmt::format("needs more memory for this file than the {} MB that it may take",
                       process_.memory_bytes / 1'000'000));
    }
    if (status == static_cast<int>(ForeignExit::refused)) throw Error({path_}, "cannot be read: " + reason, kRemedy);
    fail(fmt::format("could not be run (status {} of {})", status, process_.program));
  }

  /// Reads the pipe until its other end is closed.
  std::string take_all(int pipe) const {
    const auto end = Clock::now() + std::chrono::seconds(process_.clock_seconds);
    std::string bytes;
    std::vector<char> piece(std::size_t{1} << 16);
    for (;;) {
      check_cancelled();
      if (Clock::now() > end) {
        fail(fmt::format("did not end within {} s, its limit", process_.clock_seconds));
      }
      pollfd wanted{pipe, POLLIN, 0};
      if (poll(&wanted, 1, kPatienceMilliseconds) <= 0) continue;
      const ssize_t got = read(pipe, piece.data(), piece.size());
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return bytes;
      if (bytes.size() + static_cast<std::size_t>(got) > process_.memory_bytes) {
        fail(fmt::format("hands over more than {} MB", process_.memory_bytes / 1'000'000));
      }
      held_.grow(static_cast<std::uint64_t>(got));
      bytes.append(piece.data(), static_cast<std::size_t>(got));
    }
  }

  const std::string& path_;
  const ReaderProcess& process_;
  Reservation& held_;
};

}  // namespace

std::string run_reader(const std::string& path, const ReaderProcess& process, Reservation& held) {
  return Reading(path, process, held).run();
}

std::string find_reader() {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path code = file_of_code(reinterpret_cast<std::uintptr_t>(&find_reader));
  std::vector<std::filesystem::path> candidates{program.parent_path() / kProgram,
                                                program.parent_path().parent_path() / kLibexec / kProgram};
  // A library that another program has loaded, such as a module of Python, may lie deeper below its prefix.
  if (!code.empty() && code != program) {
    candidates.push_back(code.parent_path() / kProgram);
    for (auto above = code.parent_path(); above.has_relative_path(); above = above.parent_path())
      candidates.push_back(above.parent_path() / kLibexec / kProgram);
  }
  for (const std::filesystem::path& candidate : candidates)
    if (candidate.is_absolute() && std::filesystem::exists(candidate, error)) return candidate.string();
  return candidates.front().string();
}

}  // namespace glowworm
