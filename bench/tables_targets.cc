// Renders that are held to a limit: the grey box to an error within processor seconds, the large atrium to minutes, and
// progressive renders to an error that goes on falling.
//
// usage: tables_targets [grey|atrium|progressive]... [samples:N] [full]
// All where none is named (about two minutes). The atrium is measured by N of its 24 samples a pixel, 1 where
// not told; full: progressive renders go on to 1024 passes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "image/metrics.h"
#include "render/job.h"
#include "render/output.h"
#include "support/paper_render.h"
#include "support/run_tables.h"
#include "support/table.h"

namespace glowworm::bench {
namespace {

/// Of the process so far, the start of the program included.
double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// The grey box against its reference.
/// @param start_s processor seconds that the start of the program took
void table_grey(double start_s) {
  const std::string folder = shared_folder();
  const std::string reference = folder + "/references/cornell-grey.exr";
  if (!std::filesystem::exists(reference)) return;
  Table table(
      "grey_box", "Grey Cornell box, 128x128 pixels, all light, against its reference of 4096 samples",
      {"samples", "gather rays each", "photons", "k", "relRMSE", "processor, s", "with the program's start, s"});
  const Image truth = read_image(reference);
  struct Effort {
    std::uint32_t samples, gather;
    std::uint64_t photons;
    std::uint32_t nearest;
    int threads;
  };
  const int usual_threads = thread_count();
  for (const Effort& e : {Effort{16, 25, 100'000, 50, 1},
                          {64, 4, 100'000, 100, 1},
                          {64, 6, 100'000, 100, 1},
                          {64, 4, 100'000, 100, usual_threads}}) {
    set_thread_count(e.threads);
    const double start = processor_seconds();
    const RenderedScene set(folder + "/scenes/cornell-grey-pbrt/cornell-grey-reference.pbrt");
    RenderSettings settings;
    settings.width = settings.height = 128;
    settings.samples = e.samples;
    settings.gather = e.gather;
    settings.photons = e.photons;
    settings.nearest = e.nearest;
    settings.separate_layers = false;
    Job job(set.scene, set.tracer, settings);
    job.wait();
    const Image image = make_image(job.snapshot(), job);
    const double seconds = processor_seconds() - start;
    table.add({Number{double(e.samples)}, Number{double(e.gather)}, Number{double(e.photons), 7},
               Number{double(e.nearest)}, Number{compare_images(image, truth).relative_rmse}, Number{seconds},
               Number{seconds + start_s}});
  }
  set_thread_count(usual_threads);
  table.note(
      "Published for pbrt-v4 on such a machine: SPPM 153 s to 0.022, bidirectional 82 s to 0.033, path tracing 32 s "
      "to 0.047. The reference's own noise is about 0.012. The start is the loading of shared libraries.");
  table.write();
}

/// The large render, by some of its samples.
void table_atrium(std::uint32_t samples) {
  Table table("atrium_2mp", "Atrium, 1920x1080 pixels, 600 gather rays each, within 4 GB",
              {"engine", "samples measured", "photon pass, s", "these samples, s", "of it, looking up, s", "k",
               "whole, min", "whole without looking up, min", "held beside the scene, MB"});
  const RenderedScene set("builtin:atrium");
  for (const char* engine : {"reverse", "blocked"}) {
    RenderSettings settings = paper_settings(engine, 1080);
    settings.preference = Preference::automatic;
    settings.width = 1920;
    settings.samples = samples;
    settings.memory_bytes = 4'000'000'000;
    const RenderTimes r = render(set, settings);
    const double factor = static_cast<double>(kPaperSamples) / samples;
    table.add({engine, Number{double(samples)}, Number{r.photons}, Number{r.rest}, Number{r.look_up}, Number{r.k},
               Number{r.whole(factor) / 60}, Number{(r.whole(factor) - r.look_up * factor) / 60},
               Number{static_cast<double>(r.peak) / 1e6}});
  }
  table.note(
      "Camera samples of each pixel with 25 gather rays each were rendered, of 24; the whole is photon pass and 24 "
      "such. "
      "500,000 photons. Published for Sponza with 600: 160 minutes.");
  table.write();
}

/// Mean over pixels and channels of the squared difference over the squared second.
double relative_mse(const std::vector<RGB>& a, const std::vector<RGB>& b) {
  double scale = 0, sum = 0;
  for (const RGB& c : b) scale += luminance(c) / static_cast<double>(b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int c = 0; c < 3; ++c)
      sum += std::pow(double(a[i][c]) - b[i][c], 2) / (std::pow(double(b[i][c]), 2) + std::pow(0.1 * scale, 2));
  return sum / (3 * static_cast<double>(a.size()));
}

std::vector<RGB> pixels_of(const RenderedScene& set, const RenderSettings& settings) {
  Job job(set.scene, set.tracer, settings);
  job.wait();
  const Film film = job.snapshot();
  std::vector<RGB> pixels;
  for (std::size_t i = 0; i < film.pixel_count(); ++i) pixels.push_back(film.radiance(i, true));
  return pixels;
}

/// A mean and its standard error.
struct Mean {
  double value = 0, error = 0;
};
Mean mean_of(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  Mean mean;
  for (const double v : values) mean.value += v / n;
  for (const double v : values) mean.error += (v - mean.value) * (v - mean.value);
  mean.error = std::sqrt(mean.error / (n - 1) / n);
  return mean;
}

/// Error of progressive renders and of renders with one photon map over the number of passes.
void table_progressive(bool full) {
  constexpr int kSide = 12;
  constexpr std::uint32_t kSeeds = 6;
  Table table("progressive", "Error over passes, Cornell box at 12x12 pixels, indirect light, 2,000 photons a pass",
              {"passes", "relative error, progressive", "its standard error", "slope from the row before",
               "relative error, one photon map"});
  const RenderedScene set("builtin:cornell");
  RenderSettings by_path;
  by_path.integrator = Integrator::path;
  by_path.width = by_path.height = kSide;
  by_path.samples = 1 << 15;
  by_path.indirect_only = true;
  const std::vector<RGB> truth = pixels_of(set, by_path);
  by_path.seed = 1;
  const double noise = relative_mse(pixels_of(set, by_path), truth) / 2;  // of each of the two
  Mean before;
  for (const std::uint32_t passes : {4, 16, 64, 256, 1024}) {
    if (passes > 256 && !full) break;
    const auto error = [&](bool progressive) {
      std::vector<double> found;
      for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
        RenderSettings settings = by_path;
        settings.integrator = Integrator::photon;
        settings.samples = passes;
        settings.gather = 16;
        settings.photons = 2000;
        settings.engine = "blocked";
        settings.progressive = progressive;
        settings.seed = 10 + seed;
        found.push_back(std::sqrt(std::max(relative_mse(pixels_of(set, settings), truth) - noise, 0.0)));
      }
      return mean_of(found);
    };
    const Mean progressive = error(true);
    std::vector<Cell> row = {Number{double(passes), 4}, Number{progressive.value}, Number{progressive.error, 2}};
    row.resize(5);
    if (before.value > 0)
      row[3] =
          fmt::format("{:.2f} +- {:.2f}", std::log(progressive.value / before.value) / std::log(4.0),
                      std::hypot(progressive.error / progressive.value, before.error / before.value) / std::log(4.0));
    if (passes <= 256) row[4] = Number{error(false).value};
    table.add(row);
    before = progressive;
  }
  table.note(fmt::format(
      "Means of {} seeds, against path tracing with 32,768 samples a pixel, whose own relative error of {:.5f} is "
      "taken "
      "off. Theory (Knaus and Zwicker 2011, Kaplanyan and Dachsbacher 2013) with alpha = 2/3: -1/2 where the noise of "
      "gather rays dominates, -1/3 in the end, where variance and squared bias both fall with the power -2/3.",
      kSeeds, std::sqrt(noise)));
  table.write();
}

void write_tables(const std::vector<std::string>& arguments) {
  const double start_s = processor_seconds();
  std::set<std::string> parts;
  std::uint32_t samples = 1;
  bool full = false;
  for (const std::string& argument : arguments) {
    if (argument.starts_with("samples:"))
      samples = static_cast<std::uint32_t>(std::clamp(std::atoi(argument.c_str() + 8), 1, int(kPaperSamples)));
    else if (argument == "full")
      full = true;
    else
      parts.insert(argument);
  }
  const auto wanted = [&](const char* part) { return parts.empty() || parts.count(part) > 0; };
  if (wanted("grey")) table_grey(start_s);
  if (wanted("progressive")) table_progressive(full);
  if (wanted("atrium")) table_atrium(samples);
}

}  // namespace
}  // namespace glowworm::bench

int main(int argc, char** argv) {
  return glowworm::bench::run_tables("tables_targets", [&] { glowworm::bench::write_tables({argv + 1, argv + argc}); });
}
