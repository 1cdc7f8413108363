#include "density/paged_array.h"

#include <algorithm>
#include <cstring>

#include "core/error.h"

namespace glowworm {

double PagedCounts::hit_rate() const {
  const std::uint64_t all = hits + misses;
  return all == 0 ? 1 : static_cast<double>(hits) / static_cast<double>(all);
}

PagedCounts& PagedCounts::operator+=(const PagedCounts& other) {
  hits += other.hits;
  misses += other.misses;
  bytes_read += other.bytes_read;
  bytes_written += other.bytes_written;
  return *this;
}

PagedFile::PagedFile(std::uint64_t bytes, const PagedSettings& settings, std::size_t element_bytes)
    : bytes_(bytes),
      block_bytes_(settings.block_bytes),
      element_bytes_(std::max<std::size_t>(element_bytes, 1)),
      file_(settings.folder) {
  if (settings.block_bytes == 0 || settings.cache_blocks == 0)
    throw Error("a paged array needs blocks, and a cache for one block at least");
  ways_ = std::min(kWays, settings.cache_blocks);
  sets_ = settings.cache_blocks / ways_;
  slots_.resize(sets_ * ways_);
  cache_ = LargeArray<std::byte>(slots_.size() * block_bytes_);
  stored_.resize((bytes + block_bytes_ - 1) / block_bytes_);
}

PagedCounts PagedFile::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void PagedFile::check(std::uint64_t first, std::size_t bytes) const {
  if (first > bytes_ || bytes > bytes_ - first) throw Error("access behind the end of a paged array");
}

std::size_t PagedFile::bytes_of(std::uint64_t block) const {
  return static_cast<std::size_t>(std::min<std::uint64_t>(block_bytes_, bytes_ - block * block_bytes_));
}

void PagedFile::read(std::uint64_t first, std::span<std::byte> to) {
  const std::lock_guard lock(mutex_);
  check(first, to.size());
  while (!to.empty()) {
    const std::uint64_t block = first / block_bytes_;
    const auto offset = static_cast<std::size_t>(first % block_bytes_);
    const std::size_t count = std::min(to.size(), block_bytes_ - offset);
    std::memcpy(to.data(), slot_data(fetch(block, false, count)) + offset, count);
    to = to.subspan(count);
    first += count;
  }
}

void PagedFile::write(std::uint64_t first, std::span<const std::byte> from) {
  const std::lock_guard lock(mutex_);
  check(first, from.size());
  while (!from.empty()) {
    const std::uint64_t block = first / block_bytes_;
    const auto offset = static_cast<std::size_t>(first % block_bytes_);
    const std::size_t count = std::min(from.size(), block_bytes_ - offset);
    const std::size_t slot = fetch(block, count == bytes_of(block), count);
    std::memcpy(slot_data(slot) + offset, from.data(), count);
    slots_[slot].dirty = true;
    from = from.subspan(count);
    first += count;
  }
}

std::size_t PagedFile::fetch(std::uint64_t block, bool whole, std::size_t wanted) {
  const std::uint64_t accesses = std::max<std::uint64_t>(wanted / element_bytes_, 1);
  const std::size_t set = static_cast<std::size_t>(block % sets_) * ways_;
  std::size_t victim = set;
  for (std::size_t slot = set; slot < set + ways_; ++slot) {
    if (slots_[slot].block == block) {
      counts_.hits += accesses;
      slots_[slot].last_use = ++time_;
      return slot;
    }
    if (slots_[slot].last_use < slots_[victim].last_use) victim = slot;
  }
  ++counts_.misses;
  counts_.hits += accesses - 1;
  std::byte* data = slot_data(victim);
  evict(slots_[victim], data);
  // Nothing may be found under the old name while the new contents are on their way.
  slots_[victim] = Slot();
  const std::size_t bytes = bytes_of(block);
  if (!stored_[block]) {
    if (!whole) std::memset(data, 0, bytes);
  } else if (!whole) {
    file_.read(block * block_bytes_, std::span(data, bytes));
    counts_.bytes_read += bytes;
  }
  slots_[victim].block = block;
  slots_[victim].last_use = ++time_;
  return victim;
}

void PagedFile::evict(Slot& slot, const std::byte* data) {
  if (!slot.dirty) return;
  const std::size_t bytes = bytes_of(slot.block);
  file_.write(slot.block * block_bytes_, std::span(data, bytes));
  counts_.bytes_written += bytes;
  stored_[slot.block] = true;
  slot.dirty = false;
}

}  // namespace glowworm
