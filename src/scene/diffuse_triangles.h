// The triangle data that rays read most often, in one cache line.
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/large_array.h"
#include "core/rgb.h"
#include "core/vec.h"
#include "scene/geometry.h"
#include "scene/material.h"

namespace glowworm {

/// Triangle data for rays that end on diffuse surfaces. Hits of incoherent rays are scattered over the scene, and the
/// data of a hit would come from nine tables. The position is valid for any material; `kind` says which of the other
/// members are.
struct alignas(64) DiffuseTriangle {
  // Bits of `kind`:
  static constexpr std::uint16_t kDiffuse = 1;   ///< the material only reflects diffusely; otherwise kind is 0
  static constexpr std::uint16_t kTextured = 2;  ///< the reflectance varies: `reflectance` is black
  static constexpr std::uint16_t kMapped = 4;    ///< shading normals are turned by a normal or bump map
  static constexpr std::uint16_t kSmooth = 8;    ///< a vertex has a shading normal
  static constexpr std::uint16_t kEmits = 16;    ///< it has an emission

  Vec3 corner;      ///< first vertex, metres
  Vec3 edge[2];     ///< from there to the second and third vertex
  Vec3 normal;      ///< unit, by the winding; (0,0,1) for a triangle without area
  RGB reflectance;  ///< in [0, 1]
  std::uint16_t kind = 0;
  std::uint16_t offset_bits = 0;  ///< the upper half of offset()

  /// rounding_offset() of core/offset_origin.h, rounded up: the distance at which leaving rays begin, metres.
  float offset() const { return std::bit_cast<float>(static_cast<std::uint32_t>(offset_bits) << 16); }
};
static_assert(sizeof(DiffuseTriangle) == 64);

/// Room for one that is not stored.
struct DiffuseTriangleRoom {
  alignas(DiffuseTriangle) std::byte bytes[sizeof(DiffuseTriangle)];
};

/// The data of one triangle.
DiffuseTriangle make_diffuse_triangle(const Geometry& geometry, const std::vector<Material>& materials,
                                      std::uint32_t triangle);

/// One for each triangle that is not of an instance. Runs on all threads.
LargeVector<DiffuseTriangle> diffuse_triangles(const Geometry& geometry, const std::vector<Material>& materials);

}  // namespace glowworm
