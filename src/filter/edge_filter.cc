#include "filter/edge_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/parallel.h"
#include "filter/light_filter.h"

namespace glowworm {

namespace {

/// Radius of the window, pixels.
constexpr int kEdgeReach = 3;
/// A pixel has its noise left if its variance is more than this share of that without filter.
constexpr float kNoiseLeft = 0.25f;
/// 1, normal, depth, albedo, x and y.
constexpr std::size_t kFeatures = 10;
/// Least number of filtered pixels in the window: fewer determine no function.
constexpr std::size_t kLeastPixels = 16;
/// Squared distance of normal, depth and albedo at which a pixel's weight is one half.
constexpr double kAlike = 0.1;
/// The prior of each coefficient has the window's mean luminance as its deviation; this is the variance of a pixel,
/// relative to the square of that luminance.
constexpr double kPrior = 1e-3;
/// Squared deviations by which a prediction may differ from the pixel's own mean: in full, and not at all.
constexpr double kTrusted = 9, kRefuted = 16;
/// Luminances are relative to themselves and this share of the picture's mean.
constexpr double kLeastLuminance = 0.1;

using Features = std::array<double, kFeatures>;

double edge_luminance(const std::array<double, 3>& c) {
  return luminance(RGB(static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])));
}

/// Least squares over the pixels of a window.
class EdgeFit {
 public:
  void add(const Features& features, RGB radiance, double weight) {
    const double values[3] = {radiance.r, radiance.g, radiance.b};
    for (std::size_t i = 0; i < kFeatures; ++i) {
      const double f = weight * features[i];
      for (std::size_t j = 0; j <= i; ++j) matrix_[i][j] += f * features[j];
      for (std::size_t c = 0; c < 3; ++c) right_[c][i] += f * values[c];
    }
  }

  /// Factors the matrix with the prior and finds the coefficients.
  void solve(double prior) {
    for (std::size_t i = 0; i < kFeatures; ++i) {
      matrix_[i][i] += prior;
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = matrix_[i][j];
        for (std::size_t k = 0; k < j; ++k) sum -= matrix_[i][k] * matrix_[j][k];
        matrix_[i][j] = i == j ? std::sqrt(std::max(sum, 0.1 * prior)) : sum / matrix_[j][j];
      }
    }
    for (Features& right : right_) {
      forward(right);
      for (std::size_t i = kFeatures; i-- > 0;) {
        for (std::size_t k = i + 1; k < kFeatures; ++k) right[i] -= matrix_[k][i] * right[k];
        right[i] /= matrix_[i][i];
      }
    }
  }

  std::array<double, 3> at(const Features& features) const {
    std::array<double, 3> out = {};
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < kFeatures; ++i) out[c] += right_[c][i] * features[i];
    return out;
  }

  /// Variance of the function there, for values of variance 1.
  double uncertainty(Features features) const {
    forward(features);
    double sum = 0;
    for (const double f : features) sum += f * f;
    return sum;
  }

 private:
  void forward(Features& right) const {
    for (std::size_t i = 0; i < kFeatures; ++i) {
      for (std::size_t k = 0; k < i; ++k) right[i] -= matrix_[i][k] * right[k];
      right[i] /= matrix_[i][i];
    }
  }

  std::array<Features, kFeatures> matrix_ = {};
  std::array<Features, 3> right_ = {};
};

/// Weight of a pixel with features around those of another.
double alike(const Features& features) {
  double distance = 0;
  for (std::size_t k = 1; k < kFeatures - 2; ++k) distance += features[k] * features[k];
  return 1 / (1 + distance / kAlike);
}

/// How far a prediction counts that lies some squared deviations from the pixel's own mean.
double trust(double deviations) { return std::clamp((kRefuted - deviations) / (kRefuted - kTrusted), 0.0, 1.0); }

RGB above_zero(RGB c) { return {std::max(c.r, 0.0f), std::max(c.g, 0.0f), std::max(c.b, 0.0f)}; }

/// The pixels of a window.
struct EdgeWindow {
  struct Neighbour {
    Features features;
    std::size_t pixel;
    double weight;
  };

  std::array<Neighbour, (2 * kEdgeReach + 1) * (2 * kEdgeReach + 1)> filtered;  ///< that have little noise
  std::size_t count = 0;                                                        ///< of them
  double weights = 0;                                                           ///< sum over them, without levels
  double level = 0;                                                             ///< their luminance
  double noisy = 1;            ///< sum of the weights of the noisy pixels at edges, with 1 for the central one
  double noise = 0;            ///< weighted variances of the others of these
  double sample_variance = 0;  ///< of a sample without filter, from the variances of all but the central pixel
};

class EdgeFilter {
 public:
  EdgeFilter(const EdgePicture& picture, const std::vector<RGB>& radiance, const std::vector<float>& variance)
      : picture_(picture), radiance_(radiance), variance_(variance) {
    double sum = 0;
    for (const RGB& pixel : radiance) sum += luminance(pixel);
    least_ = std::max(kLeastLuminance * sum / static_cast<double>(radiance.size()), 1e-20);
  }

  bool is_noisy(std::size_t i) const { return variance_[i] > kNoiseLeft * picture_.variance[i]; }

  /// Sets the pixel's new radiance and variance.
  /// @return light of a rare sample for each of the noisy pixels of the window, at weight 1
  RGB filter(std::size_t pixel, RGB& radiance, float& variance) const {
    const EdgeWindow window = window_of(pixel);
    if (window.count < kLeastPixels) return {};
    EdgeFit fit;
    for (std::size_t k = 0; k < window.count; ++k) {
      const EdgeWindow::Neighbour& n = window.filtered[k];
      fit.add(n.features, radiance_[n.pixel], n.weight);
    }
    fit.solve(kPrior / (window.level * window.level));
    double squares = 0, noise = 0;  // relative
    for (std::size_t k = 0; k < window.count; ++k) {
      const EdgeWindow::Neighbour& n = window.filtered[k];
      const double rest = edge_luminance(fit.at(n.features)) - luminance(radiance_[n.pixel]);
      squares += n.weight * rest * rest;
      noise += n.weight * variance_[n.pixel];
    }
    squares *= static_cast<double>(window.count) / (window.weights * static_cast<double>(window.count - kFeatures));
    // How far light is from such a function: what the noise does not explain.
    const double misfit = std::max(squares - noise / window.weights, 0.0);
    const Features here = {1};
    const std::array<double, 3> predicted = fit.at(here);
    const double level = std::max(edge_luminance(predicted), 0.0) + least_;
    const double fit_variance = misfit * level * level + std::max(squares, kPrior) * fit.uncertainty(here);
    const double own_variance =
        window.sample_variance / picture_.samples[pixel] * std::min(variance / picture_.variance[pixel], 1.0f);
    const double step = edge_luminance(predicted) - luminance(radiance);
    const double share = own_variance / (own_variance + fit_variance);
    const double part = share * trust(step * step / (own_variance + fit_variance));
    // A pixel with more noise than all others at edges has met a rare bright sample. It is within what the pixel's own
    // variance allows, and its light belongs to all of them. Beside a lamp such light belongs to the pixel.
    const bool is_rare = shows_edge(picture_.normal[pixel]) && variance > window.noise;
    const double allowed = is_rare ? std::max<double>(own_variance, variance) : own_variance;
    const double rare = share * trust(step * step / (allowed + fit_variance)) - part;
    const RGB fitted{static_cast<float>(predicted[0]), static_cast<float>(predicted[1]),
                     static_cast<float>(predicted[2])};
    const RGB spread = (fitted - radiance) * static_cast<float>(rare);
    radiance = above_zero(radiance + (fitted - radiance) * static_cast<float>(part) + spread);
    variance = static_cast<float>((1 - part) * (1 - part) * own_variance + part * part * fit_variance);
    return spread * static_cast<float>(-1 / window.noisy);
  }

  /// Light of rare samples that the noisy pixels of a window spread to the central one.
  /// @param spread of each pixel, by filter()
  RGB spread_to(std::size_t pixel, const std::vector<RGB>& spread) const {
    RGB sum;
    if (!shows_edge(picture_.normal[pixel])) return sum;
    for_window(pixel, [&](std::size_t i) {
      if (is_black(spread[i])) return;
      sum += spread[i] * static_cast<float>(alike(features_of(pixel, i, per_metre(i))));
    });
    return sum;
  }

 private:
  /// Calls work(i) for the pixels of a window.
  template <typename Work>
  void for_window(std::size_t pixel, Work&& work) const {
    const int width = picture_.width, x = static_cast<int>(pixel) % width, y = static_cast<int>(pixel) / width;
    for (int v = std::max(y - kEdgeReach, 0); v < std::min(y + kEdgeReach + 1, picture_.height); ++v)
      for (int u = std::max(x - kEdgeReach, 0); u < std::min(x + kEdgeReach + 1, width); ++u)
        work(static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u));
  }

  /// Metres of depth that the window of a pixel spans, inverse.
  double per_metre(std::size_t pixel) const {
    double low = picture_.depth[pixel], high = low;
    for_window(pixel, [&](std::size_t i) {
      low = std::min<double>(low, picture_.depth[i]);
      high = std::max<double>(high, picture_.depth[i]);
    });
    return 1 / std::max(high - low, 1e-3 * high);
  }

  EdgeWindow window_of(std::size_t pixel) const {
    const double per_metre = this->per_metre(pixel);
    EdgeWindow out;
    double log_variance = 0, all_weights = 0, log_level = 0;
    for_window(pixel, [&](std::size_t i) {
      if (i == pixel) return;
      const Features features = features_of(i, pixel, per_metre);
      const double weight = alike(features);
      log_variance += weight * std::log(picture_.variance[i] * picture_.samples[i] + 1e-30);
      all_weights += weight;
      if (is_noisy(i)) {
        if (!shows_edge(picture_.normal[i])) return;
        out.noisy += weight;
        out.noise += weight * variance_[i];
        return;
      }
      // Errors are relative: light of windows would else outweigh the walls around them.
      const double level = luminance(radiance_[i]) + least_;
      out.filtered[out.count++] = {features, i, weight / (level * level)};
      log_level += weight * std::log(level);
      out.weights += weight;
    });
    if (out.count > 0) {
      out.level = std::exp(log_level / out.weights);
      out.sample_variance = std::exp(log_variance / all_weights);
    }
    return out;
  }

  /// @param centre around which features are, for the fit's precision
  Features features_of(std::size_t i, std::size_t centre, double per_metre) const {
    const Vec3 n = picture_.normal[i] - picture_.normal[centre];
    const RGB a = picture_.albedo[i], b = picture_.albedo[centre];
    const double depth = static_cast<double>(picture_.depth[i]) - picture_.depth[centre];
    const auto width = static_cast<std::size_t>(picture_.width);
    const auto offset = [](std::size_t p, std::size_t q) {
      return (static_cast<double>(p) - static_cast<double>(q)) / kEdgeReach;
    };
    return {1,
            n.x,
            n.y,
            n.z,
            depth * per_metre,
            a.r - b.r,
            a.g - b.g,
            a.b - b.b,
            offset(i % width, centre % width),
            offset(i / width, centre / width)};
  }

  const EdgePicture& picture_;
  const std::vector<RGB>& radiance_;
  const std::vector<float>& variance_;
  double least_ = 0;  // luminance
};

}  // namespace

void filter_edges(const EdgePicture& picture, std::vector<RGB>& radiance, std::vector<float>& variance) {
  if (std::any_of(picture.samples.begin(), picture.samples.end(), [](std::uint32_t n) { return n < 2; })) return;
  const std::vector<RGB> filtered = radiance;
  const std::vector<float> filtered_variance = variance;
  const EdgeFilter filter(picture, filtered, filtered_variance);
  std::vector<RGB> spread(radiance.size());
  const auto for_noisy = [&](auto&& work) {
    parallel_for_each(radiance.size(), 2048, [&](std::size_t i) {
      if (filter.is_noisy(i)) work(i);
    });
  };
  for_noisy([&](std::size_t i) { spread[i] = filter.filter(i, radiance[i], variance[i]); });
  for_noisy([&](std::size_t i) { radiance[i] = above_zero(radiance[i] + filter.spread_to(i, spread)); });
}

}  // namespace glowworm
