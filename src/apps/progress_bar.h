// Progress of long work on standard error.
#pragma once
#include <chrono>
#include <string>

namespace glowworm {

/// On a terminal, a bar with the time left; otherwise a plain line every ten seconds.
class ProgressBar {
 public:
  /// @param shown false: print nothing (-q)
  explicit ProgressBar(bool shown);
  /// @param share completed share, in [0, 1] @param label the current work
  void update(double share, const std::string& label);
  /// Clears the bar from the terminal.
  void finish();

 private:
  bool shown_, terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point start_, last_;
};

/// The progress line for a terminal of `columns` columns; it omits the bar if there is no room.
/// @param left the time left, formatted
std::string progress_line(double share, const std::string& label, const std::string& left, int columns);

/// Formats a time in seconds as "1:05" or "2:03:09".
std::string format_duration(double seconds);

}  // namespace glowworm
