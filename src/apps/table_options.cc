#include "apps/table_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

namespace glowworm {

namespace {

CLI::Option* add_table_option(CLI::App& command, const Option& option, TableOptions& options) {
  const auto take = [&options, &option](const std::string& text) {
    read_command_line([&] { option.parse(options.settings, text); });
    options.given.push_back(&option);
  };
  if (option.is_flag)
    return command.add_flag_callback(
        option.name, [take] { take("given"); }, option.meaning);
  return command.add_option_function<std::string>(option.name, take, option.meaning);
}

}  // namespace

void add_table_options(CLI::App& command, const std::string& group, bool view, TableOptions& options) {
  for (const Option& option : render_options()) {
    const char* standard = view ? option.in_view : option.standard.c_str();
    if (option.group != group || !standard) continue;
    CLI::Option* added = add_table_option(command, option, options)->group(group);
    if (option.is_list) added->join(',');
    if (!option.is_flag)
      added->option_text(*standard ? fmt::format("{} [{}]", option.values, standard) : option.values);
  }
}

}  // namespace glowworm
