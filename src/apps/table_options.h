// Options on the command line that several commands have, those of the table of renders (settings/options.h) among
// them.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "apps/commands.h"
#include "settings/options.h"

namespace CLI {
class Option;
}

namespace glowworm {

/// The options of the table, as given on the command line.
struct TableOptions {
  RenderSettings settings;
  std::vector<const Option*> given;
};

/// How much a command prints, and where it writes statistics.
struct ReportOptions {
  std::string statistics;  ///< file of --stats; empty: none
  bool verbose = false, quiet = false;

  /// Sets the level of the log.
  void apply() const;
};

/// Adds -v, -q and, if the command writes statistics, --stats.
void add_report_options(CLI::App& command, bool has_statistics, ReportOptions& options);

/// Adds an option with one text. The last one counts if it is given several times.
/// @param values placeholder in the help
CLI::Option* add_text(CLI::App& command, const std::string& group, const std::string& name, std::string& value,
                      const std::string& values, const std::string& meaning);
/// Adds an option whose every use adds a text to `values`.
CLI::Option* add_list(CLI::App& command, const std::string& group, const std::string& name,
                      std::vector<std::string>& values, const std::string& placeholder, const std::string& meaning);
/// Adds --light. @param meaning "" refers to `glowworm render`
void add_light_option(CLI::App& command, const std::string& group, std::vector<std::string>& lights,
                      const std::string& meaning = "");
/// Adds --simd.
void add_simd_option(CLI::App& command, const std::string& group, std::string& simd);

/// Adds an option whose value is one of `names`. Any other value ends the program with status 2 and suggests the
/// nearest name.
CLI::Option* add_choice(CLI::App& command, const std::string& name, std::string& value,
                        const std::vector<std::string>& names, const std::string& meaning);

/// Adds an option with a number in [least, most]: a double or a std::uint32_t. Other numbers, infinity and "nan" end
/// the program with status 2. @param values placeholder in the help
template <typename T>
CLI::Option* add_number(CLI::App& command, const std::string& group, const std::string& name, T& value,
                        std::type_identity_t<T> least, std::type_identity_t<T> most, const std::string& values,
                        const std::string& meaning);

/// Adds the options of one group of the table to a command.
/// @param which the command, as the table names it
void add_table_options(CLI::App& command, const std::string& group, Command which, TableOptions& options);

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
