#include "bake/bands.h"

#include <algorithm>

#include "render/film.h"
#include "render/filtered.h"

namespace glowworm {

namespace {

/// The filter calibrates variances by blocks of so many rows; bands begin with one.
constexpr int kBlock = 32;
/// Rows above and below a band that its filtered light depends on: the window of the filter and the blocks around that,
/// of which the last has differences with one row more.
constexpr int kAbove = 2 * kBlock, kBelow = kBlock + 2;
/// Share of the memory for the film; photons and query points take the rest.
constexpr double kFilmShare = 0.7;

}  // namespace

std::vector<BakeBand> cut_into_bands(const PointGrid& grid, const RenderSettings& settings, std::uint64_t memory) {
  const bool filtered = filters(settings);
  const PixelBounds row{0, 0, grid.width, 1};
  // The Job holds its film twice.
  const std::uint64_t row_bytes = 2 * Film::bytes(row, settings.separate_layers || filtered, {}, filtered) +
                                  row.pixel_count() * ((filtered ? kFilterBytes : 0) + sizeof(RGB) + sizeof(float));
  const double share = kFilmShare * static_cast<double>(memory) / static_cast<double>(row_bytes);
  const int rows = static_cast<int>(std::min(share, 1e9));
  if (rows >= grid.height) return {{0, grid.height, {0, 0, grid.width, grid.height}}};
  const int around = filtered ? kAbove + kBelow : 0;
  const int step = std::max((rows - around) / kBlock * kBlock, kBlock);
  std::vector<BakeBand> out;
  for (int first = 0; first < grid.height; first += step) {
    BakeBand band;
    band.first = first;
    band.end = std::min(first + step, grid.height);
    band.rendered = {0, filtered ? std::max(first - kAbove, 0) : first, grid.width,
                     filtered ? std::min(band.end + kBelow, grid.height) : band.end};
    out.push_back(band);
  }
  return out;
}

}  // namespace glowworm
