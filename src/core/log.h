// Messages on standard error.
#pragma once
#include <string>
#include <string_view>

namespace glowworm {

enum class LogLevel { quiet, normal, verbose };

/// Sets how much is printed: quiet keeps warnings only, verbose adds detail(). Thread-safe, as all functions here.
void set_log_level(LogLevel level);

/// Something the person should know of a normal run.
void inform(std::string_view message);
/// Something for -v only.
void detail(std::string_view message);
/// Something that was mended or left out, with what that means for the image. Printed even with -q.
void warn(std::string_view message);

}  // namespace glowworm
