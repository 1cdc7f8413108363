// The options of a render, one row for each: what the command line, views, statistics and the key of checkpoints know
// of RenderSettings. A new setting takes a member there and a row in options.cc.
#pragma once
#include <cstddef>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "render/settings.h"

namespace glowworm {

struct Option {
  const char* name;               ///< "--samples"; without dashes: a setting that no command line gives
  std::string group = "";         ///< heading in the help; empty: not on the command line
  const char* key = nullptr;      ///< in the settings of statistics and metadata
  std::string values = "";        ///< what to give, for the help: "N", "half|float"
  std::string standard = "";      ///< what holds where the option is not given, for the help
  const char* in_view = nullptr;  ///< the same for `glowworm view`; null: it has no such option
  std::string meaning = "";
  bool shows = false;  ///< changes bits of the samples, and so belongs to the key of a checkpoint
  /// The option, with its value, that keeps this one from having an effect; "" where it has one. Null: it always has.
  std::string (*overruled_by)(const RenderSettings&) = nullptr;
  bool is_list = false;  ///< given again, it adds to its list
  bool is_flag = false;  ///< takes no value

  /// Sets what the text says. Throws Error that names the option, the text and what is expected. Flags: "given" or "not
  /// given".
  std::function<void(RenderSettings&, const std::string&)> parse = nullptr;
  /// The text that parse() makes the same setting of.
  std::function<std::string(const RenderSettings&)> print = nullptr;
  /// Adds the setting to a JSON object; null: it is not in statistics.
  std::function<void(const RenderSettings&, nlohmann::json&)> report = nullptr;

  bool has_effect(const RenderSettings& settings) const { return !overruled_by || overruled_by(settings).empty(); }
  bool is_on_command_line() const { return !group.empty(); }
};

/// All options, in the order of the help.
const std::vector<Option>& render_options();

/// What to write on a command line so that an option has this value, as print() gives it: "--gather 4", "--preview", or
/// "no --preview" for a flag that is not to be given.
std::string command_line_text(const Option& option, const std::string& value);

/// Index of `text` among `names`. Throws Error that names `what` ("--engine"), lists the names, and says which of them
/// is near to the text.
std::size_t name_index(const std::string& what, const std::string& text, const std::vector<std::string>& names);

}  // namespace glowworm
