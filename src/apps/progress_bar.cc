#include "apps/progress_bar.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/text.h"

namespace glowworm {

namespace {
constexpr int kMaxWidth = 40, kMinWidth = 8;  // width of the bar, columns
constexpr int kUsualColumns = 80;
constexpr double kPlainInterval = 10;  // seconds
using Clock = std::chrono::steady_clock;

/// A failed write to standard error must not end a render, so nothing is thrown.
void print(const std::string& text) { std::fputs(text.c_str(), stderr); }

/// Width of the terminal in columns.
int columns() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsualColumns;
}

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }
}  // namespace

std::string format_duration(double seconds) {
  const auto whole = static_cast<long>(std::llround(std::max(0.0, seconds)));
  if (whole >= 3600) return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

std::string progress_line(double share, const std::string& label, const std::string& left, int columns) {
  std::string text = fmt::format(" {:3.0f}%  {}  {}", 100 * share, label, left);
  // The last column stays free: some terminals start a new line after it.
  const int width = std::min(columns - 3 - static_cast<int>(text.size()), kMaxWidth);
  if (width < kMinWidth) return text.substr(1, static_cast<std::size_t>(std::max(columns - 1, 0)));
  const int full = static_cast<int>(std::clamp(share, 0.0, 1.0) * width);
  return fmt::format("[{}{}]{}", std::string(full, '='), std::string(width - full, ' '), text);
}

ProgressBar::ProgressBar(bool shown)
    : shown_(shown), terminal_(isatty(STDERR_FILENO) == 1), start_(Clock::now()), last_(start_) {}

void ProgressBar::update(double share, const std::string& named) {
  if (!shown_ || (!terminal_ && seconds_since(last_) < kPlainInterval)) return;
  last_ = Clock::now();
  const std::string label = printable(named);
  const double spent = seconds_since(start_);
  const std::string left = share > 0.005 ? format_duration(spent / share * (1 - share)) + " left" : "";
  if (!terminal_) {
    print(fmt::format("{:3.0f}%  {}  {} spent  {}\n", 100 * share, label, format_duration(spent), left));
    return;
  }
  print("\r\033[K" + progress_line(share, label, left, columns()));
  std::fflush(stderr);
  drawn_ = true;
}

void ProgressBar::finish() {
  if (drawn_) print("\r\033[K");
  drawn_ = false;
}

}  // namespace glowworm
