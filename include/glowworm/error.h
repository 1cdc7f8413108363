// What the library throws.
#pragma once
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

namespace glowworm {

/// A place in a file. line and column count from 1; 0 means that they are not known.
struct FilePlace {
  std::string file;
  int line = 0;
  int column = 0;
};

/// What is wrong.
enum class ErrorCode : std::uint8_t {
  invalid,  ///< a setting, an argument or a scene makes no sense
  file,     ///< a file is missing, damaged or not supported, or cannot be written; Error::place() names it
  memory,   ///< the memory budget or the machine's memory is too small
};

// The shared library exports these types, so that its callers can catch them.
#pragma GCC visibility push(default)

/// An error with a message for the user: what is wrong, where, and what to do about it.
class Error : public std::runtime_error {
 public:
  /// @param message what was found and what was expected
  /// @param remedy  what the user can do; may be empty
  explicit Error(const std::string& message, const std::string& remedy = "", ErrorCode code = ErrorCode::invalid);
  /// As above, with the place of the error in front of the message.
  Error(const FilePlace& place, const std::string& message, const std::string& remedy = "",
        ErrorCode code = ErrorCode::file);

  ErrorCode code() const noexcept { return code_; }
  /// The place in a file; without a file if the error has none.
  const FilePlace& place() const noexcept { return *place_; }

 private:
  ErrorCode code_;
  std::shared_ptr<const FilePlace> place_;  // shared: copies of an exception must not throw
};

/// Thrown by work that was cancelled.
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled") {}
};

#pragma GCC visibility pop

}  // namespace glowworm

namespace glowworm::api {

using glowworm::Cancelled;
using glowworm::Error;
using glowworm::ErrorCode;
using glowworm::FilePlace;

}  // namespace glowworm::api
