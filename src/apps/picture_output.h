// The pictures that commands write.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "image/color_view.h"
#include "image/false_color.h"
#include "image/image.h"
#include "settings/settings.h"

namespace CLI {
class App;
}

namespace glowworm {

/// Formats of a name after -o.
enum class OutputFormat { exr, hdr, png, part };

/// A file to write.
struct Output {
  std::string path;  ///< "-": standard output
  OutputFormat format = OutputFormat::exr;
};

/// The view of a colour config that PNG files and windows show.
struct ColorViewOptions {
  ColorViewRequest request;               ///< of --ocio, --display and --view-transform; an empty config: none
  std::shared_ptr<const ColorView> view;  ///< what load() loads, or null

  /// Loads the view if one is asked for. Throws Error as load_color_view() does.
  void load();
};

/// How pictures are written.
struct PictureOptions {
  ColorViewOptions color;
  std::string tone = "filmic", precision = "half";
  std::optional<float> exposure;          ///< stops; none: chosen by the picture
  std::optional<ColorScale> false_color;  ///< cd/m^2 or lx, for PNG files in false colour
  bool illuminance = false;               ///< these show illuminance, not luminance
};

/// The output that a name after -o describes. Throws CommandLineError for an unknown ending.
Output output_of(const std::string& name);

/// Throws CommandLineError where a part cannot be written: if the number of samples depends on time or noise.
/// @param name after -o
void check_part_output(const std::string& name, const RenderSettings& asked);

/// Adds --false-color to a command: "auto", which leaves the scale at 0, or "LOW,HIGH".
/// @param illuminance set by "lux" or "lux:LOW,HIGH"; null: these are no values
void add_false_color_option(CLI::App& command, const std::string& group, const std::string& meaning,
                            std::optional<ColorScale>& scale, bool* illuminance = nullptr);

/// Adds the layers that illuminance_of() needs, if they are not there.
void add_layers_of_illuminance(std::vector<std::string>& aovs);

/// Adds --tone, --ocio, --display and --view-transform to a command. @param tone meaning of --tone
void add_tone_options(CLI::App& command, const std::string& group, const std::string& meaning, std::string& tone,
                      ColorViewOptions& color);

/// Adds --precision, the options of tone, --exposure and --false-color to a command.
void add_picture_options(CLI::App& command, const std::string& group, PictureOptions& options);

/// Says which of these options have no effect on the formats of the outputs.
void warn_of_unused_formats(const PictureOptions& options, const std::vector<Output>& outputs);

/// Writes the picture as .exr, .hdr or .png. Returns what to say of it beside the name, such as
/// ", exposure +1.0 stops (auto)", or "". Throws Error where it cannot be written.
std::string write_picture(const Output& output, const Image& image, const PictureOptions& options);

}  // namespace glowworm
