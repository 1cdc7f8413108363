#include "import/pbrt/context.h"

#include "import/pbrt/file.h"

namespace glowworm {

std::string PbrtContext::resolve(const std::string& name, const PbrtPlace& place) const {
  return resolve_pbrt_path(name, main_file, place.file ? *place.file : main_file);
}

}  // namespace glowworm
