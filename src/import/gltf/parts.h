// Which primitives of a glTF file the triangles of a scene come from.
#pragma once
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

namespace glowworm {

/// The triangles that one primitive became at one place: those from first_triangle on, in the order of the file.
struct GltfPart {
  int node = 0;
  int instance = -1;  ///< of EXT_mesh_gpu_instancing; -1: the node has none
  int mesh = 0;
  std::size_t primitive = 0;
  std::uint32_t first_triangle = 0, count = 0;
  bool mirrored = false;               ///< the second and third corner of its triangles are swapped
  std::vector<std::uint32_t> dropped;  ///< triangles of the file that the scene leaves out, in order
};

/// All parts of a scene, in the order of its triangles.
struct GltfParts {
  std::string path;                  ///< of the file; empty: the scene comes from a file of another format
  std::set<std::string> data_files;  ///< names of the file and of its buffers, as they were read
  std::vector<GltfPart> parts;
};

}  // namespace glowworm
