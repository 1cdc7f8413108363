// What determines the bits of a picture, as a list of names and values: what two renders must share to be one.
#pragma once
#include <string>
#include <vector>

#include "render/settings.h"
#include "scene/scene.h"

namespace glowworm {

/// One property of a render. Settings go by the option that gives them.
struct KeyPart {
  std::string name, value;
  bool operator==(const KeyPart&) const = default;
};

/// Everything that the samples of a render depend on, beside their numbers: version, instruction sets, hashes of the
/// scene, settings. Renders with the same key give the same samples, bit for bit.
using RenderKey = std::vector<KeyPart>;

/// @param settings resolved
/// Hashes the whole scene (scene/scene_hash.h), so it is for renders that are kept.
RenderKey render_key(const Scene& scene, const RenderSettings& settings);

/// The key as one line of text, and back; nothing where the text is no key.
std::string key_text(const RenderKey& key);
RenderKey parse_key(const std::string& text);

/// Throws Error that says in what the key of `kept`, as "the checkpoint", differs from this render's, and what to do.
void check_same_render(const RenderKey& own, const RenderKey& other, const std::string& kept);

}  // namespace glowworm
