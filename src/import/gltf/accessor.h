// Reads numbers from the buffers of a glTF file.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace glowworm {

struct GltfDocument;

/// All elements of an accessor as floats, `components` each. Integers are normalised if the accessor says so, and
/// sparse elements are substituted (glTF 2.0, sections 3.6.2 and 3.11). The accessor must have passed
/// check_gltf_json(). Throws Error if its type has fewer components.
std::vector<float> read_floats(const GltfDocument& document, int accessor, int components);

/// Elements of an accessor, one after another, in the component type of the file.
struct GltfElements {
  std::size_t size = 0, components = 0;  ///< of an element: bytes, numbers
  int component_type = 0;                ///< 5120 to 5126 (glTF 2.0, section 3.6.2.2)
  std::vector<std::uint8_t> bytes;       ///< empty: all are zero
};

/// All elements of an accessor as the file stores them, with sparse elements substituted. Throws Error as
/// read_floats() does.
GltfElements raw_elements(const GltfDocument& document, int accessor);

/// All elements of an accessor of unsigned integers. Throws Error if it has another type.
std::vector<std::uint32_t> read_indices(const GltfDocument& document, int accessor);

}  // namespace glowworm
