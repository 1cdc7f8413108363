#include "density/kernel.h"

namespace glowworm {

const std::vector<std::string>& kernel_names() {
  static const std::vector<std::string> names = {"box", "cone", "epanechnikov", "gaussian"};
  return names;
}

}  // namespace glowworm
