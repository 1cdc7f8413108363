#include "image/image_reader.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cfenv>

#include "core/error.h"

namespace glowworm {

namespace {

constexpr const char* kLibrary = "libglowworm_openimageio.so";

OpenImageFunction* load_library() {
  // Math libraries change the floating-point settings of the thread that loads them.
  std::fenv_t arithmetic;
  std::fegetenv(&arithmetic);
  void* library = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
  std::fesetenv(&arithmetic);
  void* function = library ? dlsym(library, kOpenImageFunction) : nullptr;
  if (!function) {
    throw MissingLibrary(
        fmt::format("the library that reads image files cannot be loaded ({})", dlerror()),
        fmt::format("Keep {} in the folder of the program, and install Debian's libopenimageio2.4.", kLibrary));
  }
  return reinterpret_cast<OpenImageFunction*>(function);
}

}  // namespace

std::unique_ptr<ImageReader> open_image_reader(const std::string& path, const char* plugin, std::string& failure) {
  static OpenImageFunction* const open = load_library();
  return std::unique_ptr<ImageReader>(open(path.c_str(), plugin, failure));
}

}  // namespace glowworm
