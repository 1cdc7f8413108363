#include "openvdb_files.h"

#include <openvdb/openvdb.h>

namespace glowworm {

namespace {

template <typename Grid>
openvdb::GridBase::Ptr three_voxels() {
  using Value = typename Grid::ValueType;
  const auto grid = Grid::create();
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  auto accessor = grid->getAccessor();
  accessor.setValue({0, 0, 0}, Value(1));
  accessor.setValue({1, 0, 0}, Value(2));
  accessor.setValue({9, -1, 2}, Value(3));
  return grid;
}

openvdb::FloatGrid::Ptr even_block(float value) {
  const auto grid = openvdb::FloatGrid::create();
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->fill(openvdb::CoordBBox({0, 0, 0}, {7, 7, 7}), value);
  return grid;
}

openvdb::GridBase::Ptr grid_of(VdbGrid kind) {
  switch (kind) {
    case VdbGrid::doubles:
      return three_voxels<openvdb::DoubleGrid>();
    case VdbGrid::vectors:
      return three_voxels<openvdb::Vec3SGrid>();
    case VdbGrid::hot:
      return even_block(1);
    case VdbGrid::empty:
      return openvdb::FloatGrid::create();
    default:
      return three_voxels<openvdb::FloatGrid>();
  }
}

openvdb::math::Transform::Ptr map_of(VdbGrid kind) {
  using openvdb::math::Transform;
  if (kind == VdbGrid::frustum)
    return Transform::createFrustumTransform(openvdb::BBoxd({0, 0, 0}, {10, 10, 10}), 0.5, 10, 0.5);
  const auto map = Transform::createLinearTransform(0.5);
  map->postTranslate({10, 20, 30});
  return map;
}

}  // namespace

void write_vdb(const std::string& path, const std::string& name, VdbGrid kind) {
  openvdb::initialize();
  const openvdb::GridBase::Ptr grid = grid_of(kind);
  grid->setName(name);
  grid->setTransform(map_of(kind));
  grid->setSaveFloatAsHalf(kind == VdbGrid::halves);
  if (kind == VdbGrid::level_set) grid->setGridClass(openvdb::GRID_LEVEL_SET);
  const bool hot = kind == VdbGrid::hot;
  const auto temperature = hot ? even_block(4000) : openvdb::FloatGrid::create();
  temperature->setName("temperature");
  if (hot)
    temperature->setTransform(map_of(kind));
  else
    temperature->getAccessor().setValue({2, 0, -1}, 1000);
  openvdb::io::File file(path);
  file.write({grid, temperature});
}

}  // namespace glowworm
