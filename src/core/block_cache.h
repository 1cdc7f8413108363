// A cache of file blocks in memory.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include "core/large_array.h"

namespace glowworm {

/// A set-associative cache of numbered blocks with least-recently-used replacement. It allocates all its
/// memory at construction. Thread-safe: each set has its own lock.
class BlockCache {
 public:
  static constexpr std::size_t kWays = 8;

  /// @param block_bytes, blocks at least 1; above kWays, the number of blocks is rounded down to a multiple of kWays
  BlockCache(std::size_t block_bytes, std::size_t blocks)
      : block_bytes_(block_bytes),
        ways_(std::min(kWays, blocks)),
        sets_(blocks / ways_),
        cache_(sets_.size() * ways_ * block_bytes) {}

  /// Calls use(bytes of the block) with the set locked. If the block is not cached, load(bytes) fills it first.
  /// Exceptions of these functions pass through; a block that failed to load is not kept.
  template <class Load, class Use>
  void access(std::uint64_t block, Load&& load, Use&& use) {
    // Each round through the sets is rotated by a prime, so that files of equal size do not compete for the same sets.
    const auto index = static_cast<std::size_t>((block + block / sets_.size() * 7919) % sets_.size());
    Set& set = sets_[index];
    const std::lock_guard lock(set.mutex);
    std::size_t way = 0;
    for (std::size_t i = 0; i < ways_; ++i) {
      if (set.slots[i].block == block) {
        way = i;
        break;
      }
      if (set.slots[i].last_use < set.slots[way].last_use) way = i;
    }
    Slot& slot = set.slots[way];
    const std::span<std::byte> bytes = cache_.span().subspan((index * ways_ + way) * block_bytes_, block_bytes_);
    if (slot.block != block) {
      // The old number must not match while the new contents are loading.
      slot = Slot();
      load(bytes);
      slot.block = block;
    }
    slot.last_use = ++set.time;
    use(bytes);
  }

  /// Memory held by the blocks, in bytes.
  std::uint64_t bytes() const { return cache_.size(); }

 private:
  struct Slot {
    std::uint64_t block = ~std::uint64_t{0};  // none
    std::uint64_t last_use = 0;
  };
  struct Set {
    std::mutex mutex;
    std::uint64_t time = 0;
    std::array<Slot, kWays> slots;
  };

  std::size_t block_bytes_, ways_;
  std::vector<Set> sets_;
  LargeArray<std::byte> cache_;
};

}  // namespace glowworm
