#include "import/pbrt_import.h"

#include <filesystem>
#include <new>
#include <utility>

#include "core/error.h"
#include "import/pbrt_builder.h"
#include "import/pbrt_file.h"
#include "import/pbrt_parser.h"

namespace glowworm {

SceneDescription load_pbrt(const std::string& path, const ImportOptions& options, const PbrtLimits& limits) try {
  static_cast<void>(options);
  PbrtContext context;
  context.main_file = path;
  context.scene.name = std::filesystem::path(path).stem().string();
  const std::string text = read_pbrt_file(path);
  context.v3 = is_pbrt_v3(text);
  context.load_image = [](const std::string&, bool, bool) -> std::shared_ptr<const TextureImage> {
    class Magenta : public TextureImage {
      RGB color(Vec2) const override { return {1, 0, 1}; }
      float alpha(Vec2) const override { return 1; }
      bool has_alpha() const override { return false; }
      int width() const override { return 1; }
      int height() const override { return 1; }
    };
    return std::make_shared<Magenta>();
  };
  PbrtBuilder builder(context, limits.max_triangles);
  parse_pbrt_text(text, path, context.diagnostics, [&](PbrtDirective& directive) { builder.take(directive); });
  builder.finish();
  context.diagnostics.throw_if_errors();
  for (std::string& note : context.diagnostics.notes()) context.scene.notes.push_back(std::move(note));
  return std::move(context.scene);
} catch (const std::bad_alloc&) {
  throw Error({path}, "the scene does not fit into memory", "Use simpler meshes or a machine with more memory.");
}

}  // namespace glowworm
