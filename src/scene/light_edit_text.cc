#include <fmt/format.h>

#include <string_view>

#include "core/error.h"
#include "core/text.h"
#include "scene/light_rig.h"

namespace glowworm {

namespace {

[[noreturn]] void refuse(const std::string& text) {
  throw Error(fmt::format("'{}' does not say how a light differs", text),
              "Write NAME and what differs, for example 'lamp,off' or 'lamp,scale=2,move=0:1:0,turn=0:0.5:0' "
              "(metres; axis times radians).");
}

bool read_part(std::string_view part, LightEdit& edit) {
  if (part == "off") {
    edit.on = false;
    return true;
  }
  const std::vector<float> v = numbers_of<float>(part.substr(part.find('=') + 1), ':');
  if (part.starts_with("scale=") && v.size() == 1) {
    edit.scale = v[0];
    return edit.scale >= 0;
  }
  if (v.size() != 3 || !(part.starts_with("move=") || part.starts_with("turn="))) return false;
  (part[0] == 'm' ? edit.move : edit.turn) = {v[0], v[1], v[2]};
  return true;
}

}  // namespace

std::string light_edit_text(const std::string& name, const LightEdit& edit) {
  std::string text = name;
  if (!edit.on) text += ",off";
  if (edit.scale != 1) text += fmt::format(",scale={}", edit.scale);
  if (length_squared(edit.move) > 0) text += fmt::format(",move={}:{}:{}", edit.move.x, edit.move.y, edit.move.z);
  if (length_squared(edit.turn) > 0) text += fmt::format(",turn={}:{}:{}", edit.turn.x, edit.turn.y, edit.turn.z);
  return text;
}

std::pair<std::string, LightEdit> parse_light_edit(const std::string& text) {
  LightEdit edit;
  std::string_view rest = text;
  // Names may contain commas, so the edit is at the end.
  bool any = false;
  for (std::size_t comma; (comma = rest.rfind(',')) != std::string_view::npos;) {
    if (!read_part(rest.substr(comma + 1), edit)) break;
    rest = rest.substr(0, comma);
    any = true;
  }
  if (!any || rest.empty()) refuse(text);
  return {std::string(rest), edit};
}

}  // namespace glowworm
