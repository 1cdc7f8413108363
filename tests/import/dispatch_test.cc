// The entrance to import, and errors that all formats share.
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

TEST_F(DispatchTest, WhatIsNoSceneFileIsRefused) {
  EXPECT_THAT(message_of(path("gone.gltf")), AllOf(HasSubstr("gone.gltf"), HasSubstr("no such scene file")));
  EXPECT_THAT(message_of(path("")), HasSubstr("is a folder"));
  EXPECT_THAT(message_of(write("a.xyz123", "text")), HasSubstr("'.xyz123' are not supported"));
  EXPECT_THAT(message_of(std::string("a\0b.obj", 7)), HasSubstr("NUL"));
}

TEST_F(DispatchTest, OtherFormatsAreReadByAssimp) {
  const auto d = load_scene(write("a.STL",
                                  "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                                  "endloop\nendfacet\nendsolid a\n"));
  EXPECT_EQ(d.geometry.triangle_count(), 1u);
  EXPECT_THAT(message_of(write("b.dae", "<COLLADA")), HasSubstr("b.dae: cannot be read"));
}

}  // namespace
}  // namespace glowworm
