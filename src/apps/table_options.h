// The options of a render (render/options.h) on the command line.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/commands.h"
#include "render/options.h"

namespace CLI {
class Option;
}

namespace glowworm {

/// The options of the table, as given on the command line.
struct TableOptions {
  RenderSettings settings;
  std::vector<const Option*> given;
};

/// Adds an option whose value is one of `names`. Any other value ends the program with status 2 and suggests the
/// nearest name.
CLI::Option* add_choice(CLI::App& command, const std::string& name, std::string& value,
                        const std::vector<std::string>& names, const std::string& meaning);

/// Adds an option with a number in [least, most]. Other numbers, infinity and "nan" end the program with status 2.
CLI::Option* add_number(CLI::App& command, const std::string& name, double& value, double least, double most,
                        const std::string& meaning);
CLI::Option* add_number(CLI::App& command, const std::string& name, std::uint32_t& value, std::uint32_t least,
                        std::uint32_t most, const std::string& meaning);

/// Adds the options of one group of the table to a command.
/// @param view add only those that `glowworm view` has
void add_table_options(CLI::App& command, const std::string& group, bool view, TableOptions& options);

/// Adds one option of the table to a command.
void add_table_option(CLI::App& command, std::string_view name, TableOptions& options);

/// Adds --exposure: stops, or "auto", which leaves `exposure` empty.
void add_exposure_option(CLI::App& command, const std::string& group, std::optional<float>& exposure);

/// Runs `work`, which parses the command line, and converts its Error into CommandLineError.
template <typename Work>
void read_command_line(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    throw CommandLineError(error.what());
  }
}

}  // namespace glowworm
