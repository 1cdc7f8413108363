#include "core/disk_memory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <mutex>
#include <new>
#include <set>

#include "core/error.h"
#include "core/memory_budget.h"
#include "core/unnamed_file.h"

namespace glowworm {

namespace {

/// Least interval between counts of pages. In this time threads may touch some MB of new pages. A count takes some 5
/// us.
constexpr std::chrono::microseconds kInterval{100};

thread_local bool uses_disk = false;
thread_local std::size_t least_on_disk = DiskMemory::kLeastBytes;
std::atomic<bool> available{false};

/// Numbers of mapped bytes above which pages leave memory, of all that live.
std::mutex limits_mutex;
std::multiset<std::uint64_t> limits;
std::atomic<std::uint64_t> least_limit{0};  // 0: none
std::atomic<std::int64_t> next_count_ns{0};

/// Sizes of the arrays on disk by address.
struct Blocks {
  std::mutex mutex;
  std::map<void*, std::size_t> sizes;
  std::atomic<std::size_t> count{0};
};

/// Never destroyed: destructors of other objects free memory at the end of the program.
Blocks& blocks() {
  alignas(Blocks) static std::byte storage[sizeof(Blocks)];
  static auto* const all = new (storage) Blocks;
  return *all;
}

std::size_t page_size() {
  static const auto size = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  return size;
}

/// Bytes of mapped files in the process's memory; 0 where the system does not tell (proc(5), statm).
std::uint64_t mapped_bytes() {
  std::array<char, 128> text{};
  const int file = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  if (file < 0) return 0;
  const ssize_t got = read(file, text.data(), text.size() - 1);
  close(file);
  if (got <= 0) return 0;
  char* at = text.data();
  std::strtoull(at, &at, 10);
  std::strtoull(at, &at, 10);
  return std::strtoull(at, nullptr, 10) * page_size();
}

/// Takes all pages of the arrays from the process's memory. What was written stays in their files.
void release_pages() {
  Blocks& all = blocks();
  const std::lock_guard lock(all.mutex);
  for (const auto& [memory, size] : all.sizes) madvise(memory, size, MADV_DONTNEED);
}

}  // namespace

void check_disk_memory() {
  const std::uint64_t most = least_limit;
  if (most == 0) return;
  const std::int64_t now = std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
  std::int64_t next = next_count_ns;
  const std::int64_t after = now + std::chrono::nanoseconds(kInterval).count();
  if (now < next || !next_count_ns.compare_exchange_strong(next, after)) return;
  if (mapped_bytes() > most) release_pages();
}

DiskMemory::DiskMemory(std::uint64_t resident_bytes) : most_(mapped_bytes() + resident_bytes / 2) {
  {
    const std::lock_guard lock(limits_mutex);
    limits.insert(most_);
    least_limit = *limits.begin();
  }
  thread_ = std::thread([this] {
    while (!ended_) {
      std::this_thread::sleep_for(kInterval);
      check_disk_memory();
    }
  });
}

DiskMemory::~DiskMemory() {
  ended_ = true;
  thread_.join();
  const std::lock_guard lock(limits_mutex);
  limits.erase(limits.find(most_));
  least_limit = limits.empty() ? 0 : *limits.begin();
}

bool DiskMemory::is_available() { return available; }

std::unique_ptr<DiskMemory> DiskMemory::for_arrays(DiskUse use, std::uint64_t bytes, std::uint64_t memory) {
  const bool fits = bytes <= memory;
  if (use == DiskUse::never || !is_available() || (fits && use == DiskUse::automatic)) return nullptr;
  std::error_code unknown;
  const std::filesystem::space_info room = std::filesystem::space(temporary_folder(), unknown);
  if (!fits && !unknown && room.available < bytes)
    throw MemoryError(
        fmt::format("film, image and photons take up to {:.1f} GB: more than the memory budget of {:.1f} MB, and "
                    "more than the {:.1f} GB that are free in {}",
                    static_cast<double>(bytes) / 1e9, static_cast<double>(memory) / 1e6,
                    static_cast<double>(room.available) / 1e9, temporary_folder().string()),
        "Give a larger --memory, a smaller image or fewer --photons, or set TMPDIR to a folder on a larger disk.");
  return std::make_unique<DiskMemory>(memory / 2);
}

void make_disk_memory_available() { available = true; }

DiskMemory::Scope::Scope(const DiskMemory* memory, std::size_t least) : used_(uses_disk), least_(least_on_disk) {
  uses_disk = uses_disk || memory;
  if (memory) least_on_disk = std::min(least_on_disk, least);
}
DiskMemory::Scope::~Scope() {
  uses_disk = used_;
  least_on_disk = least_;
}

void* allocate_on_disk(std::size_t bytes) {
  if (!uses_disk || bytes < least_on_disk) return nullptr;
  // What makes many arrays, such as the channels of a picture, may run in no loop that looks.
  check_disk_memory();
  const std::size_t size = (bytes + page_size() - 1) / page_size() * page_size();
  if (size < bytes) throw std::bad_alloc();
  void* const memory = map_unnamed_file(size);
  Blocks& all = blocks();
  const std::lock_guard lock(all.mutex);
  all.sizes.emplace(memory, size);
  ++all.count;
  return memory;
}

bool free_on_disk(void* memory) noexcept {
  Blocks& all = blocks();
  if (all.count == 0 || reinterpret_cast<std::uintptr_t>(memory) % page_size() != 0) return false;
  std::map<void*, std::size_t>::node_type taken;  // is freed without the lock, because freeing comes here again
  {
    const std::lock_guard lock(all.mutex);
    taken = all.sizes.extract(memory);
    if (taken.empty()) return false;
    munmap(memory, taken.mapped());
    --all.count;
  }
  return true;
}

}  // namespace glowworm
