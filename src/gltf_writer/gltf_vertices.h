// Vertices of a glTF primitive, more than once where charts need it.
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/vec.h"
#include "gltf_writer/glb.h"
#include "import/gltf/accessor.h"
#include "import/gltf/compression.h"
#include "import/gltf/document.h"

namespace glowworm {

/// The vertices of a primitive with their places in atlases. add() numbers entries; arrange() finds their indices in
/// the file.
class LitVertices {
 public:
  struct Entry {
    std::uint32_t vertex = 0;  ///< of the primitive
    std::uint32_t next = 0;    ///< another entry of this vertex; kNone: there is none
    Vec2 uv;                   ///< in its atlas
    int layer = -1;            ///< of light; -1: none
  };

  explicit LitVertices(std::size_t vertices);
  /// The entry of a vertex at a place of a layer of light.
  std::uint32_t add(std::uint32_t vertex, Vec2 uv, int layer);
  /// Any entry of a vertex.
  std::uint32_t add(std::uint32_t vertex);

  /// Gives each entry an index. Vertices keep theirs, and further entries follow, unless most vertices have no entry.
  /// @param anew whether indices may change where each vertex has one entry at most
  void arrange(bool anew);
  /// Whether the vertices are the primitive's own.
  bool unchanged() const { return unchanged_; }
  /// After arrange(): the index of an entry; the entries in this order, where uv and layer are 0 and -1 for vertices
  /// without an entry.
  std::uint32_t index(std::uint32_t entry) const { return index_[entry]; }
  const std::vector<Entry>& arranged() const { return arranged_; }

 private:
  std::vector<std::uint32_t> first_;  ///< entry of each vertex
  std::vector<Entry> entries_, arranged_;
  std::vector<std::uint32_t> index_;
  bool unchanged_ = true;
};

/// Attributes of a primitive and of its morph targets, which no file compresses by Draco, for other vertices.
class AttributeWriter {
 public:
  AttributeWriter(const GltfDocument& document, int mesh, std::size_t primitive, GlbFile& file);

  /// Whether the attributes must be written anew in any case, since the file has them compressed.
  bool is_compressed() const { return draco_.has_value(); }
  /// Adds an accessor with the values of an attribute. @param turned negates them
  int write(const std::string& name, int accessor, const std::vector<LitVertices::Entry>& vertices, bool turned);
  /// The same for an attribute of a morph target.
  int write_target(int accessor, const std::vector<LitVertices::Entry>& vertices, bool turned);
  /// The values of an attribute as floats, `components` each.
  std::vector<float> floats(const std::string& name, int accessor, std::size_t components) const;
  /// Components of an attribute.
  std::size_t components(const std::string& name, int accessor) const;

 private:
  GltfElements elements(const std::string& name, int accessor) const;
  /// @param out accessor to complete
  int write(nlohmann::json out, GltfElements from, const std::vector<LitVertices::Entry>& vertices, bool turned);

  const GltfDocument& document_;
  GlbFile& file_;
  std::optional<DracoPrimitive> draco_;
};

}  // namespace glowworm
