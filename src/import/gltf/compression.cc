#include "import/gltf/compression.h"

#include <draco/compression/decode.h>
#include <fmt/format.h>
#include <meshoptimizer.h>
#include <tiny_gltf.h>

#include <array>
#include <exception>

#include "core/error.h"
#include "import/gltf/document.h"

namespace glowworm {

namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr const char* kCompressionRemedy = "The file is damaged or invalid: export it again, without compression.";
/// Maximum ratio of decoded to compressed bytes. The codec writes about a bit or more for every element, so data with a
/// larger ratio is damaged.
constexpr std::size_t kMaxExpansion = 512;

std::size_t number_of(const tinygltf::Value& object, const char* key) {
  if (!object.Has(key) || !object.Get(key).IsNumber()) return 0;
  const double value = object.Get(key).GetNumberAsDouble();
  return value > 0 && value < 1e12 ? static_cast<std::size_t>(value) : 0;
}

std::string text_of(const tinygltf::Value& object, const char* key, const char* otherwise) {
  return object.Has(key) && object.Get(key).IsString() ? object.Get(key).Get<std::string>() : otherwise;
}

struct CompressedView {
  std::span<const std::uint8_t> bytes;
  std::size_t stride = 0, count = 0;
  std::string mode, filter;
};

CompressedView compressed_view(const GltfDocument& document, const tinygltf::Value& extension, std::size_t decoded,
                               const std::string& where) {
  CompressedView view;
  const std::size_t buffer = number_of(extension, "buffer"), offset = number_of(extension, "byteOffset");
  const std::size_t length = number_of(extension, "byteLength");
  view.stride = number_of(extension, "byteStride");
  view.count = number_of(extension, "count");
  view.mode = text_of(extension, "mode", "");
  view.filter = text_of(extension, "filter", "NONE");
  if (buffer >= document.buffers.size() || offset > document.buffers[buffer].size() ||
      length > document.buffers[buffer].size() - offset || length == 0) {
    throw Error({document.path}, where + " reaches outside of its buffer", kCompressionRemedy);
  }
  view.bytes = std::span(document.buffers[buffer]).subspan(offset, length);
  if (view.count == 0 || view.stride == 0 || view.stride > 256 || decoded != view.count * view.stride ||
      decoded / kMaxExpansion > length) {
    throw Error(
        {document.path},
        fmt::format("{}: {} elements of {} bytes cannot come from {} bytes", where, view.count, view.stride, length),
        kCompressionRemedy);
  }
  return view;
}

bool decode_elements(const CompressedView& view, std::vector<std::uint8_t>& out) {
  const std::uint8_t* bytes = view.bytes.data();
  const std::size_t size = view.bytes.size();
  if (view.mode == "ATTRIBUTES") {
    return view.stride % 4 == 0 && meshopt_decodeVertexBuffer(out.data(), view.count, view.stride, bytes, size) == 0;
  }
  if (view.stride != 2 && view.stride != 4) return false;
  if (view.mode == "TRIANGLES") {
    return view.count % 3 == 0 && meshopt_decodeIndexBuffer(out.data(), view.count, view.stride, bytes, size) == 0;
  }
  return view.mode == "INDICES" && meshopt_decodeIndexSequence(out.data(), view.count, view.stride, bytes, size) == 0;
}

bool apply_filter(const CompressedView& view, std::vector<std::uint8_t>& out) {
  if (view.filter == "NONE") return true;
  if (view.filter == "OCTAHEDRAL" && (view.stride == 4 || view.stride == 8)) {
    meshopt_decodeFilterOct(out.data(), view.count, view.stride);
  } else if (view.filter == "QUATERNION" && view.stride == 8) {
    meshopt_decodeFilterQuat(out.data(), view.count, view.stride);
  } else if (view.filter == "EXPONENTIAL" && view.stride % 4 == 0) {
    meshopt_decodeFilterExp(out.data(), view.count, view.stride);
  } else {
    return false;
  }
  return true;
}

DracoPrimitive::Attribute read_attribute(const draco::Mesh& mesh, const draco::PointAttribute& source,
                                         Reservation& held) {
  DracoPrimitive::Attribute attribute;
  attribute.components = source.num_components();
  const std::size_t width = static_cast<std::size_t>(attribute.components);
  held.grow(mesh.num_points() * width * sizeof(float));
  attribute.values.resize(mesh.num_points() * width);
  std::array<float, 4> value{};
  for (draco::PointIndex i(0); i < mesh.num_points(); ++i) {
    if (!source.ConvertValue<float>(source.mapped_index(i), source.num_components(), value.data())) continue;
    for (std::size_t c = 0; c < width; ++c) attribute.values[i.value() * width + c] = value[c];
  }
  return attribute;
}

std::unique_ptr<draco::Mesh> decode_mesh(std::span<const std::uint8_t> bytes, std::string& problem) {
  try {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    auto result = decoder.DecodeMeshFromBuffer(&buffer);
    if (result.ok()) return std::move(result).value();
    problem = result.status().error_msg_string();
  } catch (const std::exception& e) {
    problem = e.what();
  }
  return nullptr;
}

}  // namespace

void decode_meshopt_views(GltfDocument& document) {
  document.decoded_views.resize(document.model->bufferViews.size());
  for (std::size_t i = 0; i < document.model->bufferViews.size(); ++i) {
    const tinygltf::BufferView& view = document.model->bufferViews[i];
    auto extension = view.extensions.find("EXT_meshopt_compression");
    if (extension == view.extensions.end()) extension = view.extensions.find("KHR_meshopt_compression");
    if (extension == view.extensions.end()) continue;
    const std::string where = fmt::format("the compressed bufferViews[{}]", i);
    const CompressedView source = compressed_view(document, extension->second, view.byteLength, where);
    document.held->grow(view.byteLength);
    std::vector<std::uint8_t> decoded(view.byteLength);
    if (!decode_elements(source, decoded) || !apply_filter(source, decoded)) {
      throw Error({document.path},
                  fmt::format("{} cannot be decoded (mode {}, filter {})", where, source.mode, source.filter),
                  kCompressionRemedy);
    }
    document.decoded_views[i] = std::move(decoded);
  }
}

bool is_draco(const tinygltf::Primitive& primitive) { return primitive.extensions.contains(kDraco); }

std::optional<DracoPrimitive> draco_attributes(const GltfDocument& document, int mesh, std::size_t primitive) {
  const tinygltf::Primitive& source =
      document.model->meshes.at(static_cast<std::size_t>(mesh)).primitives.at(primitive);
  if (!is_draco(source)) return std::nullopt;
  return decode_draco(document, source, fmt::format("meshes[{}].primitives[{}]", mesh, primitive), *document.held);
}

DracoPrimitive decode_draco(const GltfDocument& document, const tinygltf::Primitive& primitive,
                            const std::string& where, Reservation& held) {
  const tinygltf::Value& extension = primitive.extensions.at(kDraco);
  const std::size_t view = number_of(extension, "bufferView");
  if (view >= document.model->bufferViews.size() || !extension.Has("attributes")) {
    throw Error({document.path}, where + ": its Draco extension names no buffer view or no attributes",
                kCompressionRemedy);
  }
  std::string problem;
  const std::unique_ptr<draco::Mesh> mesh = decode_mesh(document.view(static_cast<int>(view)), problem);
  if (!mesh)
    throw Error({document.path}, fmt::format("{}: Draco cannot decode it ({})", where, problem), kCompressionRemedy);
  DracoPrimitive out;
  out.vertex_count = mesh->num_points();
  const tinygltf::Value& attributes = extension.Get("attributes");
  for (const std::string& name : attributes.Keys()) {
    const int id = mesh->GetAttributeIdByUniqueId(static_cast<std::uint32_t>(number_of(attributes, name.c_str())));
    draco::PointAttribute* const attribute = id < 0 ? nullptr : mesh->attribute(id);
    if (!attribute || attribute->num_components() < 1 || attribute->num_components() > 4) {
      throw Error({document.path}, fmt::format("{}: Draco attribute {} is not there", where, name), kCompressionRemedy);
    }
    // Encoders may leave Draco's own flag unset; the accessor says how the numbers are meant.
    const auto accessor = primitive.attributes.find(name);
    if (accessor != primitive.attributes.end() && accessor->second >= 0)
      attribute->set_normalized(document.model->accessors.at(static_cast<std::size_t>(accessor->second)).normalized);
    out.attributes[name] = read_attribute(*mesh, *attribute, held);
  }
  held.grow(std::uint64_t{3} * mesh->num_faces() * sizeof(std::uint32_t));
  out.indices.reserve(std::size_t{3} * mesh->num_faces());
  for (draco::FaceIndex f(0); f < mesh->num_faces(); ++f) {
    for (const draco::PointIndex& corner : mesh->face(f)) out.indices.push_back(corner.value());
  }
  return out;
}

}  // namespace glowworm
