#include "apps/open_scene.h"

#include <utility>

#include "core/error.h"

namespace glowworm {

std::shared_ptr<const Scene> open_scene(const std::string& path, const ImportOptions& options) {
  SceneDescription description = load_scene(path, options);
  try {
    return std::make_shared<const Scene>(std::move(description));
  } catch (const Error& error) {
    throw Error(FilePlace{path}, error.what());
  }
}

}  // namespace glowworm
