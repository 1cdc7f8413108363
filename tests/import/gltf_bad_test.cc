// Damaged or hostile glTF files: each is rejected with a message that names the place.
#include "gltf_file.h"
#include "import/gltf/check.h"

namespace glowworm {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

class GltfBadTest : public GltfTest {
 protected:
  GltfBadTest() { good_.add_shown_triangle(json::object()); }
  /// The good file after a change, which must be refused.
  template <typename Change>
  std::string after(const Change& change) const {
    GltfFile file = good_;
    file.json["buffers"] = {{{"byteLength", file.bytes.size()}}};
    change(file.json);
    return refusal(file);
  }
  GltfFile good_;
};

TEST_F(GltfBadTest, TheUnchangedFileIsValid) { EXPECT_EQ(load(good_).geometry.triangle_count(), 1u); }

TEST_F(GltfBadTest, TruncatedBinaryFiles) {
  const std::string glb = good_.glb();
  EXPECT_THAT(message_of(write("t.glb", glb.substr(0, glb.size() - 5))),
              AllOf(HasSubstr("t.glb: is truncated"), HasSubstr("incomplete")));
  EXPECT_THAT(message_of(write("t.glb", glb.substr(0, 7))), HasSubstr("ends within the GLB header"));
  EXPECT_THAT(message_of(write("t.glb", "")), HasSubstr("is empty"));
  // Every other length: an error each time, never a crash.
  for (std::size_t n = 0; n < glb.size(); n += 3) EXPECT_NE(message_of(write("t.glb", glb.substr(0, n))), "");
}

TEST_F(GltfBadTest, DamagedBytesNeverCrash) {
  const std::string glb = good_.glb();
  std::uint32_t state = 1;
  for (int i = 0; i < 400; ++i) {
    std::string damaged = glb;
    for (int k = 0; k < 4; ++k) {
      state = state * 1664525u + 1013904223u;
      damaged[(state >> 8) % damaged.size()] = static_cast<char>(state >> 3);
    }
    try {
      load_scene(write("d.glb", damaged));
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("d.glb"));
    }
  }
}

TEST_F(GltfBadTest, InvalidJson) {
  EXPECT_THAT(message_of(write("a.gltf", "{\"asset\": ")), HasSubstr("a.gltf: is not valid JSON"));
  EXPECT_THAT(message_of(write("a.gltf", "[]")), HasSubstr("is not an object"));
  EXPECT_THAT(message_of(write("a.gltf", "{}")), HasSubstr("no asset.version"));
  EXPECT_THAT(message_of(write("a.gltf", "{\"asset\": {\"version\": \"1.0\"}}")), HasSubstr("not 2.0"));
  EXPECT_THAT(message_of(write("a.gltf", std::string(100000, '['))), HasSubstr("nested more than"));
  EXPECT_THAT(message_of(write("a.gltf", "{\"asset\": {\"version\": \"2.0\"}}")), HasSubstr("no triangles"));
}

TEST_F(GltfBadTest, Buffers) {
  EXPECT_THAT(message_of(write("a.gltf", good_.text("gone.bin"))), HasSubstr("buffers[0]: no such file 'gone.bin'"));
  write("short.bin", good_.bytes.substr(0, 20));
  EXPECT_THAT(message_of(write("a.gltf", good_.text("short.bin"))),
              AllOf(HasSubstr("buffers[0] has 60 bytes"), HasSubstr("holds 20")));
  EXPECT_THAT(message_of(write("a.gltf", good_.text("data:;base64,****"))), HasSubstr("holds 0"));
}

TEST_F(GltfBadTest, RangesOutsideTheirContainer) {
  EXPECT_THAT(after([](json& j) { j["bufferViews"][0]["byteLength"] = 1000; }),
              HasSubstr("bufferViews[0] reaches to byte 1000 of buffers[0], which has 60"));
  EXPECT_THAT(after([](json& j) { j["bufferViews"][0]["byteOffset"] = 4611686018427387904u; }),
              HasSubstr("bufferViews[0].byteOffset"));
  EXPECT_THAT(after([](json& j) { j["bufferViews"][0]["byteOffset"] = -4; }), HasSubstr("not negative"));
  EXPECT_THAT(after([](json& j) { j["bufferViews"][0]["buffer"] = 7; }), HasSubstr("but there are 1 buffers"));
  EXPECT_THAT(after([](json& j) { j["bufferViews"][0]["byteStride"] = 3; }), HasSubstr("byteStride is 3"));
  EXPECT_THAT(after([](json& j) { j["accessors"][0]["count"] = 4; }), HasSubstr("accessors[0] reaches to byte 48"));
  EXPECT_THAT(after([](json& j) { j["accessors"][0]["count"] = 1000000000; }), HasSubstr("accessors[0] reaches"));
  EXPECT_THAT(after([](json& j) { j["accessors"][0]["byteOffset"] = 4; }), HasSubstr("accessors[0] reaches"));
  EXPECT_THAT(after([](json& j) { j["accessors"][0]["componentType"] = 99; }), HasSubstr("componentType is 99"));
  EXPECT_THAT(after([](json& j) { j["accessors"][0]["type"] = "VEC9"; }), HasSubstr("accessors[0].type"));
  EXPECT_THAT(after([](json& j) { j["accessors"][0]["bufferView"] = 9; }), HasSubstr("there are 2 bufferViews"));
}

TEST_F(GltfBadTest, UnsuitableAccessors) {
  EXPECT_THAT(after([](json& j) { j["accessors"][0]["type"] = "VEC2"; }), HasSubstr("has 2 components; expected 3"));
  EXPECT_THAT(after([](json& j) { j["accessors"][1]["count"] = 2; }),
              HasSubstr("TEXCOORD_0 has 2 elements, POSITION has 3"));
  EXPECT_THAT(after([](json& j) { j["accessors"][0].erase("bufferView"); }), HasSubstr("accessors[0] has no data"));
  EXPECT_THAT(after([](json& j) { j["meshes"][0]["primitives"][0]["indices"] = 0; }),
              HasSubstr("cannot serve as indices"));
  EXPECT_THAT(after([](json& j) { j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 5; }),
              HasSubstr("meshes[0].primitives[0].attributes.POSITION is 5"));
  EXPECT_THAT(after([](json& j) {
                j["accessors"][0].erase("bufferView");
                j["accessors"][0]["count"] = 1000000000;
                j["accessors"][0]["sparse"] = {{"count", 1},
                                               {"indices", {{"bufferView", 0}, {"componentType", 5125}}},
                                               {"values", {{"bufferView", 0}}}};
              }),
              HasSubstr("no buffer holds so many"));
}

TEST_F(GltfBadTest, IndicesOutOfRange) {
  GltfFile file;
  const int indices = file.add_accessor<std::uint16_t>({0, 1, 300}, 5123, "SCALAR", 3);
  file.add("nodes", {{"mesh", file.add_triangle({{"indices", indices}})}});
  EXPECT_THAT(refusal(file), HasSubstr("meshes[0].primitives[0]: index 300 at place 2 is out of range"));
}

TEST_F(GltfBadTest, DanglingReferences) {
  EXPECT_THAT(after([](json& j) { j["nodes"][0]["mesh"] = 3; }), HasSubstr("nodes[0].mesh is 3"));
  EXPECT_THAT(after([](json& j) { j["nodes"][0]["children"] = {0}; }), HasSubstr("no triangles"));
  EXPECT_THAT(after([](json& j) {
                j["nodes"][0]["children"] = {0};
                j["scenes"] = {{{"nodes", {0}}}};
              }),
              HasSubstr("nodes[0] is a child of"));
  EXPECT_THAT(after([](json& j) { j["nodes"][0]["children"] = {8}; }), HasSubstr("nodes[0].children[0] is 8"));
  EXPECT_THAT(after([](json& j) { j["nodes"][0]["rotation"] = {1, 0}; }), HasSubstr("nodes[0].rotation"));
  EXPECT_THAT(after([](json& j) { j["scene"] = 2; }), HasSubstr("scene is 2"));
  EXPECT_THAT(after([](json& j) { j["meshes"][0]["primitives"][0]["material"] = 4; }), HasSubstr("material is 4"));
  EXPECT_THAT(after([](json& j) { j["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 1; }),
              HasSubstr("names light 1"));
}

TEST_F(GltfBadTest, NonFiniteVerticesAreLeftOut) {
  GltfFile file = good_;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const int positions = file.add_accessor<float>({nan, 0, 0, 1, 0, 0, 0, 1, 0}, 5126, "VEC3", 3);
  const int flat = file.add_accessor<float>({0, 0, 0, 1, 0, 0, 2, 0, 0}, 5126, "VEC3", 3);
  file.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", positions}}}});
  file.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", flat}}}});
  const auto d = load(file);
  EXPECT_EQ(d.geometry.triangle_count(), 1u);
  EXPECT_THAT(d.notes, HasNote("not finite, left out"));
  EXPECT_THAT(d.notes, HasNote("without area, left out"));
}

TEST_F(GltfBadTest, InstancesAreWithinTheBudget) {
  // A million instances of two triangles, whose places are all zero but the first, in less than a kilobyte.
  GltfFile file;
  const int indices = file.add_view(std::vector<std::uint16_t>{0, 0}),
            values = file.add_view(std::vector<float>{1, 2, 3});
  file.add("accessors", {{"componentType", 5126},
                         {"type", "VEC3"},
                         {"count", 1000000},
                         {"sparse",
                          {{"count", 1},
                           {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                           {"values", {{"bufferView", values}}}}}});
  const json instancing = {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", 0}}}}}};
  file.add("nodes", {{"mesh", file.add_triangle()}, {"extensions", instancing}});
  EXPECT_LT(file.glb().size(), 1600u);
  ImportOptions options;
  options.budget = loading_budget(std::uint64_t{64} << 20);
  const std::string path = write("a.glb", file.glb());
  const auto refusal_of = [&] {
    try {
      load_scene(path, options);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal_of(), AllOf(HasSubstr("a.glb: the memory budget of 67.1 MB has no room for"),
                                  HasSubstr("of triangles of instances (held: "), HasSubstr("--memory")));
  EXPECT_EQ(options.budget->available(), options.budget->limit()) << "all is given back";
}

TEST_F(GltfBadTest, JsonIsWithinTheBudget) {
  // Five values and a name; an empty object counts twice.
  EXPECT_EQ(check_json_depth(R"({"a,[:": [1, "\",", {}]})", ""), 7u);
  GltfFile file = good_;
  file.json["extras"] = std::vector<int>(100'000);
  const std::string path = write_gltf(file);
  ImportOptions options;
  options.budget = loading_budget(64 << 20);
  EXPECT_EQ(load_scene(path, options).geometry.triangle_count(), 1u);
  EXPECT_EQ(options.budget->available(), options.budget->limit()) << "all is given back";
  options.budget = loading_budget(8 << 20);
  try {
    load_scene(path, options);
    FAIL() << "10 MB of JSON in 8 MB";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("of JSON (held: "));
  }
}

TEST_F(GltfBadTest, MeshesOfManyPrimitivesAreWithinTheBudget) {
  // Each primitive names the same accessor of a million positions that no buffer holds.
  GltfFile file;
  const int indices = file.add_view(std::vector<std::uint16_t>{0, 0}),
            values = file.add_view(std::vector<float>{1, 2, 3});
  const int zeros = file.add("accessors", {{"componentType", 5126},
                                           {"type", "VEC3"},
                                           {"count", 1000000},
                                           {"sparse",
                                            {{"count", 1},
                                             {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                                             {"values", {{"bufferView", values}}}}}});
  json primitives = json::array();
  for (int i = 0; i < 50; ++i) primitives.push_back({{"attributes", {{"POSITION", zeros}}}});
  file.add("nodes", {{"mesh", file.add("meshes", {{"primitives", primitives}})}});
  ImportOptions options;
  options.budget = loading_budget(std::uint64_t{256} << 20);
  EXPECT_THROW(
      {
        try {
          load_scene(write("a.glb", file.glb()), options);
        } catch (const Error& error) {
          EXPECT_THAT(error.what(), AllOf(HasSubstr("has no room for"), HasSubstr("meshes 72.0 MB")));
          throw;
        }
      },
      Error);
}

TEST_F(GltfBadTest, VerticesThatAreTooFarOutAreNamed) {
  GltfFile file;
  const int far = file.add_accessor<float>({0, 0, 0, 1, 0, 0, 0, 2e12f, 0}, 5126, "VEC3", 3);
  file.add("nodes", {{"mesh", file.add("meshes", {{"primitives", {{{"attributes", {{"POSITION", far}}}}}}})}});
  EXPECT_THAT(refusal(file), AllOf(HasSubstr("a.gltf: meshes[0].primitives[0]: vertex 2 is at (0, 2e+12, 0)"),
                                   HasSubstr("may reach to 1e+12 m only"), HasSubstr("Scale the scene down")));
}

TEST_F(GltfBadTest, TexturesThatCannotBeReadAreMagenta) {
  write("broken.png", "\x89PNG\r\n\x1a\n but no more");
  for (const json& image : {json{{"uri", "gone.png"}}, json{{"uri", "broken.png"}},
                            json{{"uri", "data:image/png;base64,AAAA"}}, json{{"bufferView", 0}}}) {
    GltfFile file;
    file.add("textures", {{"source", 0}});
    file.add("images", image);
    file.add_shown_triangle({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    const auto d = load(file);
    EXPECT_EQ(evaluate(d.textures, d.materials[0].reflectance, {0.5f, 0.5f}), RGB(1, 0, 1)) << image;
    EXPECT_THAT(d.notes, HasNote("is magenta")) << image;
  }
  const auto d = with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 3}}}}}});
  EXPECT_THAT(d.notes, HasNote("no such texture"));
}

TEST_F(GltfBadTest, MissingDataTexturesChangeNothing) {
  GltfFile file;
  file.add("textures", {{"source", 0}});
  file.add("images", {{"uri", "gone.ktx2"}});
  const json map = {{"index", 0}};
  file.add_shown_triangle({{"pbrMetallicRoughness",
                            {{"baseColorFactor", {0.5, 0.5, 0.5, 1}},
                             {"metallicFactor", 0.75},
                             {"roughnessFactor", 0.5},
                             {"metallicRoughnessTexture", map}}},
                           {"normalTexture", map},
                           {"emissiveTexture", map},
                           {"emissiveFactor", {1, 1, 1}},
                           {"extensions",
                            {{"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularTexture", map}}},
                             {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}, {"anisotropyTexture", map}}},
                             {"KHR_materials_clearcoat", {{"clearcoatNormalTexture", map}}}}}});
  const auto d = load(file);
  const Material& m = d.materials.at(0);
  const Vec2 at{0.5f, 0.5f};
  EXPECT_EQ(evaluate(d.textures, m.metallic, at), 0.75f);
  EXPECT_EQ(evaluate(d.textures, m.roughness_u, at), 0.25f);
  EXPECT_EQ(evaluate(d.textures, m.specular, at), 0.5f);
  EXPECT_EQ(evaluate(d.textures, m.anisotropy, at), 0.5f);
  EXPECT_EQ(evaluate(d.textures, m.anisotropy_direction, at), RGB(1, 0.5f, 1));
  EXPECT_EQ(evaluate(d.textures, m.normal_map, at), RGB(0.5f, 0.5f, 1));
  EXPECT_EQ(evaluate(d.textures, m.coat_normal_map, at), RGB(0.5f, 0.5f, 1));
  EXPECT_EQ(evaluate(d.textures, d.emissions.at(0).radiance, at), RGB(0.0f));
  EXPECT_THAT(d.notes, HasNote("gone.ktx2' is left out: "));
  EXPECT_THAT(d.notes, testing::Not(HasNote("magenta")));
}

/// Images inside of files need no room on a disk, and leave none of it taken.
TEST_F(GltfTest, TexturesInsideOfFilesNeedNoTemporaryFolder) {
  GltfFile file;
  // A BMP of one red pixel.
  std::string bmp("BM\x3a\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x01\0\0\0\x01\0\0\0\x01\0\x18\0", 30);
  bmp.resize(54);
  bmp += std::string("\0\0\xff\0", 4);
  const int view = file.add_view(std::vector<char>(bmp.begin(), bmp.end()));
  file.add("textures", {{"source", 0}});
  file.add("images", {{"bufferView", view}, {"mimeType", "image/bmp"}});
  file.add_shown_triangle({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  const std::string glb = write("a.glb", file.glb());
  const char* before = std::getenv("TMPDIR");
  const std::string kept = before ? before : "";
  setenv("TMPDIR", path("nowhere").c_str(), 1);
  for (const bool lazy : {false, true}) {
    ImportOptions options;
    options.lazy_textures = lazy;
    const auto d = load_scene(glb, options);
    EXPECT_EQ(evaluate(d.textures, d.materials[0].reflectance, {0.5f, 0.5f}), RGB(1, 0, 0));
    EXPECT_TRUE(d.notes.empty()) << testing::PrintToString(d.notes);
  }
  before ? setenv("TMPDIR", kept.c_str(), 1) : unsetenv("TMPDIR");
}

TEST_F(GltfTest, FilesThatRequireAnUnknownExtensionAreRefused) {
  GltfFile file;
  file.add_shown_triangle(nlohmann::json::object());
  file.json["extensionsUsed"] = {"MADE_UP_extension"};
  EXPECT_THAT(load(file).notes, HasNote("extension MADE_UP_extension is not supported"));
  file.json["extensionsRequired"] = {"KHR_texture_transform", "MADE_UP_extension"};
  EXPECT_THAT(refusal(file), testing::HasSubstr("requires the extension MADE_UP_extension"));
}

}  // namespace
}  // namespace glowworm
