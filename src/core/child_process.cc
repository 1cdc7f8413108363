#include "core/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>  // strsignal, sigabbrev_np
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "core/confine.h"
#include "core/error.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

constexpr const char* kLibexec = "libexec/glowworm";
constexpr int kPatienceMilliseconds = 50;  ///< interval between checks of the clock and of cancellation

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

}  // namespace

ChildProcess::ChildProcess(const std::string& program, std::vector<std::string> arguments, const Descriptor& descriptor,
                           std::string variable)
    : parent_(getpid()) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  // First, as the descriptor may be a standard one where the parent has closed its own.
  posix_spawn_file_actions_adddup2(&files, descriptor.number(), kChildDescriptor);
  for (const int standard : {0, 1, 2}) {
    posix_spawn_file_actions_addopen(&files, standard, "/dev/null", standard == 0 ? O_RDONLY : O_WRONLY, 0);
  }
  arguments.insert(arguments.begin(), program);
  std::vector<char*> words;
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  std::vector<char*> variables;
  if (!variable.empty()) variables.push_back(variable.data());
  for (char** other = environ; *other; ++other) variables.push_back(*other);
  variables.push_back(nullptr);
  const int error = posix_spawn(&id_, program.c_str(), &files, nullptr, words.data(), variables.data());
  posix_spawn_file_actions_destroy(&files);
  if (error == 0) return;
  id_ = -1;
  throw Error(
      fmt::format("the program {} cannot be started: {}", program, strerror(error)),
      fmt::format("Put {} into the folder of the program.", std::filesystem::path(program).filename().string()));
}

ChildProcess::~ChildProcess() { end(); }

bool ChildProcess::has_ended() {
  if (id_ >= 0 && waitpid(id_, &status_, WNOHANG) == id_) id_ = -1;
  return id_ < 0;
}

int ChildProcess::end() {
  // A copy of the parent made by fork() has no such child.
  if (id_ < 0 || getpid() != parent_) return status_;
  kill(id_, SIGKILL);
  while (waitpid(id_, &status_, 0) < 0 && errno == EINTR) {
  }
  id_ = -1;
  return status_;
}

bool wait_to_read(const Descriptor& descriptor, std::chrono::steady_clock::time_point end) {
  for (;;) {
    check_cancelled();
    pollfd wanted{descriptor.number(), POLLIN, 0};
    if (poll(&wanted, 1, kPatienceMilliseconds) > 0) return true;
    if (std::chrono::steady_clock::now() > end) return false;
  }
}

std::string describe_failure(int status, const std::string& program, const ChildLimits& limits) {
  if (WIFSIGNALED(status)) {
    const int number = WTERMSIG(status);
    if (number == SIGXCPU)
      return fmt::format("was stopped after {} s of processor time, its limit", limits.cpu_seconds);
    if (number == SIGKILL) return "was killed, perhaps by the system for lack of memory";
    const char* name = sigabbrev_np(number);
    return fmt::format("crashed on this file (SIG{}): the file is damaged or malicious", name ? name : "?");
  }
  if (WEXITSTATUS(status) == static_cast<int>(ChildExit::out_of_memory))
    return fmt::format("needs more memory for this file than the {} MB that it may take",
                       limits.memory_bytes / 1'000'000);
  return fmt::format("could not be run (status {} of {})", WEXITSTATUS(status), program);
}

std::string find_companion(const std::string& name) {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path code = file_of_code(reinterpret_cast<std::uintptr_t>(&find_companion));
  std::vector<std::filesystem::path> candidates{program.parent_path() / name,
                                                program.parent_path().parent_path() / kLibexec / name};
  // A library that another program has loaded, such as a module of Python, may lie deeper below its prefix.
  if (!code.empty() && code != program) {
    candidates.push_back(code.parent_path() / name);
    for (auto above = code.parent_path(); above.has_relative_path(); above = above.parent_path())
      candidates.push_back(above.parent_path() / kLibexec / name);
  }
  for (const std::filesystem::path& candidate : candidates)
    if (candidate.is_absolute() && std::filesystem::exists(candidate, error)) return candidate.string();
  return candidates.front().string();
}

}  // namespace glowworm
