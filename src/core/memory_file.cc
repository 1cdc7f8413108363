#include "core/memory_file.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/memory_budget.h"

namespace glowworm {

namespace {

[[noreturn]] void fail(std::size_t bytes, const char* why) {
  throw MemoryError(
      fmt::format("no file of {:.1f} MB can be made in memory: {}", static_cast<double>(bytes) / 1e6, why),
      "Free some memory, and see that /proc is mounted.");
}

}  // namespace

MemoryFile::MemoryFile(std::span<const std::uint8_t> bytes)
    : descriptor_(memfd_create("glowworm", MFD_CLOEXEC)), path_(fmt::format("/proc/self/fd/{}", descriptor_)) {
  int error = descriptor_ < 0 || access(path_.c_str(), R_OK) != 0 ? errno : 0;
  for (auto rest = bytes; error == 0 && !rest.empty();) {
    const ssize_t put = write(descriptor_, rest.data(), rest.size());
    if (put > 0)
      rest = rest.subspan(static_cast<std::size_t>(put));
    else if (put == 0 || errno != EINTR)
      error = put == 0 ? ENOSPC : errno;
  }
  if (error == 0) return;
  if (descriptor_ >= 0) close(descriptor_);
  fail(bytes.size(), std::strerror(error));
}

MemoryFile::~MemoryFile() { close(descriptor_); }

}  // namespace glowworm
