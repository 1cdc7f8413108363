// Files and names from others: what they must not make the program do.
#include <cstdlib>

#include "import/gltf_file.h"
#include "program.h"

namespace glowworm {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class SecurityTest : public ProgramTest {
 protected:
  /// Bakes a scene to lit.glb.
  Outcome bake(const std::string& scene, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"bake",      scene, "--environment", "1,1,1", "--atlas", "16",
                                   "--samples", "1",   "--photons",     "100",   "-o",      "lit.glb"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
  void write_in(const std::string& name, const std::string& bytes) const {
    fs::create_directories(fs::path(path(name)).parent_path());
    write(name, bytes);
  }
};

TEST_F(SecurityTest, TheProgramsThatReadFilesAreNotTakenFromTheWorkingFolder) {
  write_scenes();
  fs::create_directory(path("bin"));
  fs::copy_file(GLOWWORM_PROGRAM, path("bin/glowworm"));
  write("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  for (const auto& [program, scene] : {std::pair("glowworm-assimp", "a.off"), std::pair("glowworm-reader", "a.obj")}) {
    write(program, "#!/bin/sh\ntouch \"$(dirname \"$2\")/ran\" ran\n");
    fs::permissions(path(program), fs::perms::owner_all);
    // A shell that finds a program by PATH passes on its bare name.
    const std::string command =
        "cd '" + folder_.string() + "' && bash -c 'exec -a glowworm bin/glowworm info " + scene + "' " + "> out 2> err";
    EXPECT_NE(std::system(command.c_str()), 0);
    EXPECT_FALSE(fs::exists(path("ran")));
    EXPECT_THAT(read(path("err")), HasSubstr(std::string("bin/") + program));
  }
}

TEST_F(SecurityTest, ABakeCopiesNoFilesFromOutsideOfTheScenesFolder) {
  write_scenes();
  const std::string wood = read(path("wood.png"));
  GltfFile file;
  file.add("images", {{"uri", "../wood.png"}});
  file.add("textures", {{"source", 0}});
  file.add_shown_triangle({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  write_in("room/t.bin", file.bytes);
  write_in("room/textured.gltf", file.text("t.bin"));
  write_in("room/unused.gltf", [&] {
    GltfFile other = file;
    other.json["materials"][0].clear();
    return other.text("t.bin");
  }());
  fs::rename(path("room/t.bin"), path("t.bin"));
  write_in("room/buffer.gltf", [&] {
    GltfFile other = file;
    other.json.erase("images");
    other.json.erase("textures");
    other.json["materials"][0].clear();
    return other.text("../t.bin");
  }());
  fs::create_symlink("../t.bin", path("room/t.bin"));
  for (const char* scene : {"room/textured.gltf", "room/buffer.gltf", "room/unused.gltf"}) {
    EXPECT_TRUE(refused(bake(scene), {"outside its folder", "--allow-outside"})) << scene;
    EXPECT_FALSE(fs::exists(path("lit.glb")));
  }
  EXPECT_EQ(bake("room/textured.gltf", {"--allow-outside", "--format", "lightmap"}).status, 0);
  EXPECT_THAT(read(path("lit.glb")), HasSubstr(wood));
  // Pictures stay names, whether the scene shows them or not.
  fs::remove(path("room/t.bin"));
  fs::copy_file(path("t.bin"), path("room/t.bin"));
  for (const char* scene : {"room/textured.gltf", "room/unused.gltf"}) {
    const Outcome outcome = bake(scene, {"--format", "lightmap"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(
        outcome.err.find("does not copy them: 'room/../wood.png'. If you trust the scene, give --allow-outside") !=
            std::string::npos,
        scene == std::string("room/textured.gltf"))
        << outcome.err;
    EXPECT_THAT(read(path("lit.glb")), testing::AllOf(HasSubstr(R"("uri":"wood.png")"), Not(HasSubstr(wood))));
  }
  EXPECT_EQ(bake("room/textured.gltf", {"--format", "lightmap"}).status, 0);
  EXPECT_THAT(run({"info", "lit.glb"}).out, Not(HasSubstr("cannot")));
  // Files of other formats, and their files.
  write_in("room/a.obj", "mtllib ../b.mtl\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nusemtl m\nf 1 2 3\n");
  write_in("b.mtl", "newmtl m\nKd 1 0 0\n");
  write_in("room/a.pbrt", "WorldBegin\nInclude \"../b.pbrt\"\n");
  write_in("b.pbrt", "Shape \"trianglemesh\" \"point3 P\" [-1 0 -1 -1 0 1 1 0 1] \"integer indices\" [0 1 2]\n");
  for (const char* scene : {"room/a.obj", "room/a.pbrt"})
    EXPECT_TRUE(refused(bake(scene), {"outside its folder", "--allow-outside"})) << scene;
  EXPECT_EQ(render("room/a.obj", {"-o", "a.exr"}).status, 0);
}

TEST_F(SecurityTest, NamesFromFilesDoNotCommandTheTerminal) {
  const std::string name =
      "a\x1b]0;owned\x07\xc2\x9b"
      "31m";
  write("esc.obj", "mtllib esc.mtl\no " + name + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl " + name + "\nf 1 2 3\nmtllib " +
                       name + "\n");
  write("esc.mtl", "newmtl " + name + "\nKe 1 1 1\nmap_Kd " + name + ".png\n");
  const std::string no_scene = "\x1b[31m.obj";
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"info", "esc.obj"},
           {"info", "esc.obj", "--json"},
           {"info", no_scene},
           {"render", no_scene, "-o", "a.exr"},
           {"render", "esc.obj", "-v", "--size", "4x4", "--photons", "100", "-o", "a.exr"},
           {"render", "esc.obj", "--light", name + "=1", "-o", "a.exr"}}) {
    const Outcome outcome = run(words);
    for (const std::string& text : {outcome.out, outcome.err})
      EXPECT_EQ(text.find_first_of("\x1b\x07\x9b"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace glowworm
