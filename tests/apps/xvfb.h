// A virtual screen.
#pragma once
#include <sys/types.h>

#include <string>

namespace glowworm {

/// An Xvfb of its own, with a screen of 1280 x 1024 pixels; ends with its scope.
class Xvfb {
 public:
  /// Throws std::runtime_error, which says what to install, where it cannot be started.
  Xvfb();
  ~Xvfb();
  Xvfb(const Xvfb&) = delete;
  Xvfb& operator=(const Xvfb&) = delete;

  /// For DISPLAY: ":7".
  const std::string& display() const { return display_; }
  /// Ends it now, as a crash of the X server would.
  void kill();

 private:
  pid_t process_ = -1;
  std::string display_;
};

}  // namespace glowworm
