// Files read by Assimp, and failures of the process that reads them.
#include <signal.h>
#include <sys/stat.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "core/input_file.h"
#include "core/parallel.h"
#include "import/assimp/import.h"
#include "import/mesh_tools.h"
#include "test_files.h"

namespace glowworm {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kTetrahedron = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

std::string collada(const std::string& libraries, const std::string& nodes) {
  return "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\" "
         "xmlns=\"http://www.collada.org/2005/11/COLLADASchema\">" +
         libraries + "<library_visual_scenes><visual_scene id=\"s\">" + nodes +
         "</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
}

class AssimpTest : public FileTest {
 protected:
  /// Loads a file that must be refused, and returns the message.
  static std::string message(const std::string& file, const ChildLimits& limits = {},
                             const ImportOptions& options = {}) {
    try {
      CoordinateOrigin origin;
      load_assimp(file, options, origin, limits);
    } catch (const Error& e) {
      return e.what();
    }
    ADD_FAILURE() << file << " was accepted";
    return "";
  }
  /// What is said where a shell script stands in the program's place.
  std::string message_of_reader(const std::string& script, const ChildLimits& limits = {}) const {
    return message(write("a.off", kTetrahedron), limits, with_reader(script));
  }
  ImportOptions with_reader(const std::string& script) const {
    ImportOptions options;
    options.assimp_program = write("reader", "#!/bin/sh\n" + script);
    std::filesystem::permissions(options.assimp_program, std::filesystem::perms::owner_all);
    return options;
  }
};

TEST_F(AssimpTest, ReadsMeshes) {
  const auto d = load_scene(write("a.OFF", kTetrahedron));
  EXPECT_EQ(d.name, "a");
  EXPECT_EQ(d.geometry.triangle_count(), 4u);
  EXPECT_EQ(d.geometry.positions.size(), 4u);
  EXPECT_EQ(d.materials.at(d.geometry.material[0]).kind, MaterialKind::diffuse);
}

TEST_F(AssimpTest, SurfacesWithoutADiffuseColourHaveTheDefaultAlbedo) {
  const char* kExchange =
      "Metric (key = \"distance\") {float {1}}\n"
      "GeometryNode $n {ObjectRef {ref {$g}} MaterialRef (index = 0) {ref {$m}}}\n"
      "GeometryObject $g {Mesh (primitive = \"triangles\") {VertexArray (attrib = \"position\") {float[3] "
      "{{0,0,0},{1,0,0},{0,1,0}}} IndexArray {unsigned_int32[3]{{0,1,2}}}}}\n"
      "Material $m {Name {string {\"m\"}}}\n";
  for (const std::string& file : {write("a.off", kTetrahedron), write("a.ogex", kExchange)}) {
    const auto d = load_scene(file);
    ASSERT_GE(d.geometry.triangle_count(), 1u) << file;
    const Material& material = d.materials.at(d.geometry.material[0]);
    EXPECT_EQ(evaluate(d.textures, material.reflectance, {0, 0}), RGB(kDefaultAlbedo)) << file;
  }
}

TEST_F(AssimpTest, ReadsMaterialsTexturesPlacesCamerasAndLights) {
  write("t.tga", tga_row({{0, 0, 255, 255}, {0, 0, 255, 255}}));
  const std::string source =
      "<source id=\"p\"><float_array id=\"pa\" count=\"9\">0 0 0 1 0 0 0 1 0</float_array><technique_common><accessor "
      "source=\"#pa\" count=\"3\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" "
      "type=\"float\"/><param "
      "name=\"Z\" type=\"float\"/></accessor></technique_common></source><source id=\"u\"><float_array id=\"ua\" "
      "count=\"6\">0 0 1 0 0 1</float_array><technique_common><accessor source=\"#ua\" count=\"3\" stride=\"2\"><param "
      "name=\"S\" type=\"float\"/><param name=\"T\" type=\"float\"/></accessor></technique_common></source>";
  const std::string libraries =
      "<asset><up_axis>Y_UP</up_axis></asset>"
      "<library_cameras><camera id=\"c\"><optics><technique_common><perspective><xfov>90</xfov><aspect_ratio>1"
      "</aspect_ratio><znear>1</znear><zfar>9</zfar></perspective></technique_common></optics></camera></"
      "library_cameras>"
      "<library_lights><light id=\"l\"><technique_common><point><color>1 2 3</color></point></technique_common></light>"
      "</library_lights><library_images><image id=\"i\"><init_from>t.tga</init_from></image></library_images>"
      "<library_effects><effect id=\"e\"><profile_COMMON><newparam sid=\"f\"><surface "
      "type=\"2D\"><init_from>i</init_from>"
      "</surface></newparam><newparam sid=\"g\"><sampler2D><source>f</source></sampler2D></newparam><technique "
      "sid=\"x\"><lambert><diffuse><texture texture=\"g\" texcoord=\"UV\"/></diffuse></lambert></technique>"
      "</profile_COMMON></effect></library_effects><library_materials><material id=\"m\" name=\"red\"><instance_effect "
      "url=\"#e\"/></material></library_materials><library_geometries><geometry id=\"t\"><mesh>" +
      source +
      "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles count=\"1\" "
      "material=\"k\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><input semantic=\"TEXCOORD\" "
      "source=\"#u\" offset=\"0\"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>";
  const std::string nodes =
      "<node name=\"a\"><translate>0 0 5</translate><instance_geometry url=\"#t\"><bind_material><technique_common>"
      "<instance_material symbol=\"k\" target=\"#m\"/></technique_common></bind_material></instance_geometry></node>"
      "<node name=\"b\"><translate>0 0 9</translate><instance_camera url=\"#c\"/></node>"
      "<node name=\"d\"><translate>7 0 0</translate><instance_light url=\"#l\"/></node>";
  const auto d = load_scene(write("a.dae", collada(libraries, nodes)));
  ASSERT_EQ(d.geometry.triangle_count(), 1u);
  for (const Vec3& p : d.geometry.positions) EXPECT_EQ(p.z, 5);
  const Material& material = d.materials.at(d.geometry.material[0]);
  EXPECT_EQ(material.name, "red");
  EXPECT_EQ(evaluate(d.textures, material.reflectance, {0.5f, 0.5f}), RGB(1, 0, 0)) << "the texture alone";
  ASSERT_EQ(d.cameras.size(), 1u);
  EXPECT_EQ(d.cameras[0].to_world.translation.z, 9);
  ASSERT_EQ(d.lights.size(), 1u);
  EXPECT_EQ(d.lights[0].kind, LightKind::point);
  EXPECT_EQ(d.lights[0].position.x, 7);
  EXPECT_EQ(d.lights[0].intensity, RGB(1, 2, 3));
}

TEST_F(AssimpTest, NodesThatShareAMeshAreInstances) {
  std::string positions, corners;
  for (int i = 0; i < 60; ++i) {
    positions += std::to_string(i % 7) + " " + std::to_string(i / 7) + " " + std::to_string(i * i % 5) + " ";
    if (i % 3 == 2) corners += std::to_string(i - 2) + " " + std::to_string(i - 1) + " " + std::to_string(i) + " ";
  }
  const std::string libraries =
      "<library_geometries><geometry id=\"t\"><mesh><source id=\"p\"><float_array id=\"f\" count=\"180\">" + positions +
      "</float_array><technique_common><accessor source=\"#f\" count=\"60\" stride=\"3\"><param name=\"X\" "
      "type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor>"
      "</technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>"
      "<triangles count=\"20\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>" +
      corners + "</p></triangles></mesh></geometry></library_geometries>";
  std::string nodes;
  for (int i = 0; i < 4; ++i)
    nodes += "<node name=\"n" + std::to_string(i) + "\"><translate>0 0 " + std::to_string(10 * i) +
             "</translate><instance_geometry url=\"#t\"/></node>";
  const Geometry g = load_scene(write("a.dae", collada(libraries, nodes))).geometry;
  ASSERT_EQ(g.instances.size(), 3u);
  const auto each = static_cast<std::uint32_t>(g.triangles.size());
  ASSERT_EQ(g.triangle_count(), 4 * each);
  for (std::uint32_t t = 0; t < each; ++t)
    for (std::uint32_t i = 1; i < 4; ++i) {
      const float shift = 10 * static_cast<float>(i);
      EXPECT_NEAR(g.corners(i * each + t)[0].z, g.corners(t)[0].z + shift, 1e-5f);
      EXPECT_EQ(g.corners(i * each + t)[2].x, g.corners(t)[2].x);
    }
}

TEST_F(AssimpTest, ReportsAssimpsMessageForBadFiles) {
  EXPECT_THAT(message_of(write("b.dae", "<COLLADA")), HasSubstr("b.dae: cannot be read: "));
  EXPECT_THAT(message_of(write("b.fbx", "")), HasSubstr("b.fbx: cannot be read: "));
}

TEST_F(AssimpTest, ReadsNoFormatsThatItDoesNotReadWell) {
  for (const char* name : {"a.md2", "a.mdl", "a.md5mesh", "a.iqm", "a.smd", "a.ndo", "a.csm", "a.raw"})
    EXPECT_THAT(message_of(write(name, "x")), HasSubstr("are not supported"));
}

TEST_F(AssimpTest, CrashesBecomeErrors) {
  // Assimp 5.2 does not look whether an OFF file ends among its vertices.
  const std::string cut = write("cut.off", "OFF\n8 6 0\n-0.5 -0.5 0\n0.5 0.5 0.5\n");
  EXPECT_THAT(message_of(cut),
              AllOf(HasSubstr("cut.off: Assimp, which reads files of type '.off', crashed"), HasSubstr("(SIGABRT)")));
  // It goes through nodes by recursion.
  std::string open, close;
  for (int i = 0; i < 100'000; ++i) {
    open += "<node>";
    close += "</node>";
  }
  EXPECT_THAT(message_of(write("deep.dae", collada("", open + close))), HasSubstr("deep.dae: Assimp, which reads"));
  EXPECT_EQ(load_scene(write("good.off", kTetrahedron)).geometry.triangle_count(), 4u);
}

TEST_F(AssimpTest, MemoryIsLimited) {
  std::string nodes = "<library_nodes><node id=\"n0\"/>";
  for (int i = 1; i < 30; ++i) {
    const std::string before = "<instance_node url=\"#n" + std::to_string(i - 1) + "\"/>";
    nodes += "<node id=\"n" + std::to_string(i) + "\">" + before + before + "</node>";
  }
  ChildLimits limits;
  limits.memory_bytes = 300'000'000;
  EXPECT_THAT(
      message(write("laughs.dae", collada(nodes + "</library_nodes>",
                                          "<instance_node url=\"#n29\"/>"
                                          "<node><instance_node "
                                          "url=\"#n29\"/></node>")),
              limits),
      HasSubstr("laughs.dae: Assimp, which reads files of type '.dae', needs more memory for this file than the "
                "300 MB"));
}

TEST_F(AssimpTest, TheBudgetBoundsProcessAndScene) {
  const std::string file = write("a.off", kTetrahedron);
  ImportOptions endless = with_reader("exec cat /dev/zero >&3\n"), options;
  endless.budget = loading_budget(10'000'000);
  EXPECT_THAT(message(file, {}, endless), HasSubstr("hands over more than 10 MB"));
  options.budget = loading_budget(1'000);
  ChildLimits limits;
  limits.memory_bytes = 1'000'000'000;
  EXPECT_THAT(message(file, limits, options), HasSubstr("the memory budget"));
}

TEST_F(AssimpTest, TheProcessGetsMemoryByTheSizeOfTheFile) {
  ImportOptions options = with_reader("printf 'limit %s' \"$2\" >&3; exit 1\n");
  const std::string file = write("a.off", kTetrahedron);
  options.budget = loading_budget(std::uint64_t{1} << 40);
  const std::uint64_t most = std::uint64_t{1} << 31;  // the file has a few bytes
  const auto limit = [&] {
    const std::string text = message(file, {}, options);
    return std::stoull(text.substr(text.find("limit ") + 6));
  };
  EXPECT_LT(limit(), most);
  options.budget = loading_budget(100'000'000);
  EXPECT_EQ(limit(), 100'000'000u);
}

TEST_F(AssimpTest, FilesThatItReadAreRecorded) {
  const InputRecord record;
  const std::string file = write("a.off", kTetrahedron);
  load_scene(file);
  EXPECT_TRUE(record.names().contains(file));
}

TEST_F(AssimpTest, ProcessorTimeIsLimited) {
  constexpr int kCorners = 60'000;  // its triangulation takes time in proportion to the square of these
  std::string places, corners;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * M_PI * i / kCorners, radius = i % 2 ? 500 : 1000;
    places += std::to_string(radius * std::cos(angle)) + " " + std::to_string(radius * std::sin(angle)) + " 0 ";
    corners += std::to_string(i) + " ";
  }
  const std::string count = std::to_string(kCorners);
  const std::string geometry =
      "<library_geometries><geometry id=\"t\"><mesh><source id=\"p\"><float_array id=\"pa\" count=\"" +
      std::to_string(3 * kCorners) + "\">" + places +
      "</float_array><technique_common><accessor source=\"#pa\" count=\"" + count +
      "\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" "
      "type=\"float\"/></accessor></technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" "
      "source=\"#p\"/></vertices><polylist count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>"
      "<vcount>" +
      count + "</vcount><p>" + corners + "</p></polylist></mesh></geometry></library_geometries>";
  ChildLimits limits;
  limits.cpu_seconds = 1;
  limits.clock_seconds = 300;
  EXPECT_THAT(message(write("star.dae", collada(geometry, "<node><instance_geometry url=\"#t\"/></node>")), limits),
              HasSubstr("stopped after 1 s of processor time"));
}

TEST_F(AssimpTest, WallTimeIsLimited) {
  ChildLimits limits;
  limits.clock_seconds = 1;
  EXPECT_THAT(message_of_reader("exec sleep 1000\n", limits), HasSubstr("did not end within 1 s"));
}

TEST_F(AssimpTest, OutputOfTheReaderIsChecked) {
  EXPECT_THAT(message_of_reader("echo nonsense >&3\n"), HasSubstr("a.off: Assimp's output is invalid"));
  EXPECT_THAT(message_of_reader("exit 0\n"), HasSubstr("it ends too early"));
  EXPECT_THAT(message_of_reader("echo 'this is why' >&3; exit 1\n"), HasSubstr("cannot be read: this is why"));
  EXPECT_THAT(message_of_reader("exit 77\n"), HasSubstr("could not be run (status 77"));
  ChildLimits limits;
  limits.memory_bytes = 10'000'000;
  EXPECT_THAT(message_of_reader("exec cat /dev/zero >&3\n", limits), HasSubstr("hands over more than 10 MB"));
  ImportOptions options;
  options.assimp_program = path("nowhere");
  EXPECT_THAT(message(write("a.off", kTetrahedron), {}, options), HasSubstr("nowhere cannot be started"));
}

TEST_F(AssimpTest, PipesNamedInAFileAreNotOpened) {
  ASSERT_EQ(mkfifo(path("pipe.lwo").c_str(), 0600), 0);
  ChildLimits limits;
  limits.clock_seconds = 60;
  EXPECT_THAT(message(write("a.lws", "LWSC\n3\n\nLoadObjectLayer 1 pipe.lwo\nShowObject 7 1\n"), limits),
              Not(HasSubstr("did not end")));
}

TEST_F(AssimpTest, IsCancelledWithItsProcess) {
  const ImportOptions options = with_reader("echo $$ > " + path("id") + "\nexec sleep 1000\n");
  const std::string file = write("a.off", kTetrahedron);
  Interrupt interrupt;
  std::thread canceller([&] {
    while (!std::filesystem::exists(path("id")) || std::filesystem::file_size(path("id")) == 0)
      std::this_thread::yield();
    interrupt.request();
  });
  {
    const CancellationScope scope(interrupt);
    CoordinateOrigin origin;
    EXPECT_THROW(load_assimp(file, options, origin), Cancelled);
  }
  canceller.join();
  pid_t id = 0;
  std::ifstream(path("id")) >> id;
  ASSERT_GT(id, 0);
  EXPECT_NE(kill(id, 0), 0);
}

}  // namespace
}  // namespace glowworm
