#include "core/error.h"

#include <atomic>
#include <cstddef>
#include <string_view>

#include "core/option_names.h"

namespace glowworm {

namespace {
std::atomic<bool> has_dashes{false};

std::string join(const std::string& message, const std::string& remedy) {
  return with_option_names(remedy.empty() ? message : message + "\n  " + remedy);
}
}  // namespace

void name_options_with_dashes(bool with_dashes) { has_dashes = with_dashes; }

std::string with_option_names(const std::string& message) {
  if (has_dashes) return message;
  std::string out;
  for (std::size_t i = 0; i < message.size(); ++i) {
    const bool begins_word = i == 0 || std::string_view(" \n('\"").find(message[i - 1]) != std::string_view::npos;
    const bool is_option = begins_word && message.compare(i, 2, "--") == 0 && i + 2 < message.size() &&
                           message[i + 2] >= 'a' && message[i + 2] <= 'z';
    if (is_option) i += 2;
    out += message[i];
  }
  return out;
}

std::string to_string(const FilePlace& place) {
  std::string text = place.file;
  if (place.line > 0) {
    text += ":" + std::to_string(place.line);
    if (place.column > 0) text += ":" + std::to_string(place.column);
  }
  return text;
}

Error::Error(const std::string& message, const std::string& remedy, ErrorCode code)
    : std::runtime_error(join(message, remedy)), code_(code), place_(std::make_shared<const FilePlace>()) {}

Error::Error(const FilePlace& place, const std::string& message, const std::string& remedy, ErrorCode code)
    : std::runtime_error(to_string(place) + ": " + join(message, remedy)),
      code_(code),
      place_(std::make_shared<const FilePlace>(place)) {}

}  // namespace glowworm
