#include "import/voxel_grid.h"

#include <cstddef>

#include "core/text.h"
#include "import/nanovdb/reader.h"
#include "import/openvdb/import.h"

namespace glowworm {

namespace {

bool is_openvdb(const std::string& path) { return lower_ending(path) == ".vdb"; }

}  // namespace

float VoxelGrid::at(Vec3d at) const {
  std::array<int, 3> cell{};
  std::array<double, 3> share{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double x = at[static_cast<int>(axis)] - first[axis];
    if (!(x >= 0 && x < size[axis] - 1)) return 0;
    cell[axis] = static_cast<int>(x);
    share[axis] = x - cell[axis];
  }
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const int x = i & 1, y = (i >> 1) & 1, z = i >> 2;
    const auto line = static_cast<std::size_t>(cell[2] + z) * static_cast<std::size_t>(size[1]) +
                      static_cast<std::size_t>(cell[1] + y);
    const double weight = (x ? share[0] : 1 - share[0]) * (y ? share[1] : 1 - share[1]) * (z ? share[2] : 1 - share[2]);
    sum += weight * double{values[line * static_cast<std::size_t>(size[0]) + static_cast<std::size_t>(cell[0] + x)]};
  }
  return static_cast<float>(sum);
}

VoxelGrid read_voxel_grid(const std::string& path, const std::string& grid, MemoryBudget& budget) {
  return is_openvdb(path) ? read_openvdb(path, grid, budget) : read_nanovdb(path, grid, budget);
}

bool has_voxel_grid(const std::string& path, const std::string& grid, MemoryBudget& budget) {
  return is_openvdb(path) ? has_openvdb_grid(path, grid, budget) : has_nanovdb_grid(path, grid, budget);
}

void place_medium(const VoxelGrid& grid, const TransformDouble& to_scene, Medium& medium) {
  const auto corner = [&](std::size_t axis, int cell) { return static_cast<float>(grid.first[axis] + cell) - 0.5f; };
  medium.to_medium = inverse(to_scene).relative_to({0, 0, 0});
  medium.bounds = Box3{{corner(0, 0), corner(1, 0), corner(2, 0)},
                       {corner(0, grid.size[0]), corner(1, grid.size[1]), corner(2, grid.size[2])}};
}

}  // namespace glowworm
