#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/input_file.h"
#include "core/text.h"
#include "session/script.h"

namespace glowworm {

namespace {

using nlohmann::json;

constexpr std::uint32_t kMaxFrames = 10'000'000;

/// Reads the values of one JSON object, and names its place in errors.
class Entry {
 public:
  Entry(const json& object, std::string place, const std::vector<std::string>& keys)
      : object_(object), place_(std::move(place)) {
    if (!object.is_object()) fail("is not an object", "");
    for (const auto& [key, value] : object.items())
      if (std::find(keys.begin(), keys.end(), key) == keys.end())
        fail(fmt::format("has a key \"{}\"", key), fmt::format("The keys are: {}.", fmt::join(keys, ", ")));
  }

  bool has(const char* key) const { return object_.contains(key); }
  const json& at(const char* key) const { return object_.at(key); }

  std::optional<std::string> text(const char* key) const {
    if (!has(key)) return std::nullopt;
    if (!at(key).is_string()) fail(fmt::format("\"{}\" is not a text", key), "");
    return at(key).get<std::string>();
  }
  std::optional<bool> flag(const char* key) const {
    if (!has(key)) return std::nullopt;
    if (!at(key).is_boolean()) fail(fmt::format("\"{}\" is neither true nor false", key), "");
    return at(key).get<bool>();
  }
  std::optional<float> number(const char* key) const {
    if (!has(key)) return std::nullopt;
    return checked(at(key), key);
  }
  std::optional<std::uint32_t> count(const char* key, std::uint32_t least, std::uint32_t most) const {
    if (!has(key)) return std::nullopt;
    const json& value = at(key);
    if (!value.is_number() || value.get<double>() < least || value.get<double>() > most ||
        value.get<double>() != std::floor(value.get<double>()))
      fail(fmt::format("\"{}\" is not a whole number from {} to {}", key, least, most), "");
    return static_cast<std::uint32_t>(value.get<double>());
  }
  /// The numbers of an array of that length; nothing if the key is absent.
  template <int kCount>
  std::optional<std::array<float, kCount>> numbers(const char* key) const {
    if (!has(key)) return std::nullopt;
    const json& value = at(key);
    if (!value.is_array() || value.size() != kCount) fail(fmt::format("\"{}\" is not [{} numbers]", key, kCount), "");
    std::array<float, kCount> out;
    for (std::size_t i = 0; i < kCount; ++i) out[i] = checked(value[i], key);
    return out;
  }
  Vec2 pair(const char* key) const {
    const auto v = numbers<2>(key);
    return v ? Vec2{(*v)[0], (*v)[1]} : Vec2{0, 0};
  }
  Vec3 triple(const char* key) const {
    const auto v = numbers<3>(key);
    return v ? Vec3{(*v)[0], (*v)[1], (*v)[2]} : Vec3{0, 0, 0};
  }

  [[noreturn]] void fail(const std::string& what, const std::string& remedy) const {
    throw Error(place_ + " " + what, remedy);
  }

 private:
  float checked(const json& value, const char* key) const {
    if (!value.is_number() || !std::isfinite(value.get<float>())) fail(fmt::format("\"{}\" is not a number", key), "");
    return value.get<float>();
  }

  const json& object_;
  std::string place_;
};

ScriptLight read_light(const Entry& move, const std::string& place) {
  const Entry entry(move.at("light"), place + ", \"light\"",
                    {"name", "on", "scale", "move", "turn", "azimuth", "elevation"});
  ScriptLight light;
  const auto name = entry.text("name");
  if (!name) entry.fail("has no \"name\"", "'glowworm info SCENE' and the viewer list the lights.");
  light.name = *name;
  light.on = entry.flag("on");
  light.scale = entry.number("scale");
  if (light.scale && *light.scale < 0) entry.fail("\"scale\" is negative", "");
  light.move = entry.triple("move");
  light.turn = entry.triple("turn");
  light.azimuth = entry.number("azimuth");
  light.elevation = entry.number("elevation");
  return light;
}

WindowAction read_window(const Entry& entry) {
  static const std::vector<std::string> commands = {"minimise", "restore", "close", "lose-context"};
  WindowAction action;
  if (entry.has("resize")) {
    const Vec2 size = entry.pair("resize");
    action.command = "resize";
    action.width = static_cast<int>(std::clamp(size.x, 0.0f, 16384.0f));
    action.height = static_cast<int>(std::clamp(size.y, 0.0f, 16384.0f));
    return action;
  }
  action.command = *entry.text("window");
  if (std::find(commands.begin(), commands.end(), action.command) == commands.end())
    entry.fail(fmt::format("there is no window command \"{}\"", action.command),
               fmt::format("The commands are: {}.", fmt::join(commands, ", ")));
  return action;
}

/// The file of a screenshot. Scripts may come from others, so they name no other files than pictures of the session.
std::string read_screenshot(const Entry& entry, const std::string& name) {
  const std::filesystem::path path(name);
  const std::string ending = lower_ending(name);
  const bool leaves = path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end();
  if (leaves || (ending != ".png" && ending != ".exr") || name.find('\0') != std::string::npos)
    entry.fail(fmt::format("\"screenshot\": '{}' is not the name of a .png or .exr file in the output folder", name),
               "Leave out '/' at its start and '..'.");
  return name;
}

ScriptMove read_move(const json& object, const std::string& place) {
  const Entry entry(object, place, {"at",     "from",    "to",         "orbit",  "look",   "fly",
                                    "focus",  "camera",  "mode",       "part",   "engine", "kernel",
                                    "gather", "nearest", "photons",    "filter", "reuse",  "secondary_gather",
                                    "light",  "seconds", "screenshot", "drop",   "resize", "window"});
  ScriptMove move;
  if (entry.has("at")) {
    move.from = *entry.count("at", 0, kMaxFrames);
    move.to = move.from + 1;
  } else {
    move.from = entry.count("from", 0, kMaxFrames).value_or(0);
    move.to = entry.count("to", 1, kMaxFrames).value_or(move.from + 1);
  }
  if (move.to <= move.from) entry.fail("ends before it begins", "\"to\" is the frame behind the last.");
  move.orbit = entry.pair("orbit");
  move.look = entry.pair("look");
  move.fly = entry.triple("fly");
  move.seconds = entry.number("seconds").value_or(0);
  if (entry.has("focus")) move.focus = entry.pair("focus");
  move.camera = entry.text("camera");
  move.mode = entry.text("mode");
  move.part = entry.text("part");
  move.engine = entry.text("engine");
  move.kernel = entry.text("kernel");
  move.gather = entry.count("gather", 1, 1u << 16);
  move.nearest = entry.count("nearest", 1, 100'000);
  move.photons = entry.count("photons", 1, 1u << 30);
  move.filter = entry.flag("filter");
  move.reuse = entry.flag("reuse");
  move.secondary_gather = entry.flag("secondary_gather");
  if (entry.has("light")) move.light = read_light(entry, place);
  if (const auto name = entry.text("screenshot")) move.screenshot = read_screenshot(entry, *name);
  move.drop = entry.text("drop");
  if (entry.has("resize") || entry.has("window")) move.window = read_window(entry);
  return move;
}

}  // namespace

Script parse_script(const std::string& text, const std::string& name) {
  json root;
  try {
    root = json::parse(text);
  } catch (const json::exception& error) {
    throw Error(FilePlace{name}, error.what(), "A script is a JSON object; docs/guide.md has an example.");
  }
  const Entry entry(root, name, {"frames", "fps", "size", "moves"});
  Script script;
  script.frames = entry.count("frames", 1, kMaxFrames).value_or(0);
  script.frames_per_second = entry.number("fps").value_or(30);
  if (!(script.frames_per_second > 0)) entry.fail("\"fps\" is not above 0", "");
  if (entry.has("size")) {
    const auto size = *entry.numbers<2>("size");
    if (!(size[0] >= 1 && size[1] >= 1 && size[0] <= 16384 && size[1] <= 16384))
      entry.fail("\"size\" is not from [1, 1] to [16384, 16384]", "");
    script.width = static_cast<int>(size[0]);
    script.height = static_cast<int>(size[1]);
  }
  if (entry.has("moves")) {
    if (!entry.at("moves").is_array()) entry.fail("\"moves\" is not an array", "");
    for (std::size_t i = 0; i < entry.at("moves").size(); ++i)
      script.moves.push_back(read_move(entry.at("moves")[i], fmt::format("{}: move {}", name, i + 1)));
    for (std::size_t i = 0; i < script.moves.size(); ++i)
      if (script.frames > 0 && script.moves[i].to > script.frames)
        throw Error(fmt::format("{}: move {}: ends at frame {}, and the script has {} frames", name, i + 1,
                                script.moves[i].to, script.frames),
                    "Give \"frames\" that hold all moves; --frames plays fewer.");
  }
  return script;
}

Script read_script(const std::string& path) { return parse_script(read_input_file(path), path); }

}  // namespace glowworm
