// Links the code around OpenImageIO directly, instead of loading it as a module, so that it is instrumented.
#include "image/image_reader.h"

extern "C" glowworm::OpenImageFunction glowworm_open_image;

namespace glowworm {

std::unique_ptr<ImageReader> open_image_reader(const std::string& path, const char* plugin, std::string& failure) {
  return std::unique_ptr<ImageReader>(glowworm_open_image(path.c_str(), plugin, failure));
}

}  // namespace glowworm
