// Arrays in memory, or on disk behind a cache, for tasks larger than memory ([HHS05], section 6.5).
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/block_cache.h"
#include "core/large_array.h"
#include "core/unnamed_file.h"

namespace glowworm {

/// Where a paged array keeps its elements.
struct PagedSettings {
  bool on_disk = false;
  std::string folder;  ///< for the file; empty: from the environment (TMPDIR, else /tmp)
  std::size_t block_bytes = std::size_t{1} << 20;
  std::size_t cache_blocks = 64;  ///< blocks held in memory, as BlockCache rounds them
};

/// Statistics of the cache.
struct PagedCounts {
  std::uint64_t hits = 0, misses = 0;  ///< accesses to elements in cached and other blocks
  std::uint64_t bytes_read = 0;        ///< from disk
  std::uint64_t bytes_written = 0;     ///< to disk

  /// Share of accesses that found their block in the cache; 1 if there were no accesses.
  double hit_rate() const;
  PagedCounts& operator+=(const PagedCounts& other);
};

/// Bytes on disk behind a BlockCache. The file never has a name: it vanishes with the process, however that ends.
/// Thread-safe.
class PagedFile {
 public:
  /// @param element_bytes size of one access
  /// Throws Error if no file can be made in the folder, or a size is 0.
  PagedFile(std::uint64_t bytes, const PagedSettings& settings, std::size_t element_bytes = 1);
  PagedFile(const PagedFile&) = delete;
  PagedFile& operator=(const PagedFile&) = delete;

  /// Copies bytes out. Bytes never written are 0. Throws Error if the disk fails.
  void read(std::uint64_t first, std::span<std::byte> to);
  /// Copies bytes in. Throws Error if the disk fails or is full, perhaps at a later call than the one whose bytes do
  /// not fit; the contents are undefined after that.
  void write(std::uint64_t first, std::span<const std::byte> from);

  PagedCounts counts() const;
  /// Size of the cache in bytes.
  std::uint64_t cache_bytes() const { return cache_.bytes(); }

 private:
  /// Calls work(bytes of a block, done) for the parts of blocks that hold `count` bytes from `first` on; `done` counts
  /// the bytes before the part. @param written whether the bytes are replaced
  template <class Work>
  void for_parts(std::uint64_t first, std::size_t count, bool written, Work&& work);
  std::size_t bytes_of(std::uint64_t block) const;

  std::uint64_t bytes_;
  std::size_t block_bytes_, element_bytes_;
  UnnamedFile file_;
  mutable std::mutex mutex_;
  BlockCache cache_;
  std::vector<bool> stored_;  // by block: has it been written to the file
  PagedCounts counts_;
};

/// An array of n elements of a plain type, in memory or on disk. Elements have no value until they are written.
template <typename T>
class PagedArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  PagedArray() = default;
  explicit PagedArray(std::size_t n, const PagedSettings& settings = {}) : size_(n) {
    if (settings.on_disk && n > 0) {
      file_ = std::make_unique<PagedFile>(std::uint64_t{n} * sizeof(T), settings, sizeof(T));
    } else {
      memory_ = LargeArray<T>(n);
    }
  }

  std::size_t size() const { return size_; }
  bool on_disk() const { return file_ != nullptr; }

  /// Reads element i, and replaces it.
  T get(std::size_t i) const {
    T value;
    read(i, std::span<T>(&value, 1));
    return value;
  }
  void set(std::size_t i, const T& value) { write(i, std::span<const T>(&value, 1)); }

  /// Copies elements from `first` on. Threads may read and write different elements at the same time.
  void read(std::size_t first, std::span<T> to) const {
    if (file_) {
      file_->read(std::uint64_t{first} * sizeof(T), std::as_writable_bytes(to));
    } else {
      std::copy_n(memory_.data() + first, to.size(), to.data());
    }
  }
  void write(std::size_t first, std::span<const T> from) {
    if (file_) {
      file_->write(std::uint64_t{first} * sizeof(T), std::as_bytes(from));
    } else {
      std::copy_n(from.data(), from.size(), memory_.data() + first);
    }
  }

  /// Elements from `first` on: in place if the array is in memory, else read into `scratch`.
  std::span<const T> view(std::size_t first, std::size_t count, std::vector<T>& scratch) const {
    if (!file_) return memory_.span().subspan(first, count);
    scratch.resize(count);
    read(first, scratch);
    return scratch;
  }

  /// All zero for an array in memory.
  PagedCounts counts() const { return file_ ? file_->counts() : PagedCounts(); }
  /// Bytes of memory that the array takes.
  std::uint64_t memory_bytes() const { return file_ ? file_->cache_bytes() : std::uint64_t{size_} * sizeof(T); }

 private:
  std::size_t size_ = 0;
  LargeArray<T> memory_;
  std::unique_ptr<PagedFile> file_;
};

}  // namespace glowworm
