#include "import/gltf/mesh.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "core/error.h"
#include "import/gltf/accessor.h"
#include "import/gltf/compression.h"
#include "import/gltf/document.h"

namespace glowworm {

namespace {

constexpr const char* kRemedy = "The file is damaged or was written wrongly: export it anew.";

/// Gives the attributes of one primitive, compressed or not.
class AttributeReader {
 public:
  AttributeReader(const GltfDocument& document, const tinygltf::Primitive& primitive, const std::string& where)
      : document_(document), primitive_(primitive), where_(where) {
    if (is_draco(primitive)) draco_ = decode_draco(document, primitive, where);
  }

  bool has(const std::string& name) const {
    return (draco_ && draco_->attributes.contains(name)) || primitive_.attributes.contains(name);
  }

  /// Numbers of an attribute, `components` a vertex; throws Error where there are not as many as vertices.
  std::vector<float> read(const std::string& name, std::size_t components) {
    std::vector<float> values;
    if (draco_ && draco_->attributes.contains(name)) {
      const auto& attribute = draco_->attributes.at(name);
      const std::size_t width = static_cast<std::size_t>(attribute.components);
      if (width < components) fail(name, fmt::format("has {} components; expected {}", width, components));
      for (std::size_t i = 0; i < draco_->vertex_count; ++i) {
        for (std::size_t c = 0; c < components; ++c) values.push_back(attribute.values[i * width + c]);
      }
    } else {
      const int accessor = primitive_.attributes.at(name);
      const std::size_t count = document_.model->accessors[static_cast<std::size_t>(accessor)].count;
      // Told before the numbers are read, so that a wrong count cannot make us allocate.
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
    if (draco_) {
      out = draco_->indices;
    } else if (primitive_.indices >= 0) {
      held_.grow(document_.model->accessors[static_cast<std::size_t>(primitive_.indices)].count *
                 (sizeof(std::uint32_t) + sizeof(std::array<std::uint32_t, 3>)));
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
                    kRemedy);
      }
    }
    return out;
  }

  bool compressed() const { return draco_.has_value(); }

 private:
  [[noreturn]] void fail(const std::string& name, const std::string& what) const {
    throw Error({document_.path}, fmt::format("{}: {} {}", where_, name, what), kRemedy);
  }

  const GltfDocument& document_;
  const tinygltf::Primitive& primitive_;
  const std::string& where_;
  Reservation held_{*document_.budget, "meshes", 0};  // of what is read
  std::optional<DracoPrimitive> draco_;
  std::optional<std::size_t> vertex_count_;
};

/// Triangles of a mode (glTF 2.0, section 3.7.2.1).
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

std::optional<RGB> uniform_color(AttributeReader& reader, NoteCounter& notes) {
  if (!reader.has("COLOR_0")) return std::nullopt;
  const std::vector<float> colors = reader.read("COLOR_0", 3);
  for (std::size_t i = 3; i < colors.size(); ++i) {
    if (colors[i] != colors[i - 3]) {
      notes.add("primitive with colours that differ from vertex to vertex, not used");
      return std::nullopt;
    }
  }
  if (colors.empty()) return std::nullopt;
  const RGB color(colors[0], colors[1], colors[2]);
  return color == RGB(1.0f) ? std::nullopt : std::optional(color);
}

}  // namespace

GltfPrimitive read_gltf_primitive(const GltfDocument& document, const tinygltf::Primitive& primitive, int uv_set,
                                  const std::string& where, NoteCounter& notes) {
  GltfPrimitive out;
  const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
  if (mode < TINYGLTF_MODE_TRIANGLES || mode > TINYGLTF_MODE_TRIANGLE_FAN) {
    notes.add("primitive of points or lines, left out");
    return out;
  }
  AttributeReader reader(document, primitive, where);
  if (!reader.has("POSITION")) {
    notes.add("primitive without positions, left out");
    return out;
  }
  Geometry& mesh = out.mesh;
  const std::vector<float> positions = reader.read("POSITION", 3);
  const std::size_t count = positions.size() / 3;
  for (std::size_t i = 0; i < count; ++i) {
    mesh.positions.push_back({positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]});
  }
  mesh.normals.resize(count);
  if (reader.has("NORMAL")) {
    const std::vector<float> normals = reader.read("NORMAL", 3);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 n{normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]};
      const float l = length(n);
      mesh.normals[i] = l > 0 && std::isfinite(l) ? n / l : Vec3{0, 0, 0};
    }
  }
  mesh.uvs.resize(count);
  if (const std::string name = fmt::format("TEXCOORD_{}", uv_set); reader.has(name)) {
    const std::vector<float> uvs = reader.read(name, 2);
    for (std::size_t i = 0; i < count; ++i) mesh.uvs[i] = {uvs[2 * i], 1 - uvs[2 * i + 1]};
  }
  out.vertex_color = uniform_color(reader, notes);
  mesh.triangles = triangles_of(reader.indices(), reader.compressed() ? TINYGLTF_MODE_TRIANGLES : mode);
  if (!primitive.targets.empty()) notes.add("primitive with morph targets: shown without them");
  return out;
}

}  // namespace glowworm
