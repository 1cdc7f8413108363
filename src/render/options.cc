#include "render/options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "core/error.h"
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
constexpr Unit kNoUnits[] = {{"", 1}};
constexpr Unit kCountUnits[] = {{"", 1}, {"k", 1e3}, {"M", 1e6}};
constexpr Unit kTimeUnits[] = {{"", 1}, {"s", 1}, {"m", 60}, {"min", 60}, {"h", 3600}};
constexpr double kKiB = 1024, kMiB = 1024 * kKiB, kGiB = 1024 * kMiB, kTiB = 1024 * kGiB;
constexpr Unit kByteUnits[] = {{"", 1},     {"K", 1e3},    {"KB", 1e3},  {"KiB", kKiB}, {"M", 1e6},
                               {"MB", 1e6}, {"MiB", kMiB}, {"G", 1e9},   {"GB", 1e9},   {"GiB", kGiB},
                               {"T", 1e12}, {"TB", 1e12},  {"TiB", kTiB}};

/// A decimal number with one of the units behind it, times the unit's factor; not a number where it is none.
double parse_quantity(std::string_view text, std::span<const Unit> units) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
  if (error == std::errc())
    for (const Unit& known : units)
      if (unit == known.name) return value * known.factor;
  return std::numeric_limits<double>::quiet_NaN();
}

/// Single letters to insert, delete or replace that make one word of the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] != b[j]);
      diagonal = std::exchange(row[j + 1], std::min({replaced, row[j] + 1, row[j + 1] + 1}));
    }
  }
  return row.back();
}

/// Completes a row whose setting is one member: `read` makes its value of a text, `print` does the reverse, and
/// `report` makes what statistics say of it.
template <typename T, typename Read, typename Print, typename Report>
Option member(Option row, T RenderSettings::*field, Read read, Print print, Report report) {
  row.parse = [field, read](RenderSettings& s, const std::string& text) { s.*field = static_cast<T>(read(text)); };
  row.print = [field, print](const RenderSettings& s) -> std::string { return print(s.*field); };
  if (row.key)
    row.report = [field, report, key = row.key](const RenderSettings& s, json& out) { out[key] = report(s.*field); };
  return row;
}

constexpr auto kAsItIs = [](const auto& value) { return value; };

/// The values of a number.
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
  const auto name_of = [names](T value) { return names[static_cast<std::size_t>(value)]; };
  return member(
      row, field, [names, name = row.name](const std::string& text) { return name_index(name, text, names); }, name_of,
      name_of);
}

constexpr const char *kGiven = "given", *kNotGiven = "not given";

/// @param value of the setting where the flag is given
Option flag(Option row, bool RenderSettings::*field, bool value = true) {
  row.is_flag = true;
  const auto read = [value, name = row.name](const std::string& text) {
    return (name_index(name, text, {kNotGiven, kGiven}) == 1) == value;
  };
  const auto print = [value](bool set) { return set == value ? kGiven : kNotGiven; };
  return member(std::move(row), field, read, print, kAsItIs);
}

Option size_row(Option row) {
  row.parse = [name = row.name](RenderSettings& s, const std::string& text) {
    int width = 0, height = 0;
    const char* const end = text.data() + text.size();
    const auto x = std::from_chars(text.data(), end, width);
    const bool has_x = x.ec == std::errc() && x.ptr != end && *x.ptr == 'x';
    const auto y = std::from_chars(has_x ? x.ptr + 1 : end, end, height);
    const bool good = has_x && y.ec == std::errc() && y.ptr == end && std::min(width, height) > 0 &&
                      std::max(width, height) <= kLargestPictureSide;
    if (!good && text != "auto")
      throw Error(
          fmt::format("{} '{}' is not a size", name, text),
          fmt::format("Give WIDTHxHEIGHT in pixels, both from 1 to {}, for example 1280x720.", kLargestPictureSide));
    s.width = good ? width : 0;
    s.height = good ? height : 0;
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
  return s.progressive ? "--progressive, whose photons are those of one sample" : "";
}

std::string without_packets(const RenderSettings& s) {
  if (const std::string overruling = without_photons(s); !overruling.empty()) return overruling;
  return s.engine == "forward" ? "" : "--engine " + s.engine;
}

std::vector<Option> picture_options() {
  return {
      size_row({.name = "--size",
                .group = kPicture,
                .values = "WxH",
                .standard = "the scene's, or 512x512",
                .in_view = "the scene's, or 512x512",
                .meaning = "Pixels",
                .shows = true}),
      // Which camera shows in the picture by its place and lens, which the key holds a hash of.
      member({.name = "--camera",
              .group = kPicture,
              .key = "camera",
              .values = "NAME",
              .standard = "the first",
              .in_view = "the first",
              .meaning = "Camera of the scene; 'glowworm info SCENE' lists them"},
             &RenderSettings::camera, kAsItIs, kAsItIs, kAsItIs),
      aov_row({.name = "--aov",
               .group = kPicture,
               .key = "aovs",
               .values = "NAME,...",
               .meaning = fmt::format("Layers beside the image: {}", fmt::join(aov_names(), ",")),
               .is_list = true}),
  };
}

std::vector<Option> method_options() {
  using S = RenderSettings;
  Names engines = engine_names();
  engines.insert(engines.begin(), "auto");
  const auto engine = [engines](const std::string& text) { return engines[name_index("--engine", text, engines)]; };
  return {
      choice({.name = "--integrator",
              .group = kMethod,
              .key = "integrator",
              .standard = "photon",
              .meaning = "photon: photon mapping; path: path tracing, the reference; photons: the photon map shown "
                         "directly",
              .shows = true},
             &S::integrator, {"photon", "path", "photons"}),
      member({.name = "--engine",
              .group = kMethod,
              .key = "engine",
              .values = fmt::format("{}", fmt::join(engines, "|")),
              .standard = "auto",
              .in_view = "auto",
              .meaning = "Density engine, which looks photons up: auto is blocked, the fastest; brute is for tests of "
                         "tiny pictures",
              .shows = true,
              .overruled_by = without_photons},
             &S::engine, engine, kAsItIs, kAsItIs),
      choice({.name = "--kernel",
              .group = kMethod,
              .key = "kernel",
              .standard = "epanechnikov",
              .in_view = "epanechnikov",
              .meaning = "Kernel of density estimation",
              .shows = true,
              .overruled_by = without_photons},
             &S::kernel, kernel_names()),
      choice({.name = "--radius",
              .group = kMethod,
              .key = "radius",
              .standard = "per-photon",
              .meaning = "Radii of photons: one for each, from the density around it, or one for all",
              .shows = true,
              .overruled_by = without_photons},
             &S::fixed_radius, {"per-photon", "fixed"}),
      count({.name = "--reorder",
             .group = kMethod,
             .key = "reorder",
             .values = "N",
             .standard = "auto",
             .meaning = "Engine forward: query points of an octree's cell that is not divided further (auto: sorted as "
                        "far as it pays)",
             .overruled_by = without_packets},
            &S::reorder, 1u << 20),
      count({.name = "--seed",
             .group = kMethod,
             .key = "seed",
             .values = "N",
             .standard = "0",
             .in_view = "0",
             .meaning = "Seed of all random numbers: the same scene, settings and seed give the same image, bit for "
                        "bit, with the same version and instruction set (--simd, and the machine's for rays)",
             .shows = true},
            &S::seed, std::numeric_limits<std::uint32_t>::max(), "0"),
  };
}

std::vector<Option> method_flags() {
  using S = RenderSettings;
  return {
      flag({.name = "--indirect-only",
            .group = kMethod,
            .key = "indirect_only",
            .meaning = "Only light gathered from surfaces",
            .shows = true},
           &S::indirect_only),
      flag({.name = "--progressive",
            .group = kMethod,
            .key = "progressive",
            .meaning = "New photons and smaller radii in every pass: converges to the exact solution",
            .shows = true,
            .overruled_by = without_photons},
           &S::progressive),
      flag({.name = "--no-gather-guiding",
            .group = kMethod,
            .key = "gather_guiding",
            .meaning = "Do not aim gather rays at small bright places (for comparison)",
            .shows = true,
            .overruled_by = without_gathering},
           &S::gather_guiding, false),
      flag({.name = "--no-secondary-gather",
            .group = kMethod,
            .key = "secondary_gather",
            .meaning = "Do not gather a second time in corners (for comparison)",
            .shows = true,
            .overruled_by = without_gathering},
           &S::secondary_gather, false),
      flag({.name = "--no-guiding",
            .group = kMethod,
            .key = "guiding",
            .meaning = "Emit photons by the lights' power alone (for comparison)",
            .shows = true,
            .overruled_by = without_photons},
           &S::guiding, false),
  };
}

std::vector<Option> effort_options() {
  using S = RenderSettings;
  return {
      count({.name = "--samples",
             .group = kEffort,
             .key = "samples",
             .values = "N",
             .standard = "auto",
             .meaning = "Camera samples of each pixel"},
            &S::samples, 1u << 24),
      count({.name = "--gather",
             .group = kEffort,
             .key = "gather",
             .values = "N",
             .standard = "auto",
             .in_view = "16",
             .meaning = "Final gather rays of each camera sample; a pixel gets samples x gather",
             .shows = true,
             .overruled_by = without_gathering},
            &S::gather, 1u << 20),
      count({.name = "--photons",
             .group = kEffort,
             .key = "photons",
             .values = "N",
             .standard = "auto",
             .in_view = "500k",
             .meaning = "Photons in the map, for example 500k or 2M",
             .shows = true,
             .overruled_by = without_photons},
            &S::photons, 1u << 30),
      count({.name = "--traced",
             .group = kEffort,
             .key = "photons_traced",
             .values = "N",
             .standard = "auto",
             .meaning = "Photons to trace; if they are more than --photons, density control thins them to that",
             .shows = true,
             .overruled_by = without_photons},
            &S::photons_traced, 1u << 30),
      count({.name = "--nearest",
             .group = kEffort,
             .key = "nearest",
             .values = "N",
             .standard = "auto",
             .in_view = "50",
             .meaning = "Photons that an estimate should catch (k)",
             .shows = true,
             .overruled_by = without_photons},
            &S::nearest, 100'000),
      choice({.name = "--prefer",
              .group = kEffort,
              .key = "prefer",
              .standard = "auto",
              .meaning = "Refine the whole picture evenly (preview), or finish one tile after another (quality)",
              .overruled_by = without_large_passes},
             &S::preference, {"auto", "preview", "quality"}),
      number({.name = "--time",
              .group = kEffort,
              .key = "time_limit_s",
              .values = "TIME",
              .standard = "none",
              .meaning = "Stop after this time, for example 60s, 5m, 2h"},
             &S::time_limit_s, {"none", kTimeUnits, 1e-9, 1e9, false, "a time", "Give for example 60s, 5m or 2h."}),
      number({.name = "--noise",
              .group = kEffort,
              .key = "noise_target",
              .values = "SHARE",
              .standard = "none",
              .meaning = "Stop at this relative standard error of the image, for example 0.01"},
             &S::noise_target,
             {"none", kNoUnits, 1e-9, 1e9, false, "a share above 0", "Give for example 0.01, which is one percent."}),
  };
}

std::vector<Option> machine_options() {
  using S = RenderSettings;
  return {
      count({.name = "--threads",
             .group = kMachine,
             .values = "N",
             .standard = "one for each core",
             .in_view = "one for each core",
             .meaning = "Threads; the image does not depend on it"},
            &S::threads, 1024, "0"),
      number({.name = "--memory",
              .group = kMachine,
              .key = "memory_bytes",
              .values = "SIZE",
              .standard = "half of the machine's",
              .in_view = "half of the machine's",
              .meaning = "Memory that the scene may take, and that the render may take beside it; for example 800M, "
                         "4G. The image does not depend on it"},
             &S::memory_bytes,
             {"auto", kByteUnits, 1e6, 1e15, false, "a size", "Give at least 1M, for example 512M or 4G."}),
      choice({.name = "--disk",
              .group = kMachine,
              .key = "disk",
              .standard = "auto",
              .meaning = "Keep query points in a file (in TMPDIR) where memory is too small for fast look-ups; the "
                         "image does not depend on it"},
             &S::disk, {"auto", "never", "always"}),
  };
}

/// Settings that programs choose, not people.
std::vector<Option> inner_options() {
  using S = RenderSettings;
  return {
      flag({.name = "layers", .shows = true}, &S::separate_layers),
      choice({.name = "boundary correction", .shows = true, .overruled_by = without_photons}, &S::boundary_correction,
             {"off", "on"}),
      count({.name = "light samples", .key = "light_samples", .shows = true, .overruled_by = without_gathering},
            &S::light_samples, 1u << 20),
      count({.name = "most bounces", .shows = true}, &S::max_bounces, 1u << 20),
      choice({.name = "sampler", .shows = true}, &S::sampler, {"sobol", "independent"}),
  };
}

}  // namespace

const std::vector<Option>& render_options() {
  static const std::vector<Option> options = [] {
    std::vector<Option> all;
    for (auto* part : {picture_options, method_options, method_flags, effort_options, machine_options, inner_options}) {
      const std::vector<Option> rows = part();
      all.insert(all.end(), rows.begin(), rows.end());
    }
    return all;
  }();
  return options;
}

std::string command_line_text(const Option& option, const std::string& value) {
  if (!option.is_flag) return fmt::format("{} {}", option.name, value);
  return value == kGiven ? option.name : fmt::format("no {}", option.name);
}

std::size_t name_index(const std::string& what, const std::string& text, const Names& names) {
  const auto found = std::find(names.begin(), names.end(), text);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  constexpr std::size_t kMostMistakes = 2;
  std::string remedy;
  for (const std::string& name : names)
    if (remedy.empty() && text.size() > kMostMistakes && edit_distance(text, name) <= kMostMistakes)
      remedy = fmt::format("Did you mean '{}'? ", name);
  throw Error(fmt::format("{} '{}' is not known", what, text),
              fmt::format("{}Choose from: {}.", remedy, fmt::join(names, ", ")));
}

}  // namespace glowworm
