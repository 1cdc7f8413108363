#include "import/gltf/accessor.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>

#include "core/error.h"
#include "import/gltf/check.h"
#include "import/gltf/document.h"

namespace glowworm {

namespace {

template <typename T>
T load(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// Converts one number to a float (glTF 2.0, section 3.11: "decoded" values of normalised integers).
float component(const std::uint8_t* bytes, int type, bool normalized) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
      const float value = load<std::int8_t>(bytes);
      return normalized ? std::max(value / 127, -1.0f) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return normalized ? static_cast<float>(*bytes) / 255 : static_cast<float>(*bytes);
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
      const float value = load<std::int16_t>(bytes);
      return normalized ? std::max(value / 32767, -1.0f) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: {
      const float value = load<std::uint16_t>(bytes);
      return normalized ? value / 65535 : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return static_cast<float>(load<std::uint32_t>(bytes));
    default:
      return load<float>(bytes);
  }
}

std::uint32_t index_value(const std::uint8_t* bytes, int type) {
  if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return *bytes;
  if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return load<std::uint16_t>(bytes);
  return load<std::uint32_t>(bytes);
}

bool is_index_type(int type) {
  return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

std::size_t component_size(int type) {
  return static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type)));
}

std::size_t component_count(const tinygltf::Accessor& accessor) {
  return static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)));
}

/// Calls `visit` with the index and the bytes of each element in the sparse part of an accessor.
template <typename Visit>
void for_each_sparse(const GltfDocument& document, int index, std::size_t element_size, const Visit& visit) {
  const tinygltf::Accessor& accessor = document.model->accessors[static_cast<std::size_t>(index)];
  const auto& sparse = accessor.sparse;
  if (!is_index_type(sparse.indices.componentType)) {
    throw Error({document.path}, fmt::format("accessors[{}].sparse.indices are not unsigned integers", index),
                kDamagedGltf);
  }
  const std::uint8_t* indices = document.view(sparse.indices.bufferView).data() + sparse.indices.byteOffset;
  const std::uint8_t* values = document.view(sparse.values.bufferView).data() + sparse.values.byteOffset;
  const std::size_t index_size = component_size(sparse.indices.componentType);
  for (std::size_t i = 0; i < static_cast<std::size_t>(sparse.count); ++i) {
    const std::size_t target = index_value(indices + i * index_size, sparse.indices.componentType);
    if (target >= accessor.count) {
      throw Error(
          {document.path},
          fmt::format("accessors[{}].sparse replaces element {}, but there are {}", index, target, accessor.count),
          kDamagedGltf);
    }
    visit(target, values + i * element_size);
  }
}

/// Calls `visit` with the index and the bytes of each element of an accessor, those of its sparse part last.
template <typename Visit>
void for_each_element(const GltfDocument& document, int index, const Visit& visit) {
  const tinygltf::Accessor& accessor = document.model->accessors[static_cast<std::size_t>(index)];
  const std::size_t size = component_count(accessor) * component_size(accessor.componentType);
  if (accessor.bufferView >= 0) {
    const tinygltf::BufferView& view = document.model->bufferViews[static_cast<std::size_t>(accessor.bufferView)];
    const std::size_t stride = std::max(size, view.byteStride);
    const std::uint8_t* const bytes = document.view(accessor.bufferView).data() + accessor.byteOffset;
    for (std::size_t i = 0; i < accessor.count; ++i) visit(i, bytes + i * stride);
  }
  if (accessor.sparse.isSparse) for_each_sparse(document, index, size, visit);
}

}  // namespace

std::vector<float> read_floats(const GltfDocument& document, int index, int components) {
  const tinygltf::Accessor& accessor = document.model->accessors.at(static_cast<std::size_t>(index));
  const std::size_t given = component_count(accessor), wanted = static_cast<std::size_t>(components);
  if (given < wanted) {
    throw Error({document.path}, fmt::format("accessors[{}] has {} components; expected {}", index, given, components),
                kDamagedGltf);
  }
  if (accessor.bufferView < 0 && !accessor.sparse.isSparse) {
    throw Error({document.path}, fmt::format("accessors[{}] has no data", index), kDamagedGltf);
  }
  const std::size_t size = component_size(accessor.componentType);
  std::vector<float> out(accessor.count * wanted);
  for_each_element(document, index, [&](std::size_t i, const std::uint8_t* bytes) {
    for (std::size_t c = 0; c < wanted; ++c)
      out[i * wanted + c] = component(bytes + c * size, accessor.componentType, accessor.normalized);
  });
  return out;
}

GltfElements raw_elements(const GltfDocument& document, int index) {
  const tinygltf::Accessor& accessor = document.model->accessors.at(static_cast<std::size_t>(index));
  GltfElements out;
  out.component_type = accessor.componentType;
  out.components = component_count(accessor);
  out.size = out.components * component_size(accessor.componentType);
  if (accessor.bufferView < 0 && !accessor.sparse.isSparse) return out;
  out.bytes.resize(accessor.count * out.size);
  for_each_element(document, index, [&](std::size_t i, const std::uint8_t* bytes) {
    std::memcpy(out.bytes.data() + i * out.size, bytes, out.size);
  });
  return out;
}

std::vector<std::uint32_t> read_indices(const GltfDocument& document, int index) {
  const tinygltf::Accessor& accessor = document.model->accessors.at(static_cast<std::size_t>(index));
  if (!is_index_type(accessor.componentType) || accessor.type != TINYGLTF_TYPE_SCALAR || accessor.sparse.isSparse ||
      accessor.bufferView < 0) {
    throw Error({document.path},
                fmt::format("accessors[{}] cannot serve as indices: expected plain unsigned integers", index),
                kDamagedGltf);
  }
  std::vector<std::uint32_t> out(accessor.count);
  for_each_element(document, index, [&](std::size_t i, const std::uint8_t* bytes) {
    out[i] = index_value(bytes, accessor.componentType);
  });
  return out;
}

}  // namespace glowworm
