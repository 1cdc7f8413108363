// Glare of the lamps of a scene at an eye, by their shapes and luminances.
#pragma once
#include <vector>

#include "measure/glare.h"
#include "trace/tracer.h"

namespace glowworm {

/// The emitting surfaces in front of an eye, in pieces whose sides are short beside their distance, as sources for
/// unified_glare_rating(). What hides a piece's middle hides the piece. Lights without extent are left out.
/// @param view unit and level
std::vector<GlareSource> lamps_in_view(const Tracer& tracer, Vec3 eye, Vec3 view);

}  // namespace glowworm
