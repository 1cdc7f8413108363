#include "control/adaptive.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>

namespace glowworm {

namespace {

constexpr int kSquare = CameraTask::kSquare, kBlock = CameraTask::kBlock, kEach = kBlock / kSquare;

/// The squares of a film: whole blocks, so that some may lie outside of it.
class Squares {
 public:
  explicit Squares(const PixelBounds& bounds)
      : bounds_(bounds),
        x0_(bounds.x0 / kBlock * kBlock),
        y0_(bounds.y0 / kBlock * kBlock),
        columns_((bounds.x1 - x0_ + kBlock - 1) / kBlock * kEach),
        rows_((bounds.y1 - y0_ + kBlock - 1) / kBlock * kEach) {}

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  std::size_t size() const { return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_); }
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }
  /// The pixels of a square that lie in the film; may be none.
  PixelBounds pixels(int column, int row) const { return within(column * kSquare, row * kSquare, kSquare); }
  /// The same of a block.
  PixelBounds pixels_of_block(int column, int row) const { return within(column * kBlock, row * kBlock, kBlock); }

 private:
  PixelBounds within(int x, int y, int side) const {
    return {std::max(x0_ + x, bounds_.x0), std::max(y0_ + y, bounds_.y0), std::min(x0_ + x + side, bounds_.x1),
            std::min(y0_ + y + side, bounds_.y1)};
  }
  PixelBounds bounds_;
  int x0_, y0_, columns_, rows_;
};

/// Samples of the pixel of a part that has the fewest.
std::uint32_t fewest_samples(const Film& film, const PixelBounds& part) {
  std::uint32_t fewest = UINT32_MAX;
  for (int y = part.y0; y < part.y1; ++y)
    for (int x = part.x0; x < part.x1; ++x) fewest = std::min(fewest, film.sample_count(film.pixel_at(x, y)));
  return fewest;
}

/// A square of pixels and its noise.
struct Square {
  std::uint32_t pixels = 0;
  std::uint32_t samples = 0;  ///< of the pixel with the fewest
  double error = 0;           ///< its part of the sum in relative_error()
  double of_one_sample = 0;   ///< the same if each pixel had one sample
  double earlier = 0;         ///< sum of FilmPicture::earlier

  /// Samples of a pixel behind the error: its own and those of earlier frames.
  double all_samples() const { return samples + earlier / pixels; }
};

std::vector<Square> measure(const Film& film, const FilmPicture& picture, const Squares& squares) {
  const double level = mean_luminance(picture);
  std::vector<Square> out(squares.size());
  for (int row = 0; row < squares.rows(); ++row)
    for (int column = 0; column < squares.columns(); ++column) {
      const PixelBounds part = squares.pixels(column, row);
      if (part.empty()) continue;
      Square& square = out[squares.index(column, row)];
      square.pixels = static_cast<std::uint32_t>(part.pixel_count());
      square.samples = fewest_samples(film, part);
      for (int y = part.y0; y < part.y1; ++y)
        for (int x = part.x0; x < part.x1; ++x) {
          const std::size_t pixel = film.pixel_at(x, y);
          const double error = relative_variance(picture, pixel, level);
          const double earlier = picture.earlier.empty() ? 0 : picture.earlier[pixel];
          square.error += error;
          square.of_one_sample += error * (film.sample_count(pixel) + earlier);
          square.earlier += earlier;
        }
    }
  return out;
}

/// Error of a pixel with one sample, by the squares around a square; by its own where there are none.
double error_around(const std::vector<Square>& all, const Squares& squares, int column, int row) {
  double sum = 0, pixels = 0;
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, squares.rows() - 1); ++y)
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, squares.columns() - 1); ++x) {
      if (x == column && y == row) continue;
      sum += all[squares.index(x, y)].of_one_sample;
      pixels += all[squares.index(x, y)].pixels;
    }
  const Square& own = all[squares.index(column, row)];
  return pixels > 0 ? sum / pixels : own.of_one_sample / own.pixels;
}

/// A square that may have its samples doubled.
struct Candidate {
  std::size_t square;
  double gain;  ///< by which the error falls, for each sample
};

}  // namespace

SquareSamples next_round(const Film& film, const FilmPicture& picture, double target, std::uint32_t most) {
  const Squares squares(film.bounds());
  const std::vector<Square> all = measure(film, picture, squares);
  double error = 0, done = 0;
  for (const Square& square : all) {
    error += square.error;
    done += static_cast<double>(square.samples) * square.pixels;
  }
  const auto pixels = static_cast<double>(film.pixel_count());
  std::vector<Candidate> candidates;
  std::size_t behind = 0;
  for (int row = 0; row < squares.rows(); ++row)
    for (int column = 0; column < squares.columns(); ++column) {
      const Square& square = all[squares.index(column, row)];
      if (square.pixels == 0 || square.samples >= most) continue;
      const double n = square.samples;
      // Squares with less than a quarter of the mean number of samples are always chosen.
      const bool is_behind = n < 0.25 * done / pixels;
      behind += is_behind;
      const double now = square.all_samples(), gain = error_around(all, squares, column, row) / (now * (now + n));
      candidates.push_back({squares.index(column, row), is_behind ? std::numeric_limits<double>::infinity() : gain});
    }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.gain > b.gain; });
  // Each round ends with a filtered picture, so it has a 64th of the squares at least.
  const std::size_t least = std::max(behind, static_cast<std::size_t>(1.0 / 64 * static_cast<double>(all.size())));
  SquareSamples wanted(candidates.empty() ? 0 : all.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] = all[i].samples;
  double cost = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (i > least && (cost >= kRoundGrowth * done || error <= target * target * pixels)) break;
    const Square& square = all[candidates[i].square];
    wanted[candidates[i].square] = std::min(2 * square.samples, most);
    cost += static_cast<double>(square.samples) * square.pixels;
    error -= square.error * square.samples / (square.all_samples() + square.samples);
  }
  return wanted;
}

SquareSamples even_round(const Film& film, std::uint32_t most) {
  const Squares squares(film.bounds());
  SquareSamples wanted(squares.size(), 0);
  bool any = false;
  for (int row = 0; row < squares.rows(); ++row)
    for (int column = 0; column < squares.columns(); ++column) {
      const PixelBounds part = squares.pixels(column, row);
      if (part.empty()) continue;
      const std::uint32_t samples = fewest_samples(film, part);
      wanted[squares.index(column, row)] = std::min(samples + 1, most);
      any = any || samples < most;
    }
  return any ? wanted : SquareSamples();
}

std::vector<CameraTask> tasks_of_round(const Film& film, const SquareSamples& wanted) {
  const Squares squares(film.bounds());
  std::vector<CameraTask> tasks;
  for (int y = 0; y < squares.rows() / kEach; ++y)
    for (int x = 0; x < squares.columns() / kEach; ++x) {
      // Squares of a block with the same samples to take share a task.
      std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> parts;
      for (int i = 0; i < kEach * kEach; ++i) {
        const int column = kEach * x + i % kEach, row = kEach * y + i / kEach;
        const PixelBounds part = squares.pixels(column, row);
        if (part.empty()) continue;
        const std::uint32_t first = fewest_samples(film, part), end = wanted[squares.index(column, row)];
        if (first < end) parts[{first, end}] |= 1u << i;
      }
      const PixelBounds block = squares.pixels_of_block(x, y);
      for (const auto& [samples, bits] : parts)
        tasks.push_back({block.x0, block.y0, block.x1, block.y1, samples.first, samples.second - samples.first, bits});
    }
  return tasks;
}

bool is_round_of(const PixelBounds& bounds, const SquareSamples& wanted) {
  return wanted.size() == Squares(bounds).size() &&
         std::all_of(wanted.begin(), wanted.end(), [](std::uint32_t samples) { return samples <= Film::kMaxSamples; });
}

}  // namespace glowworm
