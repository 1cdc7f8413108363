// Keeps memory of freed large arrays for reuse.
#pragma once
#include <cstddef>

namespace glowworm {

/// While this object lives, up to `bytes` bytes of freed large arrays (core/large_array.h) are kept for later arrays of
/// similar size, so that the system need not clear new pages. The C library keeps as many bytes of smaller blocks. The
/// limits of several keepers add up. Use it in programs that allocate the same arrays again and again. It keeps nothing
/// on systems that cannot tell the size of a block. return_free_memory() returns what the C library kept.
class FreedMemoryKeeper {
 public:
  explicit FreedMemoryKeeper(std::size_t bytes);
  ~FreedMemoryKeeper();
  FreedMemoryKeeper(const FreedMemoryKeeper&) = delete;
  FreedMemoryKeeper& operator=(const FreedMemoryKeeper&) = delete;

 private:
  std::size_t bytes_;
};

}  // namespace glowworm
