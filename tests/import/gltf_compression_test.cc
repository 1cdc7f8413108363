// Compressed glTF: Draco and meshopt, encoded here by their own libraries.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <meshoptimizer.h>

#include "gltf_file.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

class GltfCompressionTest : public GltfTest {
 protected:
  /// A square of two triangles in Draco's form, grey by colours at its vertices that Draco takes for plain numbers.
  static GltfFile draco_file(std::size_t bytes_kept = std::string::npos) {
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(2);
    const int attribute = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    builder.SetAttributeValuesForFace(attribute, draco::FaceIndex(0), corners[0], corners[1], corners[2]);
    builder.SetAttributeValuesForFace(attribute, draco::FaceIndex(1), corners[0], corners[2], corners[3]);
    const int colors_attribute = builder.AddAttribute(draco::GeometryAttribute::COLOR, 3, draco::DT_UINT8);
    const std::uint8_t grey[3] = {128, 128, 128};
    for (const std::uint32_t face : {0u, 1u})
      builder.SetAttributeValuesForFace(colors_attribute, draco::FaceIndex(face), grey, grey, grey);
    const auto mesh = builder.Finalize();
    draco::EncoderBuffer buffer;
    draco::Encoder encoder;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
    std::vector<char> bytes(buffer.data(), buffer.data() + buffer.size());
    if (bytes_kept < bytes.size()) bytes.resize(bytes_kept);
    GltfFile file;
    const int view = file.add_view(bytes);
    const int positions = file.add("accessors", {{"componentType", 5126}, {"type", "VEC3"}, {"count", 4}});
    const int indices = file.add("accessors", {{"componentType", 5125}, {"type", "SCALAR"}, {"count", 6}});
    const int colors =
        file.add("accessors", {{"componentType", 5121}, {"type", "VEC3"}, {"count", 4}, {"normalized", true}});
    const nlohmann::json ids = {{"POSITION", mesh->attribute(attribute)->unique_id()},
                                {"COLOR_0", mesh->attribute(colors_attribute)->unique_id()}};
    file.add("meshes",
             {{"primitives",
               {{{"attributes", {{"POSITION", positions}, {"COLOR_0", colors}}},
                 {"indices", indices},
                 {"extensions", {{"KHR_draco_mesh_compression", {{"bufferView", view}, {"attributes", ids}}}}}}}}});
    file.add("nodes", {{"mesh", 0}});
    return file;
  }

  /// A triangle whose positions and indices meshoptimizer compressed, as gltfpack writes it: a second buffer without
  /// bytes stands in for what is decoded.
  static GltfFile meshopt_file(bool damaged = false) {
    const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::vector<unsigned> indices = {0, 1, 2};
    std::vector<unsigned char> vertex_bytes(meshopt_encodeVertexBufferBound(3, 12));
    vertex_bytes.resize(meshopt_encodeVertexBuffer(vertex_bytes.data(), vertex_bytes.size(), positions.data(), 3, 12));
    std::vector<unsigned char> index_bytes(meshopt_encodeIndexBufferBound(3, 3));
    index_bytes.resize(meshopt_encodeIndexBuffer(index_bytes.data(), index_bytes.size(), indices.data(), 3));
    if (damaged) vertex_bytes[0] = 0;
    GltfFile file;
    const auto compressed = [&](const std::vector<unsigned char>& bytes, int offset, int stride, const char* mode) {
      while (file.bytes.size() % 4 != 0) file.bytes.push_back('\0');
      const std::size_t at = file.bytes.size();
      append_bytes(file.bytes, bytes);
      return file.add("bufferViews", {{"buffer", 1},
                                      {"byteOffset", offset},
                                      {"byteLength", 3 * stride},
                                      {"extensions",
                                       {{"EXT_meshopt_compression",
                                         {{"buffer", 0},
                                          {"byteOffset", at},
                                          {"byteLength", bytes.size()},
                                          {"byteStride", stride},
                                          {"count", 3},
                                          {"mode", mode}}}}}});
    };
    compressed(vertex_bytes, 0, 12, "ATTRIBUTES");
    compressed(index_bytes, 36, 4, "TRIANGLES");
    file.add("accessors", {{"bufferView", 0}, {"componentType", 5126}, {"type", "VEC3"}, {"count", 3}});
    file.add("accessors", {{"bufferView", 1}, {"componentType", 5125}, {"type", "SCALAR"}, {"count", 3}});
    file.add("meshes", {{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}});
    file.add("nodes", {{"mesh", 0}});
    file.json["buffers"] = {{{"byteLength", file.bytes.size()}},
                            {{"byteLength", 48}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
    file.json["extensionsUsed"] = {"EXT_meshopt_compression"};
    return file;
  }
};

TEST_F(GltfCompressionTest, Draco) {
  const auto d = load(draco_file());
  ASSERT_EQ(d.geometry.triangle_count(), 2u);
  EXPECT_NEAR(d.geometry.area(0) + d.geometry.area(1), 1, 1e-3);
  EXPECT_GT(d.geometry.normal(0).z, 0.999f);
  ASSERT_FALSE(d.geometry.colors.empty());
  for (const VertexColor& color : d.geometry.colors) EXPECT_NEAR(color.color.g, 128 / 255.0f, 1e-5f);
}

TEST_F(GltfCompressionTest, TheBudgetBoundsDraco) {
  ImportOptions options;
  options.budget = loading_budget(1'000'000);
  EXPECT_EQ(load_scene(write_gltf(draco_file()), options).geometry.triangle_count(), 2u);
  // Four vertices with position and colour and six indices, as they are decoded and as they are read.
  EXPECT_GE(options.budget->peaks().at("meshes"), 2 * 4 * 6 * sizeof(float) + 6 * (4 + 16));
}

TEST_F(GltfCompressionTest, DamagedDraco) {
  EXPECT_THAT(refusal(draco_file(20)), HasSubstr("meshes[0].primitives[0]: Draco cannot decode it"));
  GltfFile file = draco_file();
  file.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = 8;
  EXPECT_THAT(refusal(file), HasSubstr("names no buffer view"));
}

TEST_F(GltfCompressionTest, Meshopt) {
  const GltfFile file = meshopt_file();
  for (const std::string& path : {write_gltf(file), write("b.glb", file.glb())}) {
    const auto d = load_scene(path);
    ASSERT_EQ(d.geometry.triangle_count(), 1u);
    EXPECT_FLOAT_EQ(d.geometry.area(0), 0.5f);
    EXPECT_TRUE(d.notes.empty()) << testing::PrintToString(d.notes);
  }
}

TEST_F(GltfCompressionTest, DamagedMeshopt) {
  EXPECT_THAT(refusal(meshopt_file(true)), HasSubstr("the compressed bufferViews[0] cannot be decoded"));
  GltfFile file = meshopt_file();
  auto& extension = file.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
  extension["count"] = 1000000000;
  EXPECT_THAT(refusal(file), HasSubstr("cannot come from"));
  extension["count"] = 3;
  extension["byteLength"] = 100000;
  EXPECT_THAT(refusal(file), HasSubstr("reaches outside of its buffer"));
  extension.erase("mode");
  EXPECT_THAT(refusal(file), HasSubstr("reaches outside of its buffer"));
}

}  // namespace
}  // namespace glowworm
