// operator new and delete of the programs: large arrays may lie on disk (core/disk_memory.h). Sanitizers have their
// own.
#include <cstddef>
#include <cstdlib>
#include <new>

#include "core/disk_memory.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define GLOWWORM_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define GLOWWORM_SANITIZED
#endif
#endif

#ifndef GLOWWORM_SANITIZED

namespace {

[[maybe_unused]] const bool made_available = (glowworm::make_disk_memory_available(), true);

}  // namespace

// Other forms call these.
void* operator new(std::size_t bytes) {
  if (void* memory = glowworm::allocate_on_disk(bytes)) return memory;
  while (true) {
    if (void* memory = std::malloc(bytes == 0 ? 1 : bytes)) return memory;
    const std::new_handler handler = std::get_new_handler();
    if (!handler) throw std::bad_alloc();
    handler();
  }
}

void operator delete(void* memory) noexcept {
  if (!glowworm::free_on_disk(memory)) std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept { operator delete(memory); }

#endif
