#include "film/filtered.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "filter/edge_filter.h"
#include "filter/light_filter.h"

namespace glowworm {

namespace {

using Layer = Film::Layer;

/// What each channel of light is divided by.
/// @param layer albedo or surface_albedo
RGB shading_albedo(const Film& film, std::size_t pixel, Layer layer = Layer::albedo) {
  const RGB albedo = film.mean(layer, pixel);
  const float least = std::max(Film::kMinAlbedo, 0.05f * max_component(albedo));
  return {std::max(albedo.r, least), std::max(albedo.g, least), std::max(albedo.b, least)};
}

/// Light of media is not divided by albedo.
LightEstimate estimate_of(const Film& film, Layer layer) {
  LightEstimate estimate;
  estimate.light.resize(film.pixel_count());
  estimate.level.resize(film.pixel_count());
  estimate.variance.resize(film.pixel_count());
  estimate.samples.resize(film.pixel_count());
  parallel_for_each(film.pixel_count(), 4096, [&](std::size_t i) {
    const Film::Moments moments = film.moments(layer, i);
    estimate.light[i] = film.mean(layer, i) / (layer == Layer::medium ? RGB(1.0f) : shading_albedo(film, i));
    estimate.level[i] = moments.mean;
    estimate.variance[i] = moments.variance;
    estimate.samples[i] = film.sample_count(i);
  });
  return estimate;
}

/// @param layer whose light is filtered
FilterGuides guides_of(const Film& film, Layer layer) {
  FilterGuides guides{film.width(), film.height(), std::vector<Vec3>(film.pixel_count()),
                      std::vector<float>(film.pixel_count())};
  parallel_for_each(film.pixel_count(), 4096, [&](std::size_t i) {
    const RGB n = film.mean(Layer::normal, i);
    guides.normal[i] = {n.r, n.g, n.b};
    guides.depth[i] = film.depth(i);
    // A pixel that sees two surfaces has nearly all its noise in indirect light. Its direct light depends on the share
    // of each surface, and beside a light its albedo is a mix of both.
    if (length_squared(guides.normal[i]) < 0.95f && (layer == Layer::direct || !is_black(film.mean(Layer::emitted, i))))
      guides.normal[i].x = std::numeric_limits<float>::quiet_NaN();
  });
  return guides;
}

/// Guides of the light of media. It does not change where the surface behind turns, but where that is farther away.
FilterGuides guides_of_media(const Film& film) {
  FilterGuides guides{film.width(), film.height(), std::vector<Vec3>(film.pixel_count(), {0, 0, 1}),
                      std::vector<float>(film.pixel_count())};
  float farthest = 0;
  for (std::size_t i = 0; i < film.pixel_count(); ++i)
    if (std::isfinite(film.depth(i))) farthest = std::max(farthest, film.depth(i));
  parallel_for_each(film.pixel_count(), 4096, [&](std::size_t i) {
    // A pixel that sees nothing in part of its samples lies at an edge.
    const float hits = film.coverage(i);
    guides.depth[i] = (hits > 0 ? hits * film.depth(i) : 0) + (1 - hits) * 2 * farthest;
  });
  return guides;
}

/// What filter_edges() takes, without the variance.
EdgePicture edges_of(const Film& film) {
  const std::size_t n = film.pixel_count();
  EdgePicture out;
  out.width = film.width();
  out.height = film.height();
  out.normal.resize(n);
  out.depth.resize(n);
  out.albedo.resize(n);
  out.samples.resize(n);
  parallel_for_each(film.pixel_count(), 4096, [&](std::size_t i) {
    const RGB normal = film.mean(Layer::normal, i);
    out.normal[i] = {normal.r, normal.g, normal.b};
    const float hits = film.coverage(i);
    out.depth[i] = hits > 0 ? hits * film.depth(i) : 0;
    out.albedo[i] = film.mean(Layer::albedo, i);
    out.samples[i] = film.sample_count(i);
  });
  return out;
}

/// Adds caustic light and emission to a picture of direct and indirect light, and scales reflected light to the albedo
/// of the surface samples.
void add_surfaces(const Film& film, bool indirect_only, FilmPicture& picture) {
  parallel_for_each(film.pixel_count(), 4096, [&](std::size_t i) {
    RGB& pixel = picture.radiance[i];
    if (!indirect_only) pixel += film.mean(Layer::caustic, i);
    pixel = pixel / shading_albedo(film, i) * shading_albedo(film, i, Layer::surface_albedo);
    if (!indirect_only) pixel += film.mean(Layer::surface_emitted, i);
  });
}

/// Variance of the luminance of a pixel's mean without direct and indirect light, as at edges of surfaces.
/// Surface samples reduce it. A light that a pixel sees counts as one of even radiance that a share of the samples
/// meet. To be multiplied by gain_of_strata().
/// @param other variance by the spread of the camera samples
float variance_beside_light(const Film& film, std::size_t pixel, float other) {
  if (!film.has_surface_samples()) return other;
  const float caustic = luminance(film.mean(Layer::caustic, pixel)),
              emitted = luminance(film.mean(Layer::emitted, pixel));
  if (!(emitted > 0)) return caustic > 0 ? other : other / kSurfaceSamples;
  const auto samples = static_cast<float>(film.sample_count(pixel));
  const float level = (other * (samples - 1) + emitted * emitted) / emitted;  // mean square over mean
  const float share = std::min(luminance(film.mean(Layer::surface_emitted, pixel)) / level, 1.0f);
  return level * level * share * (1 - share) / (kSurfaceSamples * samples) + std::min(other, caustic * caustic);
}

/// Ratio of the variances of a pixel's stratified and independent samples where they come from edges:
/// n^(-1/d) for n samples and edges in d dimensions (Mitchell, as in filter/light_filter.cc). Edges of surfaces have
/// two; the choice of reflection or refraction, through which caustics are seen, adds two more.
float gain_of_strata(const Film& film, std::size_t pixel) {
  const float of_two = 1 / std::sqrt(static_cast<float>(std::max(film.sample_count(pixel), 1u)));
  return is_black(film.mean(Layer::caustic, pixel)) ? of_two : std::sqrt(of_two);
}

/// @param edges pixels are beside each other: also filter edges
FilmPicture filtered_film(const Film& film, bool indirect_only, FilteredRows rows, bool edges,
                          const EarlierFrames* earlier = nullptr) {
  FilmPicture out{std::vector<RGB>(film.pixel_count()), std::vector<float>(film.pixel_count()),
                  edges ? film.width() : 0};
  std::vector<float> of_light(film.pixel_count()), stratified(film.pixel_count());
  for (const Layer layer : {Layer::direct, Layer::indirect}) {
    if (indirect_only && layer == Layer::direct) continue;
    LightEstimate estimate = estimate_of(film, layer);
    const std::vector<float> own_variance = earlier ? estimate.variance : std::vector<float>();
    if (earlier)
      add_earlier_samples(*earlier, guides_of(film, Layer::indirect),
                          layer == Layer::direct ? &FrameLight::direct : &FrameLight::indirect, estimate);
    const FilteredLight filtered = filter_light(estimate, guides_of(film, layer), rows);
    parallel_for_each(film.pixel_count(), 4096, [&](std::size_t i) {
      const RGB albedo = shading_albedo(film, i);
      const float factor = luminance(albedo) * luminance(albedo);
      out.radiance[i] += filtered.light[i] * albedo;
      out.variance[i] += filtered.variance[i] * factor;
      of_light[i] += (earlier ? own_variance : estimate.variance)[i] * factor;
      stratified[i] += filtered.unfiltered[i] * factor;
    });
  }
  FilteredLight medium;
  if (film.has_moments_of_media() && !indirect_only) {
    const LightEstimate estimate = estimate_of(film, Layer::medium);
    medium = filter_light(estimate, guides_of_media(film), rows);
    parallel_for_each(film.pixel_count(), 4096, [&](std::size_t i) { of_light[i] += estimate.variance[i]; });
  }
  if (edges) {
    EdgePicture picture = edges_of(film);
    picture.variance = stratified;
    filter_edges(picture, out.radiance, out.variance);
  }
  // What varies beside, as at edges of surfaces, stays.
  parallel_for_each(film.pixel_count(), 4096, [&](std::size_t i) {
    const float other = variance_beside_light(film, i, std::max(film.variance(i) - of_light[i], 0.0f));
    out.variance[i] += other * gain_of_strata(film, i);
  });
  add_surfaces(film, indirect_only, out);
  for (std::size_t i = 0; i < medium.light.size(); ++i) {
    out.radiance[i] += medium.light[i];
    out.variance[i] += medium.variance[i];
  }
  return out;
}

/// Mean of 5 x 5 pixels, fewer at borders of the picture.
double luminance_around(const FilmPicture& picture, std::size_t pixel) {
  constexpr int kReach = 2;
  const int width = picture.width, height = static_cast<int>(picture.radiance.size()) / width;
  const int x = static_cast<int>(pixel) % width, y = static_cast<int>(pixel) / width;
  double sum = 0;
  int count = 0;
  for (int v = std::max(y - kReach, 0); v < std::min(y + kReach + 1, height); ++v)
    for (int u = std::max(x - kReach, 0); u < std::min(x + kReach + 1, width); ++u, ++count)
      sum += luminance(picture.radiance[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                                        static_cast<std::size_t>(u)]);
  return sum / count;
}

}  // namespace

double mean_luminance(const FilmPicture& picture) {
  double sum = 0;
  for (const RGB& pixel : picture.radiance) sum += luminance(pixel);
  return sum / static_cast<double>(picture.radiance.size());
}

double relative_variance(const FilmPicture& picture, std::size_t pixel, double mean_luminance) {
  double level = luminance(picture.radiance[pixel]);
  if (picture.width > 0) level = std::min(level, luminance_around(picture, pixel));
  const double scale = level * level + 0.01 * mean_luminance * mean_luminance;
  return scale > 0 ? picture.variance[pixel] / scale : 0;
}

double relative_error(const FilmPicture& picture) {
  const double mean = mean_luminance(picture);
  double sum = 0;
  for (std::size_t i = 0; i < picture.radiance.size(); ++i) sum += relative_variance(picture, i, mean);
  return std::sqrt(sum / static_cast<double>(picture.radiance.size()));
}

FilmPicture unfiltered_picture(const Film& film, bool indirect_only) {
  FilmPicture out{std::vector<RGB>(film.pixel_count()), std::vector<float>(film.pixel_count()), film.width()};
  parallel_for_each(film.pixel_count(), 4096, [&](std::size_t i) {
    out.radiance[i] = film.radiance(i, indirect_only);
    out.variance[i] = film.variance(i);
  });
  return out;
}

FilmPicture shown_picture(const Film& film, const RenderSettings& settings, const EarlierFrames* earlier) {
  return filters(settings) ? filtered_picture(film, settings.indirect_only, earlier)
                           : unfiltered_picture(film, settings.indirect_only);
}

FilmPicture filtered_picture(const Film& film, bool indirect_only, const EarlierFrames* earlier) {
  return filtered_film(film, indirect_only, {}, true, earlier);
}

FrameLight light_of_frame(const Film& film, FrameView view) {
  return {std::move(view), guides_of(film, Layer::indirect), estimate_of(film, Layer::direct),
          estimate_of(film, Layer::indirect)};
}

FilmPicture filtered_texels(const Film& film, bool indirect_only, FilteredRows rows) {
  return filtered_film(film, indirect_only, rows, false);
}

}  // namespace glowworm
