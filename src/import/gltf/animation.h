// Animations of glTF files: values of their channels at a moment.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

namespace tinygltf {
struct Animation;
}

namespace glowworm {

struct GltfDocument;

/// Numbers of a camera, as in the file.
struct GltfLens {
  double yfov = 0, aspect_ratio = 0, xmag = 0, ymag = 0;
};

/// Values that a file's nodes have in a pose, by node; as in the file, so an array may be empty.
struct GltfNodeValues {
  std::vector<std::vector<double>> translation, rotation, scale;
  std::vector<std::vector<float>> weights;  ///< of morph targets
  std::vector<GltfLens> lenses;             ///< by camera
};

/// How values between two keys arise (glTF 2.0, appendix C).
enum class GltfInterpolation { step, linear, cubic };

/// The value of a channel at a time. Before the first key and after the last, the key's value holds.
/// @param times of the keys, s, ascending; at least one
/// @param values of the keys, `width` numbers each; cubic: tangent, value and tangent of each
/// @param rotation the values are quaternions: linear interpolation follows the shorter arc, and the result is unit
std::vector<float> gltf_value_at(std::span<const float> times, std::span<const float> values, std::size_t width,
                                 GltfInterpolation interpolation, bool rotation, double seconds);

/// Seconds of an animation up to its last key. @param name as animate() takes it
double animation_seconds(const GltfDocument& document, const std::string& name);

/// Sets the values that an animation moves to a moment, by channels of nodes or by KHR_animation_pointer.
/// @param name of the animation, or its number from 0; empty: the first, if there is one
/// Throws Error, which lists the animations, for an unknown name, and if an animation has too few numbers.
void animate(const GltfDocument& document, const std::string& name, double seconds, GltfNodeValues& values);

/// The same for other properties that pointers move, of materials and lights for example, in the file's JSON. Returns
/// whether there are any.
bool animate_properties(const GltfDocument& document, const std::string& name, double seconds, nlohmann::json& root);

/// Whether an animation, named as for animate(), moves what animate_properties() sets.
bool moves_properties(const GltfDocument& document, const std::string& name);

}  // namespace glowworm
