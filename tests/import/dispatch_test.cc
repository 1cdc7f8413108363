// Choosing an importer by name, and errors common to all formats.
#include <sys/stat.h>

#include "test_files.h"

namespace glowworm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

using DispatchTest = FileTest;

TEST_F(DispatchTest, BuiltinScenesAreFoundByName) {
  EXPECT_GT(load_scene("builtin:cornell").geometry.triangle_count(), 0u);
  EXPECT_THAT(message_of("builtin:nothing"), HasSubstr("cornell"));
}

TEST_F(DispatchTest, OtherFilesAreRejected) {
  EXPECT_THAT(message_of(path("gone.gltf")), AllOf(HasSubstr("gone.gltf"), HasSubstr("no such scene file")));
  EXPECT_THAT(message_of(path("")), HasSubstr("is a folder"));
  EXPECT_THAT(message_of(write("a.xyz123", "text")), HasSubstr("'.xyz123' are not supported"));
  EXPECT_THAT(message_of(std::string("a\0b.obj", 7)), HasSubstr("NUL"));
}

TEST_F(DispatchTest, PipesAndDevicesAreRefused) {
  ASSERT_EQ(mkfifo(path("a.obj").c_str(), 0600), 0);
  ASSERT_EQ(mkfifo(path("m.mtl").c_str(), 0600), 0);
  ASSERT_EQ(mkfifo(path("t.png").c_str(), 0600), 0);
  ASSERT_EQ(mkfifo(path("a.ply").c_str(), 0600), 0);
  EXPECT_THAT(message_of(path("a.obj")), HasSubstr("a.obj: is not a regular file"));
  std::filesystem::create_symlink("/dev/zero", path("zero.gltf"));
  EXPECT_THAT(message_of(path("zero.gltf")), HasSubstr("zero.gltf: is not a regular file"));
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
  EXPECT_THAT(load_scene(write("b.obj", "mtllib m.mtl\n" + triangle)).notes, HasNote("'m.mtl' cannot be opened"));
  write("n.mtl", "newmtl m\nmap_Kd t.png\n");
  EXPECT_THAT(load_scene(write("c.obj", "mtllib n.mtl\n" + triangle)).notes, HasNote("t.png' is magenta"));
  EXPECT_THAT(message_of(write("d.pbrt", "WorldBegin\nShape \"plymesh\" \"string filename\" \"a.ply\"\n")),
              HasSubstr("a.ply: is not a regular file"));
  EXPECT_THAT(message_of(write("e.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"uri":"t.png","byteLength":4}]})")),
              HasSubstr("t.png"));
}

}  // namespace
}  // namespace glowworm
