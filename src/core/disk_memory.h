// Large arrays in temporary files, for what does not fit into memory.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <thread>

namespace glowworm {

/// Whether arrays of a render may lie in temporary files.
enum class DiskUse : std::uint8_t {
  automatic,  ///< film, image and photons that do not fit into memory; query points if memory holds too few of them for
              ///< the engine to be fast (density/query_store.h)
  never,
  always,
};

/// While this object lives, the pages of arrays on disk leave the process's memory as soon as they fill most of a
/// limit. The system writes them to the disk, and reads them back when they are used. A thread of its own counts them,
/// and so do the loops of core/parallel.h, because that thread may wake up late on a busy machine.
class DiskMemory {
 public:
  /// @param resident_bytes limit of the pages of all arrays on disk that the process holds
  explicit DiskMemory(std::uint64_t resident_bytes);
  ~DiskMemory();
  DiskMemory(const DiskMemory&) = delete;
  DiskMemory& operator=(const DiskMemory&) = delete;

  /// Whether operator new of this program calls allocate_on_disk(). If not, nothing should be placed on disk, because
  /// most arrays would stay in memory.
  static bool is_available();

  /// For arrays of so many bytes in all; null if they fit into `memory` bytes, or if `use` forbids files. Throws Error
  /// if they do not fit on the disk either.
  static std::unique_ptr<DiskMemory> for_arrays(DiskUse use, std::uint64_t bytes, std::uint64_t memory);

  /// Bytes of the smallest array that lies on disk: usually, and for the channels of a picture, which may be many.
  static constexpr std::size_t kLeastBytes = std::size_t{1} << 20, kLeastOfChannels = std::size_t{1} << 15;

  /// While this object lives, arrays of at least so many bytes that its thread allocates lie on disk. They may outlive
  /// the Scope and the DiskMemory.
  class Scope {
   public:
    /// @param memory null: no effect
    explicit Scope(const DiskMemory* memory, std::size_t least = kLeastBytes);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    bool used_;
    std::size_t least_;
  };

 private:
  std::uint64_t most_;  // mapped pages of all files
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

/// For allocators: an array in an unnamed file in TMPDIR, aligned to a page; null outside of a DiskMemory::Scope, or if
/// it is small. Throws Error if the disk has no room.
void* allocate_on_disk(std::size_t bytes);
/// Frees what allocate_on_disk() gave. Returns false if it did not.
bool free_on_disk(void* memory) noexcept;

/// Counts the pages of arrays on disk, and releases them if they fill most of the limit. Does nothing if no DiskMemory
/// lives, or if they were counted a moment ago.
void check_disk_memory();

/// Tells DiskMemory that this program's operator new uses these functions.
void make_disk_memory_available();

}  // namespace glowworm
