#include "core/large_array.h"

#include <cstdlib>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace glowworm {

namespace {
constexpr std::size_t kHugePage = std::size_t{1} << 21;
}

void* allocate_large(std::size_t bytes) {
  const bool huge = bytes >= 2 * kHugePage;
  const std::size_t alignment = huge ? kHugePage : 64;
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  if (rounded < bytes) throw std::bad_alloc();
  void* memory = std::aligned_alloc(alignment, rounded == 0 ? alignment : rounded);
  if (memory == nullptr) throw std::bad_alloc();
#ifdef __linux__
  // A wish; where it is refused pages are small, and nothing else changes.
  if (huge) (void)madvise(memory, rounded, MADV_HUGEPAGE);
#endif
  return memory;
}

void free_large(void* memory) { std::free(memory); }

}  // namespace glowworm
