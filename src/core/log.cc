#include "core/log.h"

#include <atomic>
#include <cstdio>
#include <mutex>

#include "core/option_names.h"
#include "core/text.h"

namespace glowworm {

namespace {
std::atomic<LogLevel> current_level{LogLevel::normal};
std::mutex output_mutex;

void print(std::string_view prefix, std::string_view message) {
  const std::string shown = printable(with_option_names(std::string(message)));
  const std::lock_guard lock(output_mutex);
  std::fprintf(stderr, "%.*s%s\n", static_cast<int>(prefix.size()), prefix.data(), shown.c_str());
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
void report_error(std::string_view message) { print("glowworm: error: ", message); }

void write_output(std::string_view text) {
  const std::string shown = printable(text);
  std::fwrite(shown.data(), 1, shown.size(), stdout);
}

}  // namespace glowworm
