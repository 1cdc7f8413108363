#include "filter/light_filter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.h"
#include "kernels/light_window.h"

namespace glowworm {

namespace {

/// Planes have this border of pixels that show nothing.
constexpr int kBorder = kWindowReach + 1;
constexpr int kTileWidth = WindowSums::kWidth, kTileHeight = WindowSums::kHeight;
/// Side of the squares in which the spread of samples is set against differences of pixels.
constexpr int kBlock = 32;
/// Samples whose spread a pixel shares with its neighbours.
constexpr float kSharedSamples = 8;
/// Weights favour pixels whose noise resembles the centre's, and differences that the test cannot tell from noise
/// make the mean wrong. Both leave a share of the centre's variance in addition to what the weights predict: kLeastKept
/// where all pixels of its surface show the same light, and kKeptApart more where none does. Noise alone leaves 0.006
/// to 0.15 on indirect light of two rooms; with squared bias, which is 15 to 60% of the squared error, it is 2.5 times
/// that (six scenes, 4 to 40 samples).
constexpr float kLeastKept = 0.015f, kKeptApart = 0.35f;

float kept_variance(float apart) { return kLeastKept + kKeptApart * apart * apart * (3 - 2 * apart); }

/// A linear function of the place, fitted to the levels of a window: at the pixel itself, beside their mean. Where the
/// pixels lie on one side, as at edges of surfaces and of noise, light that changes makes the mean wrong. Where they do
/// so because of their levels, they are levels around the pixel's own, and their mean is right.
struct LinearFit {
  float factor = 1;    ///< on the mean
  float variance = 1;  ///< factor on the mean's variance

  LinearFit(const WindowSums& sums, std::size_t at) {
    const float share = 1 / sums.weight[at], level = sums.level[at] * share;
    const float x = sums.step[0][at] * share, y = sums.step[1][at] * share;
    const float any_x = sums.any_step[0][at] / sums.any_weight[at], any_y = sums.any_step[1][at] / sums.any_weight[at];
    const float aside = (any_x * x + any_y * y) / std::max(x * x + y * y, 1e-6f);
    if (!(level > 0) || !(aside > 0)) return;
    constexpr float kInPixel = 1.0f / 12;  // squared deviation of places
    const float xx = sums.square[0][at] * share - x * x + kInPixel, xy = sums.square[1][at] * share - x * y,
                yy = sums.square[2][at] * share - y * y + kInPixel;
    const float determinant = xx * yy - xy * xy;
    const float a = (yy * x - xy * y) / determinant, b = (xx * y - xy * x) / determinant;
    const float change = a * (sums.slope[0][at] * share - x * level) + b * (sums.slope[1][at] * share - y * level);
    const float part = std::min(aside, 1.0f);
    factor = std::clamp(1 - part * change / level, 0.0f, 2.0f);
    variance = 1 + part * part * (a * x + b * y);
  }
};

/// One float per pixel, with a border of zeros, and what windows of the last tile read after it.
class Plane {
 public:
  Plane(int width, int height)
      : stride_(static_cast<std::size_t>(width + 2 * kBorder)),
        values_(stride_ * static_cast<std::size_t>(height + 2 * kBorder) + kTileWidth + kWindowPadding) {}
  /// @param x, y from -kBorder
  float* at(int x, int y) { return values_.data() + index(x, y); }
  const float* at(int x, int y) const { return values_.data() + index(x, y); }
  std::ptrdiff_t stride() const { return static_cast<std::ptrdiff_t>(stride_); }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y + kBorder) * stride_ + static_cast<std::size_t>(x + kBorder);
  }
  std::size_t stride_;
  std::vector<float> values_;
};

float squared(float x) { return x * x; }

class LightFilter {
 public:
  LightFilter(const LightEstimate& estimate, const FilterGuides& guides, FilteredRows rows)
      : estimate_(estimate), guides_(guides), width_(guides.width), height_(guides.height), rows_(rows) {
    rows_.end = std::min(rows_.end, height_);
  }

  FilteredLight run() {
    find_noise_of_all();
    for_rows([&](int y) { share_variance(y); });
    calibrate();
    out_.light.resize(guides_.size());
    out_.variance.resize(guides_.size());
    out_.unfiltered.resize(guides_.size());
    const int columns = (width_ + kTileWidth - 1) / kTileWidth;
    const int rows = (std::max(rows_.end - rows_.first, 0) + kTileHeight - 1) / kTileHeight;
    parallel_for(0, static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 4,
                 [&](std::size_t first, std::size_t last) {
                   for (std::size_t tile = first; tile < last; ++tile)
                     filter_tile(static_cast<int>(tile) % columns * kTileWidth,
                                 rows_.first + static_cast<int>(tile) / columns * kTileHeight);
                 });
    return std::move(out_);
  }

  std::vector<float> expected() {
    find_noise_of_all();
    std::vector<float> out(guides_.size());
    for_rows([&](int y) {
      for (int x = 0; x < width_; ++x)
        out[index(x, y)] = *noise_.at(x, y) / static_cast<float>(std::max(estimate_.samples[index(x, y)], 1u));
    });
    return out;
  }

 private:
  void find_noise_of_all() {
    for_rows([&](int y) { load_surfaces(y); });
    for_rows([&](int y) { find_slopes(y); });
    for_rows([&](int y) { find_noise(planes_at(0, y), width_, noise_.at(0, y)); });
  }
  template <typename Work>
  void for_rows(Work&& work) const {
    parallel_for(0, static_cast<std::size_t>(height_), 8, [&](std::size_t first, std::size_t last) {
      for (std::size_t y = first; y < last; ++y) work(static_cast<int>(y));
    });
  }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  void load_surfaces(int y) {
    for (int x = 0; x < width_; ++x) {
      const std::size_t i = index(x, y);
      const bool nothing = !std::isfinite(guides_.depth[i]);
      constexpr float kNoNormal = std::numeric_limits<float>::quiet_NaN();
      const Vec3 normal = nothing ? Vec3{kNoNormal, kNoNormal, kNoNormal} : guides_.normal[i];
      *normal_x_.at(x, y) = normal.x;
      *normal_y_.at(x, y) = normal.y;
      *normal_z_.at(x, y) = normal.z;
      *depth_.at(x, y) = nothing ? 0 : guides_.depth[i];
      *red_.at(x, y) = estimate_.light[i].r;
      *green_.at(x, y) = estimate_.light[i].g;
      *blue_.at(x, y) = estimate_.light[i].b;
      *level_.at(x, y) = estimate_.level[i];
      *shown_.at(x, y) = estimate_.level[i] + (estimate_.beside.empty() ? 0 : estimate_.beside[i]);
      *spread_.at(x, y) = estimate_.variance[i] * static_cast<float>(estimate_.samples[i]);
    }
  }

  /// 1 for pixels of equal normals, 0 for different surfaces and where a normal is NaN: at no surface, or as the guides
  /// say.
  float facing(const float* x, const float* y, const float* z, std::ptrdiff_t to) const {
    const float difference = squared(x[to] - x[0]) + squared(y[to] - y[0]) + squared(z[to] - z[0]);
    // In this order NaN gives 0.
    return std::max(0.0f, 1 - difference / kNormalDifference);
  }
  bool same_surface(int x, int y, int dx, int dy) const {
    const std::ptrdiff_t to = level_.at(x + dx, y + dy) - level_.at(x, y);
    return facing(normal_x_.at(x, y), normal_y_.at(x, y), normal_z_.at(x, y), to) > 0;
  }

  /// Change of depth from pixel to pixel: in each direction the smaller of both sides, so that no edge counts.
  void find_slopes(int y) {
    for (int x = 0; x < width_; ++x) {
      const float z = *depth_.at(x, y);
      const auto step = [&](int dx, int dy) { return std::abs(*depth_.at(x + dx, y + dy) - z); };
      *slope_.at(x, y) = std::max(std::min(step(-1, 0), step(1, 0)), std::min(step(0, -1), step(0, 1)));
    }
  }

  /// The variance of few samples is itself uncertain, so neighbours on the same surface contribute.
  void share_variance(int y) {
    for (int x = 0; x < width_; ++x) {
      float sum = 0, count = 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          if (x + dx < 0 || y + dy < 0 || x + dx >= width_ || y + dy >= height_ || !same_surface(x, y, dx, dy))
            continue;
          sum += *spread_.at(x + dx, y + dy);
          count += 1;
        }
      const auto samples = static_cast<float>(estimate_.samples[index(x, y)]);
      const float own = *spread_.at(x, y);
      *variance_.at(x, y) =
          (count > 0 ? (samples * own + kSharedSamples * sum / count) / (samples + kSharedSamples) : own) / samples;
    }
  }

  /// Ratio of the square of a fourth difference to what the variances say of it; negative where there is none. A fourth
  /// difference holds little of the light itself, which counts beside the noise of many samples.
  float fourth_difference(int x, int y, int dx, int dy) const {
    if (x < 2 * dx || y < 2 * dy || x + 2 * dx >= width_ || y + 2 * dy >= height_) return -1;
    constexpr float kWeights[] = {1, -4, 6, -4, 1};
    float variance = 0, difference = 0;
    for (int i = -2; i <= 2; ++i) {
      if (i != 0 && !same_surface(x, y, i * dx, i * dy)) return -1;
      variance += squared(kWeights[i + 2]) * *variance_.at(x + i * dx, y + i * dy);
      difference += kWeights[i + 2] * *level_.at(x + i * dx, y + i * dy);
    }
    return variance > 0 ? squared(difference) / variance : -1;
  }

  /// Scales variances by what stratified samples gain at edges of light, which differs from block to block, for the
  /// comparison of pixels. The variance stated is for smooth light, with no more than the gain of n samples at
  /// edges, n^-0.5.
  void calibrate() {
    const int columns = (width_ + kBlock - 1) / kBlock, rows = (height_ + kBlock - 1) / kBlock;
    std::vector<float> gain(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    parallel_for(0, gain.size(), 4, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i)
        gain[i] = gain_at_edges(static_cast<int>(i) % columns * kBlock, static_cast<int>(i) / columns * kBlock);
    });
    const auto of_block = [&](int column, int row) {
      return gain[static_cast<std::size_t>(std::clamp(row, 0, rows - 1)) * static_cast<std::size_t>(columns) +
                  static_cast<std::size_t>(std::clamp(column, 0, columns - 1))];
    };
    for_rows([&](int y) {
      for (int x = 0; x < width_; ++x) {
        const float u = (static_cast<float>(x) + 0.5f) / kBlock - 0.5f,
                    v = (static_cast<float>(y) + 0.5f) / kBlock - 0.5f;
        const int column = static_cast<int>(std::floor(u)), row = static_cast<int>(std::floor(v));
        const float s = u - static_cast<float>(column), t = v - static_cast<float>(row);
        const float above = std::lerp(of_block(column, row), of_block(column + 1, row), s);
        const float below = std::lerp(of_block(column, row + 1), of_block(column + 1, row + 1), s);
        const float at_edges = std::lerp(above, below, t);
        *variance_.at(x, y) *= at_edges;
        const auto samples = static_cast<float>(estimate_.samples[index(x, y)]);
        *stated_.at(x, y) = std::min(std::max(squared(squared(at_edges)), 1 / std::sqrt(samples)) / at_edges, 1.0f);
      }
    });
  }

  /// Variance of stratified samples over the variance of independent ones at edges of light: the fourth root of the
  /// ratio in smooth light. With n samples, variances fall with n^-3 in smooth light and with n^-1.5 at edges;
  /// for independent samples, with n^-1 (A. Owen, "Scrambled Net Variance for Integrals of Smooth Functions", Annals of
  /// Statistics 25(4), 1997; D. Mitchell, "Consequences of Stratified Sampling in Graphics", SIGGRAPH 1996). The ratio
  /// in smooth light comes from the median of fourth differences, which ignores edges. Pixels are not compared by it,
  /// because those that met rare bright samples would then differ from all others and remain as specks.
  float gain_at_edges(int x0, int y0) const {
    std::vector<float> ratios;
    for (int y = y0; y < std::min(y0 + kBlock, height_); ++y)
      for (int x = x0; x < std::min(x0 + kBlock, width_); ++x)
        for (const float ratio : {fourth_difference(x, y, 1, 0), fourth_difference(x, y, 0, 1)})
          if (ratio >= 0) ratios.push_back(ratio);
    constexpr std::size_t kMinRatios = 50;
    if (ratios.size() < kMinRatios) return 1;
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    // Of the square of a standard normal number the median is 0.4549.
    return std::sqrt(std::sqrt(std::clamp(*middle / 0.4549f, 0.02f, 1.0f)));
  }

  WindowPlanes planes_at(int x, int y) const {
    return {level_.stride(),
            {normal_x_.at(x, y), normal_y_.at(x, y), normal_z_.at(x, y)},
            depth_.at(x, y),
            slope_.at(x, y),
            {red_.at(x, y), green_.at(x, y), blue_.at(x, y)},
            level_.at(x, y),
            shown_.at(x, y),
            variance_.at(x, y),
            spread_.at(x, y),
            noise_.at(x, y),
            estimate_.lone};
  }

  void filter_tile(int x0, int y0) {
    const int width = std::min(kTileWidth, width_ - x0), height = std::min(kTileHeight, rows_.end - y0);
    const WindowPlanes planes = planes_at(x0, y0);
    WindowSums sums = {};
    for (int y = 0; y < height; ++y) {
      const std::size_t at = WindowSums::at(0, y);
      for (int c = 0; c < 3; ++c) std::copy_n(planes.light[c] + y * planes.stride, width, sums.light[c] + at);
      std::copy_n(planes.variance + y * planes.stride, width, sums.variance + at);
      std::copy_n(planes.level + y * planes.stride, width, sums.level + at);
      std::fill_n(sums.weight + at, width, 1.0f);
      std::fill_n(sums.surface + at, width, 1.0f);
      std::fill_n(sums.any_weight + at, width, 1.0f);
    }
    if (shows_something(x0, y0, width, height)) add_window(planes, height, sums);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const std::size_t at = WindowSums::at(x, y);
        const std::size_t pixel = index(x0 + x, y0 + y);
        const float share = 1 / sums.weight[at];
        const LinearFit fit(sums, at);
        out_.light[pixel] = RGB(sums.light[0][at], sums.light[1][at], sums.light[2][at]) * (share * fit.factor);
        const float own = *variance_.at(x0 + x, y0 + y);
        const float apart = 1 - sums.weight[at] / sums.surface[at];
        out_.variance[pixel] = sums.variance[at] * squared(share) * fit.variance * *stated_.at(x0 + x, y0 + y) +
                               kept_variance(apart) * (1 - share) * own;
        out_.unfiltered[pixel] = own;
      }
  }

  /// Whether a tile has a pixel with a surface. Atlases have large gaps.
  bool shows_something(int x0, int y0, int width, int height) const {
    for (int y = y0; y < y0 + height; ++y)
      if (!std::all_of(normal_x_.at(x0, y), normal_x_.at(x0, y) + width, [](float n) { return std::isnan(n); }))
        return true;
    return false;
  }

  const LightEstimate& estimate_;
  const FilterGuides& guides_;
  int width_, height_;
  FilteredRows rows_;
  Plane normal_x_{width_, height_}, normal_y_{width_, height_}, normal_z_{width_, height_};
  Plane depth_{width_, height_}, slope_{width_, height_};
  Plane red_{width_, height_}, green_{width_, height_}, blue_{width_, height_};
  Plane level_{width_, height_}, shown_{width_, height_}, variance_{width_, height_};
  Plane spread_{width_, height_}, noise_{width_, height_};  // variance of a sample: the pixel's, and what to expect
  Plane stated_{width_, height_};                           // ratio of the variance stated to variance_
  FilteredLight out_;
};

}  // namespace

FilteredLight filter_light(const LightEstimate& estimate, const FilterGuides& guides, FilteredRows rows) {
  if (std::any_of(estimate.samples.begin(), estimate.samples.end(), [](std::uint32_t n) { return n < 2; }))
    return {estimate.light, estimate.variance, estimate.variance};
  return LightFilter(estimate, guides, rows).run();
}

std::vector<float> expected_variance(const LightEstimate& estimate, const FilterGuides& guides) {
  return LightFilter(estimate, guides, {}).expected();
}

}  // namespace glowworm
