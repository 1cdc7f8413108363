#include "gather/cell_place.h"

#include "core/random.h"

namespace glowworm {

namespace {

/// The extent of a cell between those `step` before and after it; 0 where these are not on its surface, or the three
/// not on one line.
Vec3 extent(const PointGrid& grid, std::size_t cell, std::size_t step) {
  constexpr float kStraight = 1e-3f;
  const std::size_t before = cell - step, after = cell + step;
  const bool amid = grid.has(before) && grid.has(after) && grid.surface[before] == grid.surface[cell] &&
                    grid.surface[after] == grid.surface[cell];
  if (!amid) return {0, 0, 0};
  const Vec3 there = grid.position[after] - grid.position[cell], back = grid.position[before] - grid.position[cell];
  return length(there + back) <= kStraight * length(there) ? (there - back) * 0.5f : Vec3{0, 0, 0};
}

}  // namespace

Vec3 place_in_cell(const PointGrid& grid, std::size_t cell, std::uint32_t sample) {
  const Vec3 middle = grid.position[cell];
  const auto width = static_cast<std::size_t>(grid.width);
  const std::size_t x = cell % width;
  if (grid.surface.empty() || x == 0 || x + 1 == width || cell < width || cell + width >= grid.position.size())
    return middle;
  const Vec3 across = extent(grid, cell, 1), down = extent(grid, cell, width);
  if (!(length_squared(across) > 0 && length_squared(down) > 0)) return middle;
  const Vec2 u =
      Sampler(SamplerKind::sobol, 0, hash_combine(static_cast<std::uint32_t>(cell), kCameraStream), sample).next2();
  return middle + across * (u.x - 0.5f) + down * (u.y - 0.5f);
}

}  // namespace glowworm
