#include "filter/light_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/parallel.h"

namespace glowworm {

namespace {

/// Radius of the window, pixels.
constexpr int kReach = 8;
/// Planes have this border of pixels that show nothing.
constexpr int kBorder = kReach + 1;
/// Pixels of the tiles that the filter works on at a time: their arrays fit the first cache.
constexpr int kTileWidth = 32, kTileHeight = 16;
/// Side of the squares in which the spread of samples is set against differences of pixels.
constexpr int kBlock = 32;
/// Squared difference of normals above which pixels show different surfaces. The mean normals of pixels at an edge are
/// shorter than 1, and alike along the edge.
constexpr float kNormalDifference = 0.2f;
/// Depths may differ by this share, beside what the slope of the surface explains.
constexpr float kDepthShare = 0.005f;
/// Samples whose spread a pixel shares with its neighbours.
constexpr float kSharedSamples = 8;
/// Share of the squared level that is added to variances, so that 0 / 0 counts as no difference.
constexpr float kMinVariance = 1e-10f;
/// Weights favour pixels whose noise resembles that of the centre, so this share of its noise remains in addition to
/// what the weights predict (measured on flat surfaces).
constexpr float kNoiseKept = 0.1f;

/// One float per pixel, with a border of zeros.
class Plane {
 public:
  Plane(int width, int height)
      : stride_(static_cast<std::size_t>(width + 2 * kBorder)),
        values_(stride_ * static_cast<std::size_t>(height + 2 * kBorder)) {}
  /// @param x, y from -kBorder
  float* at(int x, int y) { return values_.data() + index(x, y); }
  const float* at(int x, int y) const { return values_.data() + index(x, y); }

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
  LightFilter(const LightEstimate& estimate, const FilterGuides& guides)
      : estimate_(estimate), guides_(guides), width_(guides.width), height_(guides.height) {}

  FilteredLight run() {
    for_rows([&](int y) { load_surfaces(y); });
    for_rows([&](int y) { find_slopes(y); });
    for_rows([&](int y) { share_variance(y); });
    calibrate();
    out_.light.resize(guides_.size());
    out_.variance.resize(guides_.size());
    out_.unfiltered.resize(guides_.size());
    const int columns = (width_ + kTileWidth - 1) / kTileWidth, rows = (height_ + kTileHeight - 1) / kTileHeight;
    parallel_for(0, static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 4,
                 [&](std::size_t first, std::size_t last) {
                   for (std::size_t tile = first; tile < last; ++tile)
                     filter_tile(static_cast<int>(tile) % columns * kTileWidth,
                                 static_cast<int>(tile) / columns * kTileHeight);
                 });
    return std::move(out_);
  }

 private:
  /// Sums of a tile, row by row of kTileWidth pixels.
  struct Tile {
    static constexpr int kPixels = kTileWidth * kTileHeight;
    std::array<float, kPixels> red, green, blue, weight, variance;
  };
  /// Similarity and squared normalized difference of pixel pairs, for a tile with a border of one pixel.
  struct Pairs {
    static constexpr int kStride = kTileWidth + 2;
    std::array<float, kStride*(kTileHeight + 2)> alike, differ;
  };

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

  float of_one_sample(std::size_t pixel) const {
    return estimate_.variance[pixel] * static_cast<float>(estimate_.samples[pixel]);
  }

  /// The variance of few samples is itself uncertain, so neighbours on the same surface contribute.
  void share_variance(int y) {
    for (int x = 0; x < width_; ++x) {
      float sum = 0, count = 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          if (x + dx < 0 || y + dy < 0 || x + dx >= width_ || y + dy >= height_ || !same_surface(x, y, dx, dy))
            continue;
          sum += of_one_sample(index(x + dx, y + dy));
          count += 1;
        }
      const std::size_t i = index(x, y);
      const auto samples = static_cast<float>(estimate_.samples[i]);
      const float own = of_one_sample(i);
      *variance_.at(x, y) =
          (count > 0 ? (samples * own + kSharedSamples * sum / count) / (samples + kSharedSamples) : own) / samples;
    }
  }

  /// Ratio of the square of a second difference to what the variances say of it; negative where there is none.
  float second_difference(int x, int y, int dx, int dy) const {
    if (!same_surface(x, y, dx, dy) || !same_surface(x, y, -dx, -dy)) return -1;
    const float variance = *variance_.at(x - dx, y - dy) + 4 * *variance_.at(x, y) + *variance_.at(x + dx, y + dy);
    const float difference = *level_.at(x - dx, y - dy) - 2 * *level_.at(x, y) + *level_.at(x + dx, y + dy);
    return variance > 0 ? squared(difference) / variance : -1;
  }

  /// Scales variances by what differences between pixels say, block by block.
  void calibrate() {
    const int columns = (width_ + kBlock - 1) / kBlock, rows = (height_ + kBlock - 1) / kBlock;
    std::vector<float> factor(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    parallel_for(0, factor.size(), 4, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i)
        factor[i] = block_factor(static_cast<int>(i) % columns * kBlock, static_cast<int>(i) / columns * kBlock);
    });
    const auto factor_at = [&](int column, int row) {
      return factor[static_cast<std::size_t>(std::clamp(row, 0, rows - 1)) * static_cast<std::size_t>(columns) +
                    static_cast<std::size_t>(std::clamp(column, 0, columns - 1))];
    };
    for_rows([&](int y) {
      for (int x = 0; x < width_; ++x) {
        const float u = (static_cast<float>(x) + 0.5f) / kBlock - 0.5f,
                    v = (static_cast<float>(y) + 0.5f) / kBlock - 0.5f;
        const int column = static_cast<int>(std::floor(u)), row = static_cast<int>(std::floor(v));
        const float s = u - static_cast<float>(column), t = v - static_cast<float>(row);
        const float above = std::lerp(factor_at(column, row), factor_at(column + 1, row), s);
        const float below = std::lerp(factor_at(column, row + 1), factor_at(column + 1, row + 1), s);
        *variance_.at(x, y) *= std::lerp(above, below, t);
      }
    });
  }

  /// The median tells noise from edges. Of the square of a standard normal number it is 0.4549.
  float block_factor(int x0, int y0) const {
    std::vector<float> ratios;
    for (int y = std::max(y0, 1); y < std::min(y0 + kBlock, height_ - 1); ++y)
      for (int x = std::max(x0, 1); x < std::min(x0 + kBlock, width_ - 1); ++x)
        for (const float ratio : {second_difference(x, y, 1, 0), second_difference(x, y, 0, 1)})
          if (ratio >= 0) ratios.push_back(ratio);
    constexpr std::size_t kMinRatios = 50;
    if (ratios.size() < kMinRatios) return 1;
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return std::clamp(*middle / 0.4549f, 0.02f, 1.0f);
  }

  void filter_tile(int x0, int y0) {
    const int width = std::min(kTileWidth, width_ - x0), height = std::min(kTileHeight, height_ - y0);
    Tile sums;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const auto at = static_cast<std::size_t>(y * kTileWidth + x);
        sums.red[at] = *red_.at(x0 + x, y0 + y);
        sums.green[at] = *green_.at(x0 + x, y0 + y);
        sums.blue[at] = *blue_.at(x0 + x, y0 + y);
        sums.variance[at] = *variance_.at(x0 + x, y0 + y);
        sums.weight[at] = 1;
      }
    if (shows_something(x0, y0, width, height)) add_neighbours(x0, y0, width, height, sums);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const auto at = static_cast<std::size_t>(y * kTileWidth + x);
        const std::size_t pixel = index(x0 + x, y0 + y);
        const float share = 1 / sums.weight[at];
        out_.light[pixel] = RGB(sums.red[at], sums.green[at], sums.blue[at]) * share;
        const float own = *variance_.at(x0 + x, y0 + y);
        out_.variance[pixel] = sums.variance[at] * squared(share) + squared(kNoiseKept) * (1 - share) * own;
        out_.unfiltered[pixel] = own;
      }
  }

  void add_neighbours(int x0, int y0, int width, int height, Tile& sums) const {
    Pairs pairs;
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const int distance2 = dx * dx + dy * dy;
        if (distance2 == 0 || distance2 > kReach * kReach) continue;
        const float distance = std::sqrt(static_cast<float>(distance2));
        const std::ptrdiff_t to = level_.at(dx, dy) - level_.at(0, 0);
        for (int y = -1; y <= height; ++y) compare_row(x0 - 1, y0 + y, width + 2, to, distance, &pairs, y + 1);
        const float near = 1 - static_cast<float>(distance2) / squared(kReach + 1);
        for (int y = 0; y < height; ++y) add_row(x0, y0 + y, width, to, near, pairs, y, sums);
      }
  }

  /// Whether a tile has a pixel with a surface. Atlases have large gaps.
  bool shows_something(int x0, int y0, int width, int height) const {
    for (int y = y0; y < y0 + height; ++y)
      if (!std::all_of(normal_x_.at(x0, y), normal_x_.at(x0, y) + width, [](float n) { return std::isnan(n); }))
        return true;
    return false;
  }

  /// Compares each pixel of a row with the one that lies `to` entries on.
  void compare_row(int x0, int y, int width, std::ptrdiff_t to, float distance, Pairs* pairs, int row) const {
    const float *nx = normal_x_.at(x0, y), *ny = normal_y_.at(x0, y), *nz = normal_z_.at(x0, y);
    const float *depth = depth_.at(x0, y), *slope = slope_.at(x0, y);
    const float *level = level_.at(x0, y), *variance = variance_.at(x0, y);
    float* const alike = pairs->alike.data() + row * Pairs::kStride;
    float* const differ = pairs->differ.data() + row * Pairs::kStride;
    for (int x = 0; x < width; ++x) {
      const float facing = this->facing(nx + x, ny + x, nz + x, to);
      const float step = depth[x + to] - depth[x];
      const float expected = 1.5f * distance * std::max(slope[x], slope[x + to]) + kDepthShare * depth[x] + 1e-20f;
      const float near = std::max(1 - step * step / (expected * expected), 0.0f);
      const float a = facing * facing * near;
      const float d = level[x + to] - level[x];
      const float least = kMinVariance * level[x] * level[x] + 1e-30f;
      alike[x] = a;
      differ[x] = a * d * d / (variance[x] + variance[x + to] + least);
    }
  }

  /// Adds pixels that lie `to` entries on to a row of the tile, as far as the pairs around them are alike.
  void add_row(int x0, int y, int width, std::ptrdiff_t to, float near, const Pairs& pairs, int row, Tile& sums) const {
    const float *red = red_.at(x0, y) + to, *green = green_.at(x0, y) + to, *blue = blue_.at(x0, y) + to;
    const float* variance = variance_.at(x0, y) + to;
    const float *a0 = pairs.alike.data() + row * Pairs::kStride, *d0 = pairs.differ.data() + row * Pairs::kStride;
    const float *a1 = a0 + Pairs::kStride, *a2 = a1 + Pairs::kStride, *d1 = d0 + Pairs::kStride,
                *d2 = d1 + Pairs::kStride;
    const auto first = static_cast<std::size_t>(row * kTileWidth);
    float *r = &sums.red[first], *g = &sums.green[first], *b = &sums.blue[first];
    float *w = &sums.weight[first], *v = &sums.variance[first];
    for (int x = 0; x < width; ++x) {
      const float pairs_alike =
          a0[x] + a0[x + 1] + a0[x + 2] + a1[x] + a1[x + 1] + a1[x + 2] + a2[x] + a2[x + 1] + a2[x + 2];
      const float difference =
          d0[x] + d0[x + 1] + d0[x + 2] + d1[x] + d1[x + 1] + d1[x + 2] + d2[x] + d2[x + 1] + d2[x + 2];
      // Of n standard normal numbers the mean square is 1 with a deviation of sqrt(2 / n).
      const float n = std::max(pairs_alike, 1e-6f);
      const float deviation = std::sqrt(2 / std::max(n, 1.0f));
      const float excess = (difference / n - 1) / deviation;
      const float same = std::min(std::max((kNoWeight - excess) / (kNoWeight - kFullWeight), 0.0f), 1.0f);
      // The weight must not depend on which of the two is noisier: else rare bright samples lose their light.
      const float weight = near * a1[x + 1] * same;
      r[x] += weight * red[x];
      g[x] += weight * green[x];
      b[x] += weight * blue[x];
      w[x] += weight;
      v[x] += weight * weight * variance[x];
    }
  }

  /// Deviations above the expected difference up to which a neighbour counts in full, and beyond which it does not.
  static constexpr float kFullWeight = 0.5f, kNoWeight = 2.0f;

  const LightEstimate& estimate_;
  const FilterGuides& guides_;
  int width_, height_;
  Plane normal_x_{width_, height_}, normal_y_{width_, height_}, normal_z_{width_, height_};
  Plane depth_{width_, height_}, slope_{width_, height_};
  Plane red_{width_, height_}, green_{width_, height_}, blue_{width_, height_};
  Plane level_{width_, height_}, variance_{width_, height_};
  FilteredLight out_;
};

}  // namespace

FilteredLight filter_light(const LightEstimate& estimate, const FilterGuides& guides) {
  if (std::any_of(estimate.samples.begin(), estimate.samples.end(), [](std::uint32_t n) { return n < 2; }))
    return {estimate.light, estimate.variance, estimate.variance};
  return LightFilter(estimate, guides).run();
}

}  // namespace glowworm
