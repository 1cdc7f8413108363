// Progress of long work on standard error.
#pragma once
#include <chrono>
#include <string>

namespace glowworm {

/// A bar with the time left on a terminal; elsewhere a plain line every ten seconds.
class ProgressBar {
 public:
  /// @param shown false keeps it silent (-q)
  explicit ProgressBar(bool shown);
  /// @param share done, in [0, 1] @param label what is being done
  void update(double share, const std::string& label);
  /// Clears the bar from the terminal.
  void finish();

 private:
  bool shown_, terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point start_, last_;
};

/// The line of a bar that fits a terminal of so many columns; without the bar where there is no room.
/// @param left the time left, for people
std::string progress_line(double share, const std::string& label, const std::string& left, int columns);

/// "1:05", "2:03:09": a time in seconds for people.
std::string format_duration(double seconds);

}  // namespace glowworm
