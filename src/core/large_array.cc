#include "core/large_array.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <mutex>

#include "core/disk_memory.h"
#include "core/spare_memory.h"

#ifdef __linux__
#include <malloc.h>
#include <sys/mman.h>
#endif

namespace glowworm {

namespace {

constexpr std::size_t kHugePage = std::size_t{1} << 21;
/// Freed blocks of at least this size are kept for reuse; smaller ones stay with the C library.
constexpr std::size_t kMinKeptBytes = std::size_t{1} << 20;

constexpr std::size_t kMaxKeptBlocks = 256;

#ifdef __GLIBC__
/// The defaults and the maximum of glibc (mallopt(3)), in bytes.
constexpr std::size_t kDefaultTrimThreshold = std::size_t{128} << 10, kDefaultMapThreshold = std::size_t{128} << 10,
                      kMaxMapThreshold = std::size_t{32} << 20;
#endif

/// Lets the C library keep up to `bytes` free bytes at the end of each heap. Blocks then come from heaps, instead of
/// being mapped one by one and returned at once. 0 restores glibc's defaults, but not its automatic adjustment of them,
/// which any mallopt() call ends.
void keep_free_heap([[maybe_unused]] std::size_t bytes) {
#ifdef __GLIBC__
  mallopt(M_TRIM_THRESHOLD, static_cast<int>(std::min<std::size_t>(std::max(bytes, kDefaultTrimThreshold), 1 << 30)));
  mallopt(M_MMAP_THRESHOLD, static_cast<int>(bytes > 0 ? kMaxMapThreshold : kDefaultMapThreshold));
#endif
}

/// Freed blocks, kept for reuse.
class SpareMemory {
 public:
  void raise_limit(std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    blocks_.reserve(kMaxKeptBlocks);
    limit_ += bytes;
    keep_free_heap(limit_);
  }
  void lower_limit(std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    limit_ -= bytes;
    keep_free_heap(limit_);
    shrink();
  }
  bool keeps() const { return limit_.load(std::memory_order_relaxed) > 0; }

  /// The smallest block of at least `bytes` that is not much larger; null if there is none.
  void* take(std::size_t bytes, std::size_t alignment) {
    const std::scoped_lock lock(mutex_);
    auto best = blocks_.end();
    for (auto i = blocks_.begin(); i != blocks_.end(); ++i) {
      const bool fits = i->bytes >= bytes && i->bytes <= bytes + bytes / 4 + kMinKeptBytes &&
                        reinterpret_cast<std::uintptr_t>(i->memory) % alignment == 0;
      if (fits && (best == blocks_.end() || i->bytes < best->bytes)) best = i;
    }
    if (best == blocks_.end()) return nullptr;
    void* memory = best->memory;
    held_ -= best->bytes;
    blocks_.erase(best);
    return memory;
  }

  void give(void* memory, std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    // Freeing must not fail, so the list does not grow.
    if (blocks_.size() == blocks_.capacity()) return std::free(memory);
    blocks_.push_back({memory, bytes});
    held_ += bytes;
    shrink();
  }

 private:
  struct Block {
    void* memory;
    std::size_t bytes;
  };

  /// Frees the oldest blocks until the limit is met.
  void shrink() {
    auto kept = blocks_.begin();
    for (; held_ > limit_ && kept != blocks_.end(); ++kept) {
      std::free(kept->memory);
      held_ -= kept->bytes;
    }
    blocks_.erase(blocks_.begin(), kept);
  }

  std::mutex mutex_;
  std::atomic<std::size_t> limit_{0};
  std::size_t held_ = 0;
  std::vector<Block> blocks_;  // oldest first
};

/// Never destroyed: destructors of other objects free memory at the end of the program. Constructed without an
/// allocation, because freeing must not fail.
SpareMemory& spare_memory() {
  alignas(SpareMemory) static std::byte storage[sizeof(SpareMemory)];
  static auto* const memory = new (storage) SpareMemory;
  return *memory;
}

std::size_t size_of([[maybe_unused]] void* memory) {
#ifdef __linux__
  return memory ? malloc_usable_size(memory) : 0;
#else
  return 0;  // unknown: nothing is kept
#endif
}

}  // namespace

FreedMemoryKeeper::FreedMemoryKeeper(std::size_t bytes) : bytes_(bytes) { spare_memory().raise_limit(bytes); }
FreedMemoryKeeper::~FreedMemoryKeeper() { spare_memory().lower_limit(bytes_); }

void* allocate_large(std::size_t bytes) {
  if (void* memory = allocate_on_disk(bytes)) return memory;
  const bool huge = bytes >= 2 * kHugePage;
  const std::size_t alignment = huge ? kHugePage : 64;
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  if (rounded < bytes) throw std::bad_alloc();
  if (rounded >= kMinKeptBytes && spare_memory().keeps())
    if (void* memory = spare_memory().take(rounded, alignment)) return memory;
  void* memory = std::aligned_alloc(alignment, rounded == 0 ? alignment : rounded);
  if (memory == nullptr) throw std::bad_alloc();
#ifdef __linux__
  // Only a hint: if the system refuses it, pages are small.
  if (huge) (void)madvise(memory, rounded, MADV_HUGEPAGE);
#endif
  return memory;
}

void free_large(void* memory) {
  if (free_on_disk(memory)) return;
  if (spare_memory().keeps())
    if (const std::size_t bytes = size_of(memory); bytes >= kMinKeptBytes) return spare_memory().give(memory, bytes);
  std::free(memory);
}

}  // namespace glowworm
