// What is read of a glTF file, which several moments of its animation share.
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "import/gltf/document.h"
#include "import/mesh_tools.h"
#include "scene/geometry.h"

namespace glowworm {

/// Primitives of the meshes of a file, each read on first use.
class GltfMeshes {
 public:
  explicit GltfMeshes(std::shared_ptr<MemoryBudget> budget)
      : budget_(std::move(budget)), held_(*budget_, "meshes", 0) {}

  /// A primitive by the numbers of its mesh and in it. @param read read() returns it if it was not read before
  template <typename Read>
  const Geometry& primitive(int mesh, std::size_t index, const Read& read) {
    const auto key = std::pair(mesh, index);
    if (const auto found = read_.find(key); found != read_.end()) return found->second;
    Geometry fresh = read();
    held_.grow(mesh_bytes(fresh));
    return read_.emplace(key, std::move(fresh)).first->second;
  }

 private:
  std::shared_ptr<MemoryBudget> budget_;
  Reservation held_;
  std::map<std::pair<int, std::size_t>, Geometry> read_;
};

/// The document of a file with its meshes. Where the animation moves more than nodes, weights and lenses, each moment
/// has a document of its own.
class GltfReader {
 public:
  /// The document at options.moment. Throws Error as read_gltf_document() does.
  const GltfDocument& document(const std::string& path, const ImportOptions& options);
  /// The meshes of that document.
  GltfMeshes& meshes() { return *meshes_; }

 private:
  std::optional<GltfDocument> document_;
  std::string animation_;  // of document_
  bool is_of_one_moment_ = false;
  std::optional<GltfMeshes> meshes_;
};

}  // namespace glowworm
