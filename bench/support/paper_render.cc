#include "support/paper_render.h"

#include <algorithm>
#include <filesystem>

#include "import/import.h"
#include "render/job.h"

namespace glowworm::bench {

RenderedScene::RenderedScene(const std::string& path)
    : scene(std::make_shared<const Scene>(load_scene(path))), tracer(std::make_shared<const Tracer>(*scene)) {}

std::string shared_folder() {
  for (const char* folder : {"../shared", "../../shared", "/work/shared"})
    if (std::filesystem::exists(std::string(folder) + "/scenes")) return folder;
  return {};
}

RenderSettings paper_settings(const char* engine, int side) {
  RenderSettings s;
  s.engine = engine;
  s.width = s.height = side;
  s.samples = kPaperSamples;
  s.gather = kPaperRays / kPaperSamples;
  s.photons = 500'000;
  s.nearest = kPaperNearest;
  s.kernel = KernelShape::box;
  s.indirect_only = true;
  s.separate_layers = false;
  s.preference = Preference::quality;  // so that a small picture has as many query points at once as a large one
  return s;
}

RenderTimes render(const RenderedScene& set, const RenderSettings& settings) {
  Job job(set.scene, set.tracer, settings);
  job.wait();
  const Statistics& s = job.statistics();
  RenderTimes r;
  r.photons = s.seconds(Phase::trace_photons) + s.seconds(Phase::build_photon_map);
  r.rest = s.seconds(Phase::total) - r.photons;
  r.look_up = s.seconds(Phase::reorder) + s.seconds(Phase::density);
  r.queries = s.count(Counter::query_points);
  r.k = static_cast<double>(s.count(Counter::shader_operations)) /
        static_cast<double>(std::max<std::uint64_t>(r.queries, 1));
  r.tested =
      static_cast<double>(s.count(Counter::pairs_tested)) / static_cast<double>(std::max<std::uint64_t>(r.queries, 1));
  r.tasks = job.tasks();
  r.peak = job.peak_beside_scene_bytes();
  return r;
}

}  // namespace glowworm::bench
