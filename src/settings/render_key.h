// The properties that determine the bits of a picture, as a list of names and values.
#pragma once
#include <string>
#include <vector>

#include "gather/point_pass.h"
#include "scene/scene.h"
#include "settings/settings.h"

namespace glowworm {

/// One property of a render. Settings have the name of their option.
struct KeyPart {
  std::string name, value;
  bool operator==(const KeyPart&) const = default;
};

/// Everything that determines the samples of a render: version, instruction sets, hashes of the scene, settings.
/// Renders with the same key give the same samples, bit for bit.
using RenderKey = std::vector<KeyPart>;

/// @param settings resolved
/// @param points that are rendered in place of the camera's pixels; null: none
/// It hashes the whole scene (scene/scene_hash.h), so call it only for renders that are saved.
RenderKey render_key(const Scene& scene, const RenderSettings& settings, const PointGrid* points = nullptr);

/// The key as one line of text, and back; nothing if the text is not a key.
std::string key_text(const RenderKey& key);
RenderKey parse_key(const std::string& text);

/// Throws Error if the key of `kept`, such as "the checkpoint", differs from this render's; names the difference.
void check_same_render(const RenderKey& own, const RenderKey& other, const std::string& kept);

/// The key without the properties of one part of a render (RenderSettings::part).
RenderKey key_of_whole(RenderKey key);

/// The properties of a whole render, of a rectangle of it, or of a sequence of frames, that determine its photons and
/// guides. It may hold others, too.
RenderKey key_of_photons(RenderKey key);

/// The key of a whole render, and the file that has it.
struct KeyOfFile {
  const std::string& path;
  const RenderKey& key;
};

/// Throws Error, which names the files and the difference, if they cannot be parts of one picture.
/// @param mixed take other instruction sets
void check_same_whole(const KeyOfFile& a, const KeyOfFile& b, bool mixed);

/// The key of `a`, where instruction sets that differ are "mixed".
RenderKey common_key(RenderKey a, const RenderKey& b);

}  // namespace glowworm
