// The layers that a picture may have beside the image. A new one takes a row in settings/layers.cc and one in aov.cc,
// and a sum of the Film if the layer cannot be computed from the sums that exist.
#pragma once
#include "film/film.h"
#include "film/filtered.h"
#include "film/picture_info.h"
#include "image/image.h"

namespace glowworm {

/// What a layer is made of.
struct LayerSource {
  const Film& film;
  const PictureInfo& info;
  const FilmPicture& picture;  ///< the image
};

/// Adds the channels of a layer of aov_names() to a picture of the film, and what readers need to know to its metadata.
/// Throws Error where there is no such layer.
void add_layer(Image& image, const LayerSource& source, const std::string& name);

/// Adds the layer of a group of light sources: "light." and its name, with '_' in place of every character other than
/// letters, digits and '-'.
void add_light_group(Image& image, const LayerSource& source, std::size_t group);

/// The 32-bit hash of a name that Cryptomatte takes for its number: MurmurHash3_x86_32 of seed 0 (Appleby), with one
/// bit of the exponent turned where the number, read as a float, would be a denormal, infinite or no number (J.
/// Friedman, A. Jones, "Cryptomatte Specification" 1.2.0).
std::uint32_t cryptomatte_hash(std::string_view name);

}  // namespace glowworm
