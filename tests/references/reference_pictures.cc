// Holds pictures to those that another renderer made of the same files: a table, and pictures of the differences.
// usage: reference_pictures [--integrator photon|path] [NAME...]
// Exit status 1 where a mean is off by more than 2%.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/log.h"
#include "image/image.h"
#include "image/metrics.h"
#include "import/import.h"
#include "references/block_comparison.h"
#include "render/job.h"

namespace {

using namespace glowworm;

constexpr const char* kShared = GLOWWORM_SHARED_DIR;
constexpr double kLargestError = 0.02;  // of the mean
constexpr int kBlock = 8;               // pixels
constexpr double kLeftOut = 0.01;       // of the pixels, in blocks
constexpr std::uint32_t kRenders = 4;

struct ReferencePicture {
  const char* name;
  const char* scene;
  bool indirect_only;
};

constexpr ReferencePicture kPictures[] = {
    {"cornell-grey", "cornell-grey-pbrt/cornell-grey-reference.pbrt", false},
    {"cornell-grey-indirect", "cornell-grey-pbrt/cornell-grey-reference.pbrt", true},
    {"cornell-box", "bitterli-cornell-box-pbrt/cornell-box-reference.pbrt", false},
    {"sponza-sun", "sponza-dabrovic/pbrt/sponza-sun.pbrt", false},
    {"veach-bidir", "bitterli-veach-bidir-pbrt/veach-bidir-reference.pbrt", false},
    {"staircase2", "bitterli-staircase2-pbrt/staircase2-reference.pbrt", false},
    {"living-room", "bitterli-living-room-pbrt/living-room-reference.pbrt", false},
    {"veach-ajar", "bitterli-veach-ajar-pbrt/veach-ajar-reference.pbrt", false},
};

struct Options {
  Integrator integrator = Integrator::photon;
  std::vector<std::string> names;  // none: all
};

RenderSettings settings_for(const ReferencePicture& picture, const Options& options, const Image& reference) {
  RenderSettings s;
  s.integrator = options.integrator;
  s.width = reference.width();
  s.height = reference.height();
  s.indirect_only = picture.indirect_only;
  s.samples = options.integrator == Integrator::path ? 64 : 4;
  s.gather = 36;
  return s;
}

/// Renders, alike but for their seeds.
std::vector<std::vector<RGB>> render(const ReferencePicture& picture, const Options& options, const Image& reference,
                                     double& seconds) {
  auto scene = std::make_shared<const Scene>(load_scene(std::string(kShared) + "/scenes/" + picture.scene));
  auto tracer = std::make_shared<const Tracer>(*scene);
  RenderSettings settings = settings_for(picture, options, reference);
  std::vector<std::vector<RGB>> out;
  seconds = 0;
  for (settings.seed = 0; settings.seed < kRenders; ++settings.seed) {
    Job job(scene, tracer, settings);
    job.wait();
    const Film film = job.snapshot();
    std::vector<RGB>& pixels = out.emplace_back();
    for (std::size_t i = 0; i < film.pixel_count(); ++i)
      pixels.push_back(film.radiance(i, settings.indirect_only) * scene->film().scale);
    seconds += job.seconds();
  }
  return out;
}

Image mean_picture(const std::vector<std::vector<RGB>>& renders, int width, int height) {
  std::vector<RGB> mean(renders.front().size());
  for (const std::vector<RGB>& render : renders)
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += render[i] / static_cast<float>(renders.size());
  Image image(width, height);
  image.add_rgb("", mean);
  return image;
}

/// The z-score of each block as a picture: red too bright, blue too dark, full at 6 standard errors.
std::vector<RGB> z_picture(const BlockComparison& comparison, int width, int height) {
  std::vector<RGB> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), RGB(0.2f));
  for (const BlockDifference& b : comparison.blocks) {
    const float t = static_cast<float>(std::clamp(b.z() / 6, -1.0, 1.0));
    const RGB color = {0.2f + 0.8f * std::max(t, 0.0f), 0.2f * (1 - std::abs(t)), 0.2f + 0.8f * std::max(-t, 0.0f)};
    for (int y = b.y; y < std::min(b.y + kBlock, height); ++y)
      for (int x = b.x; x < std::min(b.x + kBlock, width); ++x)
        pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] = color;
  }
  return pixels;
}

/// Ours, the reference, their difference and the blocks' z-scores side by side.
void write_pictures(const std::string& path, const Image& ours, const Image& reference,
                    const BlockComparison& comparison) {
  const int width = ours.width(), height = ours.height();
  const std::vector<RGB> panels[] = {ours.rgb(), reference.rgb(), difference_picture(ours, reference, 0.5f).rgb(),
                                     z_picture(comparison, width, height)};
  const int count = static_cast<int>(std::size(panels));
  std::vector<RGB> pixels;
  for (int y = 0; y < height; ++y)
    for (int p = 0; p < count; ++p) {
      const auto row = panels[p].begin() + static_cast<std::ptrdiff_t>(y) * width;
      pixels.insert(pixels.end(), row, row + width);
    }
  Image sheet(width * count, height);
  sheet.add_rgb("", pixels);
  write_png(path, sheet, ToneCurve::srgb);
}

/// Compares one picture, prints its line of the table, and returns whether its mean agrees.
bool compare(const ReferencePicture& picture, const Options& options, const std::string& folder) {
  const Image reference = read_image(fmt::format("{}/references/{}.exr", kShared, picture.name));
  double seconds = 0;
  const std::vector<std::vector<RGB>> renders = render(picture, options, reference, seconds);
  const Image ours = mean_picture(renders, reference.width(), reference.height());
  const BlockComparison blocks =
      compare_blocks(renders, reference.rgb(), reference.width(), reference.height(), kBlock, kLeftOut);
  const ImageComparison whole = compare_images(ours, reference, 0.02);
  const bool agrees = std::abs(blocks.mean_ratio - 1) <= kLargestError;
  fmt::print("| {} | {:.4f} | {:.4f} | {:.3f} {:.3f} {:.3f} | {:.3f} | {:.2f}% | {:.1f}% | {:.0f} | {} |\n",
             picture.name, blocks.mean_ratio, blocks.standard_error, whole.mean_ratio[0], whole.mean_ratio[1],
             whole.mean_ratio[2], whole.relative_rmse, 100 * blocks.structured, 100 * blocks.share_beyond_3, seconds,
             agrees ? "yes" : "NO");
  std::fflush(stdout);
  write_pictures(fmt::format("{}/{}.png", folder, picture.name), ours, reference, blocks);
  write_exr(fmt::format("{}/{}.exr", folder, picture.name), ours, ExrPrecision::single);
  return agrees;
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument != "--integrator") {
      options.names.push_back(argument);
    } else {
      const std::string name = ++i < argc ? argv[i] : "";
      if (name != "path" && name != "photon") throw Error("--integrator wants photon or path");
      options.integrator = name == "path" ? Integrator::path : Integrator::photon;
    }
  }
  for (const std::string& name : options.names)
    if (std::none_of(std::begin(kPictures), std::end(kPictures), [&](const auto& p) { return name == p.name; }))
      throw Error(fmt::format("there is no reference picture '{}'", name));
  return options;
}

int run(const Options& options) {
  const bool by_path = options.integrator == Integrator::path;
  const std::string folder = fmt::format("{}/out/references{}", GLOWWORM_SOURCE_DIR, by_path ? "-path" : "");
  std::filesystem::create_directories(folder);
  set_log_level(LogLevel::quiet);
  fmt::print("{} renders of each, {}; blocks of {} x {} pixels, the worst {:.0f}% of pixels left out of them.\n\n",
             kRenders, by_path ? "64 paths a pixel" : "4 samples x 36 gather rays", kBlock, kBlock, 100 * kLeftOut);
  fmt::print(
      "| picture | mean ratio | +- | red green blue | relRMSE | structured | blocks beyond 3 | s | within 2% |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  bool all = true;
  for (const ReferencePicture& picture : kPictures) {
    const bool wanted = options.names.empty() ||
                        std::find(options.names.begin(), options.names.end(), picture.name) != options.names.end();
    if (wanted) all = compare(picture, options, folder) && all;
  }
  fmt::print("\n'structured': root mean square of the blocks' differences less what noise explains, over the mean.\n");
  fmt::print("Pictures (ours, reference, difference, z-scores of blocks): {}\n", folder);
  return all ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(parse(argc, argv));
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
}
