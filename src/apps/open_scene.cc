#include "apps/open_scene.h"

#include <utility>

#include "core/error.h"
#include "core/input_file.h"

namespace glowworm {

std::shared_ptr<const Scene> open_scene(const std::string& path, const ImportOptions& options, OutputFiles* files) {
  const InputRecord record;
  SceneDescription description = load_scene(path, options);
  if (files)
    for (const std::string& name : record.names()) files->add_input("the scene's file", name);
  try {
    return std::make_shared<const Scene>(std::move(description));
  } catch (const Error& error) {
    throw Error(FilePlace{path}, error.what());
  }
}

}  // namespace glowworm
