// The public header glowworm/bake.h.
#include "glowworm/bake.h"

#include <cmath>
#include <exception>
#include <filesystem>
#include <memory>
#include <utility>

#include "api/run_job.h"
#include "api/scene_implementation.h"
#include "bake/bands.h"
#include "bake/layout.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/memory_budget.h"
#include "gltf_writer/scene_glb.h"
#include "settings/options.h"

namespace glowworm::api {

namespace {

/// The settings of `glowworm bake`.
RenderSettings bake_settings(const BakeOptions& options) {
  RenderSettings s = settings_of(options.render, Command::bake);
  if (s.memory_bytes == 0) s.memory_bytes = default_memory_bytes();
  if (options.indirect_only) s.indirect_only = true;
  return s;
}

AtlasRequest atlas_of(const BakeOptions& o, std::uint64_t memory_bytes) {
  if (o.atlas != 0 && (o.atlas < 16 || o.atlas > kMaxAtlasSide))
    throw Error("atlas is " + std::to_string(o.atlas), "Give from 16 to 16384 texels, or 0.");
  if (!(o.texels_per_metre >= 0 && std::isfinite(o.texels_per_metre)))
    throw Error("texels_per_metre is negative or not finite", "Give a positive number, or 0.");
  return {o.atlas, o.texels_per_metre, memory_bytes};
}

}  // namespace

std::vector<std::string> bake_option_names() { return option_names(Command::bake); }
std::vector<std::string> bake_format_names() { return glowworm::bake_format_names(); }

void bake(const Scene& scene, const std::string& path, const BakeOptions& options,
          const std::function<void(double)>& progress) {
  const BakeFormat format = options.format;
  if (static_cast<std::size_t>(format) >= bake_format_names().size())
    throw Error("there is no bake format number " + std::to_string(static_cast<int>(format)),
                "Give a value of the enumeration BakeFormat.");
  const RenderSettings settings = bake_settings(options);
  const AtlasRequest request = atlas_of(options, settings.memory_bytes);
  const Scene::Implementation& inner = scene.implementation();
  if (!options.allow_outside) check_outside_files(inner.outside_files, inner.gltf_parts.get(), "allow_outside");
  const std::shared_ptr<const glowworm::Scene> baked_scene = without_instances(inner.scene);
  const auto tracer =
      baked_scene == inner.scene ? inner.tracer : std::make_shared<const glowworm::Tracer>(*baked_scene);
  const BakeLayout layout = lay_out(baked_scene, tracer, request);
  auto points = std::make_shared<const PointGrid>(texel_points(*baked_scene, *tracer, layout));
  const auto attend_band = [&](const BandRun& run) -> std::exception_ptr {
    const double before = static_cast<double>(run.band.first) / points->height;
    const double share = static_cast<double>(run.band.end - run.band.first) / points->height;
    attend(run.job, [&](double done) {
      if (progress) progress(before + done * share);
    });
    return nullptr;
  };
  Baked baked = bake_points(baked_scene, tracer, points, settings, std::nullopt, attend_band);
  points = nullptr;
  if (baked.passes == 0) throw Error("the bake ended before every texel had light", "Give it more time.");
  const std::vector<RGB> light =
      light_of_texels(*baked_scene, layout, std::move(baked.irradiance), shown_light(format, inner.gltf_parts.get()));
  const float exposure = options.exposure
                             ? *options.exposure
                             : automatic_exposure(*baked_scene, *tracer, layout, light, quantity_of(format));
  const EncodedLight encoded = encode_light(layout, light, range_of(*baked_scene, layout, format, exposure));
  const BakeNotes notes{exposure,
                        "",
                        {},
                        inner.gltf_parts,
                        settings.indirect_only,
                        1,
                        options.allow_outside,
                        std::filesystem::path(path).parent_path().string()};
  write_file(path, glb_of_scene(*baked_scene, layout, encoded, format, notes));
}

}  // namespace glowworm::api
