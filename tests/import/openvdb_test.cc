// Grids of OpenVDB files, which the program glowworm-openvdb reads.
#include "import/openvdb/hand_over.h"
#include "import/openvdb/import.h"
#include "import/scene_changes.h"
#include "import/volume_text.h"
#include "openvdb_files.h"
#include "scene/medium.h"
#include "scene/scene_parts.h"
#include "test_files.h"

namespace glowworm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class OpenVdbTest : public FileTest {
 protected:
  std::string smoke(VdbGrid kind = VdbGrid::floats) const {
    const std::string file = path("smoke.vdb");
    write_vdb(file, "density", kind);
    return file;
  }
  static std::string error_of(const std::string& file, const std::string& grid = "density",
                              const ChildLimits& limits = {}, const std::string& program = {}) {
    MemoryBudget budget(std::uint64_t{1} << 30);
    try {
      read_openvdb(file, grid, budget, limits, program);
    } catch (const Error& error) {
      return error.what();
    }
    ADD_FAILURE() << file << " was accepted";
    return {};
  }
};

TEST_F(OpenVdbTest, ValuesAndTheMapAreRead) {
  MemoryBudget budget;
  for (const VdbGrid kind : {VdbGrid::floats, VdbGrid::halves, VdbGrid::doubles}) {
    const VoxelGrid grid = read_voxel_grid(smoke(kind), "density", budget);
    EXPECT_EQ(grid.first, (std::array<int, 3>{-1, -2, -1}));
    EXPECT_EQ(grid.size, (std::array<int, 3>{12, 4, 5}));
    EXPECT_EQ(grid.at({0, 0, 0}), 1);
    EXPECT_EQ(grid.at({1, 0, 0}), 2);
    EXPECT_EQ(grid.at({9, -1, 2}), 3);
    EXPECT_EQ(grid.at({0.5, 0, 0}), 1.5f);
    EXPECT_EQ(grid.at({5, 0, 0}), 0);
    double sum = 0;
    for (const float value : grid.values) sum += value;
    EXPECT_EQ(sum, 6);
    const Vec3d place = grid.to_world.point({1, 2, 4});
    EXPECT_EQ(place.x, 10.5);
    EXPECT_EQ(place.y, 21);
    EXPECT_EQ(place.z, 32);
  }
  EXPECT_TRUE(has_voxel_grid(smoke(), "temperature", budget));
  EXPECT_FALSE(has_voxel_grid(smoke(), "heat", budget));
}

TEST_F(OpenVdbTest, MediaOfPbrtFilesHaveThem) {
  smoke();
  const std::string scene = write("smoke.pbrt",
                                  "WorldBegin\nScale 2 2 2\nMakeNamedMedium \"smoke\" \"string type\" \"nanovdb\" "
                                  "\"string filename\" \"smoke.vdb\" \"rgb sigma_a\" [4 4 4] \"float Lescale\" 5\n"
                                  "Shape \"sphere\"\n");
  const SceneDescription d = load_scene(scene);
  ASSERT_EQ(d.media.size(), 1u);
  const auto at = [&](double x, double y, double z) {
    return medium_point(d.media[0], narrow(Vec3d(x, y, z) - Vec3d(d.origin)));
  };
  EXPECT_NEAR(at(20, 40, 60).sigma_a.r, 4, 1e-3f);
  EXPECT_NEAR(at(21, 40, 60).sigma_a.r, 8, 1e-3f);
  EXPECT_NEAR(at(23, 40, 60).sigma_a.r, 0, 1e-3f);
  EXPECT_TRUE(is_black(at(20, 40, 60).emission)) << "the hot voxel is elsewhere";
}

/// In the axes and the unit of the scene's file.
TEST_F(OpenVdbTest, ScenesGetTheSmokeOfAFile) {
  SceneChanges changes;
  changes.volume = smoke() + ",scale=4,albedo=0.75";
  for (const bool z_up : {false, true})
    for (const float unit : {1.0f, 0.5f}) {
      SceneDescription d = floor_description();
      changes.z_up = z_up;
      changes.metres_per_unit = unit;
      change_scene(d, changes, loading_budget());
      ASSERT_EQ(d.ambient_medium, 0u);
      const auto at = [&](Vec3d p) {
        return medium_point(d.media[0], narrow((z_up ? y_up_from_z_up(p) : p) * double{unit} - Vec3d(d.origin)));
      };
      EXPECT_NEAR(at({10, 20, 30}).sigma_s.r, 3 / unit, 1e-3f);
      EXPECT_NEAR(at({10, 20, 30}).sigma_a.r, 1 / unit, 1e-3f);
      EXPECT_NEAR(at({10.5, 20, 30}).sigma_s.r, 6 / unit, 1e-3f);
      EXPECT_NEAR(at({11.5, 20, 30}).sigma_s.r, 0, 1e-3f);
    }
  for (const std::string wrong : {"smoke.txt", "smoke.vdb,scale=-1", "smoke.vdb,albedo=2", "smoke.vdb,albedo=x", ""})
    EXPECT_THROW(check_volume_text(wrong), Error) << wrong;
  changes.volume = path("missing.vdb");
  SceneDescription d = floor_description();
  try {
    change_scene(d, changes, loading_budget());
    ADD_FAILURE() << "a missing file was accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("missing.vdb: no such file"));
  }
}

/// As the light of the same box in a grid of temperatures in the pbrt file itself.
TEST_F(OpenVdbTest, TemperaturesEmitAsThoseOfPbrtFiles) {
  smoke(VdbGrid::hot);
  const std::string glow = " \"rgb sigma_a\" [2 2 2] \"rgb sigma_s\" [1 1 1] \"float Lescale\" ";
  const std::string shift = " \"float temperatureoffset\" 1000 \"float temperaturescale\" 1.5 ";
  const SceneDescription d =
      load_scene(write("glow.pbrt",
                       "WorldBegin\nMakeNamedMedium \"smoke\" \"string type\" \"nanovdb\" \"string filename\" "
                       "\"smoke.vdb\"" +
                           glow + "3" + shift +
                           "\nMakeNamedMedium \"even\" \"string type\" \"uniformgrid\" \"point3 p0\" [9 19 29] "
                           "\"point3 p1\" [14 24 34] \"float density\" 1 \"float temperature\" 4000" +
                           glow + "3" + shift + "\nShape \"sphere\"\n"));
  ASSERT_EQ(d.media.size(), 2u);
  const auto at = [&](std::size_t medium, double across) {
    return medium_point(d.media[medium], narrow(Vec3d(across, 21.5, 31.5) - Vec3d(d.origin)));
  };
  const MediumPoint right = at(1, 11.5), inside = at(0, 11.5);
  EXPECT_GT(luminance(right.emission), 1);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(inside.emission[c], right.emission[c], 1e-3f * right.emission[c]) << c;
    EXPECT_NEAR(inside.sigma_a[c], right.sigma_a[c], 1e-3f) << c;
  }
  EXPECT_TRUE(is_black(at(0, 9).emission)) << "beyond the voxels";
}

TEST_F(OpenVdbTest, WhatCannotBeReadIsAnErrorWithTheFile) {
  EXPECT_THAT(error_of(smoke(), "smoke"), AllOf(HasSubstr("has no grid 'smoke'"), HasSubstr("density, temperature")));
  EXPECT_THAT(error_of(smoke(VdbGrid::vectors)), HasSubstr("values of type vec3s"));
  EXPECT_THAT(error_of(smoke(VdbGrid::level_set)), HasSubstr("level set"));
  EXPECT_THAT(error_of(smoke(VdbGrid::empty)), HasSubstr("no values"));
  EXPECT_THAT(error_of(smoke(VdbGrid::frustum)), HasSubstr("not linear"));
  EXPECT_THAT(error_of(path("none.vdb")), HasSubstr("none.vdb"));
  EXPECT_THAT(error_of(path(".")), HasSubstr("not a file"));
  EXPECT_THAT(message_of(write("smoke.pbrt",
                               "WorldBegin\nMakeNamedMedium \"smoke\" \"string type\" \"nanovdb\" \"string filename\" "
                               "\"none.vdb\"\nShape \"sphere\"\n")),
              AllOf(HasSubstr("smoke.pbrt:2"), HasSubstr("none.vdb")));
}

TEST_F(OpenVdbTest, DamagedFilesAreErrorsOrWhatIsLeft) {
  std::ifstream in(smoke(), std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  for (const std::size_t size : {std::size_t{0}, std::size_t{7}, std::size_t{60}, whole.size() / 4, whole.size() / 2})
    EXPECT_THAT(error_of(write("cut.vdb", whole.substr(0, size))), HasSubstr("cut.vdb")) << size;
  EXPECT_THAT(error_of(write("other.vdb", "PNG" + whole)), HasSubstr("other.vdb"));
  // A byte that differs may cost a value, the grid or the process, but nothing else.
  for (std::size_t at = 0; at < whole.size(); at += whole.size() / 24) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
    MemoryBudget budget(std::uint64_t{1} << 30);
    try {
      read_openvdb(write("bent.vdb", bytes), "density", budget, {std::uint64_t{1} << 29, 10, 20});
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("bent.vdb")) << at;
    }
  }
}

TEST_F(OpenVdbTest, ProcessesThatFailAreErrors) {
  const auto of = [&](const std::string& script, const ChildLimits& limits = {}) {
    const std::string program = write("reader", "#!/bin/sh\n" + script);
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    return error_of(smoke(), "density", limits, program);
  };
  EXPECT_THAT(of("kill -SEGV $$"), AllOf(HasSubstr("smoke.vdb"), HasSubstr("OpenVDB"), HasSubstr("crashed")));
  EXPECT_THAT(of("echo nonsense >&3"), HasSubstr("OpenVDB's output is invalid"));
  EXPECT_THAT(of("exec sleep 60", {std::uint64_t{1} << 30, 10, 1}), HasSubstr("within 1 s"));
}

TEST(OpenVdbHandOver, AnyBytesGiveAValidAnswerOrAnError) {
  OpenVdbAnswer answer;
  answer.names = {"density", "heat"};
  answer.found = true;
  answer.grid.first = {-1, 0, 2};
  answer.grid.size = {2, 1, 3};
  answer.grid.values = {1, 2, 3, 4, 5, 6};
  const auto bytes_of = [](const OpenVdbAnswer& of) {
    std::string bytes;
    write_openvdb_answer(
        of, [&](const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); });
    return bytes;
  };
  const std::string whole = bytes_of(answer);
  EXPECT_EQ(read_openvdb_answer(whole, "a.vdb").grid.values, answer.grid.values);
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THROW(read_openvdb_answer(whole.substr(0, size), "a.vdb"), Error) << size;
  EXPECT_THROW(read_openvdb_answer(whole + "x", "a.vdb"), Error);
  const auto refused = [&](auto&& change) {
    OpenVdbAnswer other = answer;
    change(other);
    EXPECT_THROW(read_openvdb_answer(bytes_of(other), "a.vdb"), Error);
  };
  refused([](OpenVdbAnswer& a) { a.grid.values.pop_back(); });
  refused([](OpenVdbAnswer& a) { a.grid.size = {1, -2, -3}; });
  refused([](OpenVdbAnswer& a) { a.grid.first[1] = 1 << 30; });
  refused([](OpenVdbAnswer& a) { a.grid.to_world.y.x = HUGE_VAL; });
}

}  // namespace
}  // namespace glowworm
