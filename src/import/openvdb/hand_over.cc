#include "import/openvdb/hand_over.h"

#include <cmath>
#include <cstdint>
#include <span>

#include "core/archive.h"
#include "core/error.h"

namespace glowworm {

namespace {

constexpr std::uint32_t kMagic = 0x31767767;

}  // namespace

template <typename Archive>
void transfer(Archive& archive, OpenVdbAnswer& answer) {
  std::uint32_t mark = kMagic;
  transfer(archive, mark);
  if (mark != kMagic) fail_transfer("it is not of this version of the program");
  transfer_all(archive, answer.names, answer.found, answer.grid.first, answer.grid.size, answer.grid.values);
  TransformDouble& map = answer.grid.to_world;
  for (Vec3d* column : {&map.x, &map.y, &map.z, &map.translation})
    transfer_all(archive, column->x, column->y, column->z);
}

namespace {

void check_answer(const OpenVdbAnswer& answer) {
  if (!answer.found) return;
  constexpr int kFarthest = (1 << 24) + 1;  // with the border
  const VoxelGrid& grid = answer.grid;
  double cells = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int first = grid.first[axis], size = grid.size[axis];
    if (first < -kFarthest || first > kFarthest || size < 1 || size > kFarthest - first + 1)
      fail_transfer("its voxels are too far from its origin");
    cells *= size;
  }
  if (cells != static_cast<double>(grid.values.size())) fail_transfer("it has not one value for each voxel");
  const TransformDouble& map = grid.to_world;
  for (const Vec3d& column : {map.x, map.y, map.z, map.translation})
    if (!std::isfinite(column.x) || !std::isfinite(column.y) || !std::isfinite(column.z))
      fail_transfer("its map is not finite");
}

}  // namespace

void write_openvdb_answer(const OpenVdbAnswer& answer, const std::function<void(const void*, std::size_t)>& write) {
  ArchiveWriter writer(write);
  transfer(writer, const_cast<OpenVdbAnswer&>(answer));  // a writer does not change the answer
}

OpenVdbAnswer read_openvdb_answer(std::string_view bytes, const std::string& file) try {
  auto answer = unarchived<OpenVdbAnswer>(std::as_bytes(std::span(bytes)));
  check_answer(answer);
  return answer;
} catch (const InvalidArchive& invalid) {
  throw Error({file}, std::string("OpenVDB's output is invalid: ") + invalid.what(), "Write the file again.");
}

}  // namespace glowworm
