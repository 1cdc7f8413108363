// The commands of the program. Each reads its own options.
#pragma once
#include <string>

#include "core/error.h"

namespace CLI {
class App;
}

namespace glowworm {

/// A render ended by a signal exits with this plus the signal's number, as shells report it: 130 for Ctrl-C.
inline constexpr int kExitSignalled = 128;

/// Thrown for an invalid command line; ends the program with status 2.
class CommandLineError : public Error {
 public:
  using Error::Error;
};

/// Adds the command to the program. Its options are stored for the lifetime of the program. Running it throws Error on
/// failure, and sets `exit_status`.
/// @param command_line stored in the picture, as a record of how it was made
void add_render_command(CLI::App& program, const std::string& command_line, int& exit_status);
void add_measure_command(CLI::App& program, const std::string& command_line, int& exit_status);
void add_daylight_command(CLI::App& program, const std::string& command_line, int& exit_status);
void add_glare_command(CLI::App& program, const std::string& command_line, int& exit_status);
void add_merge_command(CLI::App& program, const std::string& command_line, int& exit_status);
void add_bake_command(CLI::App& program, const std::string& command_line, int& exit_status);
void add_info_command(CLI::App& program, const std::string& command_line);
void add_view_command(CLI::App& program, int& exit_status);
void add_compare_command(CLI::App& program, const std::string& command_line, int& exit_status);

}  // namespace glowworm
