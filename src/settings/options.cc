#include "settings/options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "core/error.h"
#include "core/text.h"
#include "kernels/kernel_shape.h"

namespace glowworm {

namespace {

using nlohmann::json;
using Names = std::vector<std::string>;

constexpr const char* kPicture = "Picture";
constexpr const char* kMethod = "Method";
constexpr const char* kEffort = "Effort";
constexpr const char* kMachine = "Machine";

struct Unit {
  std::string_view name;
  double factor;
};
constexpr Unit kShareUnits[] = {{"", 1}, {"%", 0.01}};
constexpr Unit kLengthUnits[] = {{"", 1}, {"m", 1}};
constexpr Unit kCountUnits[] = {{"", 1}, {"k", 1e3}, {"M", 1e6}};
constexpr Unit kTimeUnits[] = {{"", 1}, {"s", 1}, {"m", 60}, {"min", 60}, {"h", 3600}};
constexpr Unit kByteUnits[] = {{"", 1},     {"K", 1e3},      {"KB", 1e3},    {"KiB", 0x1p10}, {"M", 1e6},
                               {"MB", 1e6}, {"MiB", 0x1p20}, {"G", 1e9},     {"GB", 1e9},     {"GiB", 0x1p30},
                               {"T", 1e12}, {"TB", 1e12},    {"TiB", 0x1p40}};

/// A decimal number with an optional unit, times the unit's factor; NaN if the text is none.
double parse_quantity(std::string_view text, std::span<const Unit> units) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
  if (error == std::errc())
    for (const Unit& known : units)
      if (unit == known.name) return value * known.factor;
  return std::numeric_limits<double>::quiet_NaN();
}

/// Completes a row for a setting that is one member: `read` parses a text, `print` is the reverse, and `report` makes
/// the value for statistics.
template <typename T, typename Read, typename Print, typename Report>
Option member(Option row, T RenderSettings::*field, Read read, Print print, Report report) {
  row.parse = [field, read](RenderSettings& s, const std::string& text) { s.*field = static_cast<T>(read(text)); };
  row.print = [field, print](const RenderSettings& s) -> std::string { return print(s.*field); };
  if (row.key)
    row.report = [field, report, key = row.key](const RenderSettings& s, json& out) { out[key] = report(s.*field); };
  return row;
}

constexpr auto kAsItIs = [](const auto& value) { return value; };

/// The range and the names of a number.
struct Range {
  const char* zero;  ///< name of the value 0
  std::span<const Unit> units;
  double least, most;
  bool whole;
  std::string kind, remedy;  ///< for errors
};

template <typename T>
Option number(Option row, T RenderSettings::*field, const Range& range) {
  const auto read = [range, name = row.name](const std::string& text) {
    const double value = text == range.zero ? 0 : parse_quantity(text, range.units);
    const bool good = value >= range.least && value <= range.most && (!range.whole || value == std::floor(value));
    if (!good && text != range.zero)
      throw Error(fmt::format("{} '{}' is not {}", name, text, range.kind), range.remedy);
    return value;
  };
  const auto print = [zero = range.zero](T value) { return value == 0 ? zero : fmt::format("{}", value); };
  return member(std::move(row), field, read, print, kAsItIs);
}

template <typename T>
Option count(Option row, T RenderSettings::*field, std::uint64_t most, const char* zero = "auto") {
  return number(std::move(row), field,
                {zero, kCountUnits, 1, static_cast<double>(most), true, "a count",
                 fmt::format("Give '{}' or a whole number from 1 to {}; 2k is 2000 and 1.5M is 1500000.", zero, most)});
}

/// A row of an enumeration or a bool, whose values index the names.
template <typename T>
Option choice(Option row, T RenderSettings::*field, const Names& names) {
  if (row.values.empty()) row.values = fmt::format("{}", fmt::join(names, "|"));
  const auto name_of = [names](T value) {
    const auto index = static_cast<std::size_t>(value);
    return index < names.size() ? names[index] : fmt::format("{}", index);  // of a program that casts any number
  };
  return member(
      row, field, [names, name = row.name](const std::string& text) { return name_index(name, text, names); }, name_of,
      name_of);
}

constexpr const char *kGiven = "given", *kNotGiven = "not given";

/// @param value of the setting if the flag is given
Option flag(Option row, bool RenderSettings::*field, bool value = true) {
  row.is_flag = true;
  const auto read = [value, name = row.name](const std::string& text) {
    return (name_index(name, text, {kNotGiven, kGiven}) == 1) == value;
  };
  const auto print = [value](bool set) { return set == value ? kGiven : kNotGiven; };
  return member(std::move(row), field, read, print, kAsItIs);
}

Option radius_row(Option row) {
  static const Names names = {"per-photon", "fixed"};
  row.parse = [name = row.name](RenderSettings& s, const std::string& text) {
    const double metres = parse_quantity(text, kLengthUnits);
    s.fixed_radius = text != names[0];
    s.radius = metres > 0 && std::isfinite(static_cast<float>(metres)) ? static_cast<float>(metres) : 0;
    if (s.fixed_radius && text != names[1] && !(s.radius > 0))
      throw Error(fmt::format("{} '{}' is no radius", name, text),
                  "Give 'per-photon', 'fixed', or a length above 0 in metres, for example 0.05.");
  };
  row.print = [](const RenderSettings& s) {
    return s.radius > 0 ? fmt::format("{}", s.radius) : names[s.fixed_radius ? 1 : 0];
  };
  row.report = [](const RenderSettings& s, json& out) {
    if (s.radius > 0)
      out["radius"] = s.radius;
    else
      out["radius"] = names[s.fixed_radius ? 1 : 0];
  };
  return row;
}

Option size_row(Option row) {
  row.parse = [name = row.name](RenderSettings& s, const std::string& text) {
    const std::vector<int> sides = numbers_of<int>(text, 'x');
    const bool good =
        sides.size() == 2 && std::min(sides[0], sides[1]) > 0 && std::max(sides[0], sides[1]) <= kMaxPictureSide;
    if (!good && text != "auto")
      throw Error(
          fmt::format("{} '{}' is not a size", name, text),
          fmt::format("Give WIDTHxHEIGHT in pixels, both from 1 to {}, for example 1280x720.", kMaxPictureSide));
    s.width = good ? sides[0] : 0;
    s.height = good ? sides[1] : 0;
  };
  row.print = [](const RenderSettings& s) {
    return s.width == 0 && s.height == 0 ? "auto" : fmt::format("{}x{}", s.width, s.height);
  };
  row.report = [](const RenderSettings& s, json& out) {
    out["width"] = s.width;
    out["height"] = s.height;
  };
  return row;
}

template <typename T>
bool parse_four(std::string_view text, T (&out)[4]) {
  const std::vector<T> numbers = numbers_of<T>(text);
  if (numbers.size() != 4) return false;
  std::copy(numbers.begin(), numbers.end(), out);
  return out[0] < out[2] && out[1] < out[3] && out[0] >= 0 && out[1] >= 0;
}

Option crop_row(Option row) {
  const auto read = [name = row.name](const std::string& text) {
    double n[4] = {};
    if (text != "auto" && (!parse_four(text, n) || !(n[2] <= 1 && n[3] <= 1)))
      throw Error(fmt::format("{} '{}' is not a part of a picture", name, text),
                  "Give x0,y0,x1,y1 as fractions from 0 (left, top) to 1, for example 0.25,0,0.75,0.5.");
    return CropWindow{n[0], n[1], n[2], n[3]};
  };
  const auto print = [](const CropWindow& c) {
    return c.empty() ? "auto" : fmt::format("{},{},{},{}", c.x0, c.y0, c.x1, c.y1);
  };
  return member(std::move(row), &RenderSettings::crop, read, print, print);
}

Option pixel_bounds_row(Option row) {
  const auto read = [name = row.name](const std::string& text) {
    int n[4] = {};
    if (text != "auto" && !parse_four(text, n))
      throw Error(fmt::format("{} '{}' is not a rectangle of pixels", name, text),
                  "Give x0,y0,x1,y1 in pixels from the upper left corner; x1 and y1 are one past the last.");
    return PixelBounds{n[0], n[1], n[2], n[3]};
  };
  const auto print = [](const PixelBounds& b) {
    return b.empty() ? "auto" : fmt::format("{},{},{},{}", b.x0, b.y0, b.x1, b.y1);
  };
  const auto report = [](const PixelBounds& b) { return json{b.x0, b.y0, b.x1, b.y1}; };
  return member(std::move(row), &RenderSettings::bounds, read, print, report);
}

Option part_row(Option row) {
  const auto read = [name = row.name](const std::string& text) {
    const std::vector<std::uint32_t> part = numbers_of<std::uint32_t>(text, '/');
    const bool good = part.size() == 2 && part[0] >= 1 && part[0] <= part[1];
    if (!good && text != "all")
      throw Error(fmt::format("{} '{}' is not a part", name, text), "Give I/N with I from 1 to N, for example 3/8.");
    return good ? SampleShare{part[0], part[1]} : SampleShare();
  };
  const auto print = [](const SampleShare& p) { return p.is_all() ? "all" : fmt::format("{}/{}", p.index, p.count); };
  return member(std::move(row), &RenderSettings::part, read, print, print);
}

Option aov_row(Option row) {
  const auto read = [name = row.name](const std::string& text) {
    Names aovs;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find(',', at), text.size());
      aovs.push_back(aov_names()[name_index(name, text.substr(at, end - at), aov_names())]);
      at = end + 1;
    }
    return aovs;
  };
  return member(
      std::move(row), &RenderSettings::aovs, read,
      [](const Names& aovs) { return fmt::format("{}", fmt::join(aovs, ",")); }, kAsItIs);
}

std::string without_photons(const RenderSettings& s) {
  return s.integrator == Integrator::path ? "--integrator path" : "";
}

std::string without_gathering(const RenderSettings& s) {
  return s.integrator == Integrator::photons ? "--integrator photons" : without_photons(s);
}

std::string without_large_passes(const RenderSettings& s) {
  if (const std::string overruling = without_gathering(s); !overruling.empty()) return overruling;
  return s.progressive ? "--progressive, which uses new photons for each sample" : "";
}

std::string without_open_end(const RenderSettings& s) {
  if (const std::string overruling = without_large_passes(s); !overruling.empty()) return overruling;
  return is_adaptive(s) || !s.adaptive ? "" : fmt::format("--samples {}", s.samples);
}

std::string without_packets(const RenderSettings& s) {
  if (const std::string overruling = without_photons(s); !overruling.empty()) return overruling;
  return s.engine == "forward" ? "" : "--engine " + s.engine;
}

std::string without_density_control(const RenderSettings& s) {
  if (const std::string overruling = without_photons(s); !overruling.empty()) return overruling;
  return s.engine == "reverse" ? "" : "--engine " + s.engine;
}

std::string by_pixel_bounds(const RenderSettings& s) { return s.bounds.empty() ? "" : "--pixel-bounds"; }

Option of_commands(std::set<Command> commands, Option row) {
  row.commands = std::move(commands);
  return row;
}

/// The commands of a row that names none. @param group of the row
std::set<Command> commands_of(const std::string& group) {
  if (group == kPicture) return {Command::render};
  if (group == kMachine) return {Command::render, Command::bake, Command::measure, Command::merge};
  if (group.empty()) return {};
  return {Command::render, Command::bake, Command::measure};
}

// Rows: name, group, key, values, standard, in_view, meaning, shows, overruled_by.
std::vector<Option> picture_options() {
  return {
      size_row({"--size", kPicture, nullptr, "WxH", "the scene's, or 512 along the longer side",
                "the scene's, or 512 along the longer side", "Pixels", true}),
      crop_row({"--crop", kPicture, nullptr, "X0,Y0,X1,Y1", "the scene's, or all", nullptr,
                "Render a part of the picture, given by fractions of its width and height from the upper left corner",
                false, by_pixel_bounds}),
      pixel_bounds_row({"--pixel-bounds", kPicture, "pixel_bounds", "X0,Y0,X1,Y1", "by --crop", nullptr,
                        "The same in pixels; X1 and Y1 are one past the last", true}),
      // Which camera it is shows in the scene's hash, which is part of the key.
      member({"--camera", kPicture, "camera", "NAME", "the first", "the first",
              "Camera of the scene; 'glowworm info SCENE' lists them"},
             &RenderSettings::camera, kAsItIs, kAsItIs, kAsItIs),
      aov_row({"--aov", kPicture, "aovs", "NAME,...", "", nullptr,
               fmt::format("Layers beside the image: {}", fmt::join(aov_names(), ",")), false, nullptr, true}),
  };
}

std::vector<Option> method_options() {
  using S = RenderSettings;
  Names engines = engine_names();
  engines.insert(engines.begin(), "auto");
  const auto engine = [engines](const std::string& text) { return engines[name_index("--engine", text, engines)]; };
  return {
      choice({"--integrator", kMethod, "integrator", "", "gather", nullptr,
              "gather: photon mapping with final gathering; path: path tracing, the reference; photons: the photon "
              "map shown directly",
              true},
             &S::integrator, {"gather", "path", "photons"}),
      member({"--engine", kMethod, "engine", fmt::format("{}", fmt::join(engines, "|")), "auto", "auto",
              "Density engine, which looks photons up: auto is blocked, the fastest; brute is for tests of "
              "tiny pictures",
              true, without_photons},
             &S::engine, engine, kAsItIs, kAsItIs),
      choice({"--kernel", kMethod, "kernel", "", "epanechnikov", "epanechnikov", "Kernel of density estimation", true,
              without_photons},
             &S::kernel, kernel_names()),
      radius_row({"--radius", kMethod, "radius", "per-photon|fixed|M", "per-photon", nullptr,
                  "Radii of photons: one for each, from the density around it; one for all, for k photons in a mean "
                  "estimate; or one radius in metres",
                  true, without_photons}),
      count({"--reorder", kMethod, nullptr, "N", "auto", nullptr,
             "Engine forward: query points of an octree's cell that is not divided further (auto: sorted as "
             "far as it pays)",
             false, without_packets},
            &S::reorder, 1u << 20),
      of_commands({Command::render, Command::bake},
                  choice({"--filter", kMethod, "filter", "", "auto", "auto",
                          "Filter of gathered light: auto averages pixels whose difference is noise; off leaves all "
                          "samples as they are",
                          true, without_gathering},
                         &S::filter, {"auto", "off"})),
      count({"--seed", kMethod, "seed", "N", "0", "0",
             "Seed of all random numbers: the same scene, settings and seed give the same image, bit for "
             "bit, with the same version and instruction set",
             true},
            &S::seed, std::numeric_limits<std::uint32_t>::max(), "0"),
  };
}

std::vector<Option> method_flags() {
  using S = RenderSettings;
  return {
      flag({"--indirect-only", kMethod, "indirect_only", "", "", nullptr, "Only light gathered from surfaces", true},
           &S::indirect_only),
      flag({"--light-groups", kPicture, "light_groups", "", "", nullptr,
            "Add an EXR layer light.NAME for each named light, or lights of one name: its light alone, not filtered",
            true},
           &S::light_groups),
      flag({"--progressive", kMethod, "progressive", "", "", nullptr,
            "New photons and smaller radii in every pass: converges to the exact solution", true, without_photons},
           &S::progressive),
      flag({"--no-gather-guiding", kMethod, "gather_guiding", "", "", nullptr,
            "Do not aim gather rays where earlier rays found light (for comparison)", true, without_gathering},
           &S::gather_guiding, false),
      flag({"--no-adaptive", kEffort, "adaptive", "", "", nullptr,
            "The same samples for all pixels of a render that ends by time or noise (for comparison)", false,
            without_open_end},
           &S::adaptive, false),
      flag({"--no-secondary-gather", kMethod, "secondary_gather", "", "", nullptr,
            "No secondary gather where gather rays are shorter than the photons' radius (for comparison)", true,
            without_gathering},
           &S::secondary_gather, false),
      flag({"--no-guiding", kMethod, "guiding", "", "", nullptr,
            "Emit photons by the lights' power alone (for comparison)", true, without_photons},
           &S::guiding, false),
  };
}

std::vector<Option> effort_options() {
  using S = RenderSettings;
  return {
      count({"--samples", kEffort, "samples", "N", "auto", nullptr, "Camera samples of each pixel"}, &S::samples,
            1u << 24),
      of_commands({Command::render, Command::bake},
                  part_row({"--part", kEffort, nullptr, "I/N", "all", nullptr,
                            "Render the I-th of N shares of the samples; 'glowworm merge' makes the picture of all"})),
      member(
          {"--share", kEffort, nullptr, "DIR", "none", nullptr,
           "Folder that all processes of a render see. They split photon tracing, and reuse what others have "
           "finished. With --progressive, only the guides and the first pass of photons",
           false, without_photons},
          &S::share, [](const std::string& text) { return text == "none" ? "" : text; },
          [](const std::string& folder) { return folder.empty() ? "none" : folder; }, kAsItIs),
      count({"--gather", kEffort, "gather", "N", "auto", "16",
             "Final gather rays of each camera sample; a pixel gets samples x gather", true, without_gathering},
            &S::gather, 1u << 20),
      count({"--photons", kEffort, "photons", "N", "auto", "500k", "Photons in the map, for example 500k or 2M", true,
             without_photons},
            &S::photons, 1u << 30),
      count({"--thinned", kMethod, "thinned", "N", "none", nullptr,
             "Engine reverse: density control leaves N of the photons, fewer where they are dense", true,
             without_density_control},
            &S::thinned, 1u << 30, "none"),
      count({"--nearest", kEffort, "nearest", "N", "auto", "50", "Photons that an estimate should catch (k)", true,
             without_photons},
            &S::nearest, 100'000),
      choice({"--prefer", kEffort, "prefer", "", "auto", nullptr,
              "Refine the whole picture evenly (preview), or finish one tile after another (quality)", false,
              without_large_passes},
             &S::preference, {"auto", "preview", "quality"}),
      number({"--time", kEffort, "time_limit_s", "TIME", "none", nullptr,
              "End after this time, with all files written, for example 60s, 5m, 2h; loading the scene is not counted"},
             &S::time_limit_s, {"none", kTimeUnits, 1e-9, 1e9, false, "a time", "Give for example 60s, 5m or 2h."}),
      number({"--noise", kEffort, "noise_target", "SHARE", "none", nullptr,
              "Stop at this relative standard error of the image, for example 0.01 or 1%"},
             &S::noise_target,
             {"none", kShareUnits, 1e-9, 1e9, false, "a share above 0", "Give for example 0.01 or 1%."}),
  };
}

std::vector<Option> machine_options() {
  using S = RenderSettings;
  return {
      count({"--threads", kMachine, nullptr, "N", "one for each core", "one for each core",
             "Threads (default: cores, at most memory / 32M); the image does not depend on it"},
            &S::threads, 1024, "0"),
      of_commands(
          {Command::render, Command::bake, Command::measure, Command::merge, Command::compare},
          number({"--memory", kMachine, "memory_bytes", "SIZE", "half of the machine's", "half of the machine's",
                  "Memory that the scene may take, and that the render, or a comparison, may take beside it; for "
                  "example 800M, 4G. The image does not depend on it"},
                 &S::memory_bytes,
                 {"auto", kByteUnits, 1e6, 1e15, false, "a size", "Give at least 1M, for example 512M or 4G."})),
      choice({"--disk", kMachine, "disk", "", "auto", nullptr,
              "Keep image, photons and query points in files (in TMPDIR) where memory is too small for them, or for "
              "fast look-ups; the image does not depend on it"},
             &S::disk, {"auto", "never", "always"}),
  };
}

/// Settings that only programs choose; no command has them.
std::vector<Option> inner_options() {
  using S = RenderSettings;
  return {
      flag({"layers", "", nullptr, "", "", nullptr, "", true}, &S::separate_layers),
      choice({"boundary correction", "", nullptr, "", "", nullptr, "", true, without_photons}, &S::boundary_correction,
             {"off", "on"}),
      count({"light samples", "", "light_samples", "", "", nullptr, "", true, without_gathering}, &S::light_samples,
            1u << 20),
      number({kPhotonTarget, "", nullptr, "", "", nullptr, "", true}, &S::photon_target,
             {kNoPhotonTarget, kShareUnits, 1e-9, 1e9, false, "a share above 0", ""}),
      count({"most bounces", "", nullptr, "", "", nullptr, "", true}, &S::max_bounces, 1u << 20),
      choice({"sampler", "", nullptr, "", "", nullptr, "", true}, &S::sampler, {"sobol", "independent"}),
  };
}

}  // namespace

const std::vector<Option>& render_options() {
  static const std::vector<Option> options = [] {
    std::vector<Option> all;
    for (auto* part : {picture_options, method_options, method_flags, effort_options, machine_options, inner_options}) {
      for (const Option& row : part())
        all.push_back(row.commands.empty() ? of_commands(commands_of(row.group), row) : row);
    }
    return all;
  }();
  return options;
}

void check_settings(const RenderSettings& settings) {
  RenderSettings read;
  for (const Option& option : render_options()) option.parse(read, option.print(settings));
}

std::string command_line_text(const Option& option, const std::string& value) {
  if (!option.is_flag) return fmt::format("{} {}", option.name, value);
  return value == kGiven ? option.name : fmt::format("no {}", option.name);
}

double parse_count(std::string_view text) { return parse_quantity(text, kCountUnits); }

nlohmann::json settings_json(const RenderSettings& settings) {
  nlohmann::json out;
  for (const Option& option : render_options())
    if (option.report) option.report(settings, out);
  return out;
}

bool parse_rectangle(std::string_view text, int (&out)[4]) { return parse_four(text, out); }
bool parse_rectangle(std::string_view text, double (&out)[4]) { return parse_four(text, out); }

}  // namespace glowworm
