// The options of a render, one row for each. The rows serve the command line, views, statistics and the key of
// checkpoints. A new setting takes a member of RenderSettings and a row in options.cc.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/names.h"
#include "settings/settings.h"

namespace glowworm {

/// Commands of the program that take options of the table.
enum class Command { render, bake, measure, merge, compare, view };

struct Option {
  const char* name;               ///< "--samples"; without dashes: not on the command line
  std::string group = "";         ///< heading in the help; empty: not on the command line
  const char* key = nullptr;      ///< in the settings of statistics and metadata
  std::string values = "";        ///< placeholder in the help: "N", "half|float"
  std::string standard = "";      ///< default value in the help
  const char* in_view = nullptr;  ///< default of `glowworm view`; null: it has no such option
  std::string meaning = "";
  bool shows = false;  ///< changes bits of the samples; part of the key of a checkpoint
  /// The option, with its value, that disables this one; "" if none does. Null: it always has an effect.
  std::string (*overruled_by)(const RenderSettings&) = nullptr;
  bool is_list = false;             ///< may be repeated; each use adds to its list
  bool is_flag = false;             ///< takes no value
  std::set<Command> commands = {};  ///< that have the option, besides view (in_view)

  /// Parses the text. Throws Error that names the option, the text and what is expected.
  /// Flags: "given" or "not given".
  std::function<void(RenderSettings&, const std::string&)> parse = nullptr;
  /// The text that parse() turns into the same setting.
  std::function<std::string(const RenderSettings&)> print = nullptr;
  /// Adds the setting to a JSON object; null: not in statistics.
  std::function<void(const RenderSettings&, nlohmann::json&)> report = nullptr;

  bool has_effect(const RenderSettings& settings) const { return !overruled_by || overruled_by(settings).empty(); }
  bool is_on_command_line() const { return !group.empty(); }
  bool is_of(Command command) const {
    return command == Command::view ? in_view != nullptr : commands.contains(command);
  }
};

/// Name of the option of RenderSettings::photon_target, which no command has.
inline constexpr const char *kPhotonTarget = "error for which photons are chosen", *kNoPhotonTarget = "none";

/// Throws Error, with the option and what it takes, if a setting has a value that the option's text cannot give: a
/// program may have set it.
void check_settings(const RenderSettings& settings);

/// All options, in the order of the help.
const std::vector<Option>& render_options();

/// The command-line text that gives an option this value, as print() formats it: "--gather 4", "--preview", or "no
/// --preview" for a flag that must be absent.
std::string command_line_text(const Option& option, const std::string& value);

/// A number as options of the table take it, with the units of counts: "10000", "1e4", "10k", "1.5M". NaN if the text
/// is none.
double parse_count(std::string_view text);

/// The settings that statistics report, by Option::report.
nlohmann::json settings_json(const RenderSettings& settings);

/// Reads x0,y0,x1,y1 with x0 < x1 and y0 < y1, all at least 0. Returns whether the text is that.
bool parse_rectangle(std::string_view text, int (&out)[4]);
bool parse_rectangle(std::string_view text, double (&out)[4]);

}  // namespace glowworm
