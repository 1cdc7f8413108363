// Memory of large arrays that is kept for others.
#pragma once
#include <cstddef>

namespace glowworm {

/// While it lives, up to so many bytes of large arrays (core/large_array.h) that are freed are kept for others of about
/// their size, which then need not be cleared by the system page by page, and up to so many bytes of smaller ones stay
/// with the C library. The bytes of several add up. For programs that make the same arrays over and over. Where the
/// system does not tell how large a block is nothing is kept. return_free_memory() gives back what small arrays left.
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
