// What the library throws.
#pragma once
#include <stdexcept>
#include <string>

namespace glowworm {

/// A place in a file. line and column count from 1; 0 means that they are not known.
struct FilePlace {
  std::string file;
  int line = 0;
  int column = 0;
};

/// An error with a message for the user: what is wrong, where, and what to do about it.
class Error : public std::runtime_error {
 public:
  /// @param message what was found and what was expected
  /// @param remedy  what the user can do; may be empty
  explicit Error(const std::string& message, const std::string& remedy = "");
  /// As above, with the place of the error in front of the message.
  Error(const FilePlace& place, const std::string& message, const std::string& remedy = "");
};

/// Thrown by work that was cancelled.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled") {}
};

}  // namespace glowworm
