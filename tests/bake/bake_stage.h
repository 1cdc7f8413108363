// A scene laid out for baking, and settings of bakes.
#pragma once
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "bake/layout.h"
#include "bake/light.h"
#include "control/job.h"
#include "render/render_testing.h"

namespace glowworm {

/// A scene laid out, ready for bakes.
struct BakeStage {
  Stage stage;
  BakeLayout layout;
  std::shared_ptr<const PointGrid> grid;

  explicit BakeStage(SceneDescription description, AtlasRequest request)
      : stage(without_instances(std::make_shared<const Scene>(std::move(description)))),
        layout(lay_out(stage.scene, stage.tracer, request)),
        grid(std::make_shared<const PointGrid>(texel_points(*stage.scene, *stage.tracer, layout))) {}

  Film film(const RenderSettings& settings) const {
    Job job(stage.scene, stage.tracer, settings, nullptr, 0, grid);
    job.wait();
    return job.snapshot();
  }
  std::vector<RGB> light(const RenderSettings& settings, TexelLight what) const {
    TexelIrradiance irradiance(layout.texels.face.size());
    irradiance.take(film(settings), *grid, settings, 0, grid->height);
    return light_of_texels(*stage.scene, layout, std::move(irradiance), what);
  }
};

inline RenderSettings by_gathering(std::uint32_t samples, std::uint32_t gather, std::uint64_t photons = 50'000) {
  RenderSettings s;
  s.samples = samples;
  s.gather = gather;
  s.photons = photons;
  return s;
}

inline RenderSettings by_paths(std::uint32_t samples) {
  RenderSettings s;
  s.integrator = Integrator::path;
  s.samples = samples;
  return s;
}

}  // namespace glowworm
