// The options of a render (render/options.h) on the command line.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "apps/commands.h"
#include "render/options.h"

namespace CLI {
class Option;
}

namespace glowworm {

/// What a command line says of the options in the table.
struct TableOptions {
  RenderSettings settings;
  std::vector<const Option*> given;
};

/// Adds an option that takes one of the names. Another word ends the program with status 2 and the nearest name.
CLI::Option* add_choice(CLI::App& command, const std::string& name, std::string& value,
                        const std::vector<std::string>& names, const std::string& meaning);

/// Adds an option that takes a number of [least, most]; others, infinity and "nan" end the program with status 2.
CLI::Option* add_number(CLI::App& command, const std::string& name, double& value, double least, double most,
                        const std::string& meaning);

/// Adds the options of a group of the table to a command.
/// @param view only those that `glowworm view` has
void add_table_options(CLI::App& command, const std::string& group, bool view, TableOptions& options);

/// Adds --exposure: stops, or "auto", which leaves it without a value.
void add_exposure_option(CLI::App& command, const std::string& group, std::optional<float>& exposure);

/// Runs `work`, which reads what the command line says; turns its Error into CommandLineError.
template <typename Work>
void read_command_line(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    throw CommandLineError(error.what());
  }
}

}  // namespace glowworm
