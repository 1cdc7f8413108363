#include "apps/table_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>

namespace glowworm {

namespace {

CLI::Option* add_option(CLI::App& command, const Option& option, TableOptions& options) {
  const auto take = [&options, &option](const std::string& text) {
    read_command_line([&] { option.parse(options.settings, text); });
    options.given.push_back(&option);
  };
  if (option.is_flag)
    return command.add_flag_callback(
        option.name, [take] { take("given"); }, option.meaning);
  return command.add_option_function<std::string>(option.name, take, option.meaning);
}

CLI::Option* add_row(CLI::App& command, const Option& option, const char* standard, TableOptions& options) {
  CLI::Option* added = add_option(command, option, options);
  if (option.is_list)
    added->join(',');
  else
    added->take_last();
  if (!option.is_flag) added->option_text(*standard ? fmt::format("{} [{}]", option.values, standard) : option.values);
  return added;
}

template <typename T>
CLI::Option* add_bounded(CLI::App& command, const std::string& name, T& value, T least, T most, const char* kind,
                         const std::string& meaning) {
  const auto take = [=, &value](const std::string& text) {
    T number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size() || !(number >= least && number <= most))
      throw CommandLineError(fmt::format("{} '{}' is not {} from {} to {}", name, text, kind, least, most));
    value = number;
  };
  return command.add_option_function<std::string>(name, take, meaning)->take_last();
}

}  // namespace

CLI::Option* add_choice(CLI::App& command, const std::string& name, std::string& value,
                        const std::vector<std::string>& names, const std::string& meaning) {
  const auto take = [&value, name, names](const std::string& text) {
    read_command_line([&] { value = names[name_index(name, text, names)]; });
  };
  return command.add_option_function<std::string>(name, take, meaning)
      ->take_last()
      ->option_text(fmt::format("{} [{}]", fmt::join(names, "|"), value));
}

CLI::Option* add_number(CLI::App& command, const std::string& name, double& value, double least, double most,
                        const std::string& meaning) {
  return add_bounded(command, name, value, least, most, "a number", meaning);
}

CLI::Option* add_number(CLI::App& command, const std::string& name, std::uint32_t& value, std::uint32_t least,
                        std::uint32_t most, const std::string& meaning) {
  return add_bounded(command, name, value, least, most, "a whole number", meaning);
}

void add_table_options(CLI::App& command, const std::string& group, bool view, TableOptions& options) {
  for (const Option& option : render_options()) {
    const char* standard = view ? option.in_view : option.standard.c_str();
    if (option.group != group || !standard) continue;
    add_row(command, option, standard, options)->group(group);
  }
}

void add_table_option(CLI::App& command, std::string_view name, TableOptions& options) {
  for (const Option& option : render_options())
    if (option.name == name) add_row(command, option, option.standard.c_str(), options);
}

void add_exposure_option(CLI::App& command, const std::string& group, std::optional<float>& exposure) {
  const auto read = [&exposure](const std::string& text) {
    float stops = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data() + text.starts_with('+'), end, stops);
    const bool good = error == std::errc() && rest == end && std::abs(stops) <= 100;
    if (!good && text != "auto")
      throw CommandLineError(Error(fmt::format("--exposure '{}' is not a number of stops", text),
                                   "Give 'auto' or a number from -100 to 100.")
                                 .what());
    exposure = good ? std::optional(stops) : std::nullopt;
  };
  command
      .add_option_function<std::string>(
          "--exposure", read, "Exposure in stops: +1 is twice as bright; auto suits the picture, and is printed")
      ->take_last()
      ->option_text("auto|STOPS [auto]")
      ->group(group);
}

}  // namespace glowworm
