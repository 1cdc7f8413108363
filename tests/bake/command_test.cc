// glowworm bake, as a person runs it.
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "image/image.h"
#include "import/gltf_file.h"
#include "import/import.h"

namespace glowworm {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A GLB file in parts.
struct BakedGlb {
  nlohmann::json json;
  std::string buffer;

  explicit BakedGlb(const std::string& bytes) {
    std::uint32_t size = 0;
    bytes.copy(reinterpret_cast<char*>(&size), sizeof size, 12);
    json = nlohmann::json::parse(bytes.substr(20, size));
    buffer = bytes.substr(28 + size);
  }

  const nlohmann::json& item(const char* list, const nlohmann::json& index) const {
    return json.at(list).at(index.get<std::size_t>());
  }
};

/// Two triangles of glass and of metal, in pbrt's format.
constexpr const char* kGlassAndMetal = R"(
WorldBegin
Material "dielectric" "rgb transmittance" [1 0.5 0.25]
Shape "trianglemesh" "point3 P" [0 0 5  1 0 5  1 1 5] "integer indices" [0 1 2]
Material "conductor" "rgb eta" [0.2 0.9 1.5] "rgb k" [3.9 2.5 1.9] "float roughness" 0.3 "bool remaproughness" false
Shape "trianglemesh" "point3 P" [0 0 5  1 1 5  0 1 5] "integer indices" [0 1 2]
)";

class BakeCommand : public ProgramTest {
 protected:
  static std::vector<std::string> words(std::vector<std::string> more) {
    std::vector<std::string> all{"bake", "builtin:cornell", "--atlas", "64", "--samples", "1", "--photons", "5k"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  /// Bakes a scene under a white sky to lit.glb.
  BakedGlb bake(const std::string& scene, const std::string& format) const {
    const Outcome outcome = run({"bake", scene, "--environment", "1,1,1", "--format", format, "--exposure", "0",
                                 "--atlas", "64", "--samples", "1", "--photons", "5k", "-o", "lit.glb"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return BakedGlb(read(path("lit.glb")));
  }
  /// Bakes a square of the materials "picture" and "plain". @param library with these, in MTL's format
  BakedGlb bake_square(const std::string& library, const std::string& format) const {
    write("room.mtl", library);
    write("room.obj",
          "mtllib room.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
          "usemtl picture\nf 1/1 2/2 3/3\nusemtl plain\nf 1/1 3/3 4/4\n");
    return bake("room.obj", format);
  }
  /// What a material shows of a picture of the scene: its light, or else its base colour.
  std::vector<RGB> shown_texels(const BakedGlb& file, const nlohmann::json& material) const {
    const bool glows = material.contains("emissiveTexture");
    const nlohmann::json& base = material.at("pbrMetallicRoughness");
    const nlohmann::json& texture = glows ? material.at("emissiveTexture") : base.at("baseColorTexture");
    EXPECT_EQ(texture.value("texCoord", 0), 0);
    const nlohmann::json& image = file.item("images", file.item("textures", texture.at("index")).at("source"));
    const nlohmann::json& view = file.item("bufferViews", image.at("bufferView"));
    const std::size_t begin = view.at("byteOffset").get<std::size_t>(), size = view.at("byteLength").get<std::size_t>();
    std::vector<RGB> out = read_image(write("shown.png", file.buffer.substr(begin, size))).rgb();
    const auto factor = (glows ? material.at("emissiveFactor") : base.at("baseColorFactor")).get<std::vector<float>>();
    const float strength =
        glows ? material.at("extensions").at("KHR_materials_emissive_strength").at("emissiveStrength").get<float>() : 1;
    for (RGB& c : out) c *= RGB(factor.at(0), factor.at(1), factor.at(2)) * strength;
    return out;
  }
};
using SlowBakeCommand = BakeCommand;

TEST_F(BakeCommand, WritesAFileInEveryFormat) {
  for (const char* format : {"emissive", "unlit", "lightmap", "vertex"}) {
    const Outcome outcome = run(words({"--format", format, "-o", "lit.glb", "--atlas-picture", "light.png"}));
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("texels per metre"));
    EXPECT_EQ(read(path("lit.glb")).substr(0, 4), "glTF");
    EXPECT_EQ(read(path("light.png")).substr(1, 3), "PNG");
    EXPECT_EQ(run({"info", "lit.glb"}).status, 0);
  }
  const Outcome probes = run({"bake", "builtin:cornell", "--format", "probes", "--spacing", "0.2", "--texture", "exr",
                              "--samples", "1", "--photons", "5k", "-o", "probes.json"});
  EXPECT_EQ(probes.status, 0) << probes.err;
  const nlohmann::json grid = read_json("probes.json");
  ASSERT_EQ(grid["probes"].size(), 8u);
  const Image picture = read_image(path("probes.exr"));
  EXPECT_EQ(picture.metadata.at("spacing"), grid["spacing"].dump());
  const std::vector<RGB> coefficient = picture.rgb("Y3");
  ASSERT_EQ(coefficient.size(), 8u);
  for (std::size_t i = 0; i < coefficient.size(); ++i)
    EXPECT_NEAR(coefficient[i].g, grid["probes"][i].is_null() ? 0 : grid["probes"][i][3][1].get<float>(), 1e-3);
}

TEST_F(BakeCommand, WritesTexturesOfFullRangeBesideTheFile) {
  const Outcome outcome = run(words({"--texture", "exr", "-o", "lit.glb", "--atlas-picture", "light.exr"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read_image(path("lit.0.exr")).rgb(), read_image(path("light.exr")).rgb());
  EXPECT_THAT(read(path("lit.glb")), HasSubstr(R"("light":{"file":"lit.0.exr","texCoord":1})"));
  const Outcome same = run(words({"--texture", "exr", "-o", "a.glb", "--atlas-picture", "a.0.exr"}));
  EXPECT_TRUE(refused(same, {"a.0.exr"}, 2));
  EXPECT_TRUE(refused(run(words({"--texture", "exr", "--format", "vertex", "-o", "a.glb"})), {"no textures"}, 2));
}

TEST_F(BakeCommand, KeepsTheTextureCoordinatesOfTexturesOnly) {
  ASSERT_EQ(run(words({"-o", "lit.glb", "--atlas-picture", "light.png"})).status, 0);
  const BakedGlb file = bake_square("newmtl picture\nmap_Kd light.png\nnewmtl plain\nKd 0.5 0.5 0.5\n", "lightmap");
  std::size_t primitives = 0;
  for (const auto& mesh : file.json.at("meshes"))
    for (const auto& primitive : mesh.at("primitives")) {
      const auto& attributes = primitive.at("attributes");
      const bool own = file.item("materials", primitive.at("material")).at("name") == "picture";
      EXPECT_EQ(attributes.at("TEXCOORD_0") != attributes.at("TEXCOORD_1"), own);
      ++primitives;
    }
  EXPECT_EQ(primitives, 2u);
}

TEST_F(SlowBakeCommand, KeepsPicturesOfTheLightOfScreens) {
  write("screen.png", encode_png(2, 1, 3, {0, 0, 0, 255, 255, 255}, {}));
  // A lamp, and a surface that reflects, too: only its irradiance lacks its own light.
  const std::string light = "Ke 0.8 0.4 0.2\nmap_Ke screen.png\n";
  const std::string library = "newmtl picture\nKd 0 0 0\n" + light + "newmtl plain\nKd 0.5 0.5 0.5\n" + light;
  const RGB bright{0.8f, 0.4f, 0.2f};
  for (const std::string format : {"emissive", "unlit", "vertex", "lightmap"}) {
    const BakedGlb file = bake_square(library, format);
    std::size_t screens = 0;
    for (const auto& mesh : file.json.at("meshes"))
      for (const auto& primitive : mesh.at("primitives")) {
        const auto& material = file.item("materials", primitive.at("material"));
        const bool glows = format == "lightmap" && material.contains("emissiveTexture");  // Its back does not.
        if (material.at("name") == "plain" && !glows) continue;
        ++screens;
        const auto& attributes = primitive.at("attributes");
        ASSERT_TRUE(attributes.contains("TEXCOORD_0")) << format;
        EXPECT_TRUE(!attributes.contains("TEXCOORD_1") || attributes.at("TEXCOORD_0") != attributes.at("TEXCOORD_1"));
        const std::vector<RGB> shown = shown_texels(file, material);
        ASSERT_EQ(shown.size(), 2u);
        EXPECT_LT(max_component(shown[0]), 0.01f) << format;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(shown[1][c], bright[c], 0.01f) << format;
      }
    EXPECT_GE(screens, format == "lightmap" ? 2u : 1u);
  }
}

TEST_F(BakeCommand, KeepsTheColoursOfGlassAndMetal) {
  write("room.pbrt", kGlassAndMetal);
  const auto reflectance = [](float eta, float k) {
    return ((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k);
  };
  // Facets of GGX with alpha 0.3 return the share 1 - kLost at once, at normal incidence. The rest meets two facets or
  // more.
  constexpr float kLost = 0.123f;
  const RGB glass{1, 0.5f, 0.25f};
  RGB metal(reflectance(0.2f, 3.9f), reflectance(0.9f, 2.5f), reflectance(1.5f, 1.9f));
  for (int c = 0; c < 3; ++c) metal[c] *= 1 - kLost * (1 - metal[c]);
  for (const char* format : {"lightmap", "vertex"}) {
    const BakedGlb file = bake("room.pbrt", format);
    std::size_t metals = 0;
    for (const auto& material : file.json.at("materials")) {
      const bool is_metal = material.at("name") == "conductor";
      metals += is_metal;
      const auto base = material.at("pbrMetallicRoughness").at("baseColorFactor").get<std::vector<float>>();
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(base.at(static_cast<std::size_t>(c)), (is_metal ? metal : glass)[c], 0.02f) << format;
    }
    EXPECT_GE(metals, 1u);
    EXPECT_GT(file.json.at("materials").size(), metals);
  }
}

TEST_F(BakeCommand, KeepsTheFieldsOfViewOfCameras) {
  const float narrow = std::tan(kPi / 6);
  write("room.pbrt", std::string(R"(Camera "perspective" "float fov" 60
Film "rgb" "integer xresolution" 90 "integer yresolution" 160)") +
                         kGlassAndMetal);
  const auto upright = bake("room.pbrt", "vertex").json.at("cameras").at(0).at("perspective");
  EXPECT_NEAR(upright.at("yfov").get<float>(), 2 * std::atan(narrow * 160 / 90), 1e-4f);
  EXPECT_NEAR(upright.at("aspectRatio").get<float>(), 90.0f / 160, 1e-4f);
  EXPECT_NEAR(load_scene(path("lit.glb")).cameras.at(0).half_extent, narrow, 1e-4f);
  write("room.pbrt", std::string(R"(Camera "orthographic" "float screenwindow" [-2 2 -0.5 0.5]
Film "rgb" "integer xresolution" 160 "integer yresolution" 40)") +
                         kGlassAndMetal);
  const auto flat = bake("room.pbrt", "vertex").json.at("cameras").at(0).at("orthographic");
  EXPECT_NEAR(flat.at("xmag").get<float>(), 2, 1e-4f);
  EXPECT_NEAR(flat.at("ymag").get<float>(), 0.5f, 1e-4f);
}

TEST_F(BakeCommand, GoesOnFromACheckpointToTheSameFile) {
  const std::vector<std::string> line = words({"-o", "lit.glb", "--resume", "bake.checkpoint"});
  EXPECT_EQ(run(line).status, 0);
  const std::string once = read(path("lit.glb"));
  EXPECT_EQ(run(line).status, 0);
  EXPECT_EQ(read(path("lit.glb")), once);
}

/// A bake of the Cornell box that 64 MB hold in bands.
std::vector<std::string> banded(const std::string& memory, const std::vector<std::string>& more = {}) {
  std::vector<std::string> line{"bake", "builtin:cornell", "--atlas", "256", "--samples", "2", "--gather", "4"};
  line.insert(line.end(), {"--photons", "5k", "-o", "lit.glb", "--atlas-picture", "light.exr", "--memory", memory});
  line.insert(line.end(), {"--threads", "2"});  // each takes some of the memory
  line.insert(line.end(), more.begin(), more.end());
  return line;
}

TEST_F(BakeCommand, GivesTheSameLightInLittleMemory) {
  ASSERT_EQ(run(banded("1G")).status, 0);
  const std::vector<RGB> whole = read_image(path("light.exr")).rgb();
  const Outcome bands = run(banded("64M"));
  ASSERT_EQ(bands.status, 0) << bands.err;
  EXPECT_THAT(bands.err, HasSubstr("rows 256 of 256, as --memory allows"));
  EXPECT_TRUE(read_image(path("light.exr")).rgb() == whole);
  EXPECT_TRUE(refused(run(banded("2M")), {"--memory"}));
}

TEST_F(BakeCommand, GoesOnFromACheckpointOfABand) {
  ASSERT_EQ(run(banded("1G")).status, 0);
  const std::vector<RGB> whole = read_image(path("light.exr")).rgb();
  // A checkpoint of an early band, as an interrupted bake leaves it: for little memory, and for much.
  Running bake(folder_, banded("64M", {"--resume", "bake.checkpoint"}));
  ASSERT_TRUE(bake.wait_for_text("rows 192 of 256", 60));
  bake.send(SIGINT);
  bake.wait();
  std::filesystem::copy_file(path("bake.checkpoint"), path("copy.checkpoint"));
  std::filesystem::remove(path("light.exr"));
  for (const char* memory : {"1G", "64M"}) {
    std::filesystem::copy_file(path("copy.checkpoint"), path("bake.checkpoint"),
                               std::filesystem::copy_options::overwrite_existing);
    const Outcome rest = run(banded(memory, {"--resume", "bake.checkpoint"}));
    ASSERT_EQ(rest.status, 0) << rest.err;
    EXPECT_THAT(rest.err, Not(HasSubstr("rows 96 of 256")));
    EXPECT_TRUE(read_image(path("light.exr")).rgb() == whole) << memory;
  }
  EXPECT_TRUE(refused(run(words({"-o", "a.glb", "--resume", "bake.checkpoint"})), {"checkpoint", "--atlas"}));
}

TEST_F(BakeCommand, MergesPartsToTheSameFile) {
  const auto of_samples = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"bake", "builtin:cornell", "--atlas", "64", "--samples", "3", "--photons", "5k"});
    return run(more);
  };
  ASSERT_EQ(of_samples({"-o", "lit.glb", "--atlas-picture", "whole.exr"}).status, 0);
  ASSERT_EQ(of_samples({"--part", "1/2", "-o", "1.part"}).status, 0);
  const Outcome second = of_samples({"--part", "2/2", "-o", "2.part"});
  ASSERT_EQ(second.status, 0) << second.err;
  ASSERT_EQ(run({"merge", "2.part", "1.part", "-o", "all.part"}).status, 0);
  const std::vector<std::string> bake{"bake", "builtin:cornell", "--atlas", "64"};
  const auto from = [&](std::vector<std::string> more) {
    more.insert(more.begin(), bake.begin(), bake.end());
    more.insert(more.end(), {"--from", "all.part", "-o", "merged.glb"});
    return run(more);
  };
  const Outcome merged = from({"--atlas-picture", "merged.exr"});
  ASSERT_EQ(merged.status, 0) << merged.err;
  EXPECT_TRUE(read_image(path("merged.exr")).rgb() == read_image(path("whole.exr")).rgb());
  EXPECT_TRUE(refused(from({"--light", "indirect"}), {"all.part", "--indirect-only"}));
  EXPECT_TRUE(refused(from({"--photons", "6k"}), {"all.part", "--photons"}));
  EXPECT_TRUE(refused(from({"--part", "1/2"}), {"--from"}, 2));
  EXPECT_TRUE(refused(run({"bake", "builtin:cornell", "--atlas", "32", "--from", "all.part", "-o", "a.glb"}),
                      {"points", "--atlas"}));
  EXPECT_TRUE(refused(of_samples({"--noise", "1%", "-o", "a.part"}), {"--samples"}, 2));
}

TEST_F(BakeCommand, TellsThatViewersAddNoLightToMostFormats) {
  for (const std::string format : {"emissive", "unlit", "vertex", "lightmap"}) {
    const Outcome outcome = run(words({"--format", format, "--light", "indirect", "-o", "lit.glb"}));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto note = HasSubstr("viewers add no direct light to --format " + format + "; for indirect light alone");
    if (format == "lightmap") {
      EXPECT_THAT(outcome.err, Not(HasSubstr("viewers add no direct light")));
    } else {
      EXPECT_THAT(outcome.err, note);
    }
  }
}

TEST_F(BakeCommand, SaysHowProbesNeedLessMemory) {
  EXPECT_TRUE(refused(run({"bake", "builtin:cornell", "--format", "probes", "--spacing", "0.01", "--memory", "64M",
                           "-o", "probes.json"}),
                      {"places of probes", "larger --spacing"}));
}

TEST_F(BakeCommand, GivesLightsTheIntensityForTheUnitsOfTheFile) {
  GltfFile file;
  file.add_shown_triangle(nlohmann::json::object());
  file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"intensity", kLuminousEfficacy}},
      {{"type", "directional"}, {"intensity", kLuminousEfficacy}}};
  for (const int light : {0, 1})
    file.add("nodes", {{"translation", {0, 0, 2}}, {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
  write("a.bin", file.bytes);
  write("a.gltf", file.text("a.bin"));
  const Outcome outcome = run({"bake", "a.gltf", "--scale", "0.5", "--format", "lightmap", "--light", "indirect",
                               "--exposure", "0", "--atlas", "64", "--samples", "1", "--photons", "5k", "-o", "a.glb"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json lights =
      BakedGlb(read(path("a.glb"))).json.at("extensions").at("KHR_lights_punctual").at("lights");
  EXPECT_NEAR(lights.at(0).at("intensity").get<float>(), 4, 1e-5f);
  EXPECT_NEAR(lights.at(1).at("intensity").get<float>(), 1, 1e-5f);
}

TEST_F(BakeCommand, KeepsCheckerboards) {
  write("room.pbrt", R"(
WorldBegin
Texture "board" "spectrum" "checkerboard" "rgb tex1" [0.8 0.4 0.2] "rgb tex2" [0.2 0.2 0.4]
  "float uscale" 4 "float vscale" 8 "float udelta" 0.5
Material "diffuse" "texture reflectance" "board"
Shape "trianglemesh" "point3 P" [0 0 5  1 0 5  1 1 5  0 1 5] "point2 uv" [0 0  1 0  1 1  0 1]
  "integer indices" [0 1 2  0 2 3]
)");
  for (const char* format : {"lightmap", "vertex"}) {
    const BakedGlb file = bake("room.pbrt", format);
    const nlohmann::json& material = file.json.at("materials").at(0);
    const nlohmann::json& place = material.at("pbrMetallicRoughness").at("baseColorTexture").at("extensions");
    // A picture of two by two cells; its rows run downwards, so that 8 rows of cells have no offset.
    const nlohmann::json expected = {{"offset", {0.25, -3}}, {"scale", {2, 4}}};
    EXPECT_EQ(place.at("KHR_texture_transform"), expected);
    const std::vector<RGB> board = shown_texels(file, material);
    const auto side = static_cast<std::size_t>(std::sqrt(board.size()));
    ASSERT_EQ(side * side, board.size());
    for (std::size_t i = 0; i < board.size(); ++i) {
      const bool even = (i % side < side / 2) == (i / side >= side / 2);
      const RGB cell = even ? RGB{0.8f, 0.4f, 0.2f} : RGB{0.2f, 0.2f, 0.4f};
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(board[i][c], cell[c], 0.01f) << i;
    }
  }
}

TEST_F(BakeCommand, WritesTexturesWithAMultiplierBesideTheFile) {
  const Outcome outcome = run(words({"--texture", "rgbm", "-o", "lit.glb", "--atlas-picture", "light.exr"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(read(path("lit.0.rgbm.png")).substr(1, 3), "PNG");
  const std::string glb = read(path("lit.glb")), mark = R"("light":{"file":"lit.0.rgbm.png","rgbm":)";
  const std::size_t at = glb.find(mark);
  ASSERT_NE(at, std::string::npos);
  const std::vector<RGB> light = read_image(path("light.exr")).rgb();
  float peak = 0;
  for (const RGB& texel : light) peak = std::max(peak, max_component(texel));
  EXPECT_NEAR(std::stof(glb.substr(at + mark.size())), peak, 1e-3f * peak);
  EXPECT_TRUE(refused(run(words({"--texture", "ktx2", "-o", "a.glb"})), {"KTX2", "--texture rgbm"}, 2));
}

TEST_F(BakeCommand, SaysWhatIsWrongWithACommandLine) {
  const auto refuses = [&](const std::vector<std::string>& more, const char* text) {
    const Outcome outcome = run(words(more));
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(text));
  };
  refuses({"-o", "lit.png"}, "does not end in .glb or .part");
  refuses({"-o", "lit.glb", "--format", "emisive"}, "Did you mean 'emissive'?");
  refuses({"-o", "lit.glb", "--light", "direct"}, "--light 'direct' is not known");
  refuses({"-o", "lit.glb", "--atlas", "64.5"}, "not a whole number");
  refuses({"-o", "lit.glb", "--atlas", "1"}, "not a whole number from 16");
  refuses({"-o", "lit.glb", "--texels-per-metre", "-1"}, "--texels-per-metre '-1'");
  refuses({"-o", "probes.json", "--format", "probes"}, "Give --spacing");
  refuses({"-o", "lit.glb", "--spacing", "0.5"}, "--spacing is for probes");
  refuses({"-o", "probes.json", "--format", "probes", "--spacing", "1"}, "no textures for --atlas");
  for (const std::vector<std::string>& of_textures : std::vector<std::vector<std::string>>{
           {"--exposure", "1"}, {"--texels-per-metre", "10"}, {"--atlas-picture", "light.exr"}}) {
    std::vector<std::string> line{"bake", "builtin:cornell", "--format", "probes", "--spacing", "1", "-o", "a.json"};
    line.insert(line.end(), of_textures.begin(), of_textures.end());
    EXPECT_TRUE(refused(run(line), {"no textures for " + of_textures[0]}, 2));
  }
  refuses({"-o", "lit.glb", "--atlas-picture", "lit.glb"}, "lit.glb");
  EXPECT_TRUE(names().empty());
}

}  // namespace
}  // namespace glowworm
