// Messages on standard error, and texts on standard output. All leave out what would command a terminal: they may hold
// names from files (core/text.h, printable()).
#pragma once
#include <string_view>

namespace glowworm {

enum class LogLevel { quiet, normal, verbose };

/// Sets the amount of output: quiet prints only warnings, verbose adds detail(). All functions here are thread-safe.
void set_log_level(LogLevel level);

/// Prints a message of a normal run.
void inform(std::string_view message);
/// Prints a message only with -v.
void detail(std::string_view message);
/// Prints a warning, also with -q: what was corrected or left out, and what that means for the image.
void warn(std::string_view message);
/// Prints the error that ends the program, also with -q.
void report_error(std::string_view message);

/// Writes text to standard output.
void write_output(std::string_view text);

}  // namespace glowworm
