#include "import/nanovdb/reader.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <set>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "core/input_file.h"

namespace glowworm {

namespace {

constexpr std::uint64_t kFileMagic = 0x304244566f6e614eu,
                        kNewFileMagic = 0x324244566f6e614eu;  // "NanoVDB0", "NanoVDB2"
constexpr std::uint32_t kMajorVersion = 32, kFloat = 1, kLevelSet = 1;
constexpr std::size_t kHeaderBytes = 16, kMetaBytes = 176, kGridBytes = 672, kTreeBytes = 64, kRootBytes = 64;
constexpr std::size_t kTileBytes = 32, kLeafValues = 96;

/// A level of nodes below the root: a cube of children.
struct Level {
  int children_log2;  ///< of the number along a side
  int child_log2;     ///< of a child's voxels along a side
  std::size_t mask, child_mask, table;
};
constexpr Level kUpper{5, 7, 32, 4128, 8256}, kLower{4, 3, 32, 544, 1088};

/// Bytes of a file, read with checks.
class Bytes {
 public:
  Bytes(std::string_view bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  template <typename T>
  T at(std::uint64_t offset) const {
    if (offset > bytes_.size() || bytes_.size() - offset < sizeof(T)) fail("is cut off");
    T value;
    std::memcpy(&value, bytes_.data() + offset, sizeof(T));
    return value;
  }
  std::string_view part(std::uint64_t offset, std::uint64_t size) const {
    if (offset > bytes_.size() || bytes_.size() - offset < size) fail("is cut off");
    return bytes_.substr(offset, size);
  }
  std::uint64_t size() const { return bytes_.size(); }
  [[noreturn]] void fail(const std::string& what, const std::string& remedy = "Convert it again.") const {
    throw Error({path_}, what, remedy);
  }
  const std::string& path() const { return path_; }

 private:
  std::string_view bytes_;
  const std::string& path_;
};

/// A grid in the file's directory.
struct Entry {
  std::string name;
  std::uint64_t place = 0, file_size = 0, grid_size = 0;
  std::uint32_t type = 0, grid_class = 0;
  std::uint16_t codec = 0;  ///< 0: none; 1: zlib; 2: Blosc
};

std::vector<Entry> read_directory(const Bytes& file) {
  std::vector<Entry> all;
  for (std::uint64_t at = 0; at < file.size();) {
    const auto magic = file.at<std::uint64_t>(at);
    if (magic != kFileMagic && magic != kNewFileMagic) file.fail("is not a NanoVDB file");
    if (const auto version = file.at<std::uint32_t>(at + 8) >> 21; version != kMajorVersion)
      file.fail(fmt::format("has version {} of the format; expected {}", version, kMajorVersion));
    const std::size_t begin = all.size(), count = file.at<std::uint16_t>(at + 12);
    const auto codec = file.at<std::uint16_t>(at + 14);
    at += kHeaderBytes;
    for (std::size_t i = 0; i < count; ++i) {
      Entry entry{{},
                  0,
                  file.at<std::uint64_t>(at + 8),
                  file.at<std::uint64_t>(at),
                  file.at<std::uint32_t>(at + 32),
                  file.at<std::uint32_t>(at + 36),
                  codec};
      const auto name_size = file.at<std::uint32_t>(at + 136);
      entry.name = file.part(at + kMetaBytes, name_size);
      entry.name.resize(std::strlen(entry.name.c_str()));
      at += kMetaBytes + name_size;
      all.push_back(std::move(entry));
    }
    for (std::size_t i = begin; i < all.size(); ++i) {
      all[i].place = at;
      at += file.part(at, all[i].file_size).size();
    }
  }
  return all;
}

/// The bytes of a grid. @param unpacked holds them where the file is compressed
std::string_view grid_bytes(const Bytes& file, const Entry& entry, std::string& unpacked, Reservation& held) {
  if (entry.codec == 0) return file.part(entry.place, entry.grid_size);
  if (entry.codec != 1)
    file.fail("is compressed by Blosc, which is not supported", "Write it with zip compression, or with none.");
  const auto size = file.at<std::uint64_t>(entry.place);
  const std::string_view packed = file.part(entry.place + sizeof size, size);
  // zlib makes at most 1032 bytes of one.
  if (entry.grid_size / 1040 > packed.size()) file.fail("is damaged");
  held.grow(entry.grid_size);
  unpacked.resize(entry.grid_size);
  uLongf length = entry.grid_size;
  if (uncompress(reinterpret_cast<Bytef*>(unpacked.data()), &length, reinterpret_cast<const Bytef*>(packed.data()),
                 size) != Z_OK ||
      length != entry.grid_size)
    file.fail("is damaged");
  return unpacked;
}

/// Copies the values of a grid's tree into its dense box.
class TreeReader {
 public:
  TreeReader(const Bytes& grid, VoxelGrid& out) : grid_(grid), out_(out) {}

  /// Sets the box that the values need.
  void measure() {
    const std::uint64_t offset = grid_.at<std::uint64_t>(kGridBytes + 24);
    if (offset > grid_.size()) grid_.fail("is damaged");
    root_ = kGridBytes + offset;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t low = grid_.at<std::int32_t>(root_ + 4 * axis),
                         high = grid_.at<std::int32_t>(root_ + 12 + 4 * axis);
      constexpr std::int64_t kFarthest = 1 << 24;
      if (low > high) grid_.fail("has no values", "Write a grid that is not empty.");
      if (low < -kFarthest || high > kFarthest) grid_.fail("has voxels too far from its origin");
      out_.first[axis] = static_cast<int>(low - 1);
      out_.size[axis] = static_cast<int>(high - low + 3);
    }
    background_ = grid_.at<float>(root_ + 28);
  }
  double cells() const { return double(out_.size[0]) * double(out_.size[1]) * double(out_.size[2]); }

  void read() {
    out_.values.assign(static_cast<std::size_t>(cells()), background_);
    const auto tiles = grid_.at<std::uint32_t>(root_ + 24);
    std::set<std::uint64_t> seen;
    for (std::uint32_t i = 0; i < tiles; ++i) {
      const std::uint64_t tile = root_ + kRootBytes + kTileBytes * std::uint64_t{i};
      const auto key = grid_.at<std::uint64_t>(tile);
      if (!seen.insert(key).second) grid_.fail("is damaged");
      const auto coordinate = [key](int shift) {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>((key >> shift) & 0x1fffff) << 12);
      };
      const std::array<int, 3> corner{coordinate(42), coordinate(21), coordinate(0)};
      if (const auto child = grid_.at<std::int64_t>(tile + 8); child != 0)
        inner(kUpper, child_place(root_, child), corner);
      else
        fill(corner, 4096, grid_.at<float>(tile + 20));
    }
  }

 private:
  std::uint64_t child_place(std::uint64_t parent, std::int64_t offset) const {
    if (offset <= 0 || static_cast<std::uint64_t>(offset) > grid_.size()) grid_.fail("is damaged");
    return parent + static_cast<std::uint64_t>(offset);
  }
  /// The part of a cube along an axis that lies in the box.
  std::pair<int, int> within(const std::array<int, 3>& corner, int side, std::size_t axis) const {
    return {std::max(corner[axis], out_.first[axis]),
            std::min(corner[axis] + side, out_.first[axis] + out_.size[axis])};
  }
  bool is_outside(const std::array<int, 3>& corner, int side) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (const auto [low, high] = within(corner, side, axis); low >= high) return true;
    return false;
  }
  float* row(int y, int z) {
    const auto line = static_cast<std::size_t>(z - out_.first[2]) * static_cast<std::size_t>(out_.size[1]) +
                      static_cast<std::size_t>(y - out_.first[1]);
    return out_.values.data() + line * static_cast<std::size_t>(out_.size[0]);
  }

  void inner(const Level& level, std::uint64_t node, const std::array<int, 3>& corner) {
    const int side = 1 << level.children_log2, child_side = 1 << level.child_log2;
    if (is_outside(corner, side * child_side)) return;
    for (int n = 0; n < side * side * side; ++n) {
      const int x = n >> (2 * level.children_log2), y = (n >> level.children_log2) & (side - 1), z = n & (side - 1);
      const std::array<int, 3> at{corner[0] + x * child_side, corner[1] + y * child_side, corner[2] + z * child_side};
      if (is_outside(at, child_side)) continue;
      const auto index = static_cast<std::uint64_t>(n);
      const std::uint64_t entry = node + level.table + 8 * index;
      if (!((grid_.at<std::uint8_t>(node + level.child_mask + index / 8) >> (index % 8)) & 1)) {
        fill(at, child_side, grid_.at<float>(entry));
        continue;
      }
      const std::uint64_t child = child_place(node, grid_.at<std::int64_t>(entry));
      if (&level == &kUpper)
        inner(kLower, child, at);
      else
        leaf(child, at);
    }
  }

  void leaf(std::uint64_t node, const std::array<int, 3>& corner) {
    const auto [x0, x1] = within(corner, 8, 0);
    const auto [y0, y1] = within(corner, 8, 1);
    const auto [z0, z1] = within(corner, 8, 2);
    for (int z = z0; z < z1; ++z)
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
          const int n = ((x & 7) << 6) | ((y & 7) << 3) | (z & 7);
          row(y, z)[x - out_.first[0]] = grid_.at<float>(node + kLeafValues + 4 * static_cast<std::uint64_t>(n));
        }
  }

  void fill(const std::array<int, 3>& corner, int side, float value) {
    if (value == background_ || is_outside(corner, side)) return;
    const auto [x0, x1] = within(corner, side, 0);
    const auto [y0, y1] = within(corner, side, 1);
    const auto [z0, z1] = within(corner, side, 2);
    for (int z = z0; z < z1; ++z)
      for (int y = y0; y < y1; ++y)
        std::fill(row(y, z) + (x0 - out_.first[0]), row(y, z) + (x1 - out_.first[0]), value);
  }

  const Bytes& grid_;
  VoxelGrid& out_;
  std::uint64_t root_ = 0;
  float background_ = 0;
};

/// The map from index space to the world.
TransformDouble map_of(const Bytes& grid) {
  constexpr std::uint64_t kMatrix = 296 + 88, kOffset = 296 + 232;
  const auto row = [&](std::uint64_t at) {
    return Vec3d(grid.at<double>(at), grid.at<double>(at + 8), grid.at<double>(at + 16));
  };
  const Vec3d a = row(kMatrix), b = row(kMatrix + 24), c = row(kMatrix + 48);
  return {{a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z}, row(kOffset)};
}

}  // namespace

VoxelGrid read_nanovdb(const std::string& path, const std::string& name, MemoryBudget& budget) {
  Reservation held(budget, "grids", 0);
  const std::string text = read_input_file(path, held);
  const Bytes file(text, path);
  std::string names;
  for (const Entry& entry : read_directory(file)) {
    names += (names.empty() ? "" : ", ") + entry.name;
    if (entry.name != name) continue;
    if (entry.type != kFloat) file.fail(fmt::format("grid '{}' does not hold floats", name), "Convert it to floats.");
    if (entry.grid_class == kLevelSet)
      file.fail(fmt::format("grid '{}' is a level set", name), "Convert it to a fog volume.");
    std::string unpacked;
    const Bytes grid(grid_bytes(file, entry, unpacked, held), path);
    VoxelGrid out;
    out.to_world = map_of(grid);
    TreeReader reader(grid, out);
    reader.measure();
    held.grow(static_cast<std::uint64_t>(std::min(reader.cells() * sizeof(float), 0x1p62)));
    reader.read();
    return out;
  }
  throw Error({path}, fmt::format("has no grid '{}'", name), "It has: " + names + ".");
}

bool has_nanovdb_grid(const std::string& path, const std::string& name, MemoryBudget& budget) {
  Reservation held(budget, "grids", 0);
  const std::string text = read_input_file(path, held);
  const std::vector<Entry> all = read_directory(Bytes(text, path));
  return std::any_of(all.begin(), all.end(), [&](const Entry& entry) { return entry.name == name; });
}

}  // namespace glowworm
