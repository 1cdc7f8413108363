// Reads numbers from the buffers of a glTF file.
#pragma once
#include <cstdint>
#include <vector>

namespace glowworm {

struct GltfDocument;

/// All elements of an accessor as floats, `components` each. Integers are normalised if the accessor says so, and
/// sparse elements are substituted (glTF 2.0, sections 3.6.2 and 3.11). The accessor must have passed
/// check_gltf_json(). Throws Error if its type has fewer components.
std::vector<float> read_floats(const GltfDocument& document, int accessor, int components);

/// All elements of an accessor of unsigned integers. Throws Error if it has another type.
std::vector<std::uint32_t> read_indices(const GltfDocument& document, int accessor);

}  // namespace glowworm
