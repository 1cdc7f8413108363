// Processes one input as the fuzz targets do; the tests run the seeds through it, too.
#pragma once
#include <cstdint>
#include <string_view>

#include "scene/scene.h"

namespace glowworm::fuzz {

/// Bytes that loading may hold, so that no input takes long.
inline constexpr std::uint64_t kBudget = std::uint64_t{32} << 20;

/// Builds a scene from `text` as the importer does, but opens no images. Mistakes in the text are expected and not
/// told; a scene that contradicts itself aborts.
void parse_scene(std::string_view text);

/// Reads `bytes` as a PLY file; a mesh that contradicts itself aborts.
void parse_mesh(std::string_view bytes);

/// Builds a scene from `bytes` as the importer of glTF does, .gltf or .glb. Mistakes are expected; a scene that
/// contradicts itself aborts.
void parse_gltf(std::string_view bytes);

/// Reads `text` as an OBJ file, and as each material library that it names. Mistakes are expected; a scene that
/// contradicts itself aborts.
void parse_obj_and_mtl(std::string_view text);

/// Reads `bytes` as an STL file; a mesh that contradicts itself aborts.
void parse_stl_mesh(std::string_view bytes);

/// Reads `text` as a scene of Radiance that includes no file. Mistakes are expected; a scene that contradicts itself
/// aborts.
void parse_rad_scene(std::string_view text);

/// Reads `text` as a file of BSDF data; values that are not finite abort.
void parse_window(std::string_view text);

/// Builds a scene from `bytes` as if glowworm-assimp had handed them over; one that contradicts itself aborts.
void parse_hand_over(std::string_view bytes);

/// Reads `bytes` as an image file, held in memory and by way of a temporary file; aborts where the two disagree or a
/// look-up is not finite. The format is told by the content, and is TGA where there is no other.
void parse_texture(std::string_view bytes);

/// Aborts where a description contradicts itself.
void expect_consistent(const SceneDescription& scene);

/// Reads `text` as the samples of a spectrum and converts them to colours.
void parse_spectrum(std::string_view text);

}  // namespace glowworm::fuzz
