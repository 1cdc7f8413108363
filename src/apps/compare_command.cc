#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/commands.h"
#include "apps/output_files.h"
#include "apps/picture_output.h"
#include "apps/table_options.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/log.h"
#include "core/memory_budget.h"
#include "core/text.h"
#include "image/html_page.h"
#include "image/image.h"
#include "image/metrics.h"
#include "image/picture_memory.h"
#include "settings/settings.h"

namespace glowworm {

namespace {

struct CompareOptions {
  std::string command_line, image, reference, difference, page, layer, region;
  double leave_out = 0, limit = std::numeric_limits<double>::infinity();
  bool json = false;
  TableOptions table;
};

void print_json(const ImageComparison& c) {
  // JSON has no infinity: infinite numbers become null.
  nlohmann::json out = {{"mse", c.mse},
                        {"relative_mse", c.relative_mse},
                        {"relative_rmse", c.relative_rmse},
                        {"psnr_db", c.psnr},
                        {"mean_ratio", {{"luminance", c.luminance_ratio}, {"rgb", c.mean_ratio}}},
                        {"largest_difference", c.largest_difference},
                        {"pixels", c.pixels},
                        {"pixels_not_finite", c.non_finite_pixels}};
  fmt::print("{}\n", out.dump(2));
}

void print_text(const ImageComparison& c) {
  fmt::print("MSE        {:.6g}\n", c.mse);
  fmt::print("relMSE     {:.6g}\n", c.relative_mse);
  fmt::print("relRMSE    {:.6g}\n", c.relative_rmse);
  fmt::print("PSNR       {:.4g} dB\n", c.psnr);
  fmt::print("mean ratio {:.6g} (red {:.6g}, green {:.6g}, blue {:.6g})\n", c.luminance_ratio, c.mean_ratio[0],
             c.mean_ratio[1], c.mean_ratio[2]);
  fmt::print("largest    {:.6g}\n", c.largest_difference);
  if (c.non_finite_pixels > 0) fmt::print("not finite {} pixels\n", c.non_finite_pixels);
}

/// Crops both pictures to --region, or to their common part.
void cut_both(const CompareOptions& o, Image& image, Image& reference) {
  if (o.region.empty()) return cut_to_common_part(image, reference);
  int n[4] = {};
  if (!parse_rectangle(o.region, n))
    throw CommandLineError(fmt::format("--region '{}' is not a rectangle of pixels", o.region),
                           "Give x0,y0,x1,y1 from the upper left corner; x1 and y1 are one past the last.");
  read_command_line([&] {
    image = cut(image, n[0], n[1], n[2], n[3]);
    reference = cut(reference, n[0], n[1], n[2], n[3]);
  });
}

/// Adds a file that is written.
void prepare_output(const std::string& option, const std::string& path, const std::string& ending, OutputFiles& files) {
  if (path.empty()) return;
  if (lower_ending(path) != ending)
    throw CommandLineError(fmt::format("'{}' does not end in {}", path, ending),
                           fmt::format("Give {} a name with this ending.", option));
  files.add(option, path);
}

int run_compare(const CompareOptions& o) {
  OutputFiles files;
  files.add_input("the image", o.image);
  files.add_input("the reference", o.reference);
  prepare_output("-o", o.difference, ".png", files);
  prepare_output("--html", o.page, ".html", files);
  files.probe_all();
  const std::uint64_t memory = o.table.settings.memory_bytes;
  MemoryBudget budget(memory > 0 ? memory : default_memory_bytes(), "Give a larger --memory, or reduce the pictures.");
  Reservation held(budget, "pictures", 0);
  Image image = read_image(o.image, held), reference = read_image(o.reference, held);
  // Of both, the layers that are compared.
  held.grow(image.pixel_count() * (kComparisonBytes + 2 * sizeof(RGB)));
  read_command_line([&] {
    image = layer_of(image, o.layer);
    reference = layer_of(reference, o.layer);
  });
  const auto is_exposed = [](const std::string& path) {
    return lower_ending(path) == ".png" || lower_ending(path) == ".jpg";
  };
  if (is_exposed(o.image) != is_exposed(o.reference))
    warn("one picture was exposed for display (.png, .jpg), the other not: compare two .exr files");
  cut_both(o, image, reference);
  const ImageComparison c = compare_images(image, reference, o.leave_out);
  if (!o.difference.empty()) write_png(o.difference, difference_picture(image, reference), ToneCurve::srgb);
  if (!o.page.empty()) write_file(o.page, compare_page(image, reference, c, o.command_line));
  o.json ? print_json(c) : print_text(c);
  // Means exclude pixels that are not finite, but a picture with such pixels does not match its reference.
  if (std::isinf(o.limit) || (c.relative_rmse <= o.limit && c.non_finite_pixels == 0)) return 0;
  warn(c.non_finite_pixels > 0 ? fmt::format("{} pixels are not finite", c.non_finite_pixels)
                               : fmt::format("relRMSE {:.6g} exceeds --limit {:g}", c.relative_rmse, o.limit));
  return 1;
}

}  // namespace

void add_compare_command(CLI::App& program, const std::string& command_line, int& exit_status) {
  auto options = std::make_shared<CompareOptions>();
  options->command_line = command_line;
  CLI::App* c = program.add_subcommand("compare", "Measures the difference between a picture and a reference.");
  c->add_option("image", options->image, "The picture: any file that OpenImageIO reads")
      ->required()
      ->option_text("IMAGE");
  c->add_option("reference", options->reference, "The reference, of the same size")
      ->required()
      ->option_text("REFERENCE");
  add_text(*c, "Options", "-o,--difference", options->difference, "FILE.png",
           "Write the signed relative difference in false colour: red where IMAGE is too bright, blue where dark");
  add_text(*c, "Options", "--html", options->page, "FILE.html",
           "Write a page for a browser: slider, difference, exposure, zoom, histogram, and these measures");
  add_text(*c, "Options", "--layer", options->layer, "NAME", "Compare this layer of EXR files instead of the image");
  add_text(*c, "Options", "--region", options->region, "X0,Y0,X1,Y1",
           "Compare only these pixels; X1 and Y1 are one past the last");
  add_number(*c, "Options", "--leave-out", options->leave_out, 0, 0.99, "SHARE [0]",
             "Exclude this share of the worst pixels from MSE and relMSE");
  add_number(*c, "Options", "--limit", options->limit, 0, 1e30, "NUMBER",
             "Exit with status 1 if relRMSE is above this, or a pixel is not finite; 0 takes equal pictures only");
  c->add_flag("--json", options->json, "Print a JSON object");
  add_table_options(*c, "Machine", Command::compare, options->table);
  c->footer(R"(
I: the picture, R: the reference, both linear; means are over pixels and channels.
  MSE         mean of (I - R)^2
  relMSE      mean of (I - R)^2 / (R^2 + 0.01); relRMSE is its root
  PSNR        10 log10(P^2 / MSE) with the largest number P of R
  mean ratio  mean of I over mean of R: of luminance, and of each channel

A part of a picture (--crop) is compared with the same part of the other.

Examples:
  glowworm compare out.exr reference.exr -o difference.png --limit 0.05
  glowworm compare out.exr reference.exr --html report.html
  glowworm compare out.exr reference.exr --layer indirect --region 0,0,64,64 --json)");
  c->callback([options, &exit_status] { exit_status = run_compare(*options); });
}

}  // namespace glowworm
