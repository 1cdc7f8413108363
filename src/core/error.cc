#include "core/error.h"

namespace glowworm {

namespace {
std::string join(const std::string& message, const std::string& remedy) {
  return remedy.empty() ? message : message + "\n  " + remedy;
}
}  // namespace

std::string to_string(const FilePlace& place) {
  std::string text = place.file;
  if (place.line > 0) {
    text += ":" + std::to_string(place.line);
    if (place.column > 0) text += ":" + std::to_string(place.column);
  }
  return text;
}

Error::Error(const std::string& message, const std::string& remedy) : std::runtime_error(join(message, remedy)) {}

Error::Error(const FilePlace& place, const std::string& message, const std::string& remedy)
    : std::runtime_error(join(to_string(place) + ": " + message, remedy)) {}

}  // namespace glowworm
