// glTF nodes, meshes, cameras, lights and storage formats of numbers.
#include <array>
#include <cmath>
#include <ctime>

#include "gltf_file.h"
#include "scene/light_power.h"

namespace glowworm {
namespace {

using nlohmann::json;
using testing::HasSubstr;

void expect_near(Vec3 a, Vec3 b, float tolerance = 1e-5f) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

using GltfSceneTest = GltfTest;

TEST_F(GltfSceneTest, NodesPlaceTheirMeshes) {
  GltfFile file;
  const int mesh = file.add_triangle();
  file.add("nodes", {{"mesh", mesh}, {"translation", {1, 2, 3}}, {"children", {1, 2}}});
  const float h = std::sqrt(0.5f);  // a quarter turn about z
  file.add("nodes", {{"mesh", mesh}, {"rotation", {0, 0, h, h}}, {"scale", {2, 2, 2}}});
  file.add("nodes", {{"mesh", mesh}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1}}});
  file.json["scenes"] = {{{"nodes", {0}}}};
  file.json["scene"] = 0;
  const auto d = load(file);
  ASSERT_EQ(d.geometry.triangle_count(), 3u);
  const auto corner = [&](std::size_t t, std::size_t c) { return d.geometry.positions[d.geometry.triangles[t][c]]; };
  expect_near(corner(0, 1), {2, 2, 3});
  expect_near(corner(1, 1), {1, 4, 3});
  expect_near(corner(1, 2), {-1, 2, 3});
  expect_near(corner(2, 0), {11, 2, 3});
  EXPECT_EQ(d.geometry.normals[0], (Vec3{0, 0, 0})) << "no normals in the file: flat ones";
  EXPECT_EQ(d.geometry.uvs[d.geometry.triangles[0][2]].y, 0.0f) << "v runs upwards here";
}

TEST_F(GltfSceneTest, MirroredNodesKeepTheirOutside) {
  GltfFile file;
  file.add("nodes", {{"mesh", file.add_triangle()}, {"scale", {-1, 1, 1}}});
  const auto d = load(file);
  ASSERT_EQ(d.geometry.triangle_count(), 1u);
  expect_near(d.geometry.normal(0), {0, 0, 1});
}

TEST_F(GltfSceneTest, CamerasLookAlongMinusZ) {
  GltfFile file;
  file.add("nodes", {{"mesh", file.add_triangle()}});
  file.add("nodes", {{"camera", 0}, {"name", "wide"}, {"translation", {0, 1, 5}}, {"scale", {3, 3, 3}}});
  file.add("nodes", {{"camera", 1}});
  file.add("nodes", {{"camera", 2}});
  file.add("cameras",
           {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}, {"aspectRatio", 1.5}}}});
  file.add("cameras",
           {{"type", "perspective"}, {"perspective", {{"yfov", 1.0}, {"znear", 0.1}, {"aspectRatio", 0.5}}}});
  file.add("cameras",
           {{"type", "orthographic"}, {"orthographic", {{"xmag", 2.0}, {"ymag", 3.0}, {"znear", 0.1}, {"zfar", 9}}}});
  const auto d = load(file);
  ASSERT_EQ(d.cameras.size(), 3u);
  EXPECT_EQ(d.cameras[0].name, "wide");
  EXPECT_FLOAT_EQ(d.cameras[0].half_extent, std::tan(0.5f));
  EXPECT_FLOAT_EQ(d.cameras[1].half_extent, 0.5f * std::tan(0.5f));
  EXPECT_EQ(d.cameras[2].kind, CameraKind::orthographic);
  EXPECT_FLOAT_EQ(d.cameras[2].half_extent, 2);
  EXPECT_FLOAT_EQ(d.cameras[0].aspect, 1.5f);
  EXPECT_FLOAT_EQ(d.cameras[2].aspect, 2.0f / 3);
  const CameraRay ray = generate_ray(d.cameras[0], {50, 50}, 100, 100, {0, 0});
  expect_near(ray.origin, {0, 1, 5});
  expect_near(ray.direction, {0, 0, -1});
  EXPECT_GT(generate_ray(d.cameras[0], {90, 50}, 100, 100, {0, 0}).direction.x, 0);
  EXPECT_GT(generate_ray(d.cameras[0], {50, 10}, 100, 100, {0, 0}).direction.y, 0);
}

TEST_F(GltfSceneTest, LightsBecomeRadiometric) {
  GltfFile file;
  file.add("nodes", {{"mesh", file.add_triangle()}});
  const float h = std::sqrt(0.5f);  // a quarter turn about x: -z to y
  for (int i = 0; i < 3; ++i) {
    file.add("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", i}}}}},
                       {"translation", {0, 4, 0}},
                       {"rotation", {h, 0, 0, h}}});
  }
  file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"intensity", kLuminousEfficacy}, {"color", {1, 0.5, 0}}},
      {{"type", "directional"}, {"intensity", 10 * kLuminousEfficacy}},
      {{"type", "spot"},
       {"intensity", kLuminousEfficacy / 10},
       {"range", 10},
       {"spot", {{"innerConeAngle", 0.2}, {"outerConeAngle", 0.4}}}}};
  const auto d = load(file);
  ASSERT_EQ(d.lights.size(), 3u);
  EXPECT_EQ(d.lights[0].kind, LightKind::point);
  EXPECT_EQ(d.lights[0].intensity, RGB(1, 0.5f, 0));
  expect_near(d.lights[0].position, {0, 4, 0});
  EXPECT_EQ(d.lights[1].kind, LightKind::directional);
  EXPECT_FLOAT_EQ(d.lights[1].intensity.g, 10);
  expect_near(d.lights[1].direction, {0, 1, 0});
  EXPECT_EQ(d.lights[2].kind, LightKind::spot);
  EXPECT_EQ(d.lights[2].falloff, SpotFalloff::quadratic);
  EXPECT_FLOAT_EQ(d.lights[2].intensity.r, 0.1f);
  EXPECT_FLOAT_EQ(d.lights[2].cos_inner, std::cos(0.2f));
  EXPECT_FLOAT_EQ(d.lights[2].cos_outer, std::cos(0.4f));
  EXPECT_THAT(d.notes, HasNote("range of a light"));
  // Files of bakes say what their numbers were multiplied by; what else stands there counts for nothing.
  for (const nlohmann::json& stops : std::vector<nlohmann::json>{1, 1e9, "1", nullptr}) {
    file.json["asset"]["extras"]["glowworm"]["exposure_stops"] = stops;
    EXPECT_FLOAT_EQ(load(file).lights[1].intensity.g, stops == 1 ? 5 * kLuminousEfficacy : 10) << stops;
  }
}

TEST_F(GltfSceneTest, LightsTakeIntensitiesFromPhotometricFiles) {
  const char* const lamp = "IESNA91\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0\n1 1 1\n0 45 90\n0\n179 100 0\n";
  write("lamp.ies", lamp);
  GltfFile file;
  file.add("nodes", {{"mesh", file.add_triangle()}});
  const float h = std::sqrt(0.5f);  // a quarter turn about x: -z to y
  file.add("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}, {"rotation", {h, 0, 0, h}}});
  file.add("nodes",
           {{"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}, {"extras", {{"luminaire", "lamp.ies"}}}});
  file.add("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}, {"name", "lamp.ies"}});
  file.add("nodes", {{"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}, {"name", "other.ldt"}});
  file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"color", {1, 0.5, 0}}, {"extras", {{"luminaire", "lamp.ies"}}}}, {{"type", "point"}}};
  const auto d = load(file);
  ASSERT_EQ(d.lights.size(), 4u);
  for (int i = 0; i < 3; ++i) {
    const Light& light = d.lights[static_cast<std::size_t>(i)];
    ASSERT_EQ(light.kind, LightKind::luminaire) << i;
    EXPECT_NEAR(light.intensity.r * table_intensity(light, light.direction), 1, 1e-4);  // 179 cd
    expect_near(light.right, {1, 0, 0});
  }
  expect_near(d.lights[0].direction, {0, 1, 0});
  EXPECT_FLOAT_EQ(d.lights[0].intensity.g, 0.5f * d.lights[0].intensity.r);
  expect_near(d.lights[1].direction, {0, 0, -1});
  EXPECT_EQ(d.lights[3].kind, LightKind::point);
  EXPECT_THAT(d.notes, HasNote("'other.ldt' is named like a photometric file"));
  // As in files of bakes whose light holds that of lamps.
  file.json["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = 0;
  EXPECT_EQ(load(file).lights[0].intensity, RGB(0.0f));
  file.json["nodes"][2]["extras"]["luminaire"] = "gone.ies";
  EXPECT_THROW(load(file), Error);
}

TEST_F(GltfSceneTest, EmissionMayBeDecoration) {
  GltfFile file;
  file.add("nodes", {{"mesh", file.add_triangle({{"material", 0}})}});
  file.add("materials", {{"emissiveFactor", {1, 1, 1}}});
  const Scene scene(load(file));
  ASSERT_TRUE(scene.environment());
  EXPECT_EQ(scene.environment()->name, "studio light");
  EXPECT_THAT(scene.notes(), HasNote("no light but what glows"));
}

TEST_F(GltfSceneTest, StripsFansAndIndicesOfEveryWidth) {
  const std::vector<float> square = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  for (const int mode : {5, 6}) {
    GltfFile file;
    const int positions = file.add_accessor(square, 5126, "VEC3", 4);
    const std::vector<std::uint8_t> order =
        mode == 5 ? std::vector<std::uint8_t>{0, 1, 2, 3} : std::vector<std::uint8_t>{0, 1, 3, 2};
    const int indices = file.add_accessor(order, 5121, "SCALAR", 4);
    file.add("meshes",
             {{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"mode", mode}}}}});
    file.add("nodes", {{"mesh", 0}});
    const auto d = load(file);
    ASSERT_EQ(d.geometry.triangle_count(), 2u);
    for (std::uint32_t t = 0; t < 2; ++t) expect_near(d.geometry.normal(t), {0, 0, 1});
    EXPECT_FLOAT_EQ(d.geometry.area(0) + d.geometry.area(1), 1);
  }
  GltfFile file;
  const int positions = file.add_accessor(square, 5126, "VEC3", 4);
  json primitives;
  primitives.push_back({{"attributes", {{"POSITION", positions}}},
                        {"indices", file.add_accessor<std::uint16_t>({0, 1, 2}, 5123, "SCALAR", 3)}});
  primitives.push_back({{"attributes", {{"POSITION", positions}}},
                        {"indices", file.add_accessor<std::uint32_t>({1, 3, 2}, 5125, "SCALAR", 3)}});
  primitives.push_back({{"attributes", {{"POSITION", positions}}}, {"mode", 1}});
  file.add("meshes", {{"primitives", primitives}});
  file.add("nodes", {{"mesh", 0}});
  const auto d = load(file);
  EXPECT_EQ(d.geometry.triangle_count(), 2u);
  EXPECT_THAT(d.notes, HasNote("points or lines, left out"));
}

TEST_F(GltfSceneTest, SparseQuantisedAndInterleavedNumbers) {
  GltfFile file;
  // Sparse: the first vertex moves to (0, 0, 7).
  const int base = file.add_view<float>({0, 0, 0, 1, 0, 7, 0, 1, 7});
  const int indices = file.add_view<std::uint16_t>({0, 0});
  const int values = file.add_view<float>({0, 0, 7});
  const int sparse = file.add("accessors", {{"bufferView", base},
                                            {"componentType", 5126},
                                            {"type", "VEC3"},
                                            {"count", 3},
                                            {"sparse",
                                             {{"count", 1},
                                              {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                                              {"values", {{"bufferView", values}}}}}});
  // Interleaved and quantised: positions in 16-bit integers, normals in normalised bytes.
  std::vector<std::int16_t> rows;
  for (const auto& p : {std::array<std::int16_t, 3>{0, 0, 0}, {100, 0, 0}, {0, 100, 0}}) {
    rows.insert(rows.end(), {p[0], p[1], p[2], 0, 0, 127});  // the last two: bytes 0 0 127 0
  }
  const int view = file.add_view(rows, 12);
  const auto interleaved = [&](int offset, int type, bool normalized) {
    return file.add("accessors", {{"bufferView", view},
                                  {"byteOffset", offset},
                                  {"componentType", type},
                                  {"type", "VEC3"},
                                  {"count", 3},
                                  {"normalized", normalized}});
  };
  const int positions = interleaved(0, 5122, false), normals = interleaved(8, 5120, true);
  file.add(
      "meshes",
      {{"primitives",
        {{{"attributes", {{"POSITION", sparse}}}}, {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}}}}});
  file.add("nodes", {{"mesh", 0}});
  const auto d = load(file);
  ASSERT_EQ(d.geometry.triangle_count(), 2u);
  const auto corner = [&](std::size_t t, std::size_t c) { return d.geometry.triangles[t][c]; };
  expect_near(d.geometry.positions[corner(0, 0)], {0, 0, 7});
  expect_near(d.geometry.positions[corner(1, 1)], {100, 0, 0});
  expect_near(d.geometry.normals[corner(1, 1)], {0, 0, 1});
}

TEST_F(GltfSceneTest, BinaryFilesAndDataUris) {
  GltfFile file;
  file.add_shown_triangle({{"name", "m"}});
  const auto binary = load_scene(write("b.glb", file.glb()));
  EXPECT_EQ(binary.geometry.triangle_count(), 1u);
  EXPECT_EQ(binary.materials.at(binary.geometry.material[0]).name, "m");
  GltfFile embedded;
  // Nine floats: (0,0,0) (1,0,0) (0,1,0).
  const std::string data = "data:application/gltf-buffer;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
  embedded.json["buffers"] = {{{"byteLength", 36}, {"uri", data}}};
  embedded.add("bufferViews", {{"buffer", 0}, {"byteLength", 36}});
  embedded.add("accessors", {{"bufferView", 0}, {"componentType", 5126}, {"type", "VEC3"}, {"count", 3}});
  embedded.add("meshes", {{"primitives", {{{"attributes", {{"POSITION", 0}}}}}}});
  embedded.add("nodes", {{"mesh", 0}});
  const auto d = load_scene(write("c.gltf", embedded.json.dump()));
  ASSERT_EQ(d.geometry.triangle_count(), 1u);
  EXPECT_FLOAT_EQ(d.geometry.area(0), 0.5f);
}

TEST_F(GltfSceneTest, FileNamesArePercentDecoded) {
  GltfFile file;
  file.add_shown_triangle(json::object());
  write("my data.bin", file.bytes);
  EXPECT_EQ(load_scene(write("d.gltf", file.text("my%20data.bin"))).geometry.triangle_count(), 1u);
}

TEST_F(GltfSceneTest, InstancesOfTheGpuExtension) {
  GltfFile file;
  const int translations = file.add_accessor<float>({0, 0, 0, 5, 0, 0}, 5126, "VEC3", 2);
  file.add("nodes", {{"mesh", file.add_triangle()},
                     {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", translations}}}}}}}});
  const auto d = load(file);
  ASSERT_EQ(d.geometry.triangle_count(), 2u);
  expect_near(d.geometry.positions[d.geometry.triangles[1][0]], {5, 0, 0});
}

TEST_F(GltfSceneTest, BillionsOfInstancesEndAtOnce) {
  // Places without bytes in the file, all zero.
  constexpr int kPlaces = 1 << 20, kNodes = 2000;
  for (const bool shown : {false, true}) {
    GltfFile file;
    const int mesh = file.add_triangle(shown ? nlohmann::json::object() : nlohmann::json{{"mode", 0}});
    const int places = file.add("accessors", {{"componentType", 5126}, {"type", "VEC3"}, {"count", kPlaces}});
    file.add("nodes", {{"mesh", file.add_triangle()}});
    for (int i = 0; i < kNodes; ++i)
      file.add("nodes", {{"mesh", mesh},
                         {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", places}}}}}}}});
    const std::clock_t start = std::clock();
    if (shown)
      EXPECT_THAT(message_of(write("instances.glb", file.glb())), HasSubstr("triangles of instances"));
    else
      EXPECT_EQ(load(file).geometry.triangle_count(), 1u);
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 2);
  }
}

TEST_F(GltfSceneTest, MaterialsTakeMemoryOfTheBudget) {
  GltfFile file;
  file.add_shown_triangle(nlohmann::json::object());
  for (int i = 0; i < 3000; ++i) file.add("materials", nlohmann::json::object());
  const std::string path = write("materials.glb", file.glb());
  ImportOptions options;
  options.budget = loading_budget(8'000'000);
  EXPECT_NO_THROW(load_scene(path, options));
  options.budget = loading_budget(2'500'000);
  try {
    load_scene(path, options);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("of materials"));
  }
}

TEST_F(GltfSceneTest, MorphTargetsByTheWeightsOfNodesMeshesAndAnimations) {
  GltfFile file;
  const int target = file.add_accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, 5126, "VEC3", 3);
  const int mesh = file.add_triangle({{"targets", {{{"POSITION", target}}}}});
  file.json["meshes"][static_cast<std::size_t>(mesh)]["weights"] = {0.25};
  file.add("nodes", {{"mesh", mesh}, {"translation", {0, 0, 10}}});
  file.add("nodes", {{"mesh", mesh}, {"weights", {0.5}}});
  file.add("nodes", {{"mesh", mesh}});
  // A cubic spline whose first value is 0.75, between two tangents.
  const int times = file.add_accessor<float>({0.5, 1}, 5126, "SCALAR", 2);
  const int values = file.add_accessor<float>({9, 0.75, 9, 9, 1, 9}, 5126, "SCALAR", 6);
  file.json["animations"] = {{{"samplers", {{{"input", times}, {"output", values}, {"interpolation", "CUBICSPLINE"}}}},
                              {"channels", {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "weights"}}}}}}}};
  const auto d = load(file);
  ASSERT_EQ(d.geometry.triangle_count(), 3u);
  for (std::uint32_t i = 0; i < 3; ++i)
    EXPECT_FLOAT_EQ(d.geometry.positions[d.geometry.triangles[i][0]].z, (std::array{10.25f, 0.5f, 0.75f})[i]);
  EXPECT_THAT(d.notes, HasNote("animation: the first moment is shown"));
}

/// A triangle with a skin of two joints: the first corner follows the first joint, the others follow both equally.
GltfFile skinned() {
  GltfFile file;
  const int joints = file.add_accessor<std::uint8_t>({0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, 5121, "VEC4", 3);
  const int weights = file.add_accessor<float>({1, 0, 0, 0, 0.5, 0.5, 0, 0, 0.5, 0.5, 0, 0}, 5126, "VEC4", 3);
  const int mesh = file.add_triangle({{"attributes", {{"JOINTS_0", joints}, {"WEIGHTS_0", weights}}}});
  // The inverse of a place at (0, 0, 1) for both.
  std::vector<float> inverses;
  for (int i = 0; i < 2; ++i)
    for (const float x : {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 1}) inverses.push_back(x);
  const int matrices = file.add_accessor<float>(inverses, 5126, "MAT4", 2);
  file.add("nodes", {{"mesh", mesh}, {"skin", 0}, {"translation", {100, 0, 0}}});
  file.add("nodes", {{"translation", {0, 0, 1}}, {"children", {2}}});
  file.add("nodes", {{"translation", {0, 2, 0}}});
  file.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", matrices}}};
  return file;
}

TEST_F(GltfSceneTest, SkinsFollowTheirJoints) {
  GltfFile file = skinned();
  const int times = file.add_accessor<float>({0}, 5126, "SCALAR", 1);
  const int moved = file.add_accessor<float>({0, 4, 0}, 5126, "VEC3", 1);
  const auto corner = [&](const SceneDescription& d, std::size_t c) {
    return d.geometry.positions[d.geometry.triangles[0][c]];
  };
  const auto still = load(file);
  expect_near(corner(still, 0), {0, 0, 0});
  expect_near(corner(still, 1), {1, 1, 0});  // half way to the joint, which stands 2 up; the node's place is not used
  expect_near(corner(still, 2), {0, 2, 0});
  file.json["animations"] = {{{"samplers", {{{"input", times}, {"output", moved}}}},
                              {"channels", {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "translation"}}}}}}}};
  expect_near(corner(load(file), 1), {1, 2, 0});
}

TEST_F(GltfSceneTest, DamagedPosesAreErrors) {
  GltfFile file = skinned();
  file.json["skins"][0]["joints"] = {1, 7};
  EXPECT_THAT(refusal(file), HasSubstr("skins[0].joints[1] is 7"));
  file.json["skins"][0]["joints"] = {1};
  EXPECT_THAT(refusal(file), HasSubstr("names joint 1, but the skin has 1"));
  file.json["skins"][0]["inverseBindMatrices"] = 99;
  EXPECT_THAT(refusal(file), HasSubstr("skins[0].inverseBindMatrices is 99"));
  file = skinned();
  file.json["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "scale"}}}}}}}};
  EXPECT_THAT(refusal(file), HasSubstr("animations[0].channels[0].sampler"));
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 77}}};
  EXPECT_THAT(refusal(file), HasSubstr("targets[0].POSITION is 77"));
  for (const bool in_bytes : {false, true}) {
    file = skinned();
    file.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] =
        in_bytes ? file.add_accessor<std::int8_t>({0, 0, 0, 0, -1, 1, 0, 0, 0, 1, 0, 0}, 5120, "VEC4", 3)
                 : file.add_accessor<float>({0, 0, 0, 0, -1, 1, 0, 0, 0, 1, 0, 0}, 5126, "VEC4", 3);
    EXPECT_THAT(refusal(file), HasSubstr("vertex 1 names joint -1, but the skin has 2"));
  }
}

TEST_F(GltfSceneTest, VariantsAreNamed) {
  GltfFile file;
  file.add("nodes", {{"mesh", file.add_triangle()}});
  file.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "beach"}}, {{"name", "street"}}};
  file.json["extensionsUsed"] = {"KHR_materials_variants"};
  EXPECT_THAT(load(file).notes, HasNote("variants of materials (\"beach\", \"street\")"));
}

TEST_F(GltfSceneTest, NotesNameWhatIsLeftOut) {
  GltfFile file;
  file.add("nodes", {{"mesh", file.add_triangle()}});
  file.json["extensionsUsed"] = {"KHR_made_up", "KHR_texture_transform"};
  file.json["animations"] = {{{"channels", json::array()}, {"samplers", json::array()}}};
  const auto d = load(file);
  EXPECT_THAT(d.notes, HasNote("KHR_made_up is not supported"));
  EXPECT_THAT(d.notes, testing::Not(HasNote("KHR_texture_transform")));
  EXPECT_THAT(d.notes, HasNote("animation"));
}

TEST_F(GltfTest, HiddenNodesAndTheirChildrenAreNotShown) {
  GltfFile file;
  const int mesh = file.add_triangle();
  const auto visibility = [](bool visible) { return nlohmann::json{{"KHR_node_visibility", {{"visible", visible}}}}; };
  file.add("nodes", {{"mesh", mesh}, {"extensions", visibility(true)}});
  file.add("nodes", {{"children", {2}}, {"extensions", visibility(false)}, {"translation", {5, 0, 0}}});
  file.add("nodes", {{"mesh", mesh}, {"extensions", visibility(true)}});
  file.json["extensionsUsed"] = file.json["extensionsRequired"] = {"KHR_node_visibility"};
  file.add("scenes", {{"nodes", {0, 1}}});
  const auto d = load(file);
  ASSERT_EQ(d.geometry.triangle_count(), 1u);
  EXPECT_LT(d.geometry.bounds().max.x, 2);
  EXPECT_THAT(d.notes, HasNote("hidden mesh, left out"));
}

}  // namespace
}  // namespace glowworm
