#include "import/import.h"

namespace glowworm {

std::shared_ptr<MemoryBudget> loading_budget(std::uint64_t bytes) {
  return std::make_shared<MemoryBudget>(bytes > 0 ? bytes : physical_memory_bytes() / 2,
                                        "Give a larger --memory, or use fewer instances, simpler meshes or smaller "
                                        "textures.");
}

}  // namespace glowworm
