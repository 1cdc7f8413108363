#include "import/gltf/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "import/gltf/references.h"

namespace glowworm {

namespace {

using nlohmann::json;

constexpr int kDeepestNesting = 200;
/// Limits accessors without a buffer (all zero, or sparse), so that a short file cannot allocate much memory.
constexpr std::size_t kMaxImplicitElements = std::size_t{1} << 20;

class Checker {
 public:
  Checker(const json& root, const std::string& path) : root_(root), path_(path) {}

  void run() {
    if (!root_.is_object()) fail("the JSON is not an object");
    check_version();
    for (const GltfReference& reference : kGltfReferences) check_references(reference);
    each(root_, "buffers[]", "", [this](const json& o, const std::string& where) {
      if (unsigned_member(o, "byteLength", 0, where, path_) == 0) fail(where + " has no byteLength");
    });
    each(root_, "bufferViews[]", "", [this](const json& o, const std::string& where) { check_view(o, where); });
    each(root_, "accessors[]", "", [this](const json& o, const std::string& where) { check_accessor(o, where); });
    each(root_, "meshes[]", "", [this](const json& o, const std::string& where) {
      if (!o.contains("primitives")) fail(where + " has no primitives");
    });
    each(root_, "meshes[].primitives[]", "",
         [this](const json& o, const std::string& where) { unsigned_member(o, "mode", 4, where, path_); });
    each(root_, "animations[]", "", [this](const json& o, const std::string& where) { check_animation(o, where); });
    each(root_, "nodes[]", "", [this](const json& o, const std::string& where) { check_node(o, where); });
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { throw Error({path_}, message, kDamagedGltf); }

  void check_version() const {
    const auto asset = root_.find("asset");
    if (asset == root_.end() || !asset->is_object() || !asset->contains("version")) {
      throw Error({path_}, "has no asset.version", "Is it a glTF 2.0 file?");
    }
    const json& version = (*asset)["version"];
    if (!version.is_string() || !version.get_ref<const std::string&>().starts_with("2.")) {
      throw Error({path_}, fmt::format("is glTF version {}, not 2.0", version.dump()), "Export it as glTF 2.0.");
    }
  }

  /// Calls visit(value, name) for all values at a place, as for_places() does.
  template <typename Visit>
  void visit(const json& at, std::string_view place, const std::string& where, const Visit& visit) const {
    for_places(const_cast<json&>(at), place, where, visit, [&](const std::string& name, const char* type) {
      fail(fmt::format("'{}' is not {} {}", name, type == std::string_view("list") ? "a" : "an", type));
    });
  }
  /// The same for values that must be objects.
  template <typename Check>
  void each(const json& at, std::string_view place, const std::string& where, const Check& check) const {
    visit(at, place, where, [&](const json& value, const std::string& name) {
      if (!value.is_object()) fail(name + " is not an object");
      check(value, name);
    });
  }

  /// Readers of extensions check theirs.
  void check_references(const GltfReference& reference) const {
    if (reference.place.find("extensions") != std::string_view::npos) return;
    const auto list = root_.find(std::string(reference.list));
    const std::size_t size = list != root_.end() && list->is_array() ? list->size() : 0;
    visit(root_, reference.place, "", [&](const json& value, const std::string& name) {
      const std::size_t index = unsigned_value(value, name, path_);
      if (index >= size) fail(fmt::format("{} is {}, but there are {} {}", name, index, size, reference.list));
    });
  }

  void check_view(const json& o, const std::string& where) const {
    if (!o.contains("buffer")) fail(where + " names no buffer");
    const std::size_t buffer = o["buffer"].get<std::size_t>();
    const std::size_t offset = unsigned_member(o, "byteOffset", 0, where, path_);
    const std::size_t length = unsigned_member(o, "byteLength", 0, where, path_);
    const std::size_t size = unsigned_member(root_["buffers"][buffer], "byteLength", 0, "buffers", path_);
    if (length == 0) fail(where + " has no byteLength");
    if (offset > size || length > size - offset) {
      fail(fmt::format("{} reaches to byte {} of buffers[{}], which has {}", where, offset + length, buffer, size));
    }
    const std::size_t stride = unsigned_member(o, "byteStride", 4, where, path_);
    if (stride < 4 || stride > 252 || stride % 4 != 0) {
      fail(fmt::format("{}.byteStride is {}; expected a multiple of 4 from 4 to 252", where, stride));
    }
  }

  std::size_t component_size(const json& o, const std::string& where) const {
    switch (const std::size_t type = unsigned_member(o, "componentType", 0, where, path_)) {
      case 5120:
      case 5121:
        return 1;
      case 5122:
      case 5123:
        return 2;
      case 5125:
      case 5126:
        return 4;
      default:
        fail(fmt::format("{}.componentType is {}; expected 5120, 5121, 5122, 5123, 5125 or 5126", where, type));
    }
  }

  std::size_t component_count(const json& o, const std::string& where) const {
    static constexpr std::pair<const char*, std::size_t> kTypes[] = {
        {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
    const auto type = o.find("type");
    if (type != o.end() && type->is_string()) {
      for (const auto& [name, components] : kTypes) {
        if (type->get_ref<const std::string&>() == name) return components;
      }
    }
    fail(where + ".type is not one of SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3, MAT4");
  }

  void check_accessor(const json& o, const std::string& where) const {
    const std::size_t element = component_size(o, where) * component_count(o, where);
    const std::size_t elements = unsigned_member(o, "count", 0, where, path_);
    if (elements == 0) fail(where + " has no count");
    if (elements > std::numeric_limits<std::uint32_t>::max()) fail(where + ".count is more than 32 bits can hold");
    if (o.contains("bufferView")) {
      const json& view = root_["bufferViews"][o["bufferView"].get<std::size_t>()];
      const std::size_t stride = std::max(element, unsigned_member(view, "byteStride", element, where, path_));
      check_fits(view, unsigned_member(o, "byteOffset", 0, where, path_), (elements - 1) * stride + element, where);
    }
    const auto sparse = o.find("sparse");
    if (sparse == o.end()) return;
    if (!sparse->is_object()) fail(where + ".sparse is not an object");
    if (!o.contains("bufferView") && elements > kMaxImplicitElements) {
      fail(fmt::format("{}.count is {}, but no buffer holds so many", where, elements));
    }
    check_sparse(*sparse, element, elements, where + ".sparse");
  }

  void check_sparse(const json& sparse, std::size_t element, std::size_t elements, const std::string& where) const {
    const std::size_t changed = unsigned_member(sparse, "count", 0, where, path_);
    if (changed > elements) fail(fmt::format("{}.count is {}, but the accessor has {}", where, changed, elements));
    for (const char* part : {"indices", "values"}) {
      const std::string inner = where + "." + part;
      if (!sparse.contains(part) || !sparse[part].is_object()) fail(inner + " is missing");
      const json& o = sparse[part];
      if (!o.contains("bufferView")) fail(inner + " names no bufferView");
      const std::size_t size = part[0] == 'i' ? component_size(o, inner) : element;
      check_fits(root_["bufferViews"][o["bufferView"].get<std::size_t>()],
                 unsigned_member(o, "byteOffset", 0, inner, path_), changed * size, inner);
    }
  }

  void check_fits(const json& view, std::size_t offset, std::size_t length, const std::string& where) const {
    const std::size_t size = unsigned_member(view, "byteLength", 0, "bufferViews", path_);
    if (offset > size || length > size - offset) {
      fail(fmt::format("{} reaches to byte {} of its buffer view, which has {}", where, offset + length, size));
    }
  }

  void check_animation(const json& o, const std::string& where) const {
    each(o, "samplers[]", where, [this](const json& sampler, const std::string& inner) {
      for (const char* key : {"input", "output"})
        if (!sampler.contains(key)) fail(fmt::format("{} has no {}", inner, key));
    });
    const std::size_t samplers = o.contains("samplers") ? o["samplers"].size() : 0;
    each(o, "channels[]", where, [&](const json& channel, const std::string& inner) {
      if (unsigned_member(channel, "sampler", samplers, inner, path_) >= samplers)
        fail(fmt::format("{}.sampler is missing or beyond the {} samplers", inner, samplers));
    });
  }

  void check_node(const json& o, const std::string& where) const {
    static constexpr std::pair<const char*, std::size_t> kNumbers[] = {
        {"matrix", 16}, {"rotation", 4}, {"scale", 3}, {"translation", 3}};
    for (const auto& [key, size] : kNumbers) {
      const auto it = o.find(key);
      if (it == o.end()) continue;
      const bool numbers =
          it->is_array() && std::all_of(it->begin(), it->end(), [](const json& n) { return n.is_number(); });
      if (!numbers || it->size() != size) fail(fmt::format("{}.{} is not a list of {} numbers", where, key, size));
    }
  }

  const json& root_;
  const std::string& path_;
};

}  // namespace

std::size_t check_json_depth(std::string_view text, const std::string& path) {
  int depth = 0;
  std::size_t count = 1;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      ++count;
      if (++depth > kDeepestNesting) {
        throw Error({path}, fmt::format("the JSON is nested more than {} deep", kDeepestNesting), kDamagedGltf);
      }
    } else if (c == '}' || c == ']') {
      --depth;
    } else if (c == ',' || c == ':') {
      ++count;
    }
  }
  return count;
}

void check_gltf_json(const json& root, const std::string& path) { Checker(root, path).run(); }

std::size_t unsigned_value(const json& value, const std::string& where, const std::string& path) {
  // Far below 2^64, so that sums and products of a few such numbers cannot overflow.
  constexpr std::size_t kMaxValue = std::size_t{1} << 48;
  if (value.is_number_float() && value.get<double>() >= 0 && value.get<double>() < 1e14 &&
      value.get<double>() == static_cast<double>(static_cast<std::size_t>(value.get<double>())))
    return static_cast<std::size_t>(value.get<double>());
  if (!value.is_number_unsigned() || value.get<std::size_t>() > kMaxValue)
    throw Error({path}, fmt::format("{} is {}; expected an integer that is not negative", where, value.dump()),
                kDamagedGltf);
  return value.get<std::size_t>();
}

std::size_t unsigned_member(const json& object, const char* key, std::size_t otherwise, const std::string& where,
                            const std::string& path) {
  const auto it = object.find(key);
  return it == object.end() ? otherwise : unsigned_value(*it, fmt::format("{}.{}", where, key), path);
}

}  // namespace glowworm
