#include "api/checks.h"

#include <cmath>
#include <string>

#include "glowworm/error.h"

namespace glowworm::api {

namespace {
std::string numbered(const char* what, std::size_t i) { return std::string(what) + " " + std::to_string(i); }
}  // namespace

void check_lengths(std::size_t length, std::size_t wanted, const char* what, const char* of) {
  if (length != wanted)
    throw Error("there are " + std::to_string(length) + " " + what + " for " + std::to_string(wanted) + " " + of,
                "Give one for each.");
}

void check_finite(std::span<const Vec3> vectors, const char* what) {
  for (std::size_t i = 0; i < vectors.size(); ++i)
    if (const Vec3& v = vectors[i]; !std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z))
      throw Error(numbered(what, i) + " is not finite");
}

void check_unit(std::span<const Vec3> vectors, const char* what) {
  constexpr double kTolerance = 1e-3;
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    const double x = vectors[i].x, y = vectors[i].y, z = vectors[i].z;
    // NaN fails this test, too.
    if (const double length = std::sqrt(x * x + y * y + z * z); !(std::abs(length - 1) <= kTolerance))
      throw Error(numbered(what, i) + " has length " + std::to_string(length), "Give unit vectors.");
  }
}

}  // namespace glowworm::api
