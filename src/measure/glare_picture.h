// Pictures that are rated for glare, and pictures that show the sources.
#pragma once
#include <string>

#include "image/image.h"
#include "measure/glare.h"
#include "scene/radiance_view.h"

namespace glowworm {

/// A picture of a file as luminance around its view. Without whiteLuminance, pixels are W sr^-1 m^-2 in each channel,
/// as in Radiance's pictures, by kLuminousEfficacy.
/// @param view fisheye or hemispherical. Throws Error, with the remedy, for another.
GlarePicture glare_picture_of(const Image& image, const RadianceView& view);

/// The view of a picture of a file: `given`, unless it is empty, or that of the file's header. Throws Error if neither
/// is there.
RadianceView view_of_picture(const Image& image, const std::string& path, const std::string& given);

/// The picture in grey, with each source in a colour of its own and of the same luminance, as evalglare's check file
/// has them (option -c).
/// @param rings draw a ring around every source, also around those that are less than a pixel; rings have other
/// luminances than the picture
Image glare_image(const GlarePicture& picture, const Glare& glare, bool rings);

}  // namespace glowworm
