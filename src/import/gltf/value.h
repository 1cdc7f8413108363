// Reads numbers and texture references from glTF extensions, as tinygltf stores them.
#pragma once
#include <tiny_gltf.h>

#include <cmath>

#include "core/rgb.h"
#include "core/vec.h"

namespace glowworm {

/// The extension with this name as an object; nullptr if there is none.
inline const tinygltf::Value* find_extension(const tinygltf::ExtensionMap& extensions, const char* name) {
  const auto it = extensions.find(name);
  return it != extensions.end() && it->second.IsObject() ? &it->second : nullptr;
}

/// A member that is a finite number; `otherwise` if it is absent or of another type.
inline float number_member(const tinygltf::Value& object, const char* key, float otherwise) {
  if (!object.Has(key) || !object.Get(key).IsNumber()) return otherwise;
  const float value = static_cast<float>(object.Get(key).GetNumberAsDouble());
  return std::isfinite(value) ? value : otherwise;
}

/// A member that is true or false; `otherwise` if it is absent or of another type.
inline bool bool_member(const tinygltf::Value& object, const char* key, bool otherwise) {
  return object.Has(key) && object.Get(key).IsBool() ? object.Get(key).Get<bool>() : otherwise;
}

/// Element i of a member that is a list of numbers; `otherwise` if it is absent.
inline float element_member(const tinygltf::Value& object, const char* key, int i, float otherwise) {
  if (!object.Has(key) || !object.Get(key).IsArray()) return otherwise;
  const tinygltf::Value& element = object.Get(key).Get(i);
  if (!element.IsNumber()) return otherwise;
  const float value = static_cast<float>(element.GetNumberAsDouble());
  return std::isfinite(value) ? value : otherwise;
}

inline RGB color_member(const tinygltf::Value& object, const char* key, RGB otherwise) {
  return {element_member(object, key, 0, otherwise.r), element_member(object, key, 1, otherwise.g),
          element_member(object, key, 2, otherwise.b)};
}

/// A texture reference inside an extension; its index is -1 if there is none.
inline tinygltf::TextureInfo texture_member(const tinygltf::Value& object, const char* key) {
  tinygltf::TextureInfo info;
  if (!object.Has(key) || !object.Get(key).IsObject()) return info;
  const tinygltf::Value& texture = object.Get(key);
  info.index = static_cast<int>(number_member(texture, "index", -1));
  info.texCoord = static_cast<int>(number_member(texture, "texCoord", 0));
  if (texture.Has("extensions") && texture.Get("extensions").IsObject()) {
    info.extensions = texture.Get("extensions").Get<tinygltf::Value::Object>();
  }
  return info;
}

}  // namespace glowworm
