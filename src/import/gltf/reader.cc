#include "import/gltf/reader.h"

#include "import/gltf/animation.h"

namespace glowworm {

const GltfDocument& GltfReader::document(const std::string& path, const ImportOptions& options) {
  const bool is_there = document_ && document_->path == path && animation_ == options.moment.animation;
  if (is_there && !is_of_one_moment_) return *document_;
  meshes_.reset();
  document_.reset();
  document_ = read_gltf_document(path, options);
  meshes_.emplace(options.budget);
  animation_ = options.moment.animation;
  is_of_one_moment_ = moves_properties(*document_, animation_);
  return *document_;
}

std::shared_ptr<GltfReader> gltf_reader() { return std::make_shared<GltfReader>(); }

}  // namespace glowworm
