// Public pictures to and from pictures of the image room.
#pragma once
#include "glowworm/picture.h"
#include "image/image.h"

namespace glowworm::api {

/// Joins the planes of a picture to layers.
Picture outer(const Image& image);

/// The planes of a picture's layers. Throws Error for a layer whose samples are not of the picture's size.
Image inner(const Picture& picture);

}  // namespace glowworm::api
