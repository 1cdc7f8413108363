#include "settings/render_key.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "core/content_hash.h"
#include "core/error.h"
#include "core/json_text.h"
#include "core/version.h"
#include "kernels/simd.h"
#include "scene/scene_hash.h"
#include "settings/options.h"
#include "trace/instruction_set.h"

namespace glowworm {

namespace {

using nlohmann::json;

constexpr const char* kVersion = "version";
constexpr const char* kKernels = "instruction set of the kernels";
constexpr const char* kRays = "instruction set of the rays";
constexpr const char* kGeometry = "geometry";
constexpr const char* kMaterialsOrTextures = "materials or textures";
constexpr const char* kLights = "lights";
constexpr const char* kCamera = "camera";
constexpr const char* kPoints = "points";
constexpr const char* kLayers = "layers";
constexpr const char* kFirstHits = "layers of first hits";
constexpr const char* kNoLayers = "none";
constexpr const char* kPixelBounds = "--pixel-bounds";
constexpr const char* kFirstSample = "first sample";
constexpr const char* kFrame = "frame";
constexpr const char* kSlicePhotons = "photons of the shutter's slice";
constexpr const char* kSamplesOfSlices = "samples of the shutter";
constexpr const char* kGuideCameras = "cameras of the sequence";

std::string hex(std::uint64_t value) { return fmt::format("{:016x}", value); }

constexpr const char* kUnknown = "unknown";

/// The value of a part of the key.
std::string value_of(const RenderKey& key, const std::string& name) {
  const auto found = std::find_if(key.begin(), key.end(), [&](const KeyPart& part) { return part.name == name; });
  return found == key.end() ? kUnknown : found->value;
}

/// The names of both keys, each once: those of `a` first.
std::vector<std::string> names_of_both(const RenderKey& a, const RenderKey& b) {
  std::vector<std::string> names;
  for (const RenderKey* key : {&a, &b})
    for (const KeyPart& part : *key)
      if (std::find(names.begin(), names.end(), part.name) == names.end()) names.push_back(part.name);
  return names;
}

bool is_of_scene(const std::string& name) {
  return name == kGeometry || name == kMaterialsOrTextures || name == kLights || name == kCamera || name == kPoints;
}

bool is_instruction_set(const std::string& name) { return name == kKernels || name == kRays; }

/// A name of the key as messages show it: with the option that gives its value.
std::string shown(const std::string& name) {
  if (name == kLayers) return "--aov";
  return name == kFirstHits ? fmt::format("--aov ({})", name) : name;
}

/// The command-line text for a value of the key; "" if no option gives it.
/// @param own the value of this render
std::string remedy_for(const std::string& name, const std::string& value, const std::string& own) {
  if (name == kFirstHits) return value == kNoLayers ? "--aov without " + own : "--aov " + value;
  if (name == kPhotonTarget && own == kNoPhotonTarget) return "--photons auto";
  for (const Option& option : render_options())
    if (option.is_on_command_line() && name == option.name && value != kUnknown)
      return command_line_text(option, value);
  return "";
}

std::uint64_t hash_points(const PointGrid& points) {
  ContentHash hash;
  hash.add(points.width);
  hash.add(points.height);
  hash.add(points.on_surfaces);
  hash.add(points.learns);
  hash.add(points.batches);
  for (const Vec3 p : points.position) hash.add(p);
  hash.add_array(std::span(points.position));
  hash.add_array(std::span(points.normal));
  hash.add_array(std::span(points.from_behind));
  return hash.value();
}

std::uint64_t hash_guide_cameras(const Scene& scene, const std::vector<std::string>& names) {
  ContentHash hash;
  for (const std::string& name : names) hash.add(hash_camera(scene.camera(name)));
  return hash.value();
}

std::string names_of(const PlaceLayers& layers) {
  std::string names;
  for (const auto& [kept, name] : {std::pair{layers.position, "position"},
                                   {layers.uv, "uv"},
                                   {layers.objects, "object-id"},
                                   {layers.materials, "material-id"},
                                   {layers.surface_samples, "surface samples"}})
    if (kept) names += names.empty() ? name : std::string(",") + name;
  for (std::size_t i = 0; i < kSlotValues; ++i)
    if (layers.values.has(i)) names += (names.empty() ? "" : ",") + std::string(kSlotValueNames[i]);
  return names.empty() ? kNoLayers : names;
}

[[noreturn]] void refuse_other_program(const std::string& kept, const std::string& what, const std::string& own,
                                       const std::string& other) {
  throw Error(fmt::format("{} belongs to another render: its {} is {}, but this render has {}", kept, what, other, own),
              what == kVersion ? "Continue with that version of the program, or remove the file to start again."
              : what == kKernels
                  ? fmt::format("Give --simd {} on a machine that has it, or remove the file to start again.", other)
                  : "Continue on the machine where it began, or one like it, or remove the file to start again.");
}

}  // namespace

RenderKey render_key(const Scene& scene, const RenderSettings& s, const PointGrid* points) {
  const SceneHash hash = hash_scene(scene, scene.camera(s.camera));
  RenderKey key = {{kVersion, version()},
                   {kKernels, simd_name()},
                   {kRays, ray_instruction_set()},
                   {kGeometry, hex(hash.geometry)},
                   {kMaterialsOrTextures, hex(hash.materials)},
                   {kLights, hex(hash.lights)},
                   {kCamera, hex(hash.camera)}};
  for (const Option& option : render_options())
    if (option.shows && option.has_effect(s)) key.push_back({option.name, option.print(s)});
  key.push_back({kFirstSample, std::to_string(s.sample_range().first)});
  key.push_back({kFirstHits, names_of(s.place_layers())});
  if (points) key.push_back({kPoints, hex(hash_points(*points))});
  if (s.photon_stream > 0) key.push_back({kSlicePhotons, std::to_string(s.photon_stream)});
  // Slices of time are shares of the samples.
  if (!s.slice.is_all()) key.push_back({kSamplesOfSlices, std::to_string(s.samples)});
  if (!s.guide_cameras.empty()) {
    key.push_back({kFrame, std::to_string(s.frame)});
    key.push_back({kGuideCameras, hex(hash_guide_cameras(scene, s.guide_cameras))});
  }
  // If time is short, the caustic map gets no passes of its own.
  if (s.integrator == Integrator::gather)
    key.push_back({"length of --time", has_time_for_caustics(s) ? "long or none" : "short"});
  return key;
}

std::string key_text(const RenderKey& key) {
  json out = json::array();
  for (const KeyPart& part : key) out.push_back({part.name, part.value});
  return json_text(out);
}

RenderKey parse_key(const std::string& text) {
  const json parsed = json::parse(text, nullptr, false);
  if (!parsed.is_array()) return {};
  RenderKey key;
  for (const json& part : parsed) {
    if (!part.is_array() || part.size() != 2 || !part[0].is_string() || !part[1].is_string()) return {};
    key.push_back({part[0].get<std::string>(), part[1].get<std::string>()});
  }
  return key;
}

void check_same_render(const RenderKey& own, const RenderKey& other, const std::string& kept) {
  // In another version the other parts may have another meaning.
  for (const char* what : {kVersion, kKernels, kRays})
    if (value_of(own, what) != value_of(other, what))
      refuse_other_program(kept, what, value_of(own, what), value_of(other, what));
  std::vector<std::string> parts, settings, remedy;
  for (const std::string& name : names_of_both(own, other)) {
    const std::string here = value_of(own, name), there = value_of(other, name);
    if (here == there) continue;
    if (name == kLayers)
      throw Error(fmt::format("{} is of a render {} --aov", kept, there == "given" ? "with" : "without"),
                  there == "given" ? "Give --aov with any of the layers, or remove the file to start again."
                                   : "Leave --aov out, or remove the file to start again: it holds no layers.");
    if (name == kFirstSample)
      throw Error(
          fmt::format("{} is of another part: it begins after {} samples, and this render after {}", kept, there, here),
          "Give the same --part again, or remove the file to start again.");
    if (name == kSamplesOfSlices && here != kUnknown && there != kUnknown)
      throw Error(fmt::format("{} is of a picture with motion blur and {} samples, not {}", kept, there, here),
                  "Give the same --samples again, or remove the file to start again.");
    if (is_of_scene(name)) {
      parts.push_back(name);
      continue;
    }
    settings.push_back(fmt::format("{} is {} there and {} here", shown(name), there, here));
    if (const std::string text = remedy_for(name, there, here); !text.empty()) remedy.push_back(text);
  }
  if (!parts.empty())
    throw Error(fmt::format("{} is of another scene: its {} differ", kept, fmt::join(parts, ", ")),
                "Give the scene as it was, with the same --camera, --view and --light, or remove the file to start "
                "again.");
  if (settings.empty()) return;
  throw Error(fmt::format("{} belongs to another render: {}", kept, fmt::join(settings, "; ")),
              remedy.empty() ? "Remove the file to start again."
                             : fmt::format("Give {}, or remove the file to start again.", fmt::join(remedy, " ")));
}

RenderKey key_of_whole(RenderKey key) {
  std::erase_if(key, [](const KeyPart& part) { return part.name == kFirstSample; });
  return key;
}

RenderKey key_of_photons(RenderKey key) {
  key = key_of_whole(std::move(key));
  const bool of_sequence = value_of(key, kGuideCameras) != kUnknown;
  std::erase_if(key, [&](const KeyPart& part) {
    return part.name == kPixelBounds || part.name == kFrame || (of_sequence && part.name == kCamera);
  });
  return key;
}

void check_same_whole(const KeyOfFile& a, const KeyOfFile& b, bool mixed) {
  const auto both = [&](const std::string& name) {
    return fmt::format("{} is {} in {} and {} in {}", shown(name), value_of(a.key, name), a.path, value_of(b.key, name),
                       b.path);
  };
  if (value_of(a.key, kVersion) != value_of(b.key, kVersion))
    throw Error(both(kVersion), "Render all parts by one version of the program.");
  std::vector<std::string> of_scene, settings;
  for (const std::string& name : names_of_both(a.key, b.key)) {
    if (value_of(a.key, name) == value_of(b.key, name)) continue;
    if (is_instruction_set(name)) {
      if (mixed) continue;
      throw Error("the " + both(name),
                  "Give --mixed to merge them all the same: other machines then may give other last bits.");
    }
    if (is_of_scene(name))
      of_scene.push_back(name);
    else
      settings.push_back(both(name));
  }
  if (!of_scene.empty())
    throw Error(
        fmt::format("{} and {} show different scenes: their {} differ", a.path, b.path, fmt::join(of_scene, ", ")),
        value_of(a.key, kPoints) == value_of(b.key, kPoints)
            ? "Merge parts of one scene, with the same --camera, --view and --light."
            : "Give the scene and --atlas, --texels-per-metre or --spacing as they were.");
  if (!settings.empty())
    throw Error(fmt::format("{}", fmt::join(settings, "; ")), "Merge parts that were rendered with the same options.");
}

RenderKey common_key(RenderKey a, const RenderKey& b) {
  for (KeyPart& part : a)
    if (is_instruction_set(part.name) && part.value != value_of(b, part.name)) part.value = "mixed";
  return a;
}

}  // namespace glowworm
