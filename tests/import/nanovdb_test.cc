// Grids of NanoVDB files that this file writes.
#include <zlib.h>

#include <cstring>

#include "import/nanovdb/reader.h"
#include "test_files.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

/// Bytes of a grid with one leaf node at (-8, 0, 0) and a tile of 8^3 voxels at (0, 0, 0) beside it.
class GridBytes {
 public:
  GridBytes() {
    put<std::uint64_t>(kTree + 24, kRoot - kTree);
    const std::int32_t box[] = {-8, 0, 0, 7, 7, 7};
    for (std::uint64_t i = 0; i < 6; ++i) put(kRoot + 4 * i, box[i]);
    put<std::uint32_t>(kRoot + 24, 2);
    add_branch(0, kUpper0, 0x1fffff, 31);
    add_branch(1, kUpper1, 0, 0);
    // The tile and the leaf node at the ends of the two branches.
    put(kUpper1 + kUpperBytes + 1088, 4.0f);
    set_bit(kUpper0 + kUpperBytes + 544, child_index(15, 0, 0, 4));
    put<std::int64_t>(kUpper0 + kUpperBytes + 1088 + 8 * child_index(15, 0, 0, 4), kLeaf - kUpper0 - kUpperBytes);
    for (std::uint64_t n = 0; n < 512; ++n)
      put(kLeaf + 96 + 4 * n,
          value(static_cast<int>(n >> 6) - 8, static_cast<int>(n >> 3) & 7, static_cast<int>(n) & 7));
    const double map[] = {2, 0, 0, 0, 2, 0, 0, 0, 2};  // row by row
    for (std::uint64_t i = 0; i < 9; ++i) put(384 + 8 * i, map[i]);
    for (std::uint64_t i = 0; i < 3; ++i) put(528 + 8 * i, 10.0 * static_cast<double>(i + 1));
  }
  static float value(int x, int y, int z) { return static_cast<float>(1 + (x + 8) * 64 + y * 8 + z) / 512; }
  const std::string& bytes() const { return bytes_; }
  template <typename T>
  void put(std::uint64_t at, T value) {
    if (bytes_.size() < at + sizeof value) bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  static constexpr std::uint64_t kTree = 672, kRoot = kTree + 64, kUpper0 = kRoot + 128, kUpperBytes = 270400,
                                 kLowerBytes = 33856, kUpper1 = kUpper0 + kUpperBytes + kLowerBytes,
                                 kLeaf = kUpper1 + kUpperBytes + kLowerBytes;

 private:
  static std::uint64_t child_index(std::uint64_t x, std::uint64_t y, std::uint64_t z, int log2) {
    return x << (2 * log2) | y << log2 | z;
  }
  void set_bit(std::uint64_t mask, std::uint64_t bit) {
    put(mask + bit / 8, static_cast<std::uint8_t>(1u << (bit % 8)));
  }
  /// A tile of the root with an upper node, and a lower node behind that.
  /// @param x of the upper node, in nodes; @param in_upper x of the lower node within it
  void add_branch(std::uint64_t tile, std::uint64_t upper, std::uint64_t x, std::uint64_t in_upper) {
    put<std::uint64_t>(kRoot + 64 + 32 * tile, (x & 0x1fffff) << 42);
    put<std::int64_t>(kRoot + 64 + 32 * tile + 8, upper - kRoot);
    put(upper + kUpperBytes + kLowerBytes - 1, std::uint8_t{0});
    const std::uint64_t child = child_index(in_upper, 0, 0, 5);
    set_bit(upper + 4128, child);
    put<std::int64_t>(upper + 8256 + 8 * child, kUpperBytes);
  }

  std::string bytes_;
};

/// A file with one grid of floats.
std::string file_of(const std::string& grid, const std::string& name, bool packed, std::uint32_t type = 1) {
  std::string stored = grid;
  if (packed) {
    uLongf size = compressBound(grid.size());
    std::string bytes(size, '\0');
    compress(reinterpret_cast<Bytef*>(bytes.data()), &size, reinterpret_cast<const Bytef*>(grid.data()), grid.size());
    const std::uint64_t length = size;
    stored.assign(reinterpret_cast<const char*>(&length), sizeof length);
    stored.append(bytes, 0, size);
  }
  std::string file(16 + 176, '\0');
  const auto put = [&](std::size_t at, auto value) { std::memcpy(file.data() + at, &value, sizeof value); };
  put(0, std::uint64_t{0x304244566f6e614e});
  put(8, std::uint32_t{32u << 21});
  put(12, std::uint16_t{1});
  put(14, std::uint16_t(packed ? 1 : 0));
  put(16, std::uint64_t{grid.size()});
  put(24, std::uint64_t{stored.size()});
  put(48, type);
  put(52, std::uint32_t{2});  // a fog volume
  put(152, static_cast<std::uint32_t>(name.size() + 1));
  return file + name + '\0' + stored;
}

using NanoVdbTest = FileTest;

TEST_F(NanoVdbTest, LeavesTilesAndTheMapAreRead) {
  MemoryBudget budget;
  for (const bool packed : {false, true}) {
    const std::string path = write("grid.nvdb", file_of(GridBytes().bytes(), "density", packed));
    EXPECT_TRUE(has_nanovdb_grid(path, "density", budget));
    EXPECT_FALSE(has_nanovdb_grid(path, "temperature", budget));
    const VoxelGrid grid = read_nanovdb(path, "density", budget);
    EXPECT_EQ(grid.first, (std::array<int, 3>{-9, -1, -1}));
    EXPECT_EQ(grid.size, (std::array<int, 3>{18, 10, 10}));
    for (int x = -9; x < 9; ++x)
      for (int y = -1; y < 9; ++y)
        for (int z = -1; z < 9; ++z) {
          const bool inside = x >= -8 && x < 8 && y >= 0 && y < 8 && z >= 0 && z < 8;
          const float wanted = !inside ? 0 : x < 0 ? GridBytes::value(x, y, z) : 4;
          ASSERT_EQ(grid.values[static_cast<std::size_t>(((z + 1) * 10 + y + 1) * 18 + x + 9)], wanted)
              << x << " " << y << " " << z;
        }
    EXPECT_FLOAT_EQ(grid.at({-3.5, 2, 3}), (GridBytes::value(-4, 2, 3) + GridBytes::value(-3, 2, 3)) / 2);
    EXPECT_EQ(grid.at({100, 0, 0}), 0);
    const Vec3d place = grid.to_world.point({1, 2, 3});
    EXPECT_EQ(place.x, 12);
    EXPECT_EQ(place.y, 24);
    EXPECT_EQ(place.z, 36);
  }
}

TEST_F(NanoVdbTest, DamagedFilesAreErrors) {
  const auto error_of = [&](const std::string& bytes, const std::string& name = "density") -> std::string {
    MemoryBudget budget(std::uint64_t{1} << 30);
    try {
      read_nanovdb(write("grid.nvdb", bytes), name, budget);
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  const std::string whole = file_of(GridBytes().bytes(), "density", false);
  EXPECT_EQ(error_of(whole), "");
  for (const std::size_t size :
       {std::size_t{5}, std::size_t{100}, std::size_t{200}, whole.size() / 2, whole.size() - 1})
    EXPECT_THAT(error_of(whole.substr(0, size)), HasSubstr("grid.nvdb")) << size;
  EXPECT_THAT(error_of(whole, "smoke"), HasSubstr("It has: density."));
  EXPECT_THAT(error_of(file_of(GridBytes().bytes(), "density", false, 2)), HasSubstr("does not hold floats"));
  EXPECT_THAT(error_of("PNG" + whole), HasSubstr("is not a NanoVDB file"));
  const auto with = [&](std::uint64_t at, auto value) {
    GridBytes bytes;
    bytes.put(at, value);
    return error_of(file_of(bytes.bytes(), "density", false));
  };
  EXPECT_THAT(with(GridBytes::kTree + 24, std::uint64_t{1} << 63), HasSubstr("damaged"));
  EXPECT_THAT(with(GridBytes::kRoot + 64 + 8, std::int64_t{-8}), HasSubstr("damaged"));
  EXPECT_THAT(with(GridBytes::kRoot + 64 + 8, std::int64_t{1} << 40), HasSubstr("damaged"));
  EXPECT_THAT(with(GridBytes::kRoot + 96, std::uint64_t{0x1fffff} << 42), HasSubstr("damaged")) << "the same key twice";
  EXPECT_THAT(with(GridBytes::kRoot, std::int32_t{100}), HasSubstr("no values"));
  EXPECT_THAT(with(GridBytes::kRoot, std::int32_t{-2000000000}), HasSubstr("too far"));
  EXPECT_NE(with(GridBytes::kRoot + 12, std::int32_t{16000000}), "") << "larger than the budget";
}

}  // namespace
}  // namespace glowworm
