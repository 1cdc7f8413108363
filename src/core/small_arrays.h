// Small arrays on disk.
#pragma once
#include <cstddef>

namespace glowworm {

/// While this object lives, a DiskMemory::Scope of its thread takes small arrays, too: the channels of a picture may be
/// many.
class SmallArraysOnDisk {
 public:
  SmallArraysOnDisk();
  ~SmallArraysOnDisk();
  SmallArraysOnDisk(const SmallArraysOnDisk&) = delete;
  SmallArraysOnDisk& operator=(const SmallArraysOnDisk&) = delete;

 private:
  std::size_t before_;
};

}  // namespace glowworm
