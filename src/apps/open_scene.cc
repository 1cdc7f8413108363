#include "apps/open_scene.h"

#include <fmt/format.h>

#include <utility>

#include "core/error.h"
#include "core/input_file.h"
#include "core/log.h"

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

void tell_notes(const Scene& scene, const std::string& path) {
  for (const std::string& note : scene.notes()) {
    const bool is_wrong = note.find("' is magenta: ") != std::string::npos;
    is_wrong ? warn(fmt::format("{}: {}", path, note)) : inform(fmt::format("note: {}: {}", path, note));
  }
}

}  // namespace glowworm
