// Blocks of a file in memory.
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

/// A set-associative write-back cache of numbered blocks whose least recently used blocks make room. It takes its
/// memory at once and never more. Thread-safe: a block belongs to one set, and each set has a lock.
class BlockCache {
 public:
  static constexpr std::size_t kWays = 8;

  /// @param block_bytes, blocks at least 1; above kWays blocks are rounded down to a multiple of it
  BlockCache(std::size_t block_bytes, std::size_t blocks)
      : block_bytes_(block_bytes),
        ways_(std::min(kWays, blocks)),
        sets_(blocks / ways_),
        cache_(sets_.size() * ways_ * block_bytes) {}

  /// Calls use(bytes of the block, bool& whether it differs from the file) with the set locked. A block that is not in
  /// the cache is filled by load(bytes) before; where one that differs from the file must make room for it, by
  /// store(number, bytes) before that. What these throw is passed on; a block whose loading failed is not kept.
  template <class Load, class Store, class Use>
  void access(std::uint64_t block, Load&& load, Store&& store, Use&& use) {
    // Turned by a prime for each round through the sets, so that files of one size do not all meet in the same sets.
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
      if (slot.dirty) store(slot.block, bytes);
      // Nothing may be found under the old number while the new contents are on their way.
      slot = Slot();
      load(bytes);
      slot.block = block;
    }
    slot.last_use = ++set.time;
    use(bytes, slot.dirty);
  }

  /// Bytes of memory that the blocks take.
  std::uint64_t bytes() const { return cache_.size(); }

 private:
  struct Slot {
    std::uint64_t block = ~std::uint64_t{0};  // none
    std::uint64_t last_use = 0;
    bool dirty = false;
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
