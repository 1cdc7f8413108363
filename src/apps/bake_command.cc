#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
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
#include "control/job.h"
#include "control/job_report.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/input_file.h"
#include "core/log.h"
#include "core/memory_budget.h"
#include "core/names.h"
#include "core/text.h"
#include "film/checkpoint.h"
#include "film/filtered.h"
#include "film/part.h"
#include "gltf_writer/scene_glb.h"
#include "image/image.h"
#include "settings/settings.h"

namespace glowworm {

namespace {

struct BakeOptions : LightOptions {
  std::string output, atlas_picture, resume, from, format = "emissive", light = "all", texture = "png";
  std::optional<float> exposure;  ///< stops; none: chosen by the light
  double texels_per_metre = 0, spacing = 0;
  bool allow_outside = false;
  std::uint32_t side = 0;
  RenderSettings settings;  ///< of the table, for this bake

  bool is_probes() const { return format == "probes"; }
  bool is_part() const { return lower_ending(output) == ".part"; }
};

/// Refuses options of textures for probes, and options of probes for textures.
void check_places(const BakeOptions& o) {
  if (o.is_probes() && !(o.spacing > 0))
    throw CommandLineError("--format probes needs a distance between probes", "Give --spacing, for example 0.5.");
  if (!o.is_probes() && o.spacing > 0)
    throw CommandLineError("--spacing is for probes", "Give --format probes, or leave it out.");
  const std::pair<const char*, bool> of_textures[] = {{"--atlas-picture", !o.atlas_picture.empty()},
                                                      {"--exposure", o.exposure.has_value()},
                                                      {"--atlas", o.side > 0},
                                                      {"--texels-per-metre", o.texels_per_metre > 0}};
  for (const auto& [name, is_given] : of_textures)
    if (o.is_probes() && is_given)
      throw CommandLineError(fmt::format("--format probes has no textures for {}", name), "Leave it out.");
  if (o.texture != "png" && o.format == "vertex")
    throw CommandLineError("--format vertex has no textures", "Leave --texture out.");
  if (o.texture == "rgbm" && o.is_probes())
    throw CommandLineError("--format probes has no RGBM picture", "Give --texture exr, or leave it out.");
}

void resolve_options(BakeOptions& o) {
  o.settings = o.table.settings;
  o.settings.memory_bytes = o.memory_bytes();
  if (o.light == "indirect") o.settings.indirect_only = true;
  const char* const expected = o.is_probes() ? ".json" : ".glb";
  const std::string ending = lower_ending(o.output);
  if (ending != expected && !o.is_part())
    throw CommandLineError(fmt::format("'{}' does not end in {} or .part", o.output, expected),
                           "Give -o a name with this ending.");
  read_command_line([&] { check_part(o.settings); });
  if (o.is_part()) check_part_output(o.output, o.settings);
  if (const std::string name = lower_ending(o.atlas_picture);
      !o.atlas_picture.empty() && name != ".exr" && name != ".png")
    throw CommandLineError(fmt::format("'{}' ends neither in .exr nor in .png", o.atlas_picture),
                           "Give --atlas-picture a name with one of these endings.");
  if (o.is_part() && !o.atlas_picture.empty())
    throw CommandLineError("--atlas-picture needs the light of all parts", "Give it with --from.");
  if (!o.from.empty() && (o.is_part() || !o.resume.empty() || !o.settings.part.is_all()))
    throw CommandLineError("--from computes no light", "Leave out --part, --resume and -o with a part.");
  check_places(o);
  if (o.is_probes()) o.settings.filter = Filtering::off;
  o.settings.separate_layers = filters(o.settings);
  keep_heap_small(o.settings.memory_bytes);
}

/// Name of the picture of probes: probes.exr beside probes.json. "" where there is none.
std::string probes_picture(const BakeOptions& o) {
  const bool has_one = o.is_probes() && o.texture == "exr" && !o.is_part();
  return has_one ? std::filesystem::path(o.output).replace_extension("exr").string() : "";
}

void prepare_outputs(const BakeOptions& o, OutputFiles& files) {
  files.add_input("the scene", o.scene);
  files.add("-o", o.output);
  files.add_input("--from", o.from);
  files.add("--atlas-picture", o.atlas_picture);
  files.add("--resume", o.resume);
  if (!o.resume.empty() && std::filesystem::exists(o.resume)) check_input_file(o.resume);
  files.add("--texture", probes_picture(o));
  files.probe_all();
}

/// Writes the light of all texels as a picture: .exr linear, .png with the texture's scale.
void write_atlas_picture(const BakeOptions& o, const BakeLayout& layout, const std::vector<RGB>& light,
                         const EncodedLight& encoded) {
  Image picture(layout.texels.width, layout.texels.height);
  picture.add_rgb("", light);
  picture.metadata["comments"] = o.command_line;
  write_image(o.atlas_picture, picture, ToneCurve::srgb, -std::log2(encoded.scale));
}

/// Names of the files with the light of each atlas in full range: lit.0.exr or lit.0.rgbm.png beside lit.glb.
std::vector<std::string> texture_files(const BakeOptions& o, const Atlas& atlas) {
  std::vector<std::string> out;
  const char* const ending = o.texture == "exr" ? "exr" : "rgbm.png";
  for (int a = 0; o.texture != "png" && a < atlas.count; ++a)
    out.push_back(std::filesystem::path(o.output).replace_extension(fmt::format("{}.{}", a, ending)));
  return out;
}

/// Writes these files, and returns what the GLB file says of them.
std::vector<BakeNotes::TextureFile> write_texture_files(const BakeOptions& o, const Atlas& atlas,
                                                        std::span<const RGB> light, OutputFiles& files) {
  std::vector<BakeNotes::TextureFile> out;
  const std::size_t texels = static_cast<std::size_t>(atlas.side) * static_cast<std::size_t>(atlas.side);
  for (const std::string& name : texture_files(o, atlas)) {
    const std::span<const RGB> own = light.subspan(out.size() * texels, texels);
    out.push_back({std::filesystem::path(name).filename()});
    files.write_and_report(name, [&] {
      if (o.texture == "rgbm") {
        RgbmLight encoded = encode_rgbm(own);
        out.back().range = encoded.range;
        return write_file(name, encode_png(atlas.side, atlas.side, 4, std::move(encoded.codes),
                                           {{"Comment", fmt::format("RGBM, range {}", encoded.range)}}));
      }
      Image picture(atlas.side, atlas.side);
      picture.add_rgb("", own);
      picture.metadata["comments"] = o.command_line;
      write_exr(name, picture);
    });
  }
  return out;
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
  out.layout = lay_out(scene, tracer, {static_cast<int>(o.side), o.texels_per_metre, o.settings.memory_bytes});
  out.points = std::make_shared<const PointGrid>(texel_points(*scene, *tracer, out.layout));
  return out;
}

void write_probes(const BakeOptions& o, const std::vector<RGB>& irradiance, const ProbeGrid& probes,
                  OutputFiles& files) {
  files.write_text(o.output, [&] { return probes_json(probes, irradiance, o.command_line); });
  const std::string picture = probes_picture(o);
  files.write_and_report(picture, [&] { write_exr(picture, probes_image(probes, irradiance, o.command_line)); });
}

void write_textures(const BakeOptions& o, const Scene& scene, const Tracer& tracer, TexelIrradiance irradiance,
                    const BakePlaces& places, OutputFiles& files) {
  const BakeLayout& layout = places.layout;
  const auto format = static_cast<BakeFormat>(name_index("--format", o.format, bake_format_names()));
  const std::vector<RGB> light =
      light_of_texels(scene, layout, std::move(irradiance), shown_light(format, places.gltf.get()));
  const float exposure =
      o.exposure ? *o.exposure : automatic_exposure(scene, tracer, layout, light, quantity_of(format));
  const EncodedLight encoded = encode_light(layout, light, range_of(scene, layout, format, exposure));
  const BakeNotes notes{exposure,
                        o.command_line,
                        write_texture_files(o, layout.atlas, light, files),
                        places.gltf,
                        o.settings.indirect_only,
                        o.changes.changes.metres_per_unit,
                        o.allow_outside,
                        std::filesystem::path(o.output).parent_path().string()};
  const bool written =
      files.write(o.output, [&] { write_file(o.output, glb_of_scene(scene, layout, encoded, format, notes)); });
  if (!o.atlas_picture.empty()) files.write(o.atlas_picture, [&] { write_atlas_picture(o, layout, light, encoded); });
  if (encoded.clipped > 0.001)
    inform(fmt::format("note: {:.1f}% of the texels are brighter than 8 bits show{}", 100 * encoded.clipped,
                       format == BakeFormat::vertex ? "" : ": --texture exr or rgbm keeps all light"));
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

/// Runs a Job with progress and, where wanted, a checkpoint. Returns its exception, or null.
std::exception_ptr attend(const BakeOptions& o, Job& job, OutputFiles& files,
                          const std::function<Checkpoint()>& checkpoint) {
  const auto keep = [&] { files.write(o.resume, [&] { write_checkpoint(o.resume, checkpoint()); }); };
  std::vector<RepeatedWork> repeated;
  if (!o.resume.empty()) repeated.push_back({1, keep});
  const std::exception_ptr failure = attend(job, o.report.quiet, std::move(repeated));
  if (!o.resume.empty()) keep();
  return failure;
}

void tell_choices(const BakeOptions& o, const BakePlaces& places, const Job& job) {
  inform(describe(o, places, job));
  for (const std::string& note : choice_notes(o.table.settings, job.settings())) detail("chosen: " + note);
}

std::optional<Checkpoint> checkpoint_of(const BakeOptions& o) {
  if (o.resume.empty()) return std::nullopt;
  return read_checkpoint(o.resume, o.settings.disk, o.settings.memory_bytes);
}

/// Runs the Jobs of a bake.
Baked compute(const BakeOptions& o, const std::shared_ptr<const Scene>& scene,
              const std::shared_ptr<const Tracer>& tracer, const BakePlaces& places, OutputFiles& files) {
  if (!o.from.empty()) return points_of_part(o.from, *scene, *places.points, o.settings, o.table.given);
  const auto attend_band = [&](const BandRun& run) {
    if (run.number == 0) tell_choices(o, places, run.job);
    if (run.band.end - run.band.first < places.points->height)
      inform(fmt::format("rows {} of {}, as --memory allows", run.band.end, places.points->height));
    return attend(o, run.job, files, [&] { return run.checkpoint(); });
  };
  return bake_points(scene, tracer, places.points, o.settings, checkpoint_of(o), attend_band);
}

/// Computes the light of the points by some of the samples, as a file that `glowworm merge` reads. Returns the exit
/// status.
int bake_part(const BakeOptions& o, const std::shared_ptr<const Scene>& scene,
              const std::shared_ptr<const Tracer>& tracer, const BakePlaces& places, OutputFiles& files) {
  std::optional<Checkpoint> checkpoint = checkpoint_of(o);
  Job job(scene, tracer, bake_settings(o.settings, *places.points), checkpoint ? &*checkpoint : nullptr, 0,
          places.points);
  checkpoint.reset();
  tell_choices(o, places, job);
  const std::exception_ptr failure = attend(o, job, files, [&] { return job.checkpoint(); });
  const bool any = job.passes() > 0;
  if (any) files.write_and_report(o.output, [&] { write_part(o.output, part_of(job), job.snapshot()); });
  if (failure) std::rethrow_exception(failure);
  if (!any) warn("the bake ended before every point had light: no file was written");
  files.throw_if_any_failed();
  inform(fmt::format("{} passes in {:.2f} s", job.passes(), job.seconds()));
  if (job.ending() == Ending::cancelled) return kExitSignalled + caught_interrupt();
  return any ? 0 : 1;
}

/// Writes the results, then throws the error, if any, or returns the exit status.
int finish(const BakeOptions& o, const Scene& scene, const Tracer& tracer, Baked baked, BakePlaces places,
           OutputFiles& files) {
  const bool any = baked.passes > 0;
  places.points = nullptr;
  if (any && o.is_probes()) write_probes(o, baked.irradiance.value, places.probes, files);
  if (any && !o.is_probes()) write_textures(o, scene, tracer, std::move(baked.irradiance), places, files);
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
  o.apply();
  resolve_options(o);
  OutputFiles files;
  prepare_outputs(o, files);
  ImportOptions import_options;
  import_options.budget = loading_budget(o.settings.memory_bytes);
  import_options.light_uvs = true;
  import_options.gltf_parts = std::make_shared<GltfParts>();
  import_options.outside_files = std::make_shared<std::vector<std::string>>();
  // Each instance needs texels of its own.
  if (!o.is_probes()) o.changes.changes.expand_instances = true;
  const std::shared_ptr<const Scene> scene = open_scene(o.scene, import_options, o.changes.changes, &files);
  if (!o.allow_outside)
    check_outside_files(*import_options.outside_files, import_options.gltf_parts.get(), "--allow-outside");
  tell_notes(*scene, o.scene);
  const auto tracer = std::make_shared<const Tracer>(*scene);
  catch_interrupts();
  BakePlaces places = find_places(o, scene, tracer);
  places.gltf = import_options.gltf_parts;
  for (const std::string& note : places.layout.notes) inform("note: " + note);
  if (o.settings.indirect_only && !o.is_probes() && o.format != "lightmap")
    inform(fmt::format(
        "note: viewers add no direct light to --format {}; for indirect light alone, give --format lightmap or probes",
        o.format));
  if (o.is_part()) return bake_part(o, scene, tracer, places, files);
  for (const std::string& name : texture_files(o, places.layout.atlas)) files.add("--texture", name);
  files.probe_all();
  Baked baked = compute(o, scene, tracer, places, files);
  return finish(o, *scene, *tracer, std::move(baked), std::move(places), files);
}

std::string refuse_ktx2(const std::string& texture) {
  if (texture.starts_with("ktx"))
    throw CommandLineError("--texture " + texture + ": KTX2 needs an encoder that no library of Debian has",
                           "Give --texture rgbm or exr, or convert the PNG files of the GLB by toktx or basisu.");
  return "";
}

void add_texture_options(CLI::App& c, BakeOptions& o) {
  std::vector<std::string> formats = bake_format_names();
  formats.emplace_back("probes");
  c.add_option("-o,--output", o.output, "File to write: .glb, or .json for probes; .part for 'glowworm merge'")
      ->required()
      ->option_text("FILE")
      ->group("Textures");
  add_choice(c, "--format", o.format, formats,
             "emissive: surfaces glow, for every viewer; unlit: as base colour, for the smallest devices; lightmap: "
             "irradiance beside the base colours (MOZ_lightmap); vertex: as colours of vertices, for finely divided "
             "meshes; probes: irradiance in space, as JSON")
      ->group("Textures");
  add_choice(c, "--texture", o.texture, {"png", "exr", "rgbm"},
             "png: 8 bits and a scale, in the file, which may end two stops above white; also beside it, named in the "
             "materials' extras: exr: half floats, as OUTPUT.0.exr (probes: their coefficients, as OUTPUT.exr); rgbm: "
             "8 bits and a multiplier, as OUTPUT.0.rgbm.png")
      ->check(refuse_ktx2)
      ->group("Textures");
  add_choice(c, "--light", o.light, {"all", "indirect"},
             "Light to bake: indirect leaves direct light to the viewer, which adds it to a lightmap or probes only")
      ->group("Textures");
  add_number(c, "Textures", "--texels-per-metre", o.texels_per_metre, 1e-6, 1e9, "N",
             "Density of texels, in as many atlases as that takes; by default what one atlas holds");
  add_number(c, "Textures", "--atlas", o.side, 16, kMaxAtlasSide, "N [1024 to 4096, by the scene]",
             "Side of an atlas in texels");
  add_number(c, "Textures", "--spacing", o.spacing, 1e-6, 1e9, "M", "Distance between probes in metres");
  add_text(c, "Textures", "--atlas-picture", o.atlas_picture, "FILE",
           "Write the atlases as a picture, too: .exr or .png");
  add_exposure_option(c, "Textures", o.exposure);
  c.add_flag("--allow-outside", o.allow_outside,
             "Also copy files that the scene names outside its folder, such as textures")
      ->group("Textures");
}

constexpr const char* kBakeFooter = R"(
The light of a texel is computed like a pixel, with samples over its area.
Light is baked on surfaces whose look does not depend on the place of the viewer;
lamps, glass and mirrors are left as they are. The file's values are
radiance in W sr^-1 m^-2 (lightmap: irradiance in W m^-2) times 2^exposure.
Probes hold irradiance in W m^-2 without a factor.
Everything else in a glTF file stays as it is: animations, skins, extensions,
names, extras. A mesh that several nodes share is copied for each node, and
meshes compressed by Draco are written without compression. Lamps and lights
are multiplied by the exposure; lights that a lightmap holds get intensity 0.
A texel of an RGBM file shows rgbm * (R, G, B)/255 * M/255, linear, with M the
alpha and rgbm the number in the extras.

Examples:
  glowworm bake builtin:cornell -o lit.glb
  glowworm bake room.glb --format lightmap --light indirect --texels-per-metre 50 -o lit.glb
  glowworm bake room.glb --part 1/2 -o 1.part
  glowworm bake room.glb --part 2/2 -o 2.part
  glowworm merge 1.part 2.part -o all.part
  glowworm bake room.glb --from all.part -o lit.glb
  glowworm bake builtin:atrium --atlas 2048 --time 5m -o lit.glb --atlas-picture light.png)";

}  // namespace

void add_bake_command(CLI::App& program, const std::string& command_line, int& exit_status) {
  auto o = std::make_shared<BakeOptions>();
  o->command_line = command_line;
  CLI::App* c = program.add_subcommand("bake", "Writes a scene with its light in textures (GLB).");
  add_scene_argument(*c, o->scene);
  add_texture_options(*c, *o);
  add_method_options(*c, Command::bake, *o);
  add_text(*c, "Effort", "--resume", o->resume, "FILE",
           "Keep a checkpoint in a file, and continue from it if it exists");
  add_text(*c, "Effort", "--from", o->from, "PART",
           "Take the light from a part, as of 'glowworm merge', and compute none");
  add_report_options(*c, false, o->report);
  c->footer(kBakeFooter);
  c->callback([o, &exit_status] { exit_status = run_bake(*o); });
}

}  // namespace glowworm
