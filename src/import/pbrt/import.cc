#include "import/pbrt/import.h"

#include <filesystem>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "import/pbrt/builder.h"
#include "import/pbrt/file.h"
#include "import/pbrt/parser.h"
#include "import/texture_cache.h"

namespace glowworm {

SceneDescription load_pbrt(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin) {
  PbrtContext context(origin);
  context.budget = options.budget;
  context.main_file = path;
  context.seconds = options.moment.seconds;
  context.motion = options.motion.get();
  if (!options.moment.animation.empty())
    throw Error({path}, "animations of pbrt files have no names", "Leave out --animation; --at gives the moment.");
  context.scene.name = std::filesystem::path(path).stem().string();
  Reservation held(*options.budget, "scene files", 0);
  const std::string text = read_pbrt_file(path, held);
  context.v3 = is_pbrt_v3(text);
  NoteCounter texture_notes;
  TextureCache textures(options, texture_notes);
  const auto find = [](const std::filesystem::path& file) {
    return find_texture_file(file.parent_path().string(), file.filename().string());
  };
  context.load_image = [&](const std::string& file, const TextureOptions& texture_options, StandIn stand_in) {
    return textures.load_file(find(file), texture_options, stand_in);
  };
  context.load_needed_image = [&](const std::string& file, const TextureOptions& texture_options, StandIn) {
    return textures.load_needed_file(find(file), texture_options);
  };
  PbrtBuilder builder(context);
  parse_pbrt_text(text, path, context.diagnostics, *options.budget, [&](PbrtDirective& directive) {
    check_cancelled();
    builder.take(directive);
  });
  builder.finish();
  context.diagnostics.throw_if_errors();
  if (!context.moves && (context.seconds > 0 || (context.motion && !context.motion->is_still)))
    throw Error({path}, "nothing moves in the file", "Leave out --at, and --frames without --script or --turntable.");
  for (std::string& note : context.diagnostics.notes()) context.scene.notes.push_back(std::move(note));
  texture_notes.write_to(context.scene.notes);
  return std::move(context.scene);
}

}  // namespace glowworm
