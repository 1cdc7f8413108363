#include "core/memory_budget.h"

#include <fmt/format.h>
#include <unistd.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <fstream>
#include <limits>

namespace glowworm {

void MemoryBudget::reserve(const std::string& name, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  if (limit_ != 0 && (bytes > limit_ || used_ > limit_ - bytes)) {
    std::string holders;
    for (const auto& [holder, held] : held_)
      if (held > 0) holders += fmt::format("{}{} {:.1f} MB", holders.empty() ? "" : ", ", holder, held / 1e6);
    throw MemoryError(fmt::format("the memory budget of {:.1f} MB has no room for {:.1f} MB of {} (held: {})",
                                  limit_ / 1e6, bytes / 1e6, name, holders.empty() ? "nothing" : holders),
                      remedy_);
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

std::uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void restart_peak_resident() {
  // proc(5), clear_refs: 5 resets the peak to the present resident memory.
  std::ofstream("/proc/self/clear_refs") << "5";
}

void keep_heap_small(std::uint64_t budget) {
#ifdef __GLIBC__
  constexpr std::uint64_t kAmple = std::uint64_t{3} << 30;
  if (budget >= kAmple) return;
  // Setting either threshold stops glibc from raising both when large blocks are freed.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  mallopt(M_TRIM_THRESHOLD, 1 << 20);
#endif
}

void return_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

std::uint64_t peak_resident_bytes() {
  // getrusage() would also count what the program that started this one held.
  std::ifstream file("/proc/self/status");
  for (std::string key; file >> key; file.ignore(std::numeric_limits<std::streamsize>::max(), '\n'))
    if (std::uint64_t kilobytes = 0; key == "VmHWM:" && file >> kilobytes) return kilobytes * 1024;
  return 0;
}

std::uint64_t physical_memory_bytes() {
  return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGE_SIZE));
}

}  // namespace glowworm
