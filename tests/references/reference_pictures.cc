// Compares pictures with those of another renderer for the same files: prints a table, and writes difference pictures.
// usage: reference_pictures [--integrator gather|path] [--rgb] [--photons N] [NAME...]
// Scenes with saturated colours that light each other are rendered with smooth spectra, as that renderer does; --rgb
// renders them as RGB, as the program does. Exits with status 1 if a mean is off by more than 2%, or a block by more
// than noise and BlockTolerance explain.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "control/job.h"
#include "core/error.h"
#include "core/log.h"
#include "image/image.h"
#include "image/metrics.h"
#include "import/import.h"
#include "references/block_comparison.h"
#include "references/spectral_scene.h"

namespace {

using namespace glowworm;

constexpr const char* kShared = GLOWWORM_SHARED_DIR;
constexpr double kMaxError = 0.02;  // of the mean
constexpr int kBlock = 8;           // pixels
constexpr double kLeftOut = 0.01;   // of the pixels, in blocks
constexpr std::uint32_t kRenders = 4;
constexpr int kTriples = 5;  // of wavelengths

struct ReferencePicture {
  const char* name;
  const char* scene;
  int bounces;    // of the reference: its file's maxdepth
  bool spectral;  // saturated colours that light each other: rendered as spectra unless --rgb
  bool indirect_only;
};

constexpr ReferencePicture kPictures[] = {
    {"cornell-grey", "cornell-grey-pbrt/cornell-grey-reference.pbrt", 10, false, false},
    {"cornell-grey-indirect", "cornell-grey-pbrt/cornell-grey-reference.pbrt", 10, false, true},
    {"cornell-box", "bitterli-cornell-box-pbrt/cornell-box-reference.pbrt", 20, true, false},
    {"sponza-sun", "sponza-dabrovic/pbrt/sponza-sun.pbrt", 16, false, false},
    {"veach-bidir", "bitterli-veach-bidir-pbrt/veach-bidir-reference.pbrt", 12, false, false},
    {"staircase2", "bitterli-staircase2-pbrt/staircase2-reference.pbrt", 20, false, false},
    {"living-room", "bitterli-living-room-pbrt/living-room-reference.pbrt", 20, false, false},
    {"veach-ajar", "bitterli-veach-ajar-pbrt/veach-ajar-reference.pbrt", 20, false, false},
};

struct Options {
  Integrator integrator = Integrator::gather;
  bool rgb = false;
  std::uint64_t photons = 500'000;
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
  s.photons = options.photons;
  s.max_bounces = picture.bounces;
  return s;
}

/// Adds a render, its red, green and blue weighted each, to `sum`; returns the seconds it took.
double add_render(const std::shared_ptr<const Scene>& scene, const std::shared_ptr<const Tracer>& tracer,
                  const RenderSettings& settings, const std::array<RGB, 3>& weights, std::vector<RGB>& sum) {
  Job job(scene, tracer, settings);
  job.wait();
  const Film film = job.snapshot();
  for (std::size_t i = 0; i < film.pixel_count(); ++i) {
    const RGB radiance = film.radiance(i, settings.indirect_only) * scene->film().scale;
    sum[i] += weights[0] * radiance.r + weights[1] * radiance.g + weights[2] * radiance.b;
  }
  return job.seconds();
}

/// Renders, alike but for their seeds.
std::vector<std::vector<RGB>> render(const ReferencePicture& picture, const Options& options, const Image& reference,
                                     double& seconds) {
  const SceneDescription description = load_scene(std::string(kShared) + "/scenes/" + picture.scene);
  RenderSettings settings = settings_for(picture, options, reference);
  std::vector<std::vector<RGB>> out(kRenders, std::vector<RGB>(reference.rgb().size()));
  const bool spectral = picture.spectral && !options.rgb;
  const int passes = spectral ? kTriples : 1;
  const SpectralNodes nodes = spectral_nodes(kTriples);
  settings.samples = (settings.samples + static_cast<std::uint32_t>(passes) - 1) / static_cast<std::uint32_t>(passes);
  for (int pass = 0; pass < passes; ++pass) {
    const auto first = static_cast<std::size_t>(3 * pass);
    std::array<RGB, 3> weights = {RGB(1, 0, 0), RGB(0, 1, 0), RGB(0, 0, 1)};
    if (spectral) std::copy_n(nodes.weights.begin() + 3 * pass, 3, weights.begin());
    const auto scene = std::make_shared<const Scene>(
        spectral ? at_wavelengths(description, {nodes.wavelengths[first], nodes.wavelengths[first + 1],
                                                nodes.wavelengths[first + 2]})
                 : description);
    const auto tracer = std::make_shared<const Tracer>(*scene);
    for (std::uint32_t i = 0; i < kRenders; ++i) {
      settings.seed = i * kTriples + static_cast<std::uint32_t>(pass);
      seconds += add_render(scene, tracer, settings, weights, out[i]);
    }
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
  const std::vector<BlockDifference> different = blocks.different({});
  const bool agrees = std::abs(blocks.mean_ratio - 1) <= kMaxError && different.empty();
  fmt::print("| {} | {:.4f} | {:.4f} | {:.3f} {:.3f} {:.3f} | {:.3f} | {:.2f}% | {:.1f}% | {} of {} | {:.0f} | {} |\n",
             picture.name, blocks.mean_ratio, blocks.standard_error, whole.mean_ratio[0], whole.mean_ratio[1],
             whole.mean_ratio[2], whole.relative_rmse, 100 * blocks.structured, 100 * blocks.share_beyond_3,
             different.size(), blocks.blocks.size(), seconds, agrees ? "yes" : "NO");
  for (const BlockDifference& b : different)
    fmt::print(stderr, "  {}: block at ({}, {}): {:.4f} +- {:.4f}, reference {:.4f}\n", picture.name, b.x, b.y,
               b.reference + b.difference, b.standard_error, b.reference);
  std::fflush(stdout);
  write_pictures(fmt::format("{}/{}.png", folder, picture.name), ours, reference, blocks);
  write_exr(fmt::format("{}/{}.exr", folder, picture.name), ours, ExrPrecision::single);
  return agrees;
}

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--rgb") {
      options.rgb = true;
    } else if (argument == "--photons") {
      options.photons = ++i < argc ? std::stoull(argv[i]) : 0;
    } else if (argument != "--integrator") {
      options.names.push_back(argument);
    } else {
      const std::string name = ++i < argc ? argv[i] : "";
      if (name != "path" && name != "gather") throw Error("--integrator is gather or path");
      options.integrator = name == "path" ? Integrator::path : Integrator::gather;
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
  fmt::print(
      "{} renders of each, {}, colours as {}; blocks of {} x {} pixels, the worst {:.0f}% of pixels left out.\n\n",
      kRenders, by_path ? "64 paths a pixel" : fmt::format("4 samples x 36 gather rays, {} photons", options.photons),
      options.rgb ? "RGB" : fmt::format("spectra of {} wavelengths", 3 * kTriples), kBlock, kBlock, 100 * kLeftOut);
  fmt::print(
      "| picture | mean ratio | +- | red green blue | relRMSE | structured | blocks beyond 3 | different | s | agrees "
      "|\n");
  fmt::print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  bool all = true;
  for (const ReferencePicture& picture : kPictures) {
    const bool wanted = options.names.empty() ||
                        std::find(options.names.begin(), options.names.end(), picture.name) != options.names.end();
    if (wanted) all = compare(picture, options, folder) && all;
  }
  fmt::print("\n'structured': root mean square of the blocks' differences less what noise explains, over the mean.\n");
  const BlockTolerance allowed;
  fmt::print(
      "'different': blocks off by more than {:.0f}% of themselves and {:.0f}% of the picture and {:.0f} standard "
      "errors.\n",
      100 * allowed.of_block, 100 * allowed.of_picture, allowed.standard_errors);
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
