// The picture that people see: the film with its gathered light filtered.
#pragma once
#include <cstdint>
#include <vector>

#include "core/rgb.h"
#include "film/earlier_frames.h"
#include "film/film.h"
#include "filter/light_filter.h"

namespace glowworm {

/// A film's picture; one entry a pixel.
struct FilmPicture {
  std::vector<RGB> radiance;    ///< W sr^-1 m^-2
  std::vector<float> variance;  ///< of its luminance, as an estimate of what infinitely many samples would give; with
                                ///< squared bias of filters
  int width = 0;                ///< pixels of a row; 0: pixels are not beside each other
  /// Samples of earlier frames: as many as the variance tells of beside the pixel's own. Empty: none.
  std::vector<float> earlier = {};
};

/// The means of all samples.
FilmPicture unfiltered_picture(const Film& film, bool indirect_only);

/// Filters direct and indirect light, divided by albedo, and light of media apart (filter/light_filter.h), filters
/// edges (filter/edge_filter.h), and adds caustic light as it is: its noise comes from the photons, which samples
/// share. Where the film keeps surface samples, their albedo and emission replace the samples' own.
/// @param film with moments (Film::has_moments())
/// @param earlier frames whose light is used again; null: none
FilmPicture filtered_picture(const Film& film, bool indirect_only, const EarlierFrames* earlier = nullptr);

/// The one of the two that a render of these settings shows.
FilmPicture shown_picture(const Film& film, const RenderSettings& settings, const EarlierFrames* earlier = nullptr);

/// What later frames may use of a film with moments. @param view with the film's bounds
FrameLight light_of_frame(const Film& film, FrameView view, bool indirect_only);

/// As filtered_picture(), for a film of texels. It leaves edges as they are: texels beside each other may be of
/// surfaces far apart.
/// @param rows of the film that are wanted; the others have no meaning
FilmPicture filtered_texels(const Film& film, bool indirect_only, FilteredRows rows);

/// Relative standard error of a picture: the root over pixels of the mean of variance / (m^2 + 0.01 M^2), with M the
/// mean luminance of the picture and m the luminance of the pixel, or of the 5 x 5 pixels around it where that is less:
/// the error of a single bright sample is large for what the pixel should show. What photons that all samples share add
/// to it is not in it.
double relative_error(const FilmPicture& picture);

/// M, and a pixel's part of that mean.
double mean_luminance(const FilmPicture& picture);
double relative_variance(const FilmPicture& picture, std::size_t pixel, double mean_luminance);

/// Bytes that these take for each pixel.
inline constexpr std::uint64_t kFilterBytes = kFilterBytesEach;

}  // namespace glowworm
