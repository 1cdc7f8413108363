#include "apps/progress_bar.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace glowworm {

namespace {
constexpr int kWidth = 40;
constexpr double kPlainInterval = 10;  // seconds
using Clock = std::chrono::steady_clock;

/// A standard error that cannot be written to is no reason to end a render, so that nothing is thrown.
void print(const std::string& text) { std::fputs(text.c_str(), stderr); }

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }
}  // namespace

std::string format_duration(double seconds) {
  const auto whole = static_cast<long>(std::llround(std::max(0.0, seconds)));
  if (whole >= 3600) return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

ProgressBar::ProgressBar(bool shown)
    : shown_(shown), terminal_(isatty(STDERR_FILENO) == 1), start_(Clock::now()), last_(start_) {}

void ProgressBar::update(double share, const std::string& label) {
  if (!shown_ || (!terminal_ && seconds_since(last_) < kPlainInterval)) return;
  last_ = Clock::now();
  const double spent = seconds_since(start_);
  const std::string left = share > 0.005 ? format_duration(spent / share * (1 - share)) + " left" : "";
  if (!terminal_) {
    print(fmt::format("{:3.0f}%  {}  {} spent  {}\n", 100 * share, label, format_duration(spent), left));
    return;
  }
  const int full = static_cast<int>(std::clamp(share, 0.0, 1.0) * kWidth);
  print(fmt::format("\r\033[K[{}{}] {:3.0f}%  {}  {}", std::string(full, '='), std::string(kWidth - full, ' '),
                    100 * share, label, left));
  std::fflush(stderr);
  drawn_ = true;
}

void ProgressBar::finish() {
  if (drawn_) print("\r\033[K");
  drawn_ = false;
}

}  // namespace glowworm
