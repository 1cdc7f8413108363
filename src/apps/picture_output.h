// The pictures that commands write.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "image/image.h"

namespace CLI {
class App;
}

namespace glowworm {

/// Formats of a name after -o.
enum class OutputFormat { exr, png, part };

/// A file to write.
struct Output {
  std::string path;  ///< "-": standard output
  OutputFormat format = OutputFormat::exr;
};

/// How pictures are written.
struct PictureOptions {
  std::string tone = "filmic", precision = "half";
  std::optional<float> exposure;  ///< stops; none: chosen by the picture
};

/// The ending of a file's name in small letters.
std::string ending_of(const std::string& name);

/// The output that a name after -o describes. Throws CommandLineError for an unknown ending.
Output output_of(const std::string& name);

/// Adds --precision, --tone and --exposure to a command.
void add_picture_options(CLI::App& command, const std::string& group, PictureOptions& options);

/// Says which of these options have no effect on the formats of the outputs.
void warn_of_unused_formats(const PictureOptions& options, const std::vector<Output>& outputs);

/// Writes the picture as .exr or .png. Returns what to tell of it beside the name: ", exposure +1.0 stops (auto)", or
/// "". Throws Error where it cannot be written.
std::string write_picture(const Output& output, const Image& image, const PictureOptions& options);

}  // namespace glowworm
