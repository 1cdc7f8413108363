// The commands of the program; each reads its own options.
#pragma once
#include <string>

#include "core/error.h"

namespace CLI {
class App;
}

namespace glowworm {

/// Exit status of a render that a signal ended is this and the signal's number, as shells count: 130 for Ctrl-C.
inline constexpr int kExitSignalled = 128;

/// Thrown for a command line that makes no sense, which ends the program with status 2.
class CommandLineError : public Error {
 public:
  using Error::Error;
};

/// Adds the command to the program. Its options are parsed into storage that lives as long as the program; running it
/// throws Error where it fails, and sets `exit_status`.
/// @param command_line what the picture keeps of how it was made
void add_render_command(CLI::App& program, const std::string& command_line, int& exit_status);
void add_info_command(CLI::App& program);
void add_view_command(CLI::App& program, int& exit_status);
void add_compare_command(CLI::App& program, int& exit_status);

}  // namespace glowworm
