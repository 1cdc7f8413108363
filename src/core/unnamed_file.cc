#include "core/unnamed_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "core/error.h"
#include "core/temporary_files.h"

namespace glowworm {

namespace {

constexpr const char* kRemedy =
    "Free space there, set TMPDIR to a folder on another disk, or give the render more memory so that it needs no "
    "file.";

[[noreturn]] void fail(const std::string& folder, const std::string& what, int error) {
  throw Error(FilePlace{folder}, fmt::format("{}: {}", what, std::strerror(error)), kRemedy);
}

int open_unnamed(const std::string& folder) {
#ifdef O_TMPFILE
  const int unnamed = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (unnamed >= 0) return unnamed;
  // These errors mean that the file system or the kernel does not support unnamed files.
  if (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL) fail(folder, "no temporary file can be made", errno);
#endif
  static std::atomic<unsigned> counter{0};
  for (int attempt = 0;; ++attempt) {
    const std::string path = fmt::format("{}/glowworm-{}-{}.tmp", folder, getpid(), counter++);
    const TemporaryName name(path);
    const int file = open(path.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, S_IRUSR | S_IWUSR);
    if (file < 0) {
      if (errno == EEXIST && attempt < 1000) continue;
      fail(folder, "no temporary file can be made", errno);
    }
    unlink(path.c_str());
    return file;
  }
}

}  // namespace

std::filesystem::path temporary_folder() {
  const char* folder = std::getenv("TMPDIR");
  return folder && *folder ? folder : "/tmp";
}

UnnamedFile::UnnamedFile() : folder_(temporary_folder().string()), descriptor_(open_unnamed(folder_)) {}

UnnamedFile::~UnnamedFile() { close(descriptor_); }

void UnnamedFile::read(std::uint64_t first, std::span<std::byte> to) const {
  while (!to.empty()) {
    const ssize_t got = pread(descriptor_, to.data(), to.size(), static_cast<off_t>(first));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail(folder_, "a temporary file cannot be read back", got < 0 ? errno : EIO);
    to = to.subspan(static_cast<std::size_t>(got));
    first += static_cast<std::uint64_t>(got);
  }
}

void UnnamedFile::write(std::uint64_t first, std::span<const std::byte> from) {
  while (!from.empty()) {
    const ssize_t put = pwrite(descriptor_, from.data(), from.size(), static_cast<off_t>(first));
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) fail(folder_, "a temporary file cannot be written", put < 0 ? errno : ENOSPC);
    from = from.subspan(static_cast<std::size_t>(put));
    first += static_cast<std::uint64_t>(put);
  }
}

void* map_unnamed_file(std::size_t bytes) {
  const std::string folder = temporary_folder();
  const int file = open_unnamed(folder);
  int error = posix_fallocate(file, 0, static_cast<off_t>(bytes));
  void* memory = MAP_FAILED;
  if (error == 0) {
    memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (memory == MAP_FAILED) error = errno;
  }
  close(file);
  if (error != 0)
    fail(folder, fmt::format("a temporary file of {:.1f} MB cannot be made", static_cast<double>(bytes) / 1e6), error);
  return memory;
}

}  // namespace glowworm
