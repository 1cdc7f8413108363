#include "gltf_writer/gltf_vertices.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "scene/geometry.h"

namespace glowworm {

namespace {

using nlohmann::json;

enum ComponentType : int {
  kByte = 5120,
  kUnsignedByte,
  kShort,
  kUnsignedShort,
  kUnsignedInt = 5125,
  kFloat,
};

constexpr int kVertexTarget = 34962;

std::size_t size_of(int component_type) {
  if (component_type <= kUnsignedByte) return 1;
  return component_type <= kUnsignedShort ? 2 : 4;
}

/// Calls `use` with a number of this type in memory, as its own type.
template <typename Bytes, typename Use>
auto as_number(Bytes* at, int component_type, const Use& use) {
  const auto load = [&](auto value) {
    std::memcpy(&value, at, sizeof value);
    return use(value);
  };
  switch (component_type) {
    case kByte:
      return load(std::int8_t{});
    case kUnsignedByte:
      return load(std::uint8_t{});
    case kShort:
      return load(std::int16_t{});
    case kUnsignedShort:
      return load(std::uint16_t{});
    case kUnsignedInt:
      return load(std::uint32_t{});
    default:
      return load(float{});
  }
}

/// Negates the numbers of elements; the least of an integer type becomes the largest.
void negate(GltfElements& elements) {
  const std::size_t size = size_of(elements.component_type);
  for (std::size_t i = 0; i < elements.bytes.size(); i += size) {
    std::uint8_t* const at = elements.bytes.data() + i;
    as_number(at, elements.component_type, [at](auto value) {
      using Number = decltype(value);
      const Number least = std::numeric_limits<Number>::lowest();
      const auto negative = static_cast<Number>(value == least ? std::numeric_limits<Number>::max() : -value);
      std::memcpy(at, &negative, sizeof negative);
    });
  }
}

/// The bounds that an accessor tells, of its components.
void set_bounds(const GltfElements& elements, json& accessor) {
  std::vector<double> low(elements.components, std::numeric_limits<double>::max()), high(elements.components);
  std::fill(high.begin(), high.end(), std::numeric_limits<double>::lowest());
  const std::size_t size = size_of(elements.component_type);
  for (std::size_t i = 0; i < elements.bytes.size() / size; ++i) {
    const double value = as_number(elements.bytes.data() + i * size, elements.component_type,
                                   [](auto number) { return static_cast<double>(number); });
    const std::size_t c = i % elements.components;
    low[c] = std::min(low[c], value);
    high[c] = std::max(high[c], value);
  }
  accessor["min"] = low;
  accessor["max"] = high;
}

/// Elements of a Draco attribute. Joints are numbers; all else may be floats (glTF 2.0, section 3.7.2.1).
GltfElements elements_of(const DracoPrimitive::Attribute& attribute, bool are_joints) {
  GltfElements out;
  out.components = static_cast<std::size_t>(attribute.components);
  out.component_type = are_joints ? kUnsignedShort : kFloat;
  out.size = out.components * size_of(out.component_type);
  out.bytes.resize(out.size / out.components * attribute.values.size());
  if (!are_joints) {
    std::memcpy(out.bytes.data(), attribute.values.data(), out.bytes.size());
    return out;
  }
  for (std::size_t i = 0; i < attribute.values.size(); ++i) {
    const auto joint = static_cast<std::uint16_t>(std::clamp(attribute.values[i], 0.0f, 65535.0f));
    std::memcpy(out.bytes.data() + i * sizeof joint, &joint, sizeof joint);
  }
  return out;
}

}  // namespace

LitVertices::LitVertices(std::size_t vertices) : first_(vertices, kNone) {}

std::uint32_t LitVertices::add(std::uint32_t vertex, Vec2 uv, int layer) {
  for (std::uint32_t e = first_[vertex]; e != kNone; e = entries_[e].next)
    if (entries_[e].uv.x == uv.x && entries_[e].uv.y == uv.y && entries_[e].layer == layer) return e;
  const auto number = static_cast<std::uint32_t>(entries_.size());
  entries_.push_back({vertex, std::exchange(first_[vertex], number), uv, layer});
  return number;
}

std::uint32_t LitVertices::add(std::uint32_t vertex) {
  return first_[vertex] != kNone ? first_[vertex] : add(vertex, {0, 0}, -1);
}

void LitVertices::arrange(bool anew) {
  const std::size_t used = first_.size() - static_cast<std::size_t>(std::count(first_.begin(), first_.end(), kNone));
  const bool keeps_all = !anew && 2 * used >= first_.size();
  index_.assign(entries_.size(), kNone);
  if (keeps_all)
    for (std::uint32_t v = 0; v < first_.size(); ++v) {
      const std::uint32_t entry = first_[v];
      if (entry != kNone) index_[entry] = v;
      arranged_.push_back(entry != kNone ? entries_[entry] : Entry{v, kNone, {0, 0}, -1});
    }
  for (std::uint32_t e = 0; e < entries_.size(); ++e) {
    if (index_[e] != kNone) continue;
    index_[e] = static_cast<std::uint32_t>(arranged_.size());
    arranged_.push_back(entries_[e]);
  }
  unchanged_ = keeps_all && arranged_.size() == first_.size();
}

AttributeWriter::AttributeWriter(const GltfDocument& document, int mesh, std::size_t primitive, GlbFile& file)
    : document_(document), file_(file), draco_(draco_attributes(document, mesh, primitive)) {}

GltfElements AttributeWriter::elements(const std::string& name, int accessor) const {
  if (draco_ && draco_->attributes.contains(name))
    return elements_of(draco_->attributes.at(name), name.starts_with("JOINTS_"));
  return raw_elements(document_, accessor);
}

int AttributeWriter::write(const std::string& name, int accessor, const std::vector<LitVertices::Entry>& vertices,
                           bool turned) {
  json out = file_.json["accessors"][static_cast<std::size_t>(accessor)];
  GltfElements from = elements(name, accessor);
  if (draco_ && draco_->attributes.contains(name)) {
    out["componentType"] = from.component_type;
    out.erase("normalized");
  }
  return write(std::move(out), std::move(from), vertices, turned);
}

int AttributeWriter::write_target(int accessor, const std::vector<LitVertices::Entry>& vertices, bool turned) {
  return write(file_.json["accessors"][static_cast<std::size_t>(accessor)], raw_elements(document_, accessor), vertices,
               turned);
}

int AttributeWriter::write(json out, GltfElements from, const std::vector<LitVertices::Entry>& vertices, bool turned) {
  for (const char* key : {"bufferView", "byteOffset", "sparse"}) out.erase(key);
  out["count"] = vertices.size();
  if (from.bytes.empty()) return file_.add("accessors", out);
  if (turned) negate(from);
  const std::size_t stride = (from.size + 3) / 4 * 4;  // of vertex attributes: glTF 2.0, section 3.6.2.4
  std::string bytes(vertices.size() * stride, '\0');
  GltfElements to = from;
  to.bytes.resize(vertices.size() * from.size);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const std::uint8_t* const element = from.bytes.data() + vertices[i].vertex * from.size;
    std::memcpy(bytes.data() + i * stride, element, from.size);
    std::memcpy(to.bytes.data() + i * from.size, element, from.size);
  }
  if (out.contains("min") || out.contains("max")) set_bounds(to, out);
  const int view = file_.add_view(bytes, kVertexTarget);
  if (stride != from.size) file_.json["bufferViews"][static_cast<std::size_t>(view)]["byteStride"] = stride;
  out["bufferView"] = view;
  return file_.add("accessors", out);
}

std::size_t AttributeWriter::components(const std::string& name, int accessor) const {
  if (draco_ && draco_->attributes.contains(name))
    return static_cast<std::size_t>(draco_->attributes.at(name).components);
  return file_.json["accessors"][static_cast<std::size_t>(accessor)].at("type") == "VEC4" ? 4 : 3;
}

std::vector<float> AttributeWriter::floats(const std::string& name, int accessor, std::size_t components) const {
  if (draco_ && draco_->attributes.contains(name)) return draco_->attributes.at(name).values;
  return read_floats(document_, accessor, static_cast<int>(components));
}

}  // namespace glowworm
