#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "apps/commands.h"
#include "apps/output_files.h"
#include "core/error.h"
#include "image/image.h"
#include "image/metrics.h"

namespace glowworm {

namespace {

struct CompareOptions {
  std::string image, reference, difference;
  double leave_out = 0, limit = 0;
};

int run_compare(const CompareOptions& o) {
  if (!o.difference.empty()) {
    if (std::filesystem::path(o.difference).extension() != ".png")
      throw Error(fmt::format("'{}' does not end in .png", o.difference), "Give --difference a name with this ending.");
    OutputFiles files;
    files.add_input("the image", o.image);
    files.add_input("the reference", o.reference);
    files.add("--difference", o.difference);
    if (!files.probe(o.difference)) files.throw_if_any_failed();
  }
  const Image image = read_image(o.image), reference = read_image(o.reference);
  const ImageComparison c = compare_images(image, reference, o.leave_out);
  if (!o.difference.empty()) write_png(o.difference, difference_picture(image, reference), ToneCurve::srgb);
  fmt::print("MSE        {:.6g}\n", c.mse);
  fmt::print("relMSE     {:.6g}\n", c.relative_mse);
  fmt::print("relRMSE    {:.6g}\n", c.relative_rmse);
  fmt::print("mean ratio {:.6g} (red {:.6g}, green {:.6g}, blue {:.6g})\n", c.luminance_ratio, c.mean_ratio[0],
             c.mean_ratio[1], c.mean_ratio[2]);
  fmt::print("largest    {:.6g}\n", c.largest_difference);
  if (c.non_finite_pixels > 0) fmt::print("not finite {} pixels\n", c.non_finite_pixels);
  return o.limit > 0 && !(c.relative_rmse <= o.limit) ? 1 : 0;
}

}  // namespace

void add_compare_command(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* c = program.add_subcommand("compare", "Measures how far a picture is from its reference.");
  c->add_option("image", options->image, "The picture: any file that OpenImageIO reads")
      ->required()
      ->option_text("IMAGE");
  c->add_option("reference", options->reference, "The reference, of the same size")
      ->required()
      ->option_text("REFERENCE");
  c->add_option("-o,--difference", options->difference,
                "Write the signed relative difference in false colour: red where IMAGE is too bright, blue where dark")
      ->option_text("FILE.png");
  c->add_option("--leave-out", options->leave_out, "Share of the worst pixels to leave out of MSE and relMSE")
      ->check(CLI::Range(0.0, 0.99))
      ->option_text("SHARE [0]");
  c->add_option("--limit", options->limit, "Exit with status 1 where relRMSE is above this")
      ->check(CLI::PositiveNumber)
      ->option_text("NUMBER");
  c->footer(R"(
I: the picture, R: the reference, both linear; means are over pixels and channels.
  MSE         mean of (I - R)^2
  relMSE      mean of (I - R)^2 / (R^2 + 0.01); relRMSE is its root
  mean ratio  mean of I over mean of R: of luminance, and of each channel

Example:
  glowworm compare out.exr reference.exr -o difference.png --limit 0.05)");
  c->callback([options, &exit_status] { exit_status = run_compare(*options); });
}

}  // namespace glowworm
