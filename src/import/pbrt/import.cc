#include "import/pbrt/import.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <new>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "import/pbrt/builder.h"
#include "import/pbrt/file.h"
#include "import/pbrt/parser.h"
#include "import/texture_cache.h"

namespace glowworm {

namespace {

/// Triangles whose share of a scene's tables and of the tracer's structures fits into half of the memory.
std::size_t triangles_in_memory() {
  constexpr std::size_t kBytesEach = 200;
  const auto pages = static_cast<std::size_t>(std::max(::sysconf(_SC_PHYS_PAGES), 1L));
  const auto page_size = static_cast<std::size_t>(std::max(::sysconf(_SC_PAGESIZE), 1L));
  return pages * page_size / 2 / kBytesEach;
}

}  // namespace

SceneDescription load_pbrt(const std::string& path, const ImportOptions& options, const PbrtLimits& limits) try {
  PbrtContext context;
  context.main_file = path;
  context.scene.name = std::filesystem::path(path).stem().string();
  const std::string text = read_pbrt_file(path);
  context.v3 = is_pbrt_v3(text);
  NoteCounter texture_notes;
  TextureCache textures(options, texture_notes);
  context.load_image = [&textures](const std::string& file, const TextureOptions& texture_options) {
    const std::filesystem::path full(file);
    const std::string found = find_texture_file(full.parent_path().string(), full.filename().string());
    return textures.load_file(found, texture_options);
  };
  context.max_triangles = limits.max_triangles > 0 ? limits.max_triangles : triangles_in_memory();
  PbrtBuilder builder(context);
  parse_pbrt_text(text, path, context.diagnostics, [&](PbrtDirective& directive) {
    check_cancelled();
    builder.take(directive);
  });
  builder.finish();
  context.diagnostics.throw_if_errors();
  for (std::string& note : context.diagnostics.notes()) context.scene.notes.push_back(std::move(note));
  texture_notes.write_to(context.scene.notes);
  return std::move(context.scene);
} catch (const std::bad_alloc&) {
  throw Error({path}, "the scene does not fit into memory", "Use simpler meshes or a machine with more memory.");
}

}  // namespace glowworm
