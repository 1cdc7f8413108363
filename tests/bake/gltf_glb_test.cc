// Bakes of glTF files: everything but light comes out as it was.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "bake/bands.h"
#include "bake/layout.h"
#include "bake/light.h"
#include "bake_testing.h"
#include "core/random.h"
#include "gltf_writer/scene_glb.h"
#include "image/image.h"
#include "import/gltf/accessor.h"
#include "import/gltf/document.h"
#include "import/gltf/mesh.h"
#include "import/gltf/parts.h"
#include "import/gltf_file.h"

namespace glowworm {
namespace {

using nlohmann::json;

/// Normals in three bytes each, and one to fill four.
std::vector<std::int8_t> short_normals(const std::vector<Vec3>& normals) {
  std::vector<std::int8_t> out;
  for (const Vec3& n : normals) {
    for (int c = 0; c < 3; ++c) out.push_back(static_cast<std::int8_t>(std::lround(n[c] * 127)));
    out.push_back(0);
  }
  return out;
}

/// A sphere with smooth normals, joints, weights, and a morph target of which few elements are not zero.
json sphere_primitive(GltfFile& file) {
  const Geometry mesh = sphere_mesh(12, 6);
  const std::size_t count = mesh.positions.size();
  std::vector<float> positions, uvs;
  for (const Vec3& p : mesh.positions) positions.insert(positions.end(), {p.x, p.y, p.z});
  for (const Vec2& uv : mesh.uvs) uvs.insert(uvs.end(), {uv.x, uv.y});
  std::vector<std::uint16_t> indices;
  for (const auto& triangle : mesh.triangles) indices.insert(indices.end(), triangle.begin(), triangle.end());
  std::vector<std::uint8_t> joints(4 * count);
  std::vector<float> weights(4 * count);
  for (std::size_t i = 0; i < count; ++i) {
    joints[4 * i] = i % 2;
    weights[4 * i] = 1;
  }
  json positions_accessor = {{"bufferView", file.add_view(positions)},
                             {"componentType", 5126},
                             {"type", "VEC3"},
                             {"count", count},
                             {"min", {-1, -1, -1}},
                             {"max", {1, 1, 1}},
                             {"name", "places"}};
  const json attributes = {
      {"POSITION", file.add("accessors", positions_accessor)},
      {"NORMAL", file.add("accessors", {{"bufferView", file.add_view(short_normals(mesh.normals), 4)},
                                        {"componentType", 5120},
                                        {"normalized", true},
                                        {"type", "VEC3"},
                                        {"count", count}})},
      {"TEXCOORD_0", file.add_accessor(uvs, 5126, "VEC2", count)},
      {"JOINTS_0", file.add_accessor(joints, 5121, "VEC4", count)},
      {"WEIGHTS_0", file.add_accessor(weights, 5126, "VEC4", count)}};
  const int which = file.add_view(std::vector<std::uint16_t>{3, 40});
  const int moved = file.add_view(std::vector<float>{0, 0.5f, 0, 0, 0.25f, 0});
  const int target = file.add("accessors", {{"componentType", 5126},
                                            {"type", "VEC3"},
                                            {"count", count},
                                            {"min", {0, 0, 0}},
                                            {"max", {0, 0.5, 0}},
                                            {"sparse",
                                             {{"count", 2},
                                              {"indices", {{"bufferView", which}, {"componentType", 5123}}},
                                              {"values", {{"bufferView", moved}}}}}});
  return {{"attributes", attributes},
          {"indices", file.add_accessor(indices, 5123, "SCALAR", indices.size())},
          {"targets", {{{"POSITION", target}}}}};
}

/// A floor below the sphere, seen from both sides; its second corner is its last triangle's first and second one.
json floor_primitive(GltfFile& file) {
  const std::vector<float> corners{-3, -1.5f, -3, -3, -1.5f, 3, 3, -1.5f, -3, 3, -1.5f, 3};
  return {{"attributes", {{"POSITION", file.add_accessor(corners, 5126, "VEC3", 4)}}},
          {"indices", file.add_accessor(std::vector<std::uint16_t>{0, 1, 2, 1, 3, 2, 1, 1, 3}, 5123, "SCALAR", 9)}};
}

/// A lamp above it.
void add_lamp(GltfFile& file) {
  const std::vector<float> corners{-1, 3, -1, 1, 3, -1, 1, 3, 1};
  const int positions = file.add_accessor(corners, 5126, "VEC3", 3);
  const json dark = {{"baseColorFactor", {0.2, 0.2, 0.2, 1}}};
  const int glow = file.add(
      "materials",
      {{"name", "lamp"}, {"emissiveFactor", {1, 1, 1}}, {"pbrMetallicRoughness", dark}, {"doubleSided", true}});
  const json primitive = {{"attributes", {{"POSITION", positions}}}, {"material", glow}};
  file.add("nodes", {{"mesh", file.add("meshes", {{"primitives", {primitive}}})}});
}

/// A file as bytes, and its parts.
struct Parsed {
  json whole;
  GltfDocument document;

  explicit Parsed(const std::string& path) : document(read_gltf_document(path, {}, &whole)) {}
};

class BakedGltf : public GltfTest {
 protected:
  /// A posed, animated sphere with a morph target on a floor, and things that Glowworm does not know.
  static GltfFile animated_file() {
    GltfFile file;
    json sphere = sphere_primitive(file);
    sphere["material"] = file.add("materials", {{"name", "paint"},
                                                {"extras", {{"price", 3}}},
                                                {"extensions", {{"VENDOR_rust", {{"grade", 0.25}}}}},
                                                {"pbrMetallicRoughness", {{"baseColorFactor", {0.8, 0.4, 0.2, 1}}}}});
    sphere["extras"] = {"primitive", 1};
    const int mesh = file.add(
        "meshes",
        {{"name", "ball"}, {"weights", {0.5}}, {"primitives", {sphere}}, {"extras", {{"targetNames", {"bump"}}}}});
    json floor = floor_primitive(file);
    floor["material"] = file.add("materials", {{"name", "floor"}, {"doubleSided", true}});
    const int floor_mesh = file.add("meshes", {{"primitives", {floor}}});
    file.json["nodes"] = {{{"name", "body"}, {"mesh", mesh}, {"skin", 0}, {"extras", "a node"}},
                          {{"name", "joint"}, {"children", {2}}, {"extensions", {{"VENDOR_physics", {{"mass", 2}}}}}},
                          {{"name", "tip"}, {"translation", {0, 0.125, 0}}},
                          {{"mesh", floor_mesh}},
                          {{"name", "eye"}, {"camera", 0}, {"translation", {0, 0, 8}}}};
    file.json["skins"] = {{{"joints", {1, 2}}, {"name", "bones"}}};
    file.json["cameras"] = {
        {{"type", "perspective"}, {"name", "wide"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}}};
    const int times = file.add_accessor<float>({0, 1}, 5126, "SCALAR", 2);
    const int turns = file.add_accessor<float>({0, 0, 0, 1, 0, 1, 0, 0}, 5126, "VEC4", 2);
    file.json["animations"] = {{{"name", "turn"},
                                {"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "rotation"}}}}}},
                                {"samplers", {{{"input", times}, {"output", turns}}}}}};
    add_lamp(file);
    file.json["scenes"] = {{{"nodes", {0, 1, 3, 4, 5}}, {"extras", {{"sky", "blue"}}}}, {{"nodes", {4}}}};
    file.json["scene"] = 0;
    file.json["extensionsUsed"] = {"VENDOR_rust", "VENDOR_physics"};
    file.json["extensions"] = {{"VENDOR_physics", {{"gravity", {0, -9.81, 0}}}}};
    file.json["asset"]["copyright"] = "nobody";
    return file;
  }

  struct Outcome {
    BakeLayout layout;
    PointGrid grid;
    std::size_t triangles = 0;  ///< of the source
  };

  /// Writes the file with even light on each side as lit.glb.
  Outcome bake(const std::string& source, BakeFormat format = BakeFormat::emissive, AtlasRequest request = {128, 0}) {
    ImportOptions options;
    options.light_uvs = true;
    options.gltf_parts = std::make_shared<GltfParts>();
    const auto scene = without_instances(std::make_shared<const Scene>(load_scene(source, options)));
    const auto tracer = std::make_shared<const Tracer>(*scene);
    scene_notes = scene->notes();
    Outcome out{lay_out(scene, tracer, request), {}, scene->geometry().triangle_count()};
    out.grid = texel_points(*scene, *tracer, out.layout);
    std::vector<RGB> light;
    for (const std::uint32_t face : out.layout.texels.face)
      light.emplace_back(face != kNone && out.layout.faces[face].back ? back_light : front_light);
    BakeNotes notes;
    notes.gltf = options.gltf_parts;
    write("lit.glb", glb_of_scene(*scene, out.layout, encode_light(out.layout, light, {1}), format, notes));
    return out;
  }

  /// Writes the file with its computed light as lit.glb. @param exposure stops
  void bake_light(const std::string& source, BakeFormat format, float exposure) {
    ImportOptions options;
    options.light_uvs = true;
    options.gltf_parts = std::make_shared<GltfParts>();
    const auto scene = std::make_shared<const Scene>(load_scene(source, options));
    const auto tracer = std::make_shared<const Tracer>(*scene);
    const BakeLayout layout = lay_out(scene, tracer, {16, 0});
    RenderSettings settings;
    settings.samples = 32;
    settings.gather = 1;
    settings.photons = 1000;
    settings.memory_bytes = std::uint64_t{256} << 20;
    Baked baked = bake_points(scene, tracer, std::make_shared<const PointGrid>(texel_points(*scene, *tracer, layout)),
                              settings, std::nullopt, [](const BandRun& run) {
                                run.job.wait();
                                return std::exception_ptr();
                              });
    const std::vector<RGB> light =
        light_of_texels(*scene, layout, std::move(baked.irradiance), shown_light(format, options.gltf_parts.get()));
    const BakeNotes notes{exposure, "", {}, options.gltf_parts};
    write("lit.glb",
          glb_of_scene(*scene, layout, encode_light(layout, light, range_of(*scene, layout, format, exposure)), format,
                       notes));
  }

  std::vector<std::string> scene_notes;         ///< of the last bake
  float front_light = 0.5f, back_light = 0.5f;  ///< that bake() writes

  /// Expects that a point of each triangle of lit.glb, not in its middle, reads the texel of that place.
  void expect_light_in_place(const Outcome& baked, std::size_t dark_triangles) {
    constexpr float kWeights[] = {0.7f, 0.2f, 0.1f};
    ImportOptions options;
    options.light_uvs = true;
    const SceneDescription lit = load_scene(path("lit.glb"), options);
    const Geometry& g = lit.geometry;
    const int side = baked.layout.atlas.side;
    std::vector<int> sides(baked.triangles, 0);
    std::size_t doubled = 0, dark = 0;
    for (const BakeFace& face : baked.layout.faces) doubled += ++sides[face.triangle] == 2;
    EXPECT_EQ(g.triangle_count(), baked.triangles + doubled);
    for (std::uint32_t t = 0; t < g.triangle_count(); ++t) {
      Vec2 uv{0, 0};
      Vec3 place{0, 0, 0};
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t vertex = g.triangles[t][c];
        uv = uv + g.second_uvs[vertex] * kWeights[c];
        place = place + g.positions[vertex] * kWeights[c];
      }
      if (uv.x == 0) {
        ++dark;
        continue;
      }
      const int x = static_cast<int>(uv.x * static_cast<float>(side)),
                y = static_cast<int>((1 - uv.y) * static_cast<float>(side));
      float nearest = 1e9f;
      for (int atlas = 0; atlas < baked.layout.atlas.count; ++atlas) {
        const std::size_t texel = baked.layout.texels.index(x, y + atlas * side);
        if (baked.grid.has(texel)) nearest = std::min(nearest, length(baked.grid.position[texel] - place));
      }
      EXPECT_LT(nearest, 2 / baked.layout.atlas.texels_per_metre) << "triangle " << t;
    }
    EXPECT_EQ(dark, dark_triangles);
  }
};

/// The bytes of the image of a texture.
std::string image_bytes(const Parsed& file, const json& texture) {
  const json& image =
      file.whole["images"][file.whole["textures"][texture.get<std::size_t>()]["source"].get<std::size_t>()];
  const json& view = file.whole["bufferViews"][image["bufferView"].get<std::size_t>()];
  const auto first = file.document.buffers[0].begin() + view.value("byteOffset", 0);
  return {first, first + view["byteLength"].get<int>()};
}

/// The bytes of all attributes and morph targets of the corners of a primitive's triangles.
std::string corner_bytes(const Parsed& file, int mesh, std::size_t primitive, const json& names) {
  const json& p = file.whole["meshes"][static_cast<std::size_t>(mesh)]["primitives"][primitive];
  std::vector<GltfElements> all;
  for (const auto& [name, accessor] : names["attributes"].items())
    all.push_back(raw_elements(file.document, p["attributes"][name].get<int>()));
  for (std::size_t i = 0; names.contains("targets") && i < names["targets"].size(); ++i)
    for (const auto& [name, accessor] : names["targets"][i].items())
      all.push_back(raw_elements(file.document, p["targets"][i][name].get<int>()));
  std::string out;
  for (const auto& triangle : read_gltf_primitive(file.document, mesh, primitive).triangles)
    for (const std::uint32_t vertex : triangle)
      for (const GltfElements& e : all)
        out.append(reinterpret_cast<const char*>(e.bytes.data()) + vertex * e.size, e.size);
  return out;
}

TEST_F(BakedGltf, KeepsAllButLight) {
  const std::string source = write_gltf(animated_file());
  for (const BakeFormat format : {BakeFormat::emissive, BakeFormat::lightmap, BakeFormat::vertex}) {
    bake(source, format);
    const Parsed before(source), after(path("lit.glb"));
    const json &a = before.whole, &b = after.whole;
    for (const char* key : {"animations", "skins", "cameras", "scenes", "scene", "extensions", "nodes"})
      EXPECT_EQ(a[key], b[key]) << key;
    EXPECT_EQ(b["asset"]["copyright"], "nobody");
    for (const char* list : {"accessors", "bufferViews"})
      for (std::size_t i = 0; i < a[list].size(); ++i) EXPECT_EQ(a[list][i], b[list][i]) << list << i;
    ASSERT_EQ(after.document.buffers.size(), 1u);
    const auto& bytes = before.document.buffers[0];
    EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), after.document.buffers[0].begin()));
    for (const char* key : {"name", "weights", "extras"}) EXPECT_EQ(a["meshes"][0][key], b["meshes"][0][key]);
    const json& sphere = b["meshes"][0]["primitives"][0];
    EXPECT_EQ(sphere["extras"], json({"primitive", 1}));
    EXPECT_EQ(corner_bytes(before, 0, 0, a["meshes"][0]["primitives"][0]),
              corner_bytes(after, 0, 0, a["meshes"][0]["primitives"][0]));
    const json& paint = b["materials"][sphere["material"].get<std::size_t>()];
    EXPECT_EQ(sphere["material"], 0);
    EXPECT_EQ(paint["name"], "paint");
    EXPECT_EQ(paint["extras"]["price"], 3);
    EXPECT_EQ(paint["extensions"]["VENDOR_rust"]["grade"], 0.25);
    EXPECT_EQ(b["materials"][2], a["materials"][2]);
  }
}

TEST_F(BakedGltf, PutsLightWhereItBelongs) {
  const Outcome baked = bake(write_gltf(animated_file()));
  EXPECT_THAT(scene_notes, HasNote("skin: its mesh gets the light of the file's pose"));
  expect_light_in_place(baked, 1);
  // The floor is lit from above and from below, so its back is a primitive of its own.
  const Parsed after(path("lit.glb"));
  const json& floor = after.whole["meshes"][1]["primitives"];
  ASSERT_EQ(floor.size(), 2u);
  EXPECT_EQ(after.whole["accessors"][floor[0]["indices"].get<std::size_t>()]["count"], 9) << "with its flat triangle";
  EXPECT_EQ(after.whole["accessors"][floor[1]["indices"].get<std::size_t>()]["count"], 6);
}

TEST_F(BakedGltf, KeepsFlatTrianglesWithTheFrontWhereBacksAreBrighter) {
  // So the back's layer comes first.
  front_light = 0.01f;
  back_light = 0.9f;
  expect_light_in_place(bake(write_gltf(animated_file())), 1);
  const Parsed after(path("lit.glb"));
  const json& floor = after.whole["meshes"][1]["primitives"];
  ASSERT_EQ(floor.size(), 2u);
  EXPECT_EQ(after.whole["accessors"][floor[0]["indices"].get<std::size_t>()]["count"], 6);
  EXPECT_EQ(after.whole["accessors"][floor[1]["indices"].get<std::size_t>()]["count"], 9) << "with its flat triangle";
}

TEST_F(BakedGltf, GivesEachPlaceOfAMeshItsLight) {
  GltfFile file;
  json sphere = sphere_primitive(file);
  const int mesh = file.add("meshes", {{"primitives", {sphere}}});
  const int places = file.add_accessor<float>({0, 9, 0, 0, 12, 0}, 5126, "VEC3", 2);
  file.json["nodes"] = {{{"mesh", mesh}},
                        {{"mesh", mesh}, {"translation", {3, 0, 0}}, {"scale", {-1, 1, 1}}},
                        {{"mesh", mesh}, {"translation", {6, 0, 0}}, {"scale", {0.5, 0.5, 0.5}}},
                        {{"mesh", mesh},
                         {"name", "many"},
                         {"weights", {0.5}},
                         {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", places}}}}}}}}};
  file.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  file.json["scenes"] = {{{"nodes", {0, 1, 2, 3}}}};
  add_lamp(file);
  file.json["scenes"][0]["nodes"].push_back(4);
  for (const AtlasRequest request : {AtlasRequest{256, 0}, AtlasRequest{64, 12}}) {
    const Outcome baked = bake(write_gltf(file), BakeFormat::emissive, request);
    EXPECT_EQ(baked.layout.atlas.count > 1, request.side == 64);
    expect_light_in_place(baked, 1);
    const Parsed after(path("lit.glb"));
    EXPECT_EQ(after.whole["meshes"].size(), 2u + 4u);
    EXPECT_FALSE(after.whole["nodes"][3].contains("mesh"));
    EXPECT_FALSE(after.whole["nodes"][3].contains("weights")) << "of no mesh";
    EXPECT_EQ(after.whole["nodes"][3]["children"].size(), 2u);
    for (const json& child : after.whole["nodes"][3]["children"])
      EXPECT_EQ(after.whole["nodes"][child.get<std::size_t>()]["weights"], json::array({0.5}));
    const json& used = after.whole["extensionsUsed"];
    EXPECT_EQ(std::count(used.begin(), used.end(), "EXT_mesh_gpu_instancing"), 0);
  }
}

TEST_F(BakedGltf, UsesAFurtherSetOfCoordinatesWhereATextureHasTheSecond) {
  GltfFile file;
  write("a.png", "not read");
  file.json["images"] = {{{"uri", "a.png"}}};
  file.json["textures"] = {{{"source", 0}}};
  json floor = floor_primitive(file);
  const int uvs = file.add_accessor<float>({0, 0, 0, 1, 1, 0, 1, 1}, 5126, "VEC2", 4);
  floor["attributes"]["TEXCOORD_0"] = floor["attributes"]["TEXCOORD_1"] = uvs;
  floor["material"] = file.add("materials", {{"occlusionTexture", {{"index", 0}, {"texCoord", 1}}}});
  file.add("nodes", {{"mesh", file.add("meshes", {{"primitives", {floor}}})}});
  add_lamp(file);
  bake(write_gltf(file), BakeFormat::lightmap);
  const json lit = Parsed(path("lit.glb")).whole;
  const json& primitive = lit["meshes"][0]["primitives"][0];
  EXPECT_EQ(primitive["attributes"]["TEXCOORD_1"], uvs);
  EXPECT_TRUE(primitive["attributes"].contains("TEXCOORD_2"));
  const json& material = lit["materials"][primitive["material"].get<std::size_t>()];
  EXPECT_EQ(material["extensions"]["MOZ_lightmap"]["texCoord"], 2);
  EXPECT_EQ(material["occlusionTexture"]["texCoord"], 1);
}

TEST_F(BakedGltf, WritesCompressedMeshesPlain) {
  const Geometry sphere = sphere_mesh(12, 6);
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(sphere.triangle_count()));
  const int attribute = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  for (std::uint32_t t = 0; t < sphere.triangle_count(); ++t) {
    const auto& [a, b, c] = sphere.triangles[t];
    builder.SetAttributeValuesForFace(attribute, draco::FaceIndex(t), &sphere.positions[a].x, &sphere.positions[b].x,
                                      &sphere.positions[c].x);
  }
  const auto mesh = builder.Finalize();
  draco::EncoderBuffer buffer;
  ASSERT_TRUE(draco::Encoder().EncodeMeshToBuffer(*mesh, &buffer).ok());
  GltfFile file;
  const int view = file.add_view(std::vector<char>(buffer.data(), buffer.data() + buffer.size()));
  const int positions = file.add("accessors", {{"componentType", 5126},
                                               {"type", "VEC3"},
                                               {"count", mesh->num_points()},
                                               {"min", {-1, -1, -1}},
                                               {"max", {1, 1, 1}}});
  const int indices =
      file.add("accessors", {{"componentType", 5125}, {"type", "SCALAR"}, {"count", 3 * mesh->num_faces()}});
  const json compressed = {{"bufferView", view},
                           {"attributes", {{"POSITION", mesh->attribute(attribute)->unique_id()}}}};
  // Morph targets are never compressed.
  const std::vector<float> shift(3 * mesh->num_points(), 0.25f);
  const int target = file.add_accessor(shift, 5126, "VEC3", mesh->num_points());
  file.add("meshes", {{"weights", {0.5}},
                      {"primitives",
                       {{{"attributes", {{"POSITION", positions}}},
                         {"indices", indices},
                         {"targets", {{{"POSITION", target}}}},
                         {"extensions", {{"KHR_draco_mesh_compression", compressed}}}}}}});
  file.add("nodes", {{"mesh", 0}});
  add_lamp(file);
  file.json["extensionsUsed"] = file.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  expect_light_in_place(bake(write_gltf(file)), 1);
  const json lit = Parsed(path("lit.glb")).whole;
  EXPECT_FALSE(lit.contains("extensionsRequired"));
  EXPECT_FALSE(lit["meshes"][0]["primitives"][0].contains("extensions"));
}

TEST_F(BakedGltf, BringsLampsAndLightsToItsExposure) {
  GltfFile file;
  file.add("nodes", {{"mesh", file.add("meshes", {{"primitives", {floor_primitive(file)}}})}});
  add_lamp(file);
  file.add_shown_triangle({{"pbrMetallicRoughness", {{"baseColorFactor", {0.125, 0.5, 0, 0.5}}}},
                           {"extensions", {{"KHR_materials_unlit", json::object()}}}});
  file.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", kLuminousEfficacy}}};
  file.add("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  const std::string source = write_gltf(file);
  ImportOptions options;
  options.gltf_parts = std::make_shared<GltfParts>();
  const auto scene = std::make_shared<const Scene>(load_scene(source, options));
  const BakeLayout layout = lay_out(scene, std::make_shared<const Tracer>(*scene), {64, 0});
  const EncodedLight even = encode_light(layout, std::vector<RGB>(layout.texels.face.size(), RGB(0.5f)), {1});
  BakeNotes notes{2, "", {}, options.gltf_parts, true};
  for (const bool indirect_only : {true, false}) {
    notes.indirect_only = indirect_only;
    write("lit.glb", glb_of_scene(*scene, layout, even, BakeFormat::lightmap, notes));
    const json lit = Parsed(path("lit.glb")).whole;
    EXPECT_EQ(lit["materials"][0]["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"], 4);
    EXPECT_EQ(lit["materials"][1]["pbrMetallicRoughness"]["baseColorFactor"], json({0.5, 1, 0, 0.5})) << "unlit";
    // Direct light in the lightmap must not be there twice.
    EXPECT_EQ(lit["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"], indirect_only ? 4 : 0);
  }
}

/// Lamps and lights of baked files are in the units of viewers, at an exposure.
TEST_F(BakedGltf, GivesBackTheLightOfItsScene) {
  GltfFile file;
  file.add("nodes", {{"mesh", file.add("meshes", {{"primitives", {floor_primitive(file)}}})}});
  add_lamp(file);
  file.add_shown_triangle({{"pbrMetallicRoughness", {{"baseColorFactor", {0.125, 0.25, 0, 1}}}},
                           {"extensions", {{"KHR_materials_unlit", json::object()}}}});
  file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"intensity", 300}, {"color", {1, 0.5, 0}}}, {{"type", "directional"}, {"intensity", 1e5}}};
  for (const int light : {0, 1}) file.add("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
  const std::string source = write_gltf(file), lit = path("lit.glb");
  const SceneDescription scene = load_scene(source);
  ASSERT_EQ(scene.emissions.size(), 2u);
  ASSERT_EQ(scene.lights.size(), 2u);
  const auto bake_again = [&](const std::string& from, float exposure, float metres_per_unit) {
    ImportOptions options;
    options.gltf_parts = std::make_shared<GltfParts>();
    const auto read = std::make_shared<const Scene>(load_scene(from, options));
    const BakeLayout layout = lay_out(read, std::make_shared<const Tracer>(*read), {64, 0});
    const EncodedLight even = encode_light(layout, std::vector<RGB>(layout.texels.face.size(), RGB(0.5f)), {1});
    const BakeNotes notes{exposure, "", {}, options.gltf_parts, true, metres_per_unit};
    write("lit.glb", glb_of_scene(*read, layout, even, BakeFormat::lightmap, notes));
    const SceneDescription again = load_scene(lit);
    const auto expect_same = [&](RGB a, RGB b) {
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-5f * b[c]) << from << ", " << exposure << " stops";
    };
    ASSERT_EQ(again.emissions.size(), 2u);
    ASSERT_EQ(again.lights.size(), 2u);
    for (std::size_t i : {0, 1}) {
      expect_same(again.emissions[i].radiance.value, scene.emissions[i].radiance.value);
      expect_same(again.lights[i].intensity, scene.lights[i].intensity);
    }
  };
  bake_again(source, 0, 1);
  bake_again(source, 1.5f, 1);
  bake_again(lit, -2, 1);
  bake_again(lit, 1, 0.25f);
  bake_again(lit, 0, 0.25f);
}

/// A picture that takes 12 kB, whatever the compression.
std::vector<std::uint8_t> noisy_png(std::uint32_t seed) {
  constexpr int kSide = 64;
  std::vector<std::uint8_t> codes;
  for (std::uint32_t i = 0; i < 3 * kSide * kSide; ++i)
    codes.push_back(static_cast<std::uint8_t>(hash_combine(hash32(seed), i)));
  const std::string png = encode_png(kSide, kSide, 3, std::move(codes), {});
  return {png.begin(), png.end()};
}

/// Each accessor of an animation or a skin, as bytes.
std::vector<std::vector<std::uint8_t>> moving_bytes(const Parsed& file) {
  std::vector<std::vector<std::uint8_t>> out;
  for (const char* key : {"input", "output"})
    out.push_back(raw_elements(file.document, file.whole["animations"][0]["samplers"][0][key].get<int>()).bytes);
  out.push_back(raw_elements(file.document, file.whole["skins"][0]["inverseBindMatrices"].get<int>()).bytes);
  return out;
}

/// A floor that glows faintly, under a sun in the zenith that gives it 2 W m^-2; nothing else.
constexpr const char* kSunlitFloor = R"(
LookAt 0 5 0  0 0 0  0 0 1
Camera "perspective"
WorldBegin
LightSource "distant" "rgb L" [2 2 2] "point3 from" [0 1 0] "point3 to" [0 0 0]
Material "diffuse" "rgb reflectance" [0.5 0.25 0.1]
AreaLightSource "diffuse" "rgb L" [0.3 0.2 0.1]
Shape "trianglemesh" "point3 P" [-3 -1.5 -3  -3 -1.5 3  3 -1.5 -3  3 -1.5 3] "integer indices" [0 1 2 1 3 2]
)";

/// The same floor as glTF.
GltfFile sunlit_floor() {
  GltfFile file;
  json floor = floor_primitive(file);
  floor["material"] = file.add(
      "materials", {{"emissiveFactor", {0.3, 0.2, 0.1}},
                    {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 0.1, 1}}, {"metallicFactor", 0}}},
                    {"extensions", {{"KHR_materials_specular", {{"specularFactor", 0}}}}}});
  file.add("nodes", {{"mesh", file.add("meshes", {{"primitives", {floor}}})}});
  file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "directional"}, {"intensity", 2 * kLuminousEfficacy}}};
  file.add("nodes", {{"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}},
                     {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  return file;
}

TEST_F(BakedGltf, ScalesLightAndGlowByTheExposure) {
  constexpr float kIrradiance = 2, kExposure = 1.5f;
  const float gain = std::exp2(kExposure);
  const RGB albedo{0.5f, 0.25f, 0.1f}, glow{0.3f, 0.2f, 0.1f};
  for (const std::string& source : {write_gltf(sunlit_floor()), write("floor.pbrt", kSunlitFloor)})
    for (const BakeFormat format : {BakeFormat::lightmap, BakeFormat::emissive}) {
      bake_light(source, format, kExposure);
      const Parsed lit(path("lit.glb"));
      const json& material = lit.whole["materials"][0];
      const json& extensions = material["extensions"];
      const bool lightmap = format == BakeFormat::lightmap;
      const json& texture = lightmap ? extensions["MOZ_lightmap"] : material["emissiveTexture"];
      const json& strength = extensions["KHR_materials_emissive_strength"]["emissiveStrength"];
      const json& scale = lightmap ? texture["intensity"] : strength;
      const RGB shown = lightmap ? RGB(kIrradiance) : albedo * kIrradiance * kInversePi + glow;
      const std::vector<RGB> texels = read_image(write("light.png", image_bytes(lit, texture["index"]))).rgb();
      const RGB mean = std::accumulate(texels.begin(), texels.end(), RGB()) / static_cast<float>(texels.size());
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c] * scale.get<float>(), shown[c] * gain, 0.015f * shown[c] * gain);
      if (!lightmap) continue;
      EXPECT_EQ(material["extras"]["lightmap"]["intensity"], scale);
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(material["emissiveFactor"][c].get<float>() * strength.get<float>(),
                    glow[static_cast<int>(c)] * gain, 1e-4f);
    }
}

TEST_F(BakedGltf, MultipliesColoursOfVerticesByLight) {
  constexpr float kIrradiance = 2, kExposure = -2;
  GltfFile file = sunlit_floor();
  const std::vector<float> halves(12, 0.5f);
  file.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = file.add_accessor(halves, 5126, "VEC3", 4);
  bake_light(write_gltf(file), BakeFormat::vertex, kExposure);
  const Parsed lit(path("lit.glb"));
  const RGB albedo{0.5f, 0.25f, 0.1f}, glow{0.3f, 0.2f, 0.1f};
  const json& colors = lit.whole["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"];
  const std::vector<float> values = read_floats(lit.document, colors.get<int>(), 3);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const int c = static_cast<int>(i % 3);
    const float shown = (albedo[c] / 2 * kIrradiance * kInversePi + glow[c]) * std::exp2(kExposure);
    EXPECT_NEAR(albedo[c] * values[i], shown, 0.02f * shown);
  }
}

TEST_F(BakedGltf, TakesImagesOfOtherFormatsIntoTheFile) {
  GltfFile file = sunlit_floor();
  const std::string avif(
      "\0\0\0\x1c"
      "ftypavif, the rest is not read",
      34);
  write("a.avif", avif);
  write("b.dds", "DDS , the rest is not read");
  file.json["images"] = {{{"uri", "a.avif"}}, {{"uri", "b.dds"}}};
  bake(write_gltf(file));
  const json images = Parsed(path("lit.glb")).whole["images"];
  EXPECT_EQ(images.at(0).value("mimeType", ""), "image/avif");
  EXPECT_EQ(images.at(1).value("mimeType", ""), "image/vnd-ms.dds");
  for (const json& image : {images[0], images[1]}) EXPECT_TRUE(image.contains("bufferView") && !image.contains("uri"));
}

TEST_F(BakedGltf, LeavesOutWhatItReplaces) {
  GltfFile file = animated_file();
  for (json* object : {&file.json, &file.json["nodes"][1], &file.json["materials"][0]}) object->erase("extensions");
  file.json.erase("extensionsUsed");
  // Two textures that the light replaces, with a sampler of their own; one of glass; one that nothing uses.
  file.json["samplers"] = {{{"wrapS", 33648}}, {{"wrapS", 10497}}};
  for (std::uint32_t i = 0; i < 4; ++i)
    file.add("textures", {{"source", file.add("images", {{"bufferView", file.add_view(noisy_png(i))},
                                                         {"mimeType", "image/png"},
                                                         {"name", std::string(1, static_cast<char>('A' + i))}})},
                          {"sampler", i < 2 ? 0 : 1}});
  file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  file.json["materials"][0]["normalTexture"] = {{"index", 1}};
  file.add_shown_triangle({{"name", "glass"},
                           {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 2}}}}},
                           {"occlusionTexture", {{"index", 9}}},
                           {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}}}});
  file.json["scenes"][0]["nodes"].push_back(file.json["nodes"].size() - 1);
  std::vector<float> matrices(32, 0);
  for (const std::size_t i : {0, 5, 10, 15}) matrices[i] = matrices[16 + i] = 1;
  file.json["skins"][0]["inverseBindMatrices"] = file.add_accessor(matrices, 5126, "MAT4", 2);
  const std::string source = write_gltf(file);
  bake(source);
  const Parsed before(source), after(path("lit.glb"));
  const json &a = before.whole, &b = after.whole;
  const auto size = std::filesystem::file_size(path("lit.glb"));

  ASSERT_EQ(b["images"].size(), 3u);
  EXPECT_EQ(b["images"][0]["name"], "C");
  EXPECT_EQ(b["images"][1]["name"], "D");
  ASSERT_EQ(b["textures"].size(), 3u);
  ASSERT_EQ(b["samplers"].size(), 2u);
  EXPECT_EQ(b["samplers"][0], a["samplers"][1]);
  const json& glass = b["materials"][3]["pbrMetallicRoughness"]["baseColorTexture"]["index"];
  EXPECT_EQ(glass, 0);
  EXPECT_EQ(b["materials"][3]["occlusionTexture"]["index"], 9) << "there is no such texture";
  EXPECT_EQ(image_bytes(after, glass), image_bytes(before, 2));
  EXPECT_EQ(b["materials"][0]["emissiveTexture"]["index"], 2);
  EXPECT_EQ(moving_bytes(after), moving_bytes(before));
  const json& sphere = a["meshes"][0]["primitives"][0];
  EXPECT_EQ(corner_bytes(before, 0, 0, sphere), corner_bytes(after, 0, 0, sphere));
  for (const auto& [name, accessor] : b["accessors"].items())
    EXPECT_LT(accessor.value("bufferView", 0), static_cast<int>(b["bufferViews"].size())) << name;

  // An extension that may refer to anything.
  file.json["nodes"][2]["extensions"]["VENDOR_sprite"]["image"] = 1;
  file.json["extensionsUsed"] = {"VENDOR_sprite"};
  bake(write_gltf(file));
  const Parsed whole(path("lit.glb"));
  ASSERT_EQ(whole.whole["images"].size(), 5u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(whole.whole["images"][i], a["images"][i]);
  EXPECT_GT(std::filesystem::file_size(path("lit.glb")), size + 2 * 64 * 64 * 3);
}

TEST_F(BakedGltf, KeepsTheAlphaOfDiffuseColours) {
  GltfFile file;
  file.json["images"] = {{{"bufferView", file.add_view(noisy_png(1))}, {"mimeType", "image/png"}}};
  file.json["textures"] = {{{"source", 0}}};
  json floor = floor_primitive(file);
  floor["attributes"]["TEXCOORD_0"] = file.add_accessor<float>({0, 0, 0, 1, 1, 0, 1, 1}, 5126, "VEC2", 4);
  floor["material"] = file.add("materials", {{"alphaMode", "BLEND"},
                                             {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}}},
                                             {"extensions",
                                              {{"KHR_materials_pbrSpecularGlossiness",
                                                {{"diffuseFactor", {0.5, 0.25, 0.125, 0.75}},
                                                 {"diffuseTexture", {{"index", 0}}},
                                                 {"glossinessFactor", 0}}}}}});
  file.add("nodes", {{"mesh", file.add("meshes", {{"primitives", {floor}}})}});
  add_lamp(file);
  for (const BakeFormat format : {BakeFormat::emissive, BakeFormat::vertex}) {
    const std::string source = write_gltf(file);
    bake(source, format);
    const Parsed after(path("lit.glb"));
    const json& lit = after.whole;
    const json& primitive = lit["meshes"][0]["primitives"][0];
    const json& material = lit["materials"][primitive["material"].get<std::size_t>()];
    EXPECT_FALSE(material["extensions"].contains("KHR_materials_pbrSpecularGlossiness"));
    const json& pbr = material["pbrMetallicRoughness"];
    const bool dark = format == BakeFormat::emissive;
    EXPECT_EQ(pbr["baseColorFactor"][0], dark ? 0 : 0.5);
    EXPECT_EQ(pbr["baseColorFactor"][3], 0.75);
    EXPECT_EQ(pbr["metallicFactor"], 0);
    ASSERT_TRUE(pbr.contains("baseColorTexture"));
    EXPECT_EQ(image_bytes(after, pbr["baseColorTexture"]["index"]), image_bytes(Parsed(source), 0));
  }
}

TEST_F(BakedGltf, RefusesAFileThatChangedMeanwhile) {
  const std::string source = write_gltf(animated_file());
  ImportOptions options;
  options.gltf_parts = std::make_shared<GltfParts>();
  const auto scene = std::make_shared<const Scene>(load_scene(source, options));
  const BakeLayout layout = lay_out(scene, std::make_shared<const Tracer>(*scene), {64, 0});
  const EncodedLight even = encode_light(layout, std::vector<RGB>(layout.texels.face.size()), {1});
  GltfFile other;
  other.add_triangle();
  other.add_triangle();
  other.json["nodes"] = {{{"mesh", 0}}, json::object(), json::object(), {{"mesh", 1}}};
  write_gltf(other);
  BakeNotes notes;
  notes.gltf = options.gltf_parts;
  const auto problem = [&] {
    try {
      glb_of_scene(*scene, layout, even, BakeFormat::emissive, notes);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(problem(), testing::HasSubstr("changed while it was baked"));
  other.json["nodes"] = {{{"mesh", 1}}};
  write_gltf(other);
  EXPECT_THAT(problem(), testing::HasSubstr("changed while it was baked"));
}

}  // namespace
}  // namespace glowworm
