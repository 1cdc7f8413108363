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

namespace {

const PagedSettings& checked(const PagedSettings& settings) {
  if (settings.block_bytes == 0 || settings.cache_blocks == 0)
    throw Error("a paged array needs blocks, and a cache for one block at least");
  return settings;
}

}  // namespace

PagedFile::PagedFile(std::uint64_t bytes, const PagedSettings& settings, std::size_t element_bytes)
    : bytes_(bytes),
      block_bytes_(checked(settings).block_bytes),
      element_bytes_(std::max<std::size_t>(element_bytes, 1)),
      file_(settings.folder),
      cache_(settings.block_bytes, settings.cache_blocks),
      stored_((bytes + block_bytes_ - 1) / block_bytes_) {}

PagedCounts PagedFile::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

std::size_t PagedFile::bytes_of(std::uint64_t block) const {
  return static_cast<std::size_t>(std::min<std::uint64_t>(block_bytes_, bytes_ - block * block_bytes_));
}

template <class Work>
void PagedFile::for_parts(std::uint64_t first, std::size_t count, bool written, Work&& work) {
  const std::lock_guard lock(mutex_);
  if (first > bytes_ || count > bytes_ - first) throw Error("access behind the end of a paged array");
  for (std::size_t done = 0; done < count;) {
    const std::uint64_t block = (first + done) / block_bytes_;
    const auto offset = static_cast<std::size_t>((first + done) % block_bytes_);
    const std::size_t part = std::min(count - done, block_bytes_ - offset);
    std::uint64_t missed = 0;
    const auto load = [&](std::span<std::byte> data) {
      missed = 1;
      ++counts_.misses;
      const std::span<std::byte> used = data.first(bytes_of(block));
      if (written && part == used.size()) return;  // replaced as a whole
      if (!stored_[block]) {
        std::fill(used.begin(), used.end(), std::byte{0});
      } else {
        file_.read(block * block_bytes_, used);
        counts_.bytes_read += used.size();
      }
    };
    const auto store = [&](std::uint64_t old, std::span<const std::byte> data) {
      file_.write(old * block_bytes_, data.first(bytes_of(old)));
      counts_.bytes_written += bytes_of(old);
      stored_[old] = true;
    };
    cache_.access(block, load, store, [&](std::span<std::byte> data, bool& dirty) {
      dirty = dirty || written;
      work(data.subspan(offset, part), done);
    });
    // The first element may miss; the others then hit.
    counts_.hits += std::max<std::uint64_t>(part / element_bytes_, 1) - missed;
    done += part;
  }
}

void PagedFile::read(std::uint64_t first, std::span<std::byte> to) {
  for_parts(first, to.size(), false, [&](std::span<std::byte> part, std::size_t done) {
    std::memcpy(to.data() + done, part.data(), part.size());
  });
}

void PagedFile::write(std::uint64_t first, std::span<const std::byte> from) {
  for_parts(first, from.size(), true, [&](std::span<std::byte> part, std::size_t done) {
    std::memcpy(part.data(), from.data() + done, part.size());
  });
}

}  // namespace glowworm
