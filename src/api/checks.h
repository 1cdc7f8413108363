// Checks of arrays that callers pass.
#pragma once
#include <span>

#include "glowworm/types.h"

namespace glowworm::api {

/// Throws Error if the arrays differ in length. @param what, of "normals", "points"
void check_lengths(std::size_t length, std::size_t wanted, const char* what, const char* of);

/// Throws Error with the index of the first vector that is not finite. @param what "point"
void check_finite(std::span<const Vec3> vectors, const char* what);

/// Throws Error with the index of the first vector whose length is not 1 to a thousandth. @param what "normal"
void check_unit(std::span<const Vec3> vectors, const char* what);

}  // namespace glowworm::api
