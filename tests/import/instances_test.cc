// Meshes that files place many times.
#include <cmath>

#include "gltf_file.h"
#include "import/scene_changes.h"

namespace glowworm {
namespace {

using nlohmann::json;

/// Compares scenes triangle by triangle.
void expect_same_triangles(const Geometry& a, const Geometry& b) {
  ASSERT_EQ(a.triangle_count(), b.triangle_count());
  for (std::uint32_t t = 0; t < a.triangle_count(); ++t) {
    const auto p = a.corners(t), q = b.corners(t), m = a.corner_normals(t), n = b.corner_normals(t);
    for (std::size_t c = 0; c < 3; ++c) {
      ASSERT_LT(length(p[c] - q[c]), 1e-5f) << t;
      ASSERT_LT(length(m[c] - n[c]), 1e-4f) << t;
    }
    ASSERT_EQ(a.material_of(t), b.material_of(t)) << t;
    ASSERT_EQ(a.emission_of(t), b.emission_of(t)) << t;
    const TexturePoint u = texture_point(a, t, {0.2f, 0.3f}), v = texture_point(b, t, {0.2f, 0.3f});
    ASSERT_TRUE(length(Vec3{u.uv.x - v.uv.x, u.uv.y - v.uv.y, 0}) < 1e-5f) << t;
  }
}

class PbrtInstances : public FileTest {
 protected:
  /// A scene whose object is an object, or is written out at each place.
  SceneDescription load(bool as_object, const std::string& shapes, const std::vector<std::string>& places) const {
    std::string text =
        "WorldBegin\nMakeNamedMaterial \"a\" \"string type\" \"diffuse\"\n"
        "MakeNamedMaterial \"b\" \"string type\" \"conductor\"\nNamedMaterial \"a\"\n"
        "Shape \"disk\"\n";
    if (as_object) text += "ObjectBegin \"thing\"\n" + shapes + "ObjectEnd\n";
    for (const std::string& place : places)
      text +=
          "AttributeBegin\n" + place + (as_object ? "\nObjectInstance \"thing\"\n" : "\n" + shapes) + "AttributeEnd\n";
    return load_scene(write("scene.pbrt", text));
  }
};

const std::vector<std::string> kPlaces = {"Translate 1 2 3",
                                          "Translate 0 4 0 Rotate 30 1 2 3",
                                          "Scale -1 2 0.5",
                                          "ConcatTransform [1 0.2 0 0  0.3 1 0 0  0 0.4 1 0  5 6 7 1]",
                                          "Translate -3 0 0 Scale 1 1 -1",
                                          "Scale 1 0 1"};
constexpr const char* kShapes =
    "Shape \"sphere\" \"float radius\" 0.5\nNamedMaterial \"b\"\nAttributeBegin Translate 0 0 1 ReverseOrientation\n"
    "Shape \"cylinder\" \"float radius\" 0.2 AttributeEnd\nShape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] "
    "\"integer indices\" [0 1 2]\n";

TEST_F(PbrtInstances, AreTheirShapesAtTheirPlaces) {
  const SceneDescription kept = load(true, kShapes, kPlaces), copied = load(false, kShapes, kPlaces);
  // The first place and the flattened one are copies. Of the others, two are mirrored.
  EXPECT_EQ(kept.geometry.instances.size(), 4u);
  EXPECT_EQ(kept.geometry.meshes.size(), 2u);
  // The flattened copy comes before the instances.
  const std::vector<std::string> unflat(kPlaces.begin(), kPlaces.end() - 1);
  expect_same_triangles(load(true, kShapes, unflat).geometry, load(false, kShapes, unflat).geometry);
  EXPECT_EQ(kept.geometry.triangle_count(), copied.geometry.triangle_count());
  const Geometry& g = kept.geometry;
  EXPECT_EQ(g.objects[g.object_of(g.instances[2].first)].name, "thing 3");
  EXPECT_EQ(g.object_of(g.instances[2].first - 1), g.object_of(g.instances[2].first) - 1);
}

TEST_F(PbrtInstances, LeaveOutWhatIsAbsent) {
  const std::string shapes = std::string(kShapes) + "Material \"interface\" Shape \"sphere\" \"float radius\" 3\n";
  const std::vector<std::string> places(kPlaces.begin(), kPlaces.end() - 1);
  expect_same_triangles(load(true, shapes, places).geometry, load(false, shapes, places).geometry);
  const SceneDescription gone = load(true, "Material \"interface\" Shape \"sphere\"\n", places);
  EXPECT_TRUE(gone.geometry.instances.empty());
  EXPECT_TRUE(gone.geometry.meshes.empty());
}

TEST_F(PbrtInstances, KeepTheirShapeFarAway) {
  const std::string there = "Translate 1e6 2e6 3e6", back = "Translate -1e6 -2e6 -3e6\n";
  const std::string shapes = "AttributeBegin\n" + there + "\n" + kShapes + "AttributeEnd\n";
  const std::vector<std::string> places = {back, "Translate 1 2 3 " + back, "Rotate 30 1 0 0 " + back};
  const SceneDescription kept = load(true, shapes, places), copied = load(false, shapes, places);
  EXPECT_EQ(kept.geometry.instances.size(), 2u);
  expect_same_triangles(kept.geometry, copied.geometry);
}

/// A mesh of a smooth grid of n * n quads and a lamp.
json grid_and_lamp(GltfFile& file, int n) {
  std::vector<float> positions, normals, uvs;
  std::vector<std::uint32_t> indices;
  const auto side = static_cast<std::uint32_t>(n + 1);
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(n), v = static_cast<float>(y) / static_cast<float>(n);
      positions.insert(positions.end(), {u, v, 0.1f * std::sin(5 * u)});
      normals.insert(normals.end(), {0, 0.6f, 0.8f});
      uvs.insert(uvs.end(), {u, v});
    }
  for (std::uint32_t y = 0; y + 1 < side; ++y)
    for (std::uint32_t x = 0; x + 1 < side; ++x) {
      const std::uint32_t a = y * side + x, b = a + 1, c = b + side, d = a + side;
      indices.insert(indices.end(), {a, b, c, a, c, d});
    }
  const std::size_t count = uvs.size() / 2;
  const auto accessor = [&](const std::vector<float>& values, const char* type) {
    return file.add_accessor<float>(values, 5126, type, count);
  };
  const json attributes = {{"POSITION", accessor(positions, "VEC3")},
                           {"NORMAL", accessor(normals, "VEC3")},
                           {"TEXCOORD_0", accessor(uvs, "VEC2")}};
  const int corners = file.add_accessor<std::uint32_t>(indices, 5125, "SCALAR", indices.size());
  const int lamp = file.add("materials", {{"emissiveFactor", {1, 1, 1}}, {"name", "lamp"}});
  const int last = file.add_accessor<std::uint32_t>({0, 1, 2}, 5125, "SCALAR", 3);
  const int wood = file.add("materials", {{"name", "wood"}});
  return {{"name", "grid"},
          {"primitives",
           {{{"attributes", attributes}, {"indices", last}, {"material", lamp}},
            {{"attributes", attributes}, {"indices", corners}, {"material", wood}}}}};
}

class GltfInstances : public GltfTest {
 protected:
  /// Nodes that share a mesh, or have one each.
  static GltfFile nodes(bool shared) {
    GltfFile file;
    const json mesh = grid_and_lamp(file, 6);
    const json places = {{{"translation", {1, 2, 3}}},
                         {{"rotation", {0, 0.6, 0, 0.8}}},
                         {{"scale", {-1, 1, 2}}},
                         {{"matrix", {1, 0.2, 0, 0, 0.3, 1, 0, 0, 0, 0.4, 1, 0, 5, 6, 7, 1}}}};
    for (json node : places) {
      if (!shared || !file.json.contains("meshes")) file.add("meshes", mesh);
      node["mesh"] = file.json["meshes"].size() - 1;
      file.add("nodes", node);
    }
    // The last two below another node.
    file.add("nodes", {{"children", {2, 3}}, {"translation", {0, 0, -4}}, {"scale", {1, 1, -1}}});
    file.json["scenes"] = {{{"nodes", {0, 1, 4}}}};
    return file;
  }
};

/// In any order.
void expect_same_sets(const Geometry& a, const Geometry& b) {
  ASSERT_EQ(a.triangle_count(), b.triangle_count());
  const auto sums = [](const Geometry& g) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::array<double, 8>> out;
    for (std::uint32_t t = 0; t < g.triangle_count(); ++t) {
      std::array<double, 8>& sum = out[{g.material_of(t), g.emission_of(t)}];
      const auto corners = g.corners(t), normals = g.corner_normals(t);
      const Vec3 n = g.scaled_normal(t), m = normals[0] + normals[1] + normals[2];
      const Vec3 middle = (corners[0] + corners[1] + corners[2]) / 3;
      sum[0] += 1;
      for (int i = 0; i < 3; ++i) {
        sum[1 + static_cast<std::size_t>(i)] += n[i] * middle[(i + 1) % 3];
        sum[4 + static_cast<std::size_t>(i)] += m[i] * middle[i];
      }
      sum[7] += dot(n, m);
    }
    return out;
  };
  const auto x = sums(a), y = sums(b);
  ASSERT_EQ(x.size(), y.size());
  for (auto i = x.begin(), j = y.begin(); i != x.end(); ++i, ++j) {
    EXPECT_EQ(i->first, j->first);
    for (std::size_t k = 0; k < 8; ++k) EXPECT_NEAR(i->second[k], j->second[k], 1e-3 * std::abs(j->second[k]) + 1e-3);
  }
}

TEST_F(GltfInstances, AreNodesThatShareAMesh) {
  const SceneDescription kept = load(nodes(true)), copied = load(nodes(false));
  EXPECT_EQ(kept.geometry.instances.size(), 3u);
  EXPECT_TRUE(copied.geometry.instances.empty());
  expect_same_sets(kept.geometry, copied.geometry);
  std::size_t lamps = 0;
  for (std::uint32_t t = 0; t < kept.geometry.triangles.size(); ++t) lamps += kept.geometry.emission[t] != kNone;
  EXPECT_EQ(lamps, 4u) << "lamps of instances shine";
  SceneDescription whole = kept;
  SceneChanges changes;
  changes.expand_instances = true;
  change_scene(whole, changes, std::make_shared<MemoryBudget>());
  EXPECT_TRUE(whole.geometry.instances.empty());
  expect_same_triangles(whole.geometry, kept.geometry);
}

TEST_F(GltfInstances, OfTheGpuExtensionTakeMemoryOnce) {
  constexpr int kPlaced = 500;
  GltfFile file;
  file.add("meshes", grid_and_lamp(file, 40));
  std::vector<float> places;
  for (int i = 0; i < kPlaced; ++i) places.insert(places.end(), {2.0f * static_cast<float>(i), 0, 0});
  const int translations = file.add_accessor<float>(places, 5126, "VEC3", kPlaced);
  const json attributes = {{"TRANSLATION", translations}};
  file.add("nodes", {{"mesh", 0}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", attributes}}}}}});
  // 3,200 triangles at 500 places would take 380 MB.
  ImportOptions options;
  options.budget = std::make_shared<MemoryBudget>(std::uint64_t{20} << 20);
  const SceneDescription d = load_scene(write_gltf(file), options);
  EXPECT_EQ(d.geometry.instances.size(), kPlaced - 1u);
  EXPECT_EQ(d.geometry.triangle_count(), kPlaced * (3200u + 1));
  EXPECT_LT(length(d.geometry.corners(d.geometry.instances[9].first)[0] - Vec3{20, 0, 0}), 1e-5f);
}

TEST_F(GltfInstances, AreCopiesWhereThatIsSmaller) {
  GltfFile file;
  const int mesh = file.add_triangle();
  for (int i = 0; i < 5; ++i) file.add("nodes", {{"mesh", mesh}, {"translation", {i, 0, 0}}});
  const SceneDescription d = load(file);
  EXPECT_TRUE(d.geometry.instances.empty());
  EXPECT_EQ(d.geometry.triangles.size(), 5u);
}

}  // namespace
}  // namespace glowworm
