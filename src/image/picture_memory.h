// Pictures within a memory budget.
#pragma once
#include <string>

#include "core/memory_budget.h"
#include "image/image.h"

namespace glowworm {

/// The same as read_image(). Throws MemoryError, before anything is decoded, if the budget has no room.
/// @param held grows by the picture's bytes
Image read_image(const std::string& path, Reservation& held);

}  // namespace glowworm
