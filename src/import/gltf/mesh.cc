#include "import/gltf/mesh.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "core/error.h"
#include "import/gltf/accessor.h"
#include "import/gltf/check.h"
#include "import/gltf/compression.h"
#include "import/gltf/document.h"
#include "import/mesh_tools.h"

namespace glowworm {

namespace {

/// Reads the attributes of one primitive, compressed or not.
class AttributeReader {
 public:
  AttributeReader(const GltfDocument& document, const tinygltf::Primitive& primitive, const std::string& where)
      : document_(document), primitive_(primitive), where_(where) {
    if (is_draco(primitive)) draco_ = decode_draco(document, primitive, where, held_);
  }

  bool has(const std::string& name) const {
    return (draco_ && draco_->attributes.contains(name)) || primitive_.attributes.contains(name);
  }

  /// The number of components of an attribute.
  int components(const std::string& name) const {
    if (draco_ && draco_->attributes.contains(name)) return draco_->attributes.at(name).components;
    const int accessor = primitive_.attributes.at(name);
    return tinygltf::GetNumComponentsInType(
        static_cast<std::uint32_t>(document_.model->accessors[static_cast<std::size_t>(accessor)].type));
  }

  /// Requires every attribute to have this number of elements from now on.
  void expect(std::size_t vertex_count) { vertex_count_ = vertex_count; }

  /// Reads an attribute, `components` per vertex. Throws Error if its count differs from the number of vertices.
  std::vector<float> read(const std::string& name, std::size_t components) {
    std::vector<float> values;
    if (draco_ && draco_->attributes.contains(name)) {
      const auto& attribute = draco_->attributes.at(name);
      const std::size_t width = static_cast<std::size_t>(attribute.components);
      if (width < components) fail(name, fmt::format("has {} components; expected {}", width, components));
      held_.grow(draco_->vertex_count * components * sizeof(float));
      for (std::size_t i = 0; i < draco_->vertex_count; ++i) {
        for (std::size_t c = 0; c < components; ++c) values.push_back(attribute.values[i * width + c]);
      }
    } else {
      const int accessor = primitive_.attributes.at(name);
      const std::size_t count = document_.model->accessors[static_cast<std::size_t>(accessor)].count;
      // Check before reading, so that a wrong count cannot allocate memory.
      if (vertex_count_ && count != *vertex_count_) {
        fail(name, fmt::format("has {} elements, POSITION has {}", count, *vertex_count_));
      }
      held_.grow(count * components * sizeof(float));
      values = read_floats(document_, accessor, static_cast<int>(components));
    }
    const std::size_t count = values.size() / components;
    if (!vertex_count_) vertex_count_ = count;
    if (count != *vertex_count_) fail(name, fmt::format("has {} elements, POSITION has {}", count, *vertex_count_));
    return values;
  }

  std::vector<std::uint32_t> indices() {
    std::vector<std::uint32_t> out;
    constexpr std::size_t kIndexBytes = sizeof(std::uint32_t) + sizeof(std::array<std::uint32_t, 3>);
    if (draco_) {
      held_.grow(draco_->indices.size() * kIndexBytes);
      out = draco_->indices;
    } else if (primitive_.indices >= 0) {
      held_.grow(document_.model->accessors[static_cast<std::size_t>(primitive_.indices)].count * kIndexBytes);
      out = read_indices(document_, primitive_.indices);
    } else {
      out.resize(vertex_count_.value_or(0));
      std::iota(out.begin(), out.end(), 0u);
    }
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (out[i] >= *vertex_count_) {
        throw Error({document_.path},
                    fmt::format("{}: index {} at place {} is out of range: there are {} vertices", where_, out[i], i,
                                *vertex_count_),
                    kDamagedGltf);
      }
    }
    return out;
  }

  bool compressed() const { return draco_.has_value(); }

 private:
  [[noreturn]] void fail(const std::string& name, const std::string& what) const {
    throw Error({document_.path}, fmt::format("{}: {} {}", where_, name, what), kDamagedGltf);
  }

  const GltfDocument& document_;
  const tinygltf::Primitive& primitive_;
  const std::string& where_;
  Reservation held_{*document_.budget, "meshes", 0};  // memory of everything read
  std::optional<DracoPrimitive> draco_;
  std::optional<std::size_t> vertex_count_;
};

/// Makes triangles according to the mode (glTF 2.0, section 3.7.2.1).
std::vector<std::array<std::uint32_t, 3>> triangles_of(const std::vector<std::uint32_t>& indices, int mode) {
  std::vector<std::array<std::uint32_t, 3>> out;
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    for (std::size_t i = 0; i + 3 <= indices.size(); i += 3)
      out.push_back({indices[i], indices[i + 1], indices[i + 2]});
  } else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    for (std::size_t i = 0; i + 3 <= indices.size(); ++i) {
      out.push_back({indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]});
    }
  } else {
    for (std::size_t i = 1; i + 2 <= indices.size(); ++i) out.push_back({indices[i], indices[i + 1], indices[0]});
  }
  return out;
}

/// Texture coordinates of a set, v upwards; empty if the primitive has none.
std::vector<Vec2> read_uvs(AttributeReader& reader, int set) {
  std::vector<Vec2> out;
  const std::string name = fmt::format("TEXCOORD_{}", set);
  if (set < 0 || !reader.has(name)) return out;
  const std::vector<float> uvs = reader.read(name, 2);
  for (std::size_t i = 0; i < uvs.size(); i += 2) out.push_back({uvs[i], 1 - uvs[i + 1]});
  return out;
}

/// COLOR_0; empty if all vertices are white.
std::vector<VertexColor> read_colors(AttributeReader& reader) {
  std::vector<VertexColor> out;
  if (!reader.has("COLOR_0")) return out;
  const std::size_t width = reader.components("COLOR_0") == 4 ? 4 : 3;
  const std::vector<float> colors = reader.read("COLOR_0", width);
  const auto unit = [](float x) { return x > 0 ? std::min(x, 1.0f) : 0.0f; };  // 0 for NaN
  bool white = true;
  for (std::size_t i = 0; i < colors.size(); i += width) {
    const VertexColor& color = out.emplace_back(
        VertexColor{{unit(colors[i]), unit(colors[i + 1]), unit(colors[i + 2])}, width == 4 ? unit(colors[i + 3]) : 1});
    white = white && color.color == RGB(1.0f) && color.alpha == 1;
  }
  if (white) out.clear();
  return out;
}

Vec3 unit_or_zero(Vec3 n) {
  const float l = length(n);
  return l > 0 && std::isfinite(l) ? n / l : Vec3{0, 0, 0};
}

void morph(const GltfDocument& document, const tinygltf::Primitive& primitive, const std::vector<float>& weights,
           const std::string& where, Geometry& mesh) {
  const auto add = [&](const std::map<std::string, int>& target, const char* name, float weight,
                       std::vector<Vec3>& values) {
    const auto found = target.find(name);
    if (found == target.end()) return;
    const tinygltf::Accessor& accessor = document.model->accessors[static_cast<std::size_t>(found->second)];
    if (accessor.count != values.size()) {
      throw Error(
          {document.path},
          fmt::format("{}: a morph target has {} elements, POSITION has {}", where, accessor.count, values.size()),
          kDamagedGltf);
    }
    if (accessor.bufferView < 0 && !accessor.sparse.isSparse) return;  // all zero
    const std::vector<float> by = read_floats(document, found->second, 3);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = values[i] + Vec3{by[3 * i], by[3 * i + 1], by[3 * i + 2]} * weight;
  };
  for (std::size_t i = 0; i < std::min(weights.size(), primitive.targets.size()); ++i) {
    if (weights[i] == 0) continue;
    add(primitive.targets[i], "POSITION", weights[i], mesh.positions);
    if (primitive.attributes.contains("NORMAL")) add(primitive.targets[i], "NORMAL", weights[i], mesh.normals);
  }
  for (Vec3& n : mesh.normals) n = unit_or_zero(n);
}

void add_scaled(Transform& sum, const Transform& t, float weight) {
  sum.x = sum.x + t.x * weight;
  sum.y = sum.y + t.y * weight;
  sum.z = sum.z + t.z * weight;
  sum.translation = sum.translation + t.translation * weight;
}

void skin(AttributeReader& reader, const std::vector<Transform>& joints, const std::string& file,
          const std::string& where, Geometry& mesh) {
  const std::size_t count = mesh.positions.size();
  std::vector<Transform> blended(count, Transform{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}});
  std::vector<float> total(count, 0);
  for (int set = 0; reader.has(fmt::format("JOINTS_{}", set)) && reader.has(fmt::format("WEIGHTS_{}", set)); ++set) {
    const std::vector<float> indices = reader.read(fmt::format("JOINTS_{}", set), 4);
    const std::vector<float> weights = reader.read(fmt::format("WEIGHTS_{}", set), 4);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      if (!(weights[i] > 0)) continue;
      if (!(indices[i] >= 0 && indices[i] < static_cast<float>(joints.size()))) {
        throw Error(
            {file},
            fmt::format("{}: vertex {} names joint {}, but the skin has {}", where, i / 4, indices[i], joints.size()),
            kDamagedGltf);
      }
      add_scaled(blended[i / 4], joints[static_cast<std::size_t>(indices[i])], weights[i]);
      total[i / 4] += weights[i];
    }
  }
  bool mirrors = count > 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!(total[i] > 0)) blended[i] = joints[0];
    Transform to_world{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    add_scaled(to_world, blended[i], total[i] > 0 ? 1 / total[i] : 1);
    mesh.positions[i] = to_world.point(mesh.positions[i]);
    mesh.normals[i] = unit_or_zero(to_world.normal(mesh.normals[i]));
    mirrors = mirrors && to_world.determinant() < 0;
  }
  if (!mirrors) return;
  reverse_winding(mesh);
}

}  // namespace

Geometry read_gltf_primitive(const GltfDocument& document, const tinygltf::Primitive& primitive, GltfUvSets uv_sets,
                             const std::string& where, NoteCounter& notes) {
  Geometry mesh;
  const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
  if (mode < TINYGLTF_MODE_TRIANGLES || mode > TINYGLTF_MODE_TRIANGLE_FAN) {
    notes.add("primitive of points or lines, left out");
    return mesh;
  }
  AttributeReader reader(document, primitive, where);
  if (!reader.has("POSITION")) {
    notes.add("primitive without positions, left out");
    return mesh;
  }
  const std::vector<float> positions = reader.read("POSITION", 3);
  const std::size_t count = positions.size() / 3;
  for (std::size_t i = 0; i < count; ++i) {
    mesh.positions.push_back({positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]});
  }
  mesh.normals.resize(count);
  if (reader.has("NORMAL")) {
    const std::vector<float> normals = reader.read("NORMAL", 3);
    for (std::size_t i = 0; i < count; ++i)
      mesh.normals[i] = unit_or_zero({normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]});
  }
  mesh.uvs = read_uvs(reader, uv_sets.first);
  mesh.uvs.resize(count);
  mesh.second_uvs = read_uvs(reader, uv_sets.second);
  mesh.colors = read_colors(reader);
  mesh.triangles = triangles_of(reader.indices(), reader.compressed() ? TINYGLTF_MODE_TRIANGLES : mode);
  return mesh;
}

Geometry read_gltf_primitive(const GltfDocument& document, int mesh, std::size_t primitive) {
  NoteCounter notes;
  return read_gltf_primitive(document,
                             document.model->meshes.at(static_cast<std::size_t>(mesh)).primitives.at(primitive),
                             {-1, -1}, fmt::format("meshes[{}].primitives[{}]", mesh, primitive), notes);
}

void deform_gltf_primitive(const GltfDocument& document, const tinygltf::Primitive& primitive,
                           const GltfDeformation& deformation, const std::string& where, Geometry& mesh) {
  if (!deformation.weights.empty() && !primitive.targets.empty())
    morph(document, primitive, deformation.weights, where, mesh);
  if (deformation.joints.empty()) return;
  AttributeReader reader(document, primitive, where);
  reader.expect(mesh.positions.size());
  skin(reader, deformation.joints, document.path, where, mesh);
}

}  // namespace glowworm
