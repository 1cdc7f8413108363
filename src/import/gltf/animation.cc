#include "import/gltf/animation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>
#include <string_view>

#include "core/error.h"
#include "import/gltf/accessor.h"
#include "import/gltf/document.h"

namespace glowworm {

namespace {

/// A point between two quaternions of unit length, along the shorter arc.
void slerp(const float* a, const float* b, double share, float* out) {
  double cosine = 0;
  for (int i = 0; i < 4; ++i) cosine += double{a[i]} * b[i];
  const double sign = cosine < 0 ? -1 : 1;
  const double angle = std::acos(std::min(std::abs(cosine), 1.0)), sine = std::sin(angle);
  // Nearly equal quaternions: a straight line.
  const bool near = sine < 1e-6;
  const double of_a = near ? 1 - share : std::sin((1 - share) * angle) / sine;
  const double of_b = sign * (near ? share : std::sin(share * angle) / sine);
  for (int i = 0; i < 4; ++i) out[i] = static_cast<float>(of_a * a[i] + of_b * b[i]);
}

void make_unit(std::vector<float>& q) {
  double squared = 0;
  for (const float v : q) squared += double{v} * v;
  if (!(squared > 0)) return;
  for (float& v : q) v = static_cast<float>(v / std::sqrt(squared));
}

GltfInterpolation interpolation_of(const std::string& name) {
  if (name == "STEP") return GltfInterpolation::step;
  return name == "CUBICSPLINE" ? GltfInterpolation::cubic : GltfInterpolation::linear;
}

/// Null if the file has none, and the moment is its first.
const tinygltf::Animation* find_animation(const GltfDocument& document, const std::string& name, double seconds) {
  const std::vector<tinygltf::Animation>& all = document.model->animations;
  if (name.empty() && !all.empty()) return &all.front();
  if (name.empty() && seconds == 0) return nullptr;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].name == name || std::to_string(i) == name) return &all[i];
    names.push_back(all[i].name.empty() ? std::to_string(i) : fmt::format("'{}'", all[i].name));
  }
  throw Error(
      {document.path}, names.empty() ? "the file has no animation" : fmt::format("there is no animation '{}'", name),
      names.empty() ? "Leave out --animation and --at." : fmt::format("The file has: {}.", fmt::join(names, ", ")));
}

}  // namespace

std::vector<float> gltf_value_at(std::span<const float> times, std::span<const float> values, std::size_t width,
                                 GltfInterpolation interpolation, bool rotation, double seconds) {
  const bool cubic = interpolation == GltfInterpolation::cubic;
  const auto at = [&](std::size_t key) { return values.data() + (cubic ? 3 * key + 1 : key) * width; };
  const auto after = static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), seconds) - times.begin());
  const std::size_t next = std::min(after, times.size() - 1), key = after > 0 ? after - 1 : 0;
  std::vector<float> out(at(key), at(key) + width);
  const double length = double{times[next]} - times[key];
  if (key == next || after == 0 || interpolation == GltfInterpolation::step || !(length > 0)) return out;
  const double t = (seconds - times[key]) / length;
  if (cubic) {
    const float *const leaving = at(key) + width, *const arriving = at(next) - width;
    const double t2 = t * t, t3 = t2 * t;
    for (std::size_t i = 0; i < width; ++i)
      out[i] = static_cast<float>((2 * t3 - 3 * t2 + 1) * at(key)[i] + length * (t3 - 2 * t2 + t) * leaving[i] +
                                  (3 * t2 - 2 * t3) * at(next)[i] + length * (t3 - t2) * arriving[i]);
  } else if (rotation) {
    slerp(at(key), at(next), t, out.data());
  } else {
    for (std::size_t i = 0; i < width; ++i) out[i] = static_cast<float>(std::lerp(double{at(key)[i]}, at(next)[i], t));
  }
  if (rotation) make_unit(out);
  return out;
}

double animation_seconds(const GltfDocument& document, const std::string& name) {
  const tinygltf::Animation* const animation = find_animation(document, name, 1);
  double seconds = 0;
  for (const tinygltf::AnimationSampler& sampler : animation->samplers)
    for (const float time : read_floats(document, sampler.input, 1)) seconds = std::max(seconds, double{time});
  return seconds;
}

namespace {

/// The keys of a channel, and how many numbers each has.
struct Keys {
  std::vector<float> times, values;
  std::size_t width = 0;
  GltfInterpolation interpolation = GltfInterpolation::linear;
};

/// @param components of the output accessor @param width of a value; 0: as many as there are for each key
/// @param what for messages
Keys read_keys(const GltfDocument& document, const tinygltf::AnimationSampler& sampler, int components,
               std::size_t width, const std::string& what) {
  Keys keys{read_floats(document, sampler.input, 1), read_floats(document, sampler.output, components), width,
            interpolation_of(sampler.interpolation)};
  const std::size_t each = keys.interpolation == GltfInterpolation::cubic ? 3 : 1;
  if (width == 0) keys.width = keys.values.size() / std::max<std::size_t>(keys.times.size(), 1) / each;
  if (keys.times.empty() || keys.width == 0 || keys.times.size() * each * keys.width > keys.values.size() ||
      !std::is_sorted(keys.times.begin(), keys.times.end()))
    throw Error({document.path}, fmt::format("an animation of {} has too few numbers, or times that go back", what),
                "The file is damaged or invalid: export it again.");
  return keys;
}

std::vector<float> value_of(const Keys& keys, bool rotation, double seconds) {
  return gltf_value_at(keys.times, keys.values, keys.width, keys.interpolation, rotation, seconds);
}

/// What a pointer moves in a pose: numbers of a node or of a camera. All are null if it moves something else.
struct PoseTarget {
  std::vector<double>* numbers = nullptr;
  std::vector<float>* weights = nullptr;
  double* number = nullptr;

  explicit operator bool() const { return numbers || weights || number; }
};

/// @param property "/nodes/INDEX/NAME" or "/cameras/INDEX/KIND/NAME"
PoseTarget find_target(const std::string& property, GltfNodeValues& pose) {
  static const std::regex kNode("/nodes/([0-9]{1,9})/(translation|rotation|scale|weights)");
  static const std::regex kCamera("/cameras/([0-9]{1,9})/(?:perspective|orthographic)/(yfov|aspectRatio|xmag|ymag)");
  std::smatch match;
  PoseTarget out;
  if (std::regex_match(property, match, kNode)) {
    const std::size_t node = std::stoul(match[1]);
    const std::string name = match[2];
    if (node >= pose.weights.size()) return out;
    if (name == "weights")
      out.weights = &pose.weights[node];
    else
      out.numbers = &(name == "rotation" ? pose.rotation : name == "scale" ? pose.scale : pose.translation)[node];
  } else if (std::regex_match(property, match, kCamera)) {
    const std::size_t camera = std::stoul(match[1]);
    const std::string name = match[2];
    if (camera >= pose.lenses.size()) return out;
    GltfLens& lens = pose.lenses[camera];
    out.number = name == "yfov"          ? &lens.yfov
                 : name == "aspectRatio" ? &lens.aspect_ratio
                 : name == "xmag"        ? &lens.xmag
                                         : &lens.ymag;
  }
  return out;
}

/// The properties that an animation moves. @param in_pose those of find_target(), or the others
std::vector<const GltfPointer*> pointers_of(const GltfDocument& document, const tinygltf::Animation* animation,
                                            bool in_pose) {
  GltfNodeValues any;
  for (auto* values : {&any.translation, &any.rotation, &any.scale}) values->resize(document.model->nodes.size());
  any.weights.resize(document.model->nodes.size());
  any.lenses.resize(document.model->cameras.size());
  std::vector<const GltfPointer*> out;
  for (const GltfPointer& pointer : document.pointers)
    if (animation == &document.model->animations[pointer.animation] &&
        static_cast<bool>(find_target(pointer.property, any)) == in_pose)
      out.push_back(&pointer);
  return out;
}

/// Whether a member of this name is a number or a vector, and no index.
bool is_quantity(const std::string& name) {
  static constexpr std::string_view kNames[] = {"color",
                                                "intensity",
                                                "range",
                                                "innerConeAngle",
                                                "outerConeAngle",
                                                "emissiveStrength",
                                                "alphaCutoff",
                                                "rotation",
                                                "scale",
                                                "weights",
                                                "visible",
                                                "ior",
                                                "dispersion",
                                                "attenuationDistance",
                                                "attenuationColor",
                                                "anisotropyStrength",
                                                "anisotropyRotation",
                                                "iridescenceIor",
                                                "iridescenceThicknessMinimum",
                                                "iridescenceThicknessMaximum",
                                                "offset",
                                                "strength"};
  return name.ends_with("Factor") || std::find(std::begin(kNames), std::end(kNames), name) != std::end(kNames);
}

/// The member that a pointer names, made if the file leaves it to its default; null if its object does not exist.
nlohmann::json* find_property(nlohmann::json& root, nlohmann::json::json_pointer pointer) {
  std::vector<std::string> missing;
  for (; !root.contains(pointer) && !pointer.empty(); pointer.pop_back()) missing.push_back(pointer.back());
  nlohmann::json* at = &root[pointer];
  // Members may be missing, but no elements of lists.
  if (!missing.empty() && !at->is_object()) return nullptr;
  for (const std::string& name : missing)
    if (name.find_first_not_of("0123456789") == name.npos) return nullptr;
  for (auto name = missing.rbegin(); name != missing.rend(); ++name) at = &(*at)[*name];
  return at;
}

/// The value of a property at a moment.
struct PointerValue {
  std::vector<float> value;
  bool is_number = false;  ///< of one component
};

PointerValue read_pointer(const GltfDocument& document, const tinygltf::Animation& animation,
                          const GltfPointer& pointer, double seconds) {
  const tinygltf::AnimationSampler& sampler = animation.samplers.at(pointer.sampler);
  const int type = document.model->accessors[static_cast<std::size_t>(sampler.output)].type;
  const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(type));
  const bool weights = pointer.property.ends_with("/weights");
  const bool rotation = pointer.property.ends_with("/rotation") && components == 4;
  const Keys keys = read_keys(document, sampler, components, weights ? 0 : static_cast<std::size_t>(components),
                              fmt::format("'{}'", pointer.property));
  return {value_of(keys, rotation, seconds), components == 1};
}

}  // namespace

bool moves_properties(const GltfDocument& document, const std::string& name) {
  return !pointers_of(document, find_animation(document, name, 0), false).empty();
}

bool animate_properties(const GltfDocument& document, const std::string& name, double seconds, nlohmann::json& root) {
  if (document.pointers.empty()) return false;
  const tinygltf::Animation* const animation = find_animation(document, name, seconds);
  const std::vector<const GltfPointer*> pointers = pointers_of(document, animation, false);
  for (const GltfPointer* pointer : pointers) {
    try {
      const nlohmann::json::json_pointer path(pointer->property);
      if (path.empty() || !is_quantity(path.back())) continue;
      const PointerValue moved = read_pointer(document, *animation, *pointer, seconds);
      nlohmann::json* const property = find_property(root, path);
      if (!property) continue;
      if (path.back() == "visible")
        *property = moved.value[0] != 0;
      else if (moved.is_number && path.back() != "weights")
        *property = moved.value[0];
      else
        *property = moved.value;
    } catch (const nlohmann::json::exception&) {
      throw Error({document.path}, fmt::format("an animation moves '{}', which is no JSON pointer", pointer->property),
                  "The file is damaged or invalid: export it again.");
    }
  }
  return !pointers.empty();
}

void animate(const GltfDocument& document, const std::string& name, double seconds, GltfNodeValues& out) {
  const tinygltf::Animation* const animation = find_animation(document, name, seconds);
  if (!animation) return;
  for (const tinygltf::AnimationChannel& channel : animation->channels) {
    if (channel.target_node < 0) continue;
    const auto node = static_cast<std::size_t>(channel.target_node);
    const tinygltf::AnimationSampler& sampler = animation->samplers[static_cast<std::size_t>(channel.sampler)];
    const std::string& path = channel.target_path;
    const bool is_weights = path == "weights", is_rotation = path == "rotation";
    if (!is_weights && !is_rotation && path != "translation" && path != "scale") continue;
    const int components = is_weights ? 1 : is_rotation ? 4 : 3;
    const Keys keys = read_keys(document, sampler, components, is_weights ? 0 : static_cast<std::size_t>(components),
                                fmt::format("node {}", node));
    const std::vector<float> value = value_of(keys, is_rotation, seconds);
    if (is_weights)
      out.weights[node] = value;
    else
      (is_rotation       ? out.rotation
       : path == "scale" ? out.scale
                         : out.translation)[node]
          .assign(value.begin(), value.end());
  }
  for (const GltfPointer* pointer : pointers_of(document, animation, true)) {
    const std::vector<float> value = read_pointer(document, *animation, *pointer, seconds).value;
    const PoseTarget target = find_target(pointer->property, out);
    if (target.weights) *target.weights = value;
    if (target.numbers) target.numbers->assign(value.begin(), value.end());
    if (target.number) *target.number = value[0];
  }
}

}  // namespace glowworm
