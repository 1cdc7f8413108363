// Scattering data of windows, and materials that have it.
#include <cmath>
#include <functional>

#include "bsdf/bsdf.h"
#include "import/import.h"
#include "import/material_text.h"
#include "import/window/bsdf_xml.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"
#include "scene/surface.h"
#include "test_files.h"

namespace glowworm {
namespace {

using testing::HasSubstr;

/// A basis of one ring: a patch around the normal, and four around it.
constexpr const char* kBasis =
    "<AngleBasis><AngleBasisName>Five</AngleBasisName>\n<AngleBasisBlock><Theta>0</Theta><nPhis>1</nPhis><ThetaBounds>"
    "<LowerTheta>0</LowerTheta><UpperTheta>30</UpperTheta></ThetaBounds></AngleBasisBlock>\n<AngleBasisBlock><Theta>60"
    "</Theta><nPhis>4</nPhis><ThetaBounds><LowerTheta>30</LowerTheta><UpperTheta>90</UpperTheta></ThetaBounds>"
    "</AngleBasisBlock></AngleBasis>";

std::string block(const std::string& direction, const std::string& data, const std::string& basis = "Five") {
  return "<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit=\"Integral\">Visible</Wavelength>\n"
         "<WavelengthDataBlock><WavelengthDataDirection>" +
         direction + "</WavelengthDataDirection><ColumnAngleBasis>" + basis + "</ColumnAngleBasis><RowAngleBasis>" +
         basis + "</RowAngleBasis><ScatteringDataType>BTDF</ScatteringDataType>\n<ScatteringData>" + data +
         "</ScatteringData></WavelengthDataBlock></WavelengthData>\n";
}
std::string window(const std::string& blocks, const std::string& order = "Columns", const std::string& basis = kBasis) {
  return "<?xml version=\"1.0\"?>\n<!-- a window -->\n<WindowElement><Optical><Layer><DataDefinition>"
         "<IncidentDataStructure>" +
         order + "</IncidentDataStructure>" + basis + "</DataDefinition>\n" + blocks +
         "</Layer></Optical></WindowElement>\n";
}
std::string constant(std::size_t count, double value) {
  std::string out;
  for (std::size_t i = 0; i < count; ++i) out += std::to_string(value) + ", ";
  return out;
}

class WindowTest : public FileTest {
 protected:
  std::shared_ptr<const MeasuredBsdf> read(const std::string& text) { return parse_bsdf_xml(text, "w.xml", notes_); }
  std::string refusal(const std::string& text) {
    try {
      read(text);
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  }
  std::vector<std::string> notes_;
};
using SlowWindowTest = WindowTest;

/// Light from one patch to another, in both orders of the data, by the conventions of Radiance's bsdf_m.c: rows go out,
/// columns come in by the opposite of where they are, and the front is WINDOW's back.
TEST_F(WindowTest, PlacesOfTheMatrixAreDirections) {
  const Vec3 normal{0, 0, 1}, x = normalize({1, 0, 0.5f}), y = normalize({0, 1, 0.5f});
  const auto below = [](Vec3 w) { return Vec3{w.x, w.y, -w.z}; };
  // Row 2 (towards y), column 1 (of light that goes along x, and so is at -x).
  const auto at = [](const char* direction, const char* order, int row, int column) {
    std::string data;
    for (int r = 0; r < 5; ++r)
      for (int c = 0; c < 5; ++c) data += r == row && c == column ? "0.25 " : "0 ";
    return window(block(direction, data), order);
  };
  const Vec3 minus_x{-x.x, 0, x.z};
  EXPECT_FLOAT_EQ(read(at("Transmission Front", "Columns", 2, 1))->evaluate(false, true, y, below(minus_x)), 0.25f);
  EXPECT_FLOAT_EQ(read(at("Transmission Front", "Rows", 1, 2))->evaluate(false, true, y, below(minus_x)), 0.25f);
  EXPECT_FLOAT_EQ(read(at("Transmission Front", "Columns", 2, 1))->evaluate(true, true, below(minus_x), y), 0.25f);
  EXPECT_FLOAT_EQ(read(at("Transmission Back", "Columns", 2, 1))->evaluate(true, true, below(y), minus_x), 0.25f);
  EXPECT_FLOAT_EQ(read(at("Transmission Back", "Columns", 2, 1))->evaluate(false, true, y, below(minus_x)), 0);
  // Reflection is made reciprocal: half of it goes the other way.
  EXPECT_FLOAT_EQ(read(at("Reflection Back", "Columns", 2, 1))->evaluate(false, false, y, minus_x), 0.125f);
  EXPECT_FLOAT_EQ(read(at("Reflection Front", "Columns", 2, 1))->evaluate(true, false, below(y), below(minus_x)),
                  0.125f);
  EXPECT_THAT(notes_, HasNote("not reciprocal by 100.0%"));
  EXPECT_FLOAT_EQ(read(at("Transmission Front", "Columns", 0, 0))->evaluate(false, true, normal, below(normal)), 0.25f);
}

TEST_F(WindowTest, KlemsBasesAreKnown) {
  for (const auto& [name, size] :
       {std::pair("LBNL/Klems Full", 145u), std::pair("LBNL/Klems Half", 73u), std::pair("LBNL/Klems Quarter", 41u)}) {
    const auto measured = read(window(block("Transmission Front", constant(size * size, 0.2), name), "Columns", ""));
    EXPECT_NEAR(measured->albedo(false, true, {0, 0, 1}), 0.2 * M_PI, 1e-4) << name;
  }
}

TEST_F(WindowTest, ConstantTreesAreWhiteFurnaces) {
  const std::string leaf = "{" + std::to_string(0.4 / M_PI) + "}";
  for (const int rank : {3, 4}) {
    std::string branches = "{";
    for (int i = 0; i < 1 << rank; ++i) branches += leaf;
    const std::string grid = "{" + constant(std::size_t{1} << rank, 0.6 / M_PI) + "}";
    const auto tree = read(window(block("Reflection Back", branches + "}", "") + block("Transmission Front", grid, ""),
                                  "TensorTree" + std::to_string(rank), ""));
    for (const Vec3 wo : {Vec3{0, 0, 1}, normalize({1, 0.5f, 0.3f}), normalize({-0.2f, -1, 1})}) {
      EXPECT_NEAR(tree->albedo(false, false, wo), 0.4, 1e-4) << rank;
      EXPECT_NEAR(tree->albedo(false, true, wo), 0.6, 1e-4) << rank;
    }
  }
  EXPECT_THAT(notes_, HasNote("averaged over the 145 patches"));
}

/// By the conventions of Radiance's bsdf_t.c, with the sides as those of matrices.
TEST_F(WindowTest, HalvesOfATreeAreHalvesOfTheDisc) {
  const auto lit = [](int rank, int lit_branch, bool as_grid) {
    std::string out = "{";
    for (int i = 0; i < 1 << rank; ++i)
      out += i == lit_branch ? (as_grid ? " 0.25" : "{0.25}") : (as_grid ? " 0" : "{0}");
    return window(block("Transmission Front", out + "}", ""), "TensorTree" + std::to_string(rank), "");
  };
  const auto passes = [&](const std::shared_ptr<const MeasuredBsdf>& tree, Vec3 wo, Vec3 way) {
    return tree->evaluate(false, true, normalize(wo), -normalize(way));
  };
  // Light that goes towards +x and +y (bits 0 and 1) leaves towards -x and -y.
  const auto four = read(lit(4, 3, false));
  EXPECT_NEAR(passes(four, {-1, -1, 1}, {1, 1, 1}), 0.25, 1e-5);
  EXPECT_EQ(passes(four, {-1, -1, 1}, {-1, -1, 1}), 0);
  EXPECT_EQ(passes(four, {1, 1, 1}, {1, 1, 1}), 0);
  // Beside the way, towards +x and -y where it is +x.
  for (const bool as_grid : {false, true}) {
    const auto three = read(lit(3, 2, as_grid));
    EXPECT_NEAR(passes(three, {1, -1, 1}, {1, 0, 1}), 0.25, 1e-5) << as_grid;
    EXPECT_NEAR(passes(three, {1, 1, 1}, {0, 1, 1}), 0.25, 1e-5) << as_grid;
    EXPECT_EQ(passes(three, {1, 1, 1}, {1, 0, 1}), 0) << as_grid;
  }
}

TEST_F(WindowTest, BadFilesAreRefusedWithTheirPlace) {
  const std::string good = window(block("Transmission Front", constant(25, 0.1)));
  EXPECT_EQ(refusal(good), "accepted");
  struct Case {
    std::string text, message;
  };
  const Case cases[] = {
      {"", "no matrix of visible light"},
      {"<a></a>", "w.xml:1: the file is not a <WindowElement>"},
      {"<WindowElement>\n<b></WindowElement>", "w.xml:2: </WindowElement> closes no element"},
      {"<WindowElement>\n", "<WindowElement> is not closed"},
      {"<WindowElement><!-- x", "'<!--' is not closed"},
      {window(block("Transmission Front", constant(24, 0.1))), "has 24 numbers, but its basis needs 25"},
      {window(block("Transmission Front", constant(26, 0.1))), "has more numbers"},
      {window(block("Transmission Front", "0.1 x")), "holds 'x', which is no number"},
      {window(block("Sideways", constant(25, 0.1))), "unknown WavelengthDataDirection 'sideways'"},
      {window(block("Transmission Front", constant(25, 0.1), "Six")), "unknown basis 'six'"},
      {window(block("Transmission Front", "{0.1 0.2}"), "TensorTree4"), "has 2 values, which is no power of 16"},
      {window(block("Transmission Front", "{0.1"), "TensorTree3"), "lacks a '}'"},
      {window(block("Transmission Front", "{x}"), "TensorTree3"), "holds 'x', which is no number"},
      {window(
           "", "Columns",
           "<AngleBasis><AngleBasisBlock><nPhis>3</nPhis><UpperTheta>90</UpperTheta></AngleBasisBlock></AngleBasis>"),
       "rings of 3 patches"},
      {window("", "Columns", "<AngleBasis><AngleBasisBlock><nPhis>1e9</nPhis></AngleBasisBlock></AngleBasis>"),
       "'1e9' is not a number from 1 to 1024"},
  };
  for (const Case& c : cases) EXPECT_THAT(refusal(c.text), HasSubstr(c.message)) << c.text;
  for (std::size_t cut = 0; cut < good.size(); cut += 7) refusal(good.substr(0, cut));
}

/// A floor under a pane of matrices, in the light of a uniform sky.
SceneDescription under_glass(const std::function<void(SceneDescription&)>& change) {
  SceneDescription d = floor_description();
  d.materials.emplace_back().name = "glazing";
  add_quad(d, {-40, -40, 2}, {80, 0, 0}, {0, 80, 0}, 1);
  d.environment = Environment{};
  d.cameras.push_back(square_view({0, 0, 0}, {0, 0, 1}, 1, 2));
  change(d);
  return d;
}

/// A matrix of one value transmits like the built-in diffuse material, by paths and by photons.
TEST_F(SlowWindowTest, AConstantMatrixPassesLightAsADiffuseMaterialDoes) {
  const double f = 0.15;
  const std::string data = constant(25, f);
  const std::string file = write("w.xml", window(block("Transmission Front", data) + block("Reflection Back", data) +
                                                 block("Reflection Front", data)));
  const auto by_matrix =
      under_glass([&](SceneDescription& d) { change_material("glazing,bsdf=" + file, d, *loading_budget()); });
  const auto by_colour = under_glass([&](SceneDescription& d) {
    d.materials[1].reflectance.value = d.materials[1].transmittance.value = RGB(static_cast<float>(f * M_PI));
  });
  EXPECT_EQ(by_matrix.materials[1].kind, MaterialKind::measured);
  const Stage matrix(by_matrix), colour(by_colour);
  const double wanted = mean(colour.render(by_path(8, 1024))).luminance();
  EXPECT_NEAR(mean(matrix.render(by_path(8, 1024))).luminance() / wanted, 1, 0.03);
  EXPECT_NEAR(mean(matrix.render(by_photons(8, 64, 64, 200'000))).luminance() / wanted, 1, 0.05);
}

/// In a white furnace a surface that loses nothing is not seen.
TEST_F(WindowTest, AWhiteFurnaceStaysWhite) {
  const std::string half = constant(25, 0.5 / M_PI);
  const std::string file = write("w.xml", window(block("Transmission Front", half) + block("Reflection Back", half) +
                                                 block("Reflection Front", half)));
  const auto d = under_glass([&](SceneDescription& scene) {
    change_material("glazing,bsdf=" + file, scene, *loading_budget());
    scene.cameras[0] = square_view({0, 0, 2}, normalize({0.3f, 0.2f, 1}), 3, 1);
    scene.materials[0].reflectance.value = RGB(1.0f);
  });
  EXPECT_NEAR(mean(Stage(d).render(by_path(8, 256))).luminance(), 1, 0.02);
}

/// The azimuth 0 of the file lies across `up`, to the right of who looks at the front.
TEST_F(WindowTest, UpOfTheWindowIsUpOfTheScene) {
  SceneDescription d;
  d.materials.emplace_back().name = "glazing";
  // A window that faces the viewer at +z, with texture coordinates that turn its frame.
  Geometry mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals.assign(3, {0, 0, 1});
  mesh.uvs = {{0, 0}, {0, 1}, {-1, 0.3f}};
  mesh.triangles = {{0, 1, 2}};
  append_mesh(d.geometry, mesh, "window", 0, kNone);
  // All that comes, from wherever, leaves towards azimuth 0.
  std::string data;
  for (int r = 0; r < 5; ++r)
    for (int c = 0; c < 5; ++c) data += r == 1 ? "0.2 " : "0 ";
  const std::string file = write("w.xml", window(block("Transmission Front", data)));
  change_material("glazing,bsdf=" + file, d, *loading_budget());
  const Scene scene(std::move(d));
  SurfacePoint point = surface_point(scene, 0, {0.3f, 0.3f});
  const Bsdf bsdf = resolve_bsdf(scene, point);
  const ShadedSurface surface = shaded(point, bsdf);
  const Vec3 from{0, 0, -1};
  EXPECT_GT(surface.evaluate(normalize({1, 0, 0.5f}), from, kAllLobes).r, 0.1f);
  EXPECT_EQ(surface.evaluate(normalize({-1, 0, 0.5f}), from, kAllLobes).r, 0);
  EXPECT_EQ(surface.evaluate(normalize({0, 1, 0.5f}), from, kAllLobes).r, 0);
}

}  // namespace
}  // namespace glowworm
