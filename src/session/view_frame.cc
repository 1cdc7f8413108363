#include "session/view_frame.h"

namespace glowworm {

Image frame_image(const ViewFrame& frame) {
  Image image(frame.image.width, frame.image.height);
  image.add_rgb("", frame.image.light);
  image.add_rgb("albedo", frame.image.albedo);
  image.add_vec3("normal", frame.image.normal);
  image.add_scalar("depth.Z", frame.image.depth);
  return image;
}

}  // namespace glowworm
