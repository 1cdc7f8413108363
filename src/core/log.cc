#include "core/log.h"

#include <atomic>
#include <cstdio>
#include <mutex>

namespace glowworm {

namespace {
std::atomic<LogLevel> current_level{LogLevel::normal};
std::mutex output_mutex;

void print(std::string_view prefix, std::string_view message) {
  const std::lock_guard lock(output_mutex);
  std::fprintf(stderr, "%.*s%.*s\n", static_cast<int>(prefix.size()), prefix.data(), static_cast<int>(message.size()),
               message.data());
}
}  // namespace

void set_log_level(LogLevel level) { current_level = level; }

void inform(std::string_view message) {
  if (current_level != LogLevel::quiet) print("", message);
}
void detail(std::string_view message) {
  if (current_level == LogLevel::verbose) print("", message);
}
void warn(std::string_view message) { print("warning: ", message); }

}  // namespace glowworm
