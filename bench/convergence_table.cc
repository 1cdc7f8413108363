// How the error of indirect light falls as photons and gather rays grow: two tables for each scene, in Markdown.
// usage: convergence_table [file.md]
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "image/metrics.h"
#include "render/job.h"
#include "scene/builtin.h"

namespace {

using namespace glowworm;

struct Stage {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Tracer> tracer;

  Image indirect(RenderSettings settings) const {
    settings.indirect_only = true;
    settings.width = 32;
    settings.height = 24;
    Job job(scene, tracer, settings);
    job.wait();
    const Film film = job.snapshot();
    std::vector<RGB> pixels;
    for (std::size_t i = 0; i < film.pixel_count(); ++i) pixels.push_back(film.radiance(i, true));
    Image image(film.width(), film.height());
    image.add_rgb("", pixels);
    return image;
  }
};

RenderSettings photon_mapping(const char* engine, std::uint64_t photons, std::uint32_t samples, std::uint32_t gather) {
  RenderSettings s;
  s.engine = engine;
  s.photons = photons;
  s.samples = samples;
  s.gather = gather;
  return s;
}

std::string row(const Stage& stage, const Image& reference, std::uint64_t varied, const RenderSettings& settings) {
  RenderSettings knn = settings;
  knn.engine = "knn";
  const ImageComparison a = compare_images(stage.indirect(knn), reference);
  const ImageComparison b = compare_images(stage.indirect(settings), reference);
  return fmt::format("| {} | {:.4f} | {:.4f} | {:.4f} | {:.4f} |\n", varied, a.relative_rmse, a.luminance_ratio,
                     b.relative_rmse, b.luminance_ratio);
}

std::string tables(const char* name) {
  auto scene = std::make_shared<const Scene>(builtin_scene(name));
  const Stage stage{scene, std::make_shared<const Tracer>(*scene)};
  RenderSettings path;
  path.integrator = Integrator::path;
  path.samples = 4096;
  const Image reference = stage.indirect(path);
  path.seed = 1;
  const ImageComparison again = compare_images(stage.indirect(path), reference);
  const std::string head =
      " | knn: relative RMSE | knn: luminance ratio | blocked: relative RMSE | blocked: luminance ratio |\n"
      "| --- | --- | --- | --- | --- |\n";
  std::string out = fmt::format(
      "## {}\nA second path-traced reference of the same {} samples: relative RMSE {:.4f}, luminance ratio {:.4f}.\n\n",
      name, path.samples, again.relative_rmse, again.luminance_ratio);
  out += "16 camera samples of 64 gather rays:\n\n| photons" + head;
  for (const std::uint64_t photons : {4'000u, 16'000u, 64'000u, 256'000u, 1'024'000u})
    out += row(stage, reference, photons, photon_mapping("blocked", photons, 16, 64));
  out += "\n1 camera sample, 500,000 photons:\n\n| gather rays" + head;
  for (const std::uint32_t gather : {1u, 4u, 16u, 64u, 256u})
    out += row(stage, reference, gather, photon_mapping("blocked", 500'000, 1, gather));
  return out + "\n";
}

}  // namespace

int main(int argc, char** argv) {
  std::string text =
      "# Indirect light by photon mapping against path tracing\n32 x 24 pixels, k = 50. Ratio: mean luminance over "
      "that of the reference.\n\n";
  for (const char* name : {"cornell", "ajar"}) text += tables(name);
  std::fputs(text.c_str(), stdout);
  if (argc < 2) return 0;
  std::FILE* file = std::fopen(argv[1], "w");
  if (!file) {
    fmt::print(stderr, "cannot write {}\n", argv[1]);
    return 1;
  }
  const bool written = std::fputs(text.c_str(), file) >= 0;
  return std::fclose(file) == 0 && written ? 0 : 1;
}
