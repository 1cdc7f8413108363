// The baked surfaces of a scene, and the positions of their texels.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bake/texels.h"
#include "gather/point_pass.h"
#include "trace/tracer.h"

namespace glowworm {

/// The surfaces of a scene that get texels.
struct BakeLayout {
  std::vector<BakeFace> faces;
  std::vector<Chart> charts;
  Atlas atlas;
  TexelMap texels;
  std::vector<std::uint8_t> roofs;  ///< for each triangle, whether its back is lit and faces other surfaces
  std::vector<std::string> notes;   ///< surfaces that are not baked or have new charts, with reasons; one line each
};

/// Bytes that a bake holds for each texel beside its Job: place, point with its share from behind, and light with a
/// copy for a checkpoint.
inline constexpr std::uint64_t kTexelTableBytes = 57 + 2 * sizeof(RGB);

/// What to do if memory is too small for a bake. @param of_probes of probes instead of texels
std::string memory_remedy(bool of_probes);

/// The bytes of the tables of so many texels, or points of probes. Throws Error where memory is too small for them.
std::uint64_t texel_table_bytes(std::uint64_t points, std::uint64_t memory_bytes, bool of_probes = false);

/// Whether light on a material looks the same from everywhere, so that a texture can show it: no glass, no mirror.
bool is_bakeable(const Scene& scene, std::uint32_t material);

/// Whether nearly all rays from a place meet the backs of surfaces.
bool is_inside_solid(const Scene& scene, const Tracer& tracer, Vec3 position);

/// The scene with a copy of the mesh for each instance, because each needs texels of its own. Triangles keep their
/// numbers.
std::shared_ptr<const Scene> without_instances(const std::shared_ptr<const Scene>& scene);

/// Chooses the faces to bake and lays them out: all but glass, mirrors, and lamps whose own light is all that shows.
/// Where light arrives on the backs of a surface that is seen from both sides, its backs are baked, too. Throws Error
/// if the scene has instances, if nothing is left, if an atlas is too small, or if the tables of all texels exceed the
/// memory.
BakeLayout lay_out(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Tracer>& tracer,
                   const AtlasRequest& request);

/// The points of all texels for a Job. Texels inside of solid objects have none: fill_gaps() gives them the light of
/// their neighbours.
PointGrid texel_points(const Scene& scene, const Tracer& tracer, const BakeLayout& layout);

}  // namespace glowworm
