#include "core/memory_budget.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <limits>

#include "core/error.h"

namespace glowworm {

void MemoryBudget::reserve(const std::string& name, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  if (limit_ != 0 && (bytes > limit_ || used_ > limit_ - bytes)) {
    std::string holders;
    for (const auto& [holder, held] : held_)
      if (held > 0) holders += fmt::format("{}{} {:.1f} MB", holders.empty() ? "" : ", ", holder, held / 1e6);
    throw Error(fmt::format("the memory budget of {:.1f} MB has no room for {:.1f} MB of {} (held: {})", limit_ / 1e6,
                            bytes / 1e6, name, holders.empty() ? "nothing" : holders),
                "Give a larger --memory, or a smaller image.");
  }
  used_ += bytes;
  peak_ = std::max(peak_, used_);
  std::uint64_t& held = held_[name];
  held += bytes;
  std::uint64_t& peak = peaks_[name];
  peak = std::max(peak, held);
}

void MemoryBudget::release(const std::string& name, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  used_ -= bytes;
  held_[name] -= bytes;
}

std::uint64_t MemoryBudget::available() const {
  const std::lock_guard lock(mutex_);
  return limit_ == 0 ? std::numeric_limits<std::uint64_t>::max() : limit_ - used_;
}

std::uint64_t MemoryBudget::peak() const {
  const std::lock_guard lock(mutex_);
  return peak_;
}

std::map<std::string, std::uint64_t> MemoryBudget::peaks() const {
  const std::lock_guard lock(mutex_);
  return peaks_;
}

std::uint64_t peak_resident_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

std::uint64_t physical_memory_bytes() {
  return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGE_SIZE));
}

}  // namespace glowworm
