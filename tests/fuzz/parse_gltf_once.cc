#include <cstdint>
#include <span>

#include "core/error.h"
#include "fuzz/parse_once.h"
#include "import/gltf/document.h"
#include "import/gltf/import.h"

namespace glowworm::fuzz {

void parse_gltf(std::string_view bytes) {
  try {
    const std::span file(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    ImportOptions options;
    options.budget = loading_budget(kBudget);
    CoordinateOrigin origin;
    expect_consistent(read_near(origin, [&] {
      return build_gltf_scene(read_gltf_document(file, "/nonexistent/fuzz.glb", options), options, origin);
    }));
  } catch (const Error&) {
  }
}

}  // namespace glowworm::fuzz
