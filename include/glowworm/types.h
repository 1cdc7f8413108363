// Points, colours and triangles of the public interface: plain numbers without padding.
#pragma once
#include <array>
#include <cstdint>

namespace glowworm::api {

/// A point of a picture or a texture.
struct Vec2 {
  float x = 0, y = 0;
};

/// A point (metres), a direction or a normal.
struct Vec3 {
  float x = 0, y = 0, z = 0;
};

/// Linear RGB with Rec. 709 primaries: radiance, irradiance, flux or reflectance, depending on the name.
struct Rgb {
  float r = 0, g = 0, b = 0;
};

/// Indices of three vertices, counter-clockwise seen from outside.
using Triangle = std::array<std::uint32_t, 3>;

}  // namespace glowworm::api
