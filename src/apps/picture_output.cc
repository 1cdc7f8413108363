#include "apps/picture_output.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string_view>

#include "apps/commands.h"
#include "apps/table_options.h"
#include "core/atomic_file.h"
#include "core/log.h"
#include "core/text.h"

namespace glowworm {

Output output_of(const std::string& name) {
  if (name == kStandardOutput || name == "exr:-") return {std::string(kStandardOutput), OutputFormat::exr};
  if (name == "png:-") return {std::string(kStandardOutput), OutputFormat::png};
  const std::string ending = lower_ending(name);
  if (ending == ".exr") return {name, OutputFormat::exr};
  if (ending == ".hdr") return {name, OutputFormat::hdr};
  if (ending == ".png") return {name, OutputFormat::png};
  if (ending == ".part") return {name, OutputFormat::part};
  throw CommandLineError(fmt::format("'{}' ends neither in .exr nor in .hdr or .png", name),
                         "Give -o a name with one of these endings, .part for a part of a picture, or exr:- or png:- "
                         "for standard output.");
}

void check_part_output(const std::string& name, const RenderSettings& asked) {
  if (asked.noise_target > 0 || (asked.time_limit_s > 0 && asked.samples == 0))
    throw CommandLineError(
        fmt::format("-o {}: a part has a number of samples that does not depend on time or noise", name),
        "Give --samples, and no --noise.");
}

void add_false_color_option(CLI::App& command, const std::string& group, const std::string& meaning,
                            std::optional<ColorScale>& scale, bool* illuminance) {
  const auto read = [&scale, illuminance](const std::string& text) {
    constexpr std::string_view kLux = "lux:";
    std::string_view range = text;
    if (illuminance) *illuminance = text == "lux" || text.starts_with(kLux);
    if (illuminance && *illuminance) range = text == "lux" ? "auto" : range.substr(kLux.size());
    const std::vector<float> ends = numbers_of<float>(range);
    const bool good = ends.size() == 2 && ends[0] > 0 && ends[1] > ends[0];
    if (!good && range != "auto")
      throw CommandLineError(fmt::format("--false-color '{}' is not a scale", text),
                             fmt::format("Give 'auto' or two positive numbers LOW,HIGH{}.",
                                         illuminance ? ", or 'lux' or 'lux:LOW,HIGH' for illuminance" : ""));
    scale = good ? ColorScale{ends[0], ends[1]} : ColorScale();
  };
  command.add_option_function<std::string>("--false-color", read, meaning)
      ->take_last()
      ->option_text(illuminance ? "auto|LOW,HIGH|lux[:LOW,HIGH]" : "auto|LOW,HIGH")
      ->group(group);
}

void ColorViewOptions::load() {
  if (!request.config.empty()) view = load_color_view(request);
}

void add_tone_options(CLI::App& command, const std::string& group, const std::string& meaning, std::string& tone,
                      ColorViewOptions& color) {
  CLI::Option* const curve = add_choice(command, "--tone", tone, {"filmic", "srgb"}, meaning)->group(group);
  CLI::Option* const config =
      add_text(command, group, "--ocio", color.request.config, "CONFIG",
               "Show light by a view of this OpenColorIO config instead. Pixels enter it by its role aces_interchange, "
               "or by scene_linear, which is then expected to have the primaries of Rec. 709");
  config->excludes(curve);
  add_text(command, group, "--display", color.request.display, "NAME [the config's]", "Display of --ocio")
      ->needs(config);
  add_text(command, group, "--view-transform", color.request.view, "NAME [the display's]",
           "View of --ocio; an unknown one lists those of the display")
      ->needs(config);
}

void add_picture_options(CLI::App& command, const std::string& group, PictureOptions& options) {
  add_choice(command, "--precision", options.precision, {"half", "float"}, "Precision of the EXR file")->group(group);
  add_tone_options(command, group, "Tone curve of the PNG file", options.tone, options.color);
  add_exposure_option(command, group, options.exposure);
  add_false_color_option(
      command, group,
      "PNG files show luminance (cd/m^2) in false colour from LOW to HIGH, with legend and isolines; "
      "or the illuminance of diffuse surfaces (lx)",
      options.false_color, &options.illuminance);
}

void warn_of_unused_formats(const PictureOptions& options, const std::vector<Output>& outputs) {
  const auto any = [&](OutputFormat format) {
    return std::any_of(outputs.begin(), outputs.end(), [&](const Output& output) { return output.format == format; });
  };
  if (!any(OutputFormat::exr) && options.precision != "half") warn("--precision has no effect: no -o is an EXR file");
  if (any(OutputFormat::png)) {
    if (options.false_color && options.color.view) warn("--ocio has no effect: PNG files are in false colour");
    return;
  }
  if (options.exposure.has_value()) warn("--exposure has no effect: no -o is a PNG file");
  if (options.tone != "filmic") warn("--tone has no effect: no -o is a PNG file");
  if (options.color.view) warn("--ocio has no effect: no -o is a PNG file");
  if (options.false_color) warn("--false-color has no effect: no -o is a PNG file");
}

void add_layers_of_illuminance(std::vector<std::string>& aovs) {
  for (const char* name : kLayersOfIlluminance)
    if (std::find(aovs.begin(), aovs.end(), name) == aovs.end()) aovs.emplace_back(name);
}

namespace {

std::vector<float> luminance_of(const Image& image) {
  std::vector<float> values;
  for (const RGB& pixel : image.rgb()) values.push_back(kLuminousEfficacy * luminance(pixel));
  return values;
}

/// Writes the luminance or the illuminance of a picture in false colour. Returns what to say of the scale.
std::string write_false_color(const std::string& path, const Image& image, ColorScale scale, bool illuminance) {
  const std::vector<float> values = illuminance ? illuminance_of(image) : luminance_of(image);
  const char* const unit = illuminance ? "lx" : "cd/m^2";
  const bool chosen = scale.high == 0;
  if (chosen) scale = fitting_scale(values);
  Image plot = false_color_plot(values, image.width(), image.height(), scale, unit);
  plot.metadata = image.metadata;
  write_png(path, plot, ToneCurve::srgb);
  return chosen ? fmt::format(", {:.3g} to {:.3g} {} (auto)", scale.low, scale.high, unit) : "";
}

}  // namespace

std::string write_picture(const Output& output, const Image& image, const PictureOptions& options) {
  if (output.format == OutputFormat::exr) {
    write_exr(output.path, image, options.precision == "float" ? ExrPrecision::single : ExrPrecision::half);
    return "";
  }
  if (output.format == OutputFormat::hdr) {
    write_hdr(output.path, image);
    return "";
  }
  if (options.false_color) return write_false_color(output.path, image, *options.false_color, options.illuminance);
  const float exposure = options.exposure ? *options.exposure : automatic_exposure(image.rgb());
  if (options.color.view)
    write_png(output.path, image, *options.color.view, exposure);
  else
    write_png(output.path, image, options.tone == "srgb" ? ToneCurve::srgb : ToneCurve::filmic, exposure);
  const std::string shown = options.color.view ? fmt::format(", {}", options.color.view->name()) : "";
  return options.exposure ? shown : fmt::format("{}, exposure {:+.1f} stops (auto)", shown, exposure);
}

}  // namespace glowworm
