#include "film/filtered.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/parallel.h"
#include "filter/edge_filter.h"

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

/// Light of media is not divided by albedo. That of a sun is left out: it has no noise but that of edges, which surface
/// samples reduce, and spots of it are often smaller than a pixel.
LightEstimate estimate_of(const Film& film, Layer layer) {
  LightEstimate estimate;
  estimate.light.resize(film.pixel_count());
  estimate.level.resize(film.pixel_count());
  estimate.variance.resize(film.pixel_count());
  estimate.samples.resize(film.pixel_count());
  if (layer != Layer::medium) estimate.beside.resize(film.pixel_count());
  estimate.lone = layer == Layer::direct;
  parallel_for_each(film.pixel_count(), 4096, [&](std::size_t i) {
    const Film::Moments moments = film.moments(layer, i);
    RGB light = film.mean(layer, i);
    if (layer == Layer::direct) light = light - film.mean(Layer::sun, i);
    estimate.light[i] = light / (layer == Layer::medium ? RGB(1.0f) : shading_albedo(film, i));
    estimate.level[i] = moments.mean;
    estimate.variance[i] = moments.variance;
    estimate.samples[i] = film.sample_count(i);
    if (layer != Layer::medium)
      estimate.beside[i] =
          film.moments(layer == Layer::direct ? Layer::indirect : Layer::direct, i).mean +
          luminance(film.mean(Layer::sun, i) + film.mean(Layer::caustic, i)) / luminance(shading_albedo(film, i));
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
    if (shows_edge(guides.normal[i]) && (layer == Layer::direct || !is_black(film.mean(Layer::emitted, i))))
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

/// Variance of the luminance of a pixel's mean without direct and indirect light, as at edges of surfaces.
/// Surface samples reduce it. A light that a pixel sees counts as one of even radiance that a share of the samples
/// meet. To be multiplied by gain_of_strata().
/// @param other variance by the spread of the camera samples
float variance_beside_light(const Film& film, std::size_t pixel, float other) {
  if (!film.has_surface_samples()) return other;
  const float caustic = luminance(film.mean(Layer::caustic, pixel)),
              emitted = luminance(film.mean(Layer::emitted, pixel));
  if (!(emitted > 0)) return caustic > 0 || !is_black(film.mean(Layer::sun, pixel)) ? other : other / kSurfaceSamples;
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

/// Variance of the luminance of a pixel's gathered light and of media.
float variance_of_light(const Film& film, std::size_t pixel, bool indirect_only) {
  const float albedo = luminance(shading_albedo(film, pixel));
  float out = film.moments(Layer::indirect, pixel).variance * albedo * albedo;
  if (indirect_only) return out;
  out += film.moments(Layer::direct, pixel).variance * albedo * albedo;
  return film.has_moments_of_media() ? out + film.moments(Layer::medium, pixel).variance : out;
}

PixelSurface surface_of(const Film& film, std::size_t pixel, bool indirect_only) {
  PixelSurface out;
  out.albedo = shading_albedo(film, pixel);
  out.shown = shading_albedo(film, pixel, Layer::surface_albedo);
  if (!indirect_only) {
    out.caustic = film.mean(Layer::caustic, pixel);
    out.emitted = film.mean(Layer::surface_emitted, pixel) + film.mean(Layer::sun, pixel);
  }
  const float other = std::max(film.variance(pixel) - variance_of_light(film, pixel, indirect_only), 0.0f);
  out.variance = variance_beside_light(film, pixel, other) * gain_of_strata(film, pixel);
  return out;
}

/// Makes the picture of a film with moments.
class FilmFilter {
 public:
  /// @param edges pixels are beside each other: also filter edges
  FilmFilter(const Film& film, bool indirect_only, FilteredRows rows, bool edges, const EarlierFrames* earlier)
      : film_(film), indirect_only_(indirect_only), rows_(rows), edges_(edges), earlier_(earlier) {
    const std::size_t pixels = film.pixel_count();
    out_ = {std::vector<RGB>(pixels), std::vector<float>(pixels), edges ? film.width() : 0, {}};
    if (!earlier_) return;
    same_view_ = earlier_->of_same_view();
    twice_.resize(pixels);
  }

  FilmPicture run() {
    std::vector<float> stratified(film_.pixel_count());
    if (!indirect_only_) add_gathered(Layer::direct, stratified);
    add_gathered(Layer::indirect, stratified);
    if (edges_) filter_edges_by(std::move(stratified));
    // What varies beside, as at edges of surfaces, stays.
    parallel_for_each(film_.pixel_count(), 4096, [&](std::size_t i) { add_surface(i); });
    if (film_.has_moments_of_media() && !indirect_only_) add_media();
    if (earlier_) count_earlier();
    return std::move(out_);
  }

 private:
  void add_gathered(Layer layer, std::vector<float>& stratified) {
    LightEstimate estimate = estimate_of(film_, layer);
    if (earlier_)
      add_earlier_samples(*earlier_, guides_of(film_, Layer::indirect),
                          layer == Layer::direct ? &FrameLight::direct : &FrameLight::indirect, estimate);
    const FilteredLight filtered = filter_light(estimate, guides_of(film_, layer), rows_);
    parallel_for_each(film_.pixel_count(), 4096, [&](std::size_t i) {
      const RGB albedo = shading_albedo(film_, i);
      const float factor = luminance(albedo) * luminance(albedo);
      out_.radiance[i] += filtered.light[i] * albedo;
      add_variance(i, filtered.variance[i] * factor, estimate.samples[i]);
      stratified[i] += filtered.unfiltered[i] * factor;
    });
  }

  void filter_edges_by(std::vector<float> stratified) {
    const std::vector<float> before = earlier_ ? out_.variance : std::vector<float>();
    EdgePicture picture = edges_of(film_);
    picture.variance = std::move(stratified);
    filter_edges(picture, out_.radiance, out_.variance);
    for (std::size_t i = 0; i < before.size(); ++i)
      if (before[i] > 0) twice_[i] *= out_.variance[i] / before[i];
  }

  /// Adds caustic light and emission, and scales reflected light to the albedo of the surface samples.
  void add_surface(std::size_t i) {
    std::uint32_t samples = film_.sample_count(i);
    const PixelSurface own = surface_of(film_, i, indirect_only_);
    const PixelSurface all = with_same_view(same_view_, i, own, samples);
    RGB& pixel = out_.radiance[i];
    pixel += all.caustic * (own.albedo / all.albedo);
    pixel = pixel / own.albedo * all.shown + all.emitted;
    add_variance(i, all.variance, samples);
  }

  void add_media() {
    LightEstimate estimate = estimate_of(film_, Layer::medium);
    add_same_view(same_view_, &FrameLight::medium, estimate);
    const FilteredLight medium = filter_light(estimate, guides_of_media(film_), rows_);
    for (std::size_t i = 0; i < medium.light.size(); ++i) {
      out_.radiance[i] += medium.light[i];
      add_variance(i, medium.variance[i], estimate.samples[i]);
    }
  }

  /// @param samples that the variance is of, the pixel's own and others
  void add_variance(std::size_t i, float variance, std::uint32_t samples) {
    out_.variance[i] += variance;
    if (!earlier_ || samples == 0) return;
    const float all = static_cast<float>(samples), own = static_cast<float>(film_.sample_count(i));
    twice_[i] += variance * all / (all + own);
  }

  void count_earlier() {
    out_.earlier.resize(film_.pixel_count());
    for (std::size_t i = 0; i < out_.earlier.size(); ++i)
      if (twice_[i] < out_.variance[i])
        out_.earlier[i] = std::max(
            static_cast<float>(film_.sample_count(i)) * (twice_[i] / (out_.variance[i] - twice_[i]) - 1), 0.0f);
  }

  const Film& film_;
  bool indirect_only_;
  FilteredRows rows_;
  bool edges_;
  const EarlierFrames* earlier_;  // null: none
  FrameLights same_view_;
  std::vector<float> twice_;  // variance that twice as many samples of the frame would leave; empty: no earlier frames
  FilmPicture out_;
};

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
  return FilmFilter(film, indirect_only, {}, true, earlier).run();
}

FrameLight light_of_frame(const Film& film, FrameView view, bool indirect_only) {
  FrameLight out{std::move(view),
                 guides_of(film, Layer::indirect),
                 estimate_of(film, Layer::direct),
                 estimate_of(film, Layer::indirect),
                 {},
                 {}};
  if (film.has_moments_of_media()) out.medium = estimate_of(film, Layer::medium);
  out.surfaces.resize(film.pixel_count());
  parallel_for_each(film.pixel_count(), 4096,
                    [&](std::size_t i) { out.surfaces[i] = surface_of(film, i, indirect_only); });
  return out;
}

FilmPicture filtered_texels(const Film& film, bool indirect_only, FilteredRows rows) {
  return FilmFilter(film, indirect_only, rows, false, nullptr).run();
}

}  // namespace glowworm
