#include "density/paged_array.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "core/error.h"
#include "core/temporary_files.h"

namespace glowworm {

namespace {

constexpr const char* kRemedy =
    "Make room there, name a folder on another disk by TMPDIR, or give the render more memory so that it needs none.";

[[noreturn]] void fail(const std::string& folder, const std::string& what, int error) {
  throw Error(FilePlace{folder}, fmt::format("{}: {}", what, std::strerror(error)), kRemedy);
}

std::string default_folder() {
  const char* folder = std::getenv("TMPDIR");
  return folder && *folder ? folder : "/tmp";
}

/// A file that has no name, in a folder.
int open_unnamed(const std::string& folder) {
#ifdef O_TMPFILE
  const int unnamed = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (unnamed >= 0) return unnamed;
  // These say that the file system or the kernel has no such files.
  if (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL) fail(folder, "no temporary file can be made", errno);
#endif
  static std::atomic<unsigned> counter{0};
  for (int attempt = 0;; ++attempt) {
    const std::string path = fmt::format("{}/glowworm-{}-{}.tmp", folder, getpid(), counter++);
    const TemporaryName name(path);
    const int file = open(path.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, S_IRUSR | S_IWUSR);
    if (file < 0) {
      if (errno == EEXIST && attempt < 1000) continue;
      fail(folder, "no temporary file can be made", errno);
    }
    unlink(path.c_str());
    return file;
  }
}

}  // namespace

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
      folder_(settings.folder.empty() ? default_folder() : settings.folder) {
  if (settings.block_bytes == 0 || settings.cache_blocks == 0)
    throw Error("a paged array needs blocks, and a cache for one block at least");
  ways_ = std::min(kWays, settings.cache_blocks);
  sets_ = settings.cache_blocks / ways_;
  slots_.resize(sets_ * ways_);
  cache_ = LargeArray<std::byte>(slots_.size() * block_bytes_);
  stored_.resize((bytes + block_bytes_ - 1) / block_bytes_);
  file_ = open_unnamed(folder_);
}

PagedFile::~PagedFile() { close(file_); }

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
    for (std::size_t done = 0; done < bytes;) {
      const ssize_t got = pread(file_, data + done, bytes - done, static_cast<off_t>(block * block_bytes_ + done));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) fail(folder_, "a temporary file cannot be read back", got < 0 ? errno : EIO);
      done += static_cast<std::size_t>(got);
    }
    counts_.bytes_read += bytes;
  }
  slots_[victim].block = block;
  slots_[victim].last_use = ++time_;
  return victim;
}

void PagedFile::evict(Slot& slot, const std::byte* data) {
  if (!slot.dirty) return;
  const std::size_t bytes = bytes_of(slot.block);
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t put = pwrite(file_, data + done, bytes - done, static_cast<off_t>(slot.block * block_bytes_ + done));
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) fail(folder_, "a temporary file cannot be written", put < 0 ? errno : ENOSPC);
    done += static_cast<std::size_t>(put);
  }
  counts_.bytes_written += bytes;
  stored_[slot.block] = true;
  slot.dirty = false;
}

}  // namespace glowworm
