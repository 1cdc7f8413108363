// glowworm-openvdb: reads a grid by OpenVDB and writes it to a pipe. OpenVDB may crash on damaged or malicious files,
// so this is a separate process with limits. usage: glowworm-openvdb FILE MEMORY_BYTES CPU_SECONDS GRID
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>

#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "core/confine.h"
#include "import/openvdb/hand_over.h"

namespace glowworm {
namespace {

/// The map of a grid from its index space to the world.
TransformDouble map_of(const openvdb::GridBase& grid) {
  if (!grid.transform().isLinear()) throw std::runtime_error("the grid's map is not linear");
  const openvdb::Mat4R m = grid.transform().baseMap()->getAffineMap()->getMat4();  // for vectors that are rows
  const auto row = [&](int i) { return Vec3d(m(i, 0), m(i, 1), m(i, 2)); };
  return {row(0), row(1), row(2), row(3)};
}

/// The box of a grid's active values, with a border of one voxel.
template <typename Grid>
VoxelGrid dense_box(const Grid& grid) {
  constexpr int kFarthest = 1 << 24;
  if (grid.getGridClass() == openvdb::GRID_LEVEL_SET)
    throw std::runtime_error("the grid is a level set; convert it to a fog volume");
  openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  if (box.empty()) throw std::runtime_error("the grid has no values");
  for (int axis = 0; axis < 3; ++axis)
    if (box.min()[axis] < -kFarthest || box.max()[axis] > kFarthest)
      throw std::runtime_error("the grid has voxels too far from its origin");
  box.expand(1);
  VoxelGrid out;
  out.to_world = map_of(grid);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<int>(axis);
    out.first[axis] = box.min()[a];
    out.size[axis] = box.max()[a] - box.min()[a] + 1;
  }
  std::uint64_t voxels = 1;
  for (const int side : out.size)
    if (__builtin_mul_overflow(voxels, static_cast<std::uint64_t>(side), &voxels) || voxels > out.values.max_size())
      throw std::runtime_error("the grid's voxels are too far from each other");
  out.values.resize(voxels);
  openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(box, out.values.data());
  openvdb::tools::copyToDense(grid, dense, true);  // by one thread: others would take address space
  return out;
}

OpenVdbAnswer answer(const std::string& path, const std::string& name) {
  if (!std::filesystem::is_regular_file(path)) throw std::runtime_error("it is not a file");  // others may block
  openvdb::initialize();
  openvdb::io::File file(path);
  file.open(false);  // read whole, at once
  OpenVdbAnswer out;
  for (auto at = file.beginName(); at != file.endName(); ++at) {
    out.names.push_back(at.gridName());
    out.found |= !name.empty() && out.names.back() == name;
  }
  if (!out.found) return out;
  const openvdb::GridBase::Ptr grid = file.readGrid(name);
  if (const auto floats = openvdb::gridPtrCast<openvdb::FloatGrid>(grid))
    out.grid = dense_box(*floats);
  else if (const auto doubles = openvdb::gridPtrCast<openvdb::DoubleGrid>(grid))
    out.grid = dense_box(*doubles);
  else
    throw std::runtime_error("the grid holds values of type " + grid->valueType() + "; convert it to floats");
  return out;
}

}  // namespace
}  // namespace glowworm

int main(int argc, char** argv) {
  using namespace glowworm;
  read_for_parent(argc, argv, 5, [&] { write_openvdb_answer(answer(argv[1], argv[4]), send_to_parent); });
}
