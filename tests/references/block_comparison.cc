#include "references/block_comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace glowworm {

namespace {

std::vector<double> mean_luminance(const std::vector<std::vector<RGB>>& renders) {
  std::vector<double> mean(renders.front().size());
  for (const std::vector<RGB>& render : renders)
    for (std::size_t i = 0; i < mean.size(); ++i)
      mean[i] += static_cast<double>(luminance(render[i])) / static_cast<double>(renders.size());
  return mean;
}

/// 1 for the pixels that count, 0 for the share of greatest relative error.
std::vector<char> find_kept(const std::vector<double>& picture, std::span<const RGB> reference, double left_out) {
  std::vector<double> error(picture.size());
  for (std::size_t i = 0; i < error.size(); ++i) {
    const double r = luminance(reference[i]);
    error[i] = std::abs(picture[i] - r) / (std::abs(r) + 0.1);
  }
  std::vector<double> sorted = error;
  const auto rank = static_cast<std::ptrdiff_t>((1 - left_out) * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), sorted.begin() + rank, sorted.end());
  std::vector<char> kept(error.size());
  for (std::size_t i = 0; i < error.size(); ++i) kept[i] = error[i] <= sorted[static_cast<std::size_t>(rank)];
  return kept;
}

/// Pixels of one block, gathered.
struct PixelBlock {
  std::vector<std::size_t> index;
  std::vector<double> x, y;  // relative to their mean
};

PixelBlock gather(int x0, int y0, int block, int width, int height, const std::vector<char>& kept) {
  PixelBlock out;
  double mean_x = 0, mean_y = 0;
  for (int y = y0; y < std::min(y0 + block, height); ++y)
    for (int x = x0; x < std::min(x0 + block, width); ++x) {
      const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
      if (!kept[i]) continue;
      out.index.push_back(i);
      out.x.push_back(x);
      out.y.push_back(y);
      mean_x += x;
      mean_y += y;
    }
  for (std::size_t i = 0; i < out.index.size(); ++i) {
    out.x[i] -= mean_x / static_cast<double>(out.index.size());
    out.y[i] -= mean_y / static_cast<double>(out.index.size());
  }
  return out;
}

/// Variance of the mean of `values`, by their scatter about the plane that fits them best.
double variance_about_plane(const PixelBlock& pixels, const std::vector<double>& values, double mean) {
  double xx = 0, xy = 0, yy = 0, xv = 0, yv = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    xx += pixels.x[i] * pixels.x[i];
    xy += pixels.x[i] * pixels.y[i];
    yy += pixels.y[i] * pixels.y[i];
    xv += pixels.x[i] * (values[i] - mean);
    yv += pixels.y[i] * (values[i] - mean);
  }
  const double determinant = xx * yy - xy * xy;
  const double a = determinant > 0 ? (xv * yy - yv * xy) / determinant : 0;
  const double b = determinant > 0 ? (yv * xx - xv * xy) / determinant : 0;
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double residual = values[i] - mean - a * pixels.x[i] - b * pixels.y[i];
    sum += residual * residual;
  }
  const auto n = static_cast<double>(values.size());
  return n > 3 ? sum / (n - 3) / n : std::numeric_limits<double>::infinity();
}

/// Variance of the mean over the renders of the block's mean.
double variance_among_renders(const PixelBlock& pixels, const std::vector<std::vector<RGB>>& renders) {
  std::vector<double> means;
  for (const std::vector<RGB>& render : renders) {
    double sum = 0;
    for (const std::size_t i : pixels.index) sum += luminance(render[i]);
    means.push_back(sum / static_cast<double>(pixels.index.size()));
  }
  const auto n = static_cast<double>(means.size());
  double mean = 0, squares = 0;
  for (const double m : means) mean += m / n;
  for (const double m : means) squares += (m - mean) * (m - mean);
  return squares / (n - 1) / n;
}

void sum_up(BlockComparison& out) {
  double squares = 0, variances = 0, reference = 0;
  std::size_t beyond = 0;
  for (const BlockDifference& block : out.blocks) {
    squares += block.difference * block.difference;
    variances += block.standard_error * block.standard_error;
    reference += block.reference;
    beyond += std::abs(block.z()) > 3;
  }
  const auto n = static_cast<double>(out.blocks.size());
  out.structured = std::sqrt(std::max(0.0, (squares - variances) / n)) / std::max(reference / n, 1e-12);
  out.share_beyond_3 = static_cast<double>(beyond) / n;
}

}  // namespace

std::vector<BlockDifference> BlockComparison::different(const BlockTolerance& tolerance) const {
  double mean = 0;
  for (const BlockDifference& b : blocks) mean += b.reference / static_cast<double>(blocks.size());
  std::vector<BlockDifference> out;
  for (const BlockDifference& b : blocks) {
    const double allowed = tolerance.of_block * b.reference + tolerance.of_picture * mean;
    if (std::abs(b.difference) > allowed + tolerance.standard_errors * b.standard_error) out.push_back(b);
  }
  return out;
}

BlockComparison compare_blocks(const std::vector<std::vector<RGB>>& renders, std::span<const RGB> reference, int width,
                               int height, int block, double left_out) {
  BlockComparison out;
  const std::vector<double> picture = mean_luminance(renders);
  const std::vector<char> kept = find_kept(picture, reference, left_out);
  double picture_sum = 0, reference_sum = 0, variance = 0;
  for (std::size_t i = 0; i < picture.size(); ++i) {
    picture_sum += picture[i];
    reference_sum += luminance(reference[i]);
  }
  for (int y = 0; y < height; y += block)
    for (int x = 0; x < width; x += block) {
      const PixelBlock pixels = gather(x, y, block, width, height, kept);
      if (pixels.index.size() < static_cast<std::size_t>(block)) continue;
      BlockDifference b;
      b.x = x;
      b.y = y;
      const auto n = static_cast<double>(pixels.index.size());
      std::vector<double> differences;
      for (const std::size_t i : pixels.index) {
        differences.push_back(picture[i] - luminance(reference[i]));
        b.difference += differences.back() / n;
        b.reference += luminance(reference[i]) / n;
      }
      const double squared =
          variance_about_plane(pixels, differences, b.difference) + variance_among_renders(pixels, renders);
      b.standard_error = std::sqrt(squared);
      variance += squared * n * n;
      out.blocks.push_back(b);
    }
  out.mean_ratio = picture_sum / reference_sum;
  out.standard_error = std::sqrt(variance) / reference_sum;
  sum_up(out);
  return out;
}

}  // namespace glowworm
