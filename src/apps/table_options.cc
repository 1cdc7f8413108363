#include "apps/table_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <string_view>

#include "core/log.h"
#include "core/text.h"
#include "kernels/simd.h"

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

CLI::Option* add_row(CLI::App& command, const Option& option, const std::string& standard, TableOptions& options) {
  CLI::Option* added = add_option(command, option, options);
  if (option.is_list)
    added->join(',');
  else
    added->take_last();
  if (!option.is_flag)
    added->option_text(!standard.empty() ? fmt::format("{} [{}]", option.values, standard) : option.values);
  return added;
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

template <typename T>
CLI::Option* add_number(CLI::App& command, const std::string& group, const std::string& name, T& value,
                        std::type_identity_t<T> least, std::type_identity_t<T> most, const std::string& values,
                        const std::string& meaning) {
  constexpr bool kWhole = std::is_integral_v<T>;
  const auto take = [=, &value](const std::string& text) {
    const double number = parse_count(text);
    if (!(number >= least && number <= most) || (kWhole && number != std::floor(number)))
      throw CommandLineError(fmt::format("{} '{}' is not {} from {} to {}", name, text,
                                         kWhole ? "a whole number" : "a number", least, most));
    value = static_cast<T>(number);
  };
  return command.add_option_function<std::string>(name, take, meaning)->take_last()->option_text(values)->group(group);
}
template CLI::Option* add_number(CLI::App&, const std::string&, const std::string&, double&, double, double,
                                 const std::string&, const std::string&);
template CLI::Option* add_number(CLI::App&, const std::string&, const std::string&, std::uint32_t&, std::uint32_t,
                                 std::uint32_t, const std::string&, const std::string&);

void add_table_options(CLI::App& command, const std::string& group, Command which, TableOptions& options) {
  for (const Option& option : render_options())
    if (option.group == group && option.is_of(which))
      add_row(command, option, which == Command::view ? option.in_view : option.standard, options)->group(group);
}

void ReportOptions::apply() const {
  set_log_level(quiet ? LogLevel::quiet : verbose ? LogLevel::verbose : LogLevel::normal);
}

void add_report_options(CLI::App& command, bool has_statistics, ReportOptions& options) {
  if (has_statistics)
    add_text(command, "Reports", "--stats", options.statistics, "FILE",
             "Write counts, times and settings as JSON; docs/guide.md has the keys");
  command
      .add_flag("-v,--verbose", options.verbose,
                "Also print automatic choices and, for renders, the time of each phase")
      ->group("Reports");
  command.add_flag("-q,--quiet", options.quiet, "Print only warnings and errors")->group("Reports");
}

CLI::Option* add_text(CLI::App& command, const std::string& group, const std::string& name, std::string& value,
                      const std::string& values, const std::string& meaning) {
  return command.add_option(name, value, meaning)->take_last()->option_text(values)->group(group);
}

CLI::Option* add_list(CLI::App& command, const std::string& group, const std::string& name,
                      std::vector<std::string>& values, const std::string& placeholder, const std::string& meaning) {
  return command.add_option(name, values, meaning)->allow_extra_args(false)->option_text(placeholder)->group(group);
}

void add_light_option(CLI::App& command, const std::string& group, std::vector<std::string>& lights,
                      const std::string& meaning) {
  add_list(command, group, "--light", lights, "NAME,CHANGE,...|FILE@X,Y,Z[,DX,DY,DZ[,TURN]][,CHANGE,...]",
           meaning.empty() ? "Change a light, or add a luminaire, as 'glowworm render' does" : meaning);
}

void add_simd_option(CLI::App& command, const std::string& group, std::string& simd) {
  add_text(command, group, "--simd", simd, fmt::format("auto|{} [auto]", fmt::join(simd_names(), "|")),
           "Instruction set of the kernels");
}

void add_exposure_option(CLI::App& command, const std::string& group, std::optional<float>& exposure) {
  const auto read = [&exposure](const std::string& text) {
    const std::vector<float> stops = numbers_of<float>(std::string_view(text).substr(text.starts_with('+')));
    const bool good = stops.size() == 1 && std::abs(stops[0]) <= 100;
    if (!good && text != "auto")
      throw CommandLineError(Error(fmt::format("--exposure '{}' is not a number of stops", text),
                                   "Give 'auto' or a number from -100 to 100.")
                                 .what());
    exposure = good ? std::optional(stops[0]) : std::nullopt;
  };
  command
      .add_option_function<std::string>(
          "--exposure", read, "Exposure in stops: +1 is twice as bright; auto suits the picture, and is printed")
      ->take_last()
      ->option_text("auto|STOPS [auto]")
      ->group(group);
}

}  // namespace glowworm
