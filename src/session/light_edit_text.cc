#include <fmt/format.h>

#include <charconv>
#include <string_view>

#include "core/error.h"
#include "session/light_rig.h"

namespace glowworm {

namespace {

[[noreturn]] void refuse(const std::string& text) {
  throw Error(fmt::format("'{}' does not say how a light differs", text),
              "Write NAME and what differs, for example 'lamp,off' or 'lamp,scale=2,move=0:1:0,turn=0:0.5:0' "
              "(metres; axis times radians).");
}

/// Parses numbers with colons between them; false if there are not exactly `count`.
bool read_numbers(std::string_view text, float* out, int count) {
  for (int i = 0; i < count; ++i) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out[i]);
    if (error != std::errc() || !std::isfinite(out[i])) return false;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (i + 1 == count) break;
    if (text.empty() || text[0] != ':') return false;
    text.remove_prefix(1);
  }
  return text.empty();
}

bool read_part(std::string_view part, LightEdit& edit) {
  float v[3];
  if (part == "off") {
    edit.on = false;
    return true;
  }
  if (part.starts_with("scale=")) return read_numbers(part.substr(6), &edit.scale, 1) && edit.scale >= 0;
  if (part.starts_with("move=") || part.starts_with("turn=")) {
    if (!read_numbers(part.substr(5), v, 3)) return false;
    (part[0] == 'm' ? edit.move : edit.turn) = {v[0], v[1], v[2]};
    return true;
  }
  return false;
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
