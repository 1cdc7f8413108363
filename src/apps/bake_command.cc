#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "apps/attend.h"
#include "apps/commands.h"
#include "apps/interrupt.h"
#include "apps/open_scene.h"
#include "apps/output_files.h"
#include "apps/picture_output.h"
#include "apps/table_options.h"
#include "bake/bands.h"
#include "bake/layout.h"
#include "bake/light.h"
#include "bake/probes.h"
#include "bake/scene_glb.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/input_file.h"
#include "core/log.h"
#include "core/memory_budget.h"
#include "core/parallel.h"
#include "image/image.h"
#include "render/checkpoint.h"
#include "render/filtered.h"
#include "render/job.h"

namespace glowworm {

namespace {

struct BakeOptions {
  std::string scene, command_line, output, atlas_picture, resume, format = "emissive", light = "all", texture = "png";
  std::optional<float> exposure;  ///< stops; none: chosen by the light
  double texels_per_metre = 0, side = 0, spacing = 0;
  bool verbose = false, quiet = false;
  TableOptions table;
  SceneOptions changes;
  RenderSettings settings;  ///< those of the table, for this bake

  bool is_probes() const { return format == "probes"; }
};

void resolve_options(BakeOptions& o) {
  o.settings = o.table.settings;
  if (o.settings.memory_bytes == 0) o.settings.memory_bytes = default_memory_bytes();
  o.settings.indirect_only = o.light == "indirect";
  const char* const expected = o.is_probes() ? ".json" : ".glb";
  const std::string ending = ending_of(o.output);
  if (ending != expected)
    throw CommandLineError(fmt::format("'{}' does not end in {}", o.output, expected),
                           "Give -o a name with this ending.");
  if (o.is_probes() && !(o.spacing > 0))
    throw CommandLineError("--format probes needs a distance between probes", "Give --spacing, for example 0.5.");
  if (o.texture == "exr" && (o.is_probes() || o.format == "vertex"))
    throw CommandLineError(fmt::format("--format {} has no textures", o.format), "Leave --texture out.");
  if (o.is_probes()) o.settings.filter = Filtering::off;
  o.settings.separate_layers = filters(o.settings);
  keep_heap_small(o.settings.memory_bytes);
  if (o.side != std::floor(o.side))
    throw CommandLineError(fmt::format("--atlas '{}' is not a whole number of texels", o.side));
}

void prepare_outputs(const BakeOptions& o, OutputFiles& files) {
  files.add_input("the scene", o.scene);
  files.add("-o", o.output);
  if (!o.atlas_picture.empty()) files.add("--atlas-picture", o.atlas_picture);
  if (!o.resume.empty()) files.add("--resume", o.resume);
  if (!o.resume.empty() && std::filesystem::exists(o.resume)) check_input_file(o.resume);
  for (const std::string& path : {o.output, o.atlas_picture, o.resume})
    if (!path.empty()) files.probe(path);
  files.throw_if_any_failed();
}

/// Writes the light of all texels as a picture: .exr linear, .png with the texture's scale.
void write_atlas_picture(const BakeOptions& o, const BakeLayout& layout, const std::vector<RGB>& light,
                         const EncodedLight& encoded) {
  Image picture(layout.texels.width, layout.texels.height);
  picture.add_rgb("", light);
  picture.metadata["comments"] = o.command_line;
  write_image(o.atlas_picture, picture, ToneCurve::srgb, -std::log2(encoded.scale));
}

/// Names of the files with the light of each atlas in full range: lit.0.exr beside lit.glb.
std::vector<std::string> texture_files(const BakeOptions& o, const Atlas& atlas) {
  std::vector<std::string> out;
  for (int a = 0; o.texture == "exr" && a < atlas.count; ++a)
    out.push_back(std::filesystem::path(o.output).replace_extension(fmt::format("{}.exr", a)));
  return out;
}

void write_texture_files(const BakeOptions& o, const Atlas& atlas, std::span<const RGB> light, OutputFiles& files) {
  const std::vector<std::string> names = texture_files(o, atlas);
  const std::size_t texels = static_cast<std::size_t>(atlas.side) * static_cast<std::size_t>(atlas.side);
  for (std::size_t a = 0; a < names.size(); ++a) {
    Image picture(atlas.side, atlas.side);
    picture.add_rgb("", light.subspan(a * texels, texels));
    picture.metadata["comments"] = o.command_line;
    if (files.write(names[a], [&] { write_exr(names[a], picture); })) inform(fmt::format("wrote {}", names[a]));
  }
}

/// The points of a bake: texels or probes.
struct BakePlaces {
  BakeLayout layout;
  ProbeGrid probes;
  std::shared_ptr<const PointGrid> points;
  std::shared_ptr<const GltfParts> gltf;
};

BakePlaces find_places(const BakeOptions& o, const std::shared_ptr<const Scene>& scene,
                       const std::shared_ptr<const Tracer>& tracer) {
  BakePlaces out;
  if (o.is_probes()) {
    out.probes = make_probes(*scene, *tracer, static_cast<float>(o.spacing));
    out.points = std::make_shared<const PointGrid>(probe_points(out.probes));
    return out;
  }
  out.layout = lay_out(scene, tracer, {static_cast<int>(o.side), o.texels_per_metre});
  out.points = std::make_shared<const PointGrid>(texel_points(*scene, *tracer, out.layout));
  return out;
}

void write_probes(const BakeOptions& o, const std::vector<RGB>& irradiance, const ProbeGrid& probes,
                  OutputFiles& files) {
  if (files.write(o.output, [&] { write_file(o.output, probes_json(probes, irradiance, o.command_line)); }))
    inform(fmt::format("wrote {}", o.output));
}

void write_textures(const BakeOptions& o, const Scene& scene, TexelIrradiance irradiance, const BakePlaces& places,
                    OutputFiles& files) {
  const BakeLayout& layout = places.layout;
  const BakeFormat format = format_of(o.format);
  const std::vector<RGB> light = light_of_texels(scene, layout, std::move(irradiance), quantity_of(format));
  const float exposure = o.exposure ? *o.exposure : automatic_exposure(layout, light);
  const EncodedLight encoded = encode_light(layout, light, scale_of(format, exposure));
  BakeNotes notes{exposure, o.command_line, {}, places.gltf, o.settings.indirect_only};
  for (const std::string& name : texture_files(o, layout.atlas))
    notes.textures.push_back(std::filesystem::path(name).filename());
  const bool written =
      files.write(o.output, [&] { write_file(o.output, glb_of_scene(scene, layout, encoded, format, notes)); });
  write_texture_files(o, layout.atlas, light, files);
  if (!o.atlas_picture.empty()) files.write(o.atlas_picture, [&] { write_atlas_picture(o, layout, light, encoded); });
  if (encoded.clipped > 0.001)
    inform(fmt::format("note: {:.1f}% of the texels are brighter than the texture shows", 100 * encoded.clipped));
  if (written)
    inform(fmt::format("wrote {}, exposure {:+.1f} stops{}", o.output, exposure, o.exposure ? "" : " (auto)"));
}

std::string describe(const BakeOptions& o, const BakePlaces& places, const Job& job) {
  const RenderSettings s = job.settings();
  std::size_t points = 0;
  for (std::size_t i = 0; i < places.points->normal.size(); ++i) points += places.points->has(i);
  const std::string effort = fmt::format("{} points, {} samples x {} rays", points, s.samples, s.gather);
  if (o.is_probes())
    return fmt::format("{}: {} x {} x {} probes, {}", job.scene().name(), places.probes.counts[0],
                       places.probes.counts[1], places.probes.counts[2], effort);
  const Atlas& atlas = places.layout.atlas;
  return fmt::format("{}: {} charts in {} of {}x{} texels, {:.4g} texels per metre, {}", job.scene().name(),
                     places.layout.charts.size(),
                     atlas.count == 1 ? "an atlas" : fmt::format("{} atlases", atlas.count), atlas.side, atlas.side,
                     atlas.texels_per_metre, effort);
}

/// Runs the Jobs of a bake, with progress and a checkpoint.
Baked compute(const BakeOptions& o, const std::shared_ptr<const Scene>& scene,
              const std::shared_ptr<const Tracer>& tracer, const BakePlaces& places, OutputFiles& files) {
  std::optional<Checkpoint> checkpoint;
  if (!o.resume.empty()) checkpoint = read_checkpoint(o.resume);
  const auto attend_band = [&](Job& job, const BakeBand& band, std::size_t bands) {
    if (band.first == 0) {
      inform(describe(o, places, job));
      for (const std::string& note : choice_notes(o.table.settings, job.settings())) detail("chosen: " + note);
    }
    if (bands > 1) inform(fmt::format("rows {} of {}, as --memory allows", band.end, places.points->height));
    if (bands > 1 && !o.resume.empty())
      throw Error("--resume keeps the light of all texels in memory, which --memory does not hold",
                  "Give a larger --memory, or a smaller --atlas.");
    const auto keep = [&] { files.write(o.resume, [&] { write_checkpoint(o.resume, job.checkpoint()); }); };
    std::vector<RepeatedWork> repeated;
    if (!o.resume.empty()) repeated.push_back({1, keep});
    const std::exception_ptr failure = attend(job, o.quiet, std::move(repeated));
    if (!o.resume.empty()) keep();
    return failure;
  };
  return bake_points(scene, tracer, places.points, o.settings, checkpoint ? &*checkpoint : nullptr, attend_band);
}

/// Writes the results, then throws the error, if any, or returns the exit status.
int finish(const BakeOptions& o, const Scene& scene, Baked baked, BakePlaces places, OutputFiles& files) {
  const bool any = baked.passes > 0;
  places.points = nullptr;
  if (any && o.is_probes()) write_probes(o, baked.irradiance.value, places.probes, files);
  if (any && !o.is_probes()) write_textures(o, scene, std::move(baked.irradiance), places, files);
  if (baked.failure) std::rethrow_exception(baked.failure);
  if (baked.ending == Ending::cancelled)
    warn(any ? "interrupted: the file holds the light so far"
             : "interrupted before every point had light: no file was written");
  else if (!any)
    warn("the time limit ended the bake before every point had light: no file was written");
  files.throw_if_any_failed();
  inform(fmt::format("{} passes in {:.2f} s", baked.passes, baked.seconds));
  if (baked.ending == Ending::cancelled) return kExitSignalled + caught_interrupt();
  return any ? 0 : 1;
}

int run_bake(BakeOptions& o) {
  set_log_level(o.quiet ? LogLevel::quiet : o.verbose ? LogLevel::verbose : LogLevel::normal);
  set_thread_count(o.table.settings.threads);
  resolve_options(o);
  OutputFiles files;
  prepare_outputs(o, files);
  ImportOptions import_options;
  import_options.budget = loading_budget(o.settings.memory_bytes);
  import_options.light_uvs = true;
  import_options.gltf_parts = std::make_shared<GltfParts>();
  const std::shared_ptr<const Scene> scene = open_scene(o.scene, import_options, o.changes.changes, &files);
  tell_notes(*scene, o.scene);
  const auto tracer = std::make_shared<const Tracer>(*scene);
  catch_interrupts();
  BakePlaces places = find_places(o, scene, tracer);
  places.gltf = import_options.gltf_parts;
  for (const std::string& note : places.layout.notes) inform("note: " + note);
  for (const std::string& name : texture_files(o, places.layout.atlas)) {
    files.add("--texture", name);
    files.probe(name);
  }
  files.throw_if_any_failed();
  Baked baked = compute(o, scene, tracer, places, files);
  return finish(o, *scene, std::move(baked), std::move(places), files);
}

void add_texture_options(CLI::App& c, BakeOptions& o) {
  c.add_option("-o,--output", o.output, "File to write: .glb, or .json for probes")
      ->required()
      ->option_text("FILE")
      ->group("Textures");
  add_choice(c, "--format", o.format, {"emissive", "unlit", "lightmap", "vertex", "probes"},
             "emissive: surfaces glow, for every viewer; unlit: as base colour, for the smallest devices; lightmap: "
             "irradiance beside the base colours (MOZ_lightmap); vertex: as colours of vertices, for finely divided "
             "meshes; probes: irradiance in space, as JSON")
      ->group("Textures");
  add_choice(c, "--texture", o.texture, {"png", "exr"},
             "png: 8 bits and a scale, in the file; exr: also half floats beside it, as OUTPUT.0.exr, named in the "
             "materials' extras (no KTX2: no library of Debian writes it)")
      ->group("Textures");
  add_choice(c, "--light", o.light, {"all", "indirect"}, "Light to bake: indirect leaves direct light to the viewer")
      ->group("Textures");
  add_number(c, "--texels-per-metre", o.texels_per_metre, 1e-6, 1e9,
             "Density of texels, in as many atlases as that takes; by default what one atlas holds")
      ->option_text("N")
      ->group("Textures");
  add_number(c, "--atlas", o.side, 16, kMaxAtlasSide, "Side of an atlas in texels")
      ->option_text("N [1024 to 4096, by the scene]")
      ->group("Textures");
  add_number(c, "--spacing", o.spacing, 1e-6, 1e9, "Distance between probes in metres")
      ->option_text("M")
      ->group("Textures");
  c.add_option("--atlas-picture", o.atlas_picture, "Write the atlases as a picture, too: .exr or .png")
      ->take_last()
      ->option_text("FILE")
      ->group("Textures");
  add_exposure_option(c, "Textures", o.exposure);
}

constexpr const char* kBakeFooter = R"(
Each texel is a point of a surface, and its light is computed as that of a pixel.
Light is baked on surfaces whose look does not depend on the place of the viewer;
lamps glow, and glass and mirrors are left as they are. The file's values are
radiance in W sr^-1 m^-2 (lightmap: irradiance in W m^-2) times 2^exposure.
Everything else in a glTF file stays as it is: animations, skins, extensions,
names, extras. A mesh that several nodes share is copied for each node, and
meshes compressed by Draco are written without compression. Lamps and lights
are multiplied by the exposure; lights that a lightmap holds get intensity 0.

Examples:
  glowworm bake builtin:cornell -o lit.glb
  glowworm bake room.glb --format lightmap --light indirect --texels-per-metre 50 -o lit.glb
  glowworm bake builtin:atrium --atlas 2048 --time 5m -o lit.glb --atlas-picture light.png)";

}  // namespace

void add_bake_command(CLI::App& program, const std::string& command_line, int& exit_status) {
  auto o = std::make_shared<BakeOptions>();
  o->command_line = command_line;
  CLI::App* c = program.add_subcommand("bake", "Writes a scene with its light in textures (GLB).");
  add_scene_argument(*c, o->scene);
  add_texture_options(*c, *o);
  add_scene_options(*c, o->changes);
  add_table_options(*c, "Method", false, o->table);
  add_table_options(*c, "Effort", false, o->table);
  c->add_option("--resume", o->resume, "Keep a checkpoint in a file, and continue from it if it exists")
      ->take_last()
      ->option_text("FILE")
      ->group("Effort");
  add_table_options(*c, "Machine", false, o->table);
  c->add_flag("-v,--verbose", o->verbose, "Print choices, too")->group("Reports");
  c->add_flag("-q,--quiet", o->quiet, "Print warnings and errors only")->group("Reports");
  c->footer(kBakeFooter);
  c->callback([o, &exit_status] { exit_status = run_bake(*o); });
}

}  // namespace glowworm
