#include "import/pbrt/parser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/input_file.h"
#include "core/interrupt.h"
#include "core/parallel.h"
#include "pbrt/pbrt_testing.h"

namespace glowworm {
namespace {

struct Parsed {
  std::vector<PbrtDirective> directives;
  std::string error;
};

Parsed parse(std::string_view text, PbrtDiagnostics& diagnostics) {
  Parsed out;
  MemoryBudget budget;
  parse_pbrt_text(text, "f.pbrt", diagnostics, budget, [&](PbrtDirective& d) { out.directives.push_back(d); });
  try {
    diagnostics.throw_if_errors();
  } catch (const Error& error) {
    out.error = error.what();
  }
  return out;
}

TEST(PbrtParser, NumbersCountUntilTheirDirectiveIsTaken) {
  PbrtDiagnostics diagnostics;
  constexpr std::uint64_t kLimit = 1 << 20;
  MemoryBudget budget(kLimit);
  std::vector<std::uint64_t> available;
  parse_pbrt_text("Shape \"sphere\" \"float radius\" [1 2 3 4]\nAttributeBegin", "f.pbrt", diagnostics, budget,
                  [&](PbrtDirective&) { available.push_back(budget.available()); });
  ASSERT_EQ(available.size(), 2u);
  EXPECT_LE(available[0], kLimit - 4 * sizeof(double));
  EXPECT_EQ(available[1], kLimit);
}

TEST(PbrtParser, EveryDirective) {
  const std::string text = R"(
Accelerator "bvh" "integer maxnodeprims" 4
ActiveTransform StartTime
AreaLightSource "diffuse" "rgb L" [1 2 3]
Attribute "shape" "float radius" 2
AttributeBegin AttributeEnd
Camera "perspective" "float fov" 30
ColorSpace "srgb"
ConcatTransform [1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1]
CoordSysTransform "camera"
CoordinateSystem "here"
Film "rgb" "integer xresolution" [10]
Identity
Integrator "path" "integer maxdepth" 5
LightSource "point"
LookAt 0 0 5  0 0 0  0 1 0
MakeNamedMaterial "m" "string type" "diffuse"
MakeNamedMedium "fog" "string type" "homogeneous"
Material "diffuse"
MediumInterface "fog" ""
MediumInterface "fog"
NamedMaterial "m"
ObjectBegin "o" ObjectEnd
ObjectInstance "o"
Option "bool disablepixeljitter" true
PixelFilter "box"
Renderer "sampler"
ReverseOrientation
Rotate 90 0 1 0
Sampler "halton" "integer pixelsamples" 16
Scale 1 2 3
Shape "sphere"
SurfaceIntegrator "path"
Texture "t" "float" "constant" "float value" 1
Transform [1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1]
TransformBegin TransformEnd
TransformTimes 0 1
Translate 1 2 3
VolumeIntegrator "emission"
WorldBegin
WorldEnd
)";
  PbrtDiagnostics diagnostics;
  const Parsed parsed = parse(text, diagnostics);
  EXPECT_EQ(parsed.error, "");
  ASSERT_EQ(parsed.directives.size(), 43u);
  const auto named = [&](std::string_view name) {
    const auto found = std::find_if(parsed.directives.begin(), parsed.directives.end(),
                                    [&](const PbrtDirective& d) { return d.name == name; });
    EXPECT_NE(found, parsed.directives.end()) << name;
    return *found;
  };
  EXPECT_EQ(named("Texture").strings, (std::vector<std::string>{"t", "float", "constant"}));
  EXPECT_EQ(named("MediumInterface").strings, (std::vector<std::string>{"fog", ""}));
  EXPECT_EQ(named("LookAt").numbers, (std::vector<double>{0, 0, 5, 0, 0, 0, 0, 1, 0}));
  EXPECT_EQ(named("Transform").numbers.size(), 16u);
  EXPECT_EQ(named("ActiveTransform").strings, (std::vector<std::string>{"StartTime"}));
  EXPECT_EQ(named("AreaLightSource").parameters.all()[0].numbers, (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(named("Option").parameters.all().size(), 1u);
  EXPECT_EQ(named("Camera").place.line, 7);
}

TEST(PbrtParser, EveryParameterType) {
  const std::string text = R"(Shape "x"
 "bool b" true "bool c" [ false true ] "bool v3" "true" "integer i" [ 1 -2 ] "float f" .5
 "point2 p2" [1 2] "vector2 v2" [3 4] "point3 p3" [1 2 3] "vector3 vv" [1 2 3] "normal n" [0 0 1] "normal3 n3" [0 1 0]
 "point p" [7 8 9] "vector v" [1 1 1] "string s" "one" "string ss" [ "a" "b" ] "rgb r" [.1 .2 .3] "color col" [1 1 1]
 "xyz z" [1 1 1] "blackbody bb" 6500 "spectrum named" "metal-Au-k" "spectrum samples" [ 400 1 700 2 ]
 "texture t" "name"  " float   spaced " 3)";
  PbrtDiagnostics diagnostics;
  const Parsed parsed = parse(text, diagnostics);
  ASSERT_EQ(parsed.error, "");
  ASSERT_EQ(parsed.directives.size(), 1u);
  const PbrtParameters& p = parsed.directives[0].parameters;
  EXPECT_TRUE(p.boolean("b", false));
  EXPECT_TRUE(p.boolean("v3", false));
  EXPECT_EQ(p.find("c")->numbers, (std::vector<double>{0, 1}));
  EXPECT_EQ(p.find("i")->numbers, (std::vector<double>{1, -2}));
  EXPECT_EQ(p.real("f", 0), 0.5f);
  EXPECT_EQ(p.real("spaced", 0), 3);
  EXPECT_EQ(p.find("p2")->type, PbrtType::point2);
  EXPECT_EQ(p.find("v2")->type, PbrtType::vector2);
  EXPECT_TRUE(p.point3("p3", {}) == (Vec3d{1, 2, 3}));
  EXPECT_EQ(p.find("vv")->type, PbrtType::vector3);
  EXPECT_EQ(p.find("n")->type, PbrtType::normal);
  EXPECT_EQ(p.find("n3")->type, PbrtType::normal);
  EXPECT_EQ(p.find("p")->type, PbrtType::point3);
  EXPECT_EQ(p.find("v")->type, PbrtType::vector3);
  EXPECT_EQ(p.string("s", ""), "one");
  EXPECT_EQ(p.strings("ss").size(), 2u);
  EXPECT_EQ(p.find("r")->type, PbrtType::rgb);
  EXPECT_EQ(p.find("col")->type, PbrtType::rgb);
  EXPECT_EQ(p.find("z")->type, PbrtType::xyz);
  EXPECT_EQ(p.find("bb")->numbers[0], 6500);
  EXPECT_EQ(p.find("named")->strings[0], "metal-Au-k");
  EXPECT_EQ(p.find("samples")->numbers.size(), 4u);
  EXPECT_EQ(p.find("t")->type, PbrtType::texture);
  EXPECT_EQ(p.find("absent"), nullptr);
  EXPECT_EQ(p.integer("absent", 7), 7);
}

TEST(PbrtParser, WrongCountsAndTypesAreErrorsAtTheParameter) {
  PbrtDiagnostics diagnostics;
  const Parsed parsed =
      parse("Shape \"x\" \"float f\" [1 2]\n \"string s\" \"a\" \"float big\" 1e300 \"float h\" .5", diagnostics);
  ASSERT_EQ(parsed.error, "");
  const PbrtParameters& p = parsed.directives[0].parameters;
  EXPECT_EQ(p.real("f", 9), 9);
  EXPECT_EQ(p.real("s", 9), 9);
  EXPECT_EQ(p.real("big", 9), 9);
  EXPECT_EQ(p.integer("h", 9), 9);
  try {
    diagnostics.throw_if_errors();
    FAIL();
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("f.pbrt:1:11: parameter \"f\" has 2 values, expected 1"), std::string::npos) << text;
    EXPECT_NE(text.find("f.pbrt:2:2: parameter \"s\" is of type string, expected a number"), std::string::npos) << text;
    EXPECT_NE(text.find("f.pbrt:2:17: parameter \"big\" is too large"), std::string::npos) << text;
    EXPECT_NE(text.find("f.pbrt:2:35: parameter \"h\" is not an integer"), std::string::npos) << text;
    EXPECT_NE(text.find("4 errors"), std::string::npos) << text;
  }
}

TEST(PbrtParser, ReadsOnAfterAMistake) {
  PbrtDiagnostics diagnostics;
  const Parsed parsed = parse("Shap \"sphere\"\nTranslate 1 2\nRotate 90 0 0 1\nScale 1 x 1\nIdentity", diagnostics);
  ASSERT_EQ(parsed.directives.size(), 2u);
  EXPECT_EQ(parsed.directives[0].name, "Rotate");
  EXPECT_EQ(parsed.directives[1].name, "Identity");
  EXPECT_NE(parsed.error.find("f.pbrt:1:1: unknown directive \"Shap\""), std::string::npos) << parsed.error;
  EXPECT_NE(parsed.error.find("f.pbrt:3:1: Translate needs 3 numbers, found 2"), std::string::npos) << parsed.error;
  EXPECT_NE(parsed.error.find("f.pbrt:4:9: Scale needs 3 numbers, found 1"), std::string::npos) << parsed.error;
}

TEST(PbrtParser, MistakesOfParametersHavePlacesAndRemedies) {
  const struct {
    const char *text, *message;
  } kCases[] = {
      {"Shape \"x\" \"radius\" 1", "f.pbrt:1:11: \"radius\" is not a parameter: expected a type and a name"},
      {"Shape \"x\" \"flaot r\" 1", "f.pbrt:1:11: unknown type \"flaot\" of parameter \"r\""},
      {"Shape \"x\" \"float r\" [1 2", "f.pbrt:1:21: the list of values of \"r\" has no end"},
      {"Shape \"x\" \"float r\" [1 Material \"y\"", "f.pbrt:1:21: the list of values of \"r\" has no end"},
      {"Shape \"x\" \"float r\"", "the file ends where the value of \"r\" is expected"},
      {"Shape \"x\" \"float r\" \"one\"", "f.pbrt:1:21: \"one\" is not a value of type float"},
      {"Shape \"x\" \"bool r\" 1", "f.pbrt:1:20: \"1\" is not a value of type bool"},
      {"Shape \"x\" \"string r\" 1", "f.pbrt:1:22: \"1\" is not a value of type string"},
      {"Shape \"x\" \"rgb r\" [1 2]", "f.pbrt:1:11: parameter \"r\" has 2 values, expected 3"},
      {"Shape \"x\" \"spectrum r\" [400 1 500]", "f.pbrt:1:11: spectrum \"r\" should be pairs"},
      {"Shape \"x\" \"spectrum r\" [400 \"a\"]", "f.pbrt:1:11: parameter \"r\" mixes numbers and strings"},
      {"Shape \"x\" \"float r\" 1 \"float r\" 2", "f.pbrt:1:23: parameter \"r\" is given twice"},
      {"Shape sphere", "f.pbrt:1:7: expected a string in double quotes after Shape"},
      {"Transform [1 2 3]", "f.pbrt:1:17: Transform needs 16 numbers, found 3"},
      {"Translate [1 2 3 4]", "f.pbrt:1:18: expected ] after the 3 numbers of Translate"},
      {"] Identity", "f.pbrt:1:1: unexpected \"]\", expected a directive"},
      {"attributebegin", "Write it as AttributeBegin."},
  };
  for (const auto& [text, message] : kCases) {
    PbrtDiagnostics diagnostics;
    const Parsed parsed = parse(text, diagnostics);
    EXPECT_NE(parsed.error.find(message), std::string::npos) << text << "\n" << parsed.error;
    EXPECT_NE(parsed.error.find("\n  "), std::string::npos) << "no remedy: " << parsed.error;
  }
}

TEST(PbrtParser, StopsAfterTwentyErrors) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "Bad\nIdentity\n";
  PbrtDiagnostics diagnostics;
  const Parsed parsed = parse(text, diagnostics);
  EXPECT_EQ(diagnostics.error_count(), 20u);
  EXPECT_NE(parsed.error.find("20 errors: reading stopped"), std::string::npos);
  EXPECT_LE(parsed.directives.size(), 20u);
}

TEST(PbrtParser, IncludesFilesWithPlacesOfTheirOwn) {
  const TemporaryFolder folder;
  folder.write("parts/a.pbrt", "Identity\nInclude \"b.pbrt\"\nInclude \"main-relative.pbrt\"");
  folder.write("parts/b.pbrt", "\n  Translate 1 2 3");
  folder.write("main-relative.pbrt", "ReverseOrientation");
  const std::string main = folder.write("main.pbrt", "Include \"parts/a.pbrt\"\nWorldBegin");
  PbrtDiagnostics diagnostics;
  MemoryBudget budget;
  std::vector<std::string> seen;
  parse_pbrt_text(read_input_file(main), main, diagnostics, budget, [&](PbrtDirective& d) {
    seen.push_back(std::string(d.name) + "@" + std::filesystem::path(*d.place.file).filename().string() + ":" +
                   std::to_string(d.place.line));
  });
  diagnostics.throw_if_errors();
  EXPECT_EQ(seen, (std::vector<std::string>{"Identity@a.pbrt:1", "Translate@b.pbrt:2",
                                            "ReverseOrientation@main-relative.pbrt:1", "WorldBegin@main.pbrt:2"}));
}

TEST(PbrtParser, IncludesWithoutDirectivesCanBeCancelled) {
  const TemporaryFolder folder;
  folder.write("a.pbrt", "# only a comment");
  const std::string main = folder.write("main.pbrt", "Include \"a.pbrt\"");
  Interrupt interrupt;
  interrupt.request();
  const CancellationScope scope(interrupt);
  EXPECT_THROW(load_scene(main), Cancelled);
}

TEST(PbrtParser, ImportIsIsolated) {
  const TemporaryFolder folder;
  folder.write("a.pbrt", "Translate 1 2 3");
  const std::string main = folder.write("main.pbrt", "Import \"a.pbrt\"");
  PbrtDiagnostics diagnostics;
  MemoryBudget budget;
  std::vector<std::string_view> seen;
  parse_pbrt_text(read_input_file(main), main, diagnostics, budget, [&](PbrtDirective& d) { seen.push_back(d.name); });
  EXPECT_EQ(seen, (std::vector<std::string_view>{"AttributeBegin", "Translate", "AttributeEnd"}));
}

TEST(PbrtParser, KnowsFilesOfVersion3) {
  EXPECT_TRUE(is_pbrt_v3("WorldBegin\nShape \"sphere\" # c\nWorldEnd"));
  EXPECT_FALSE(is_pbrt_v3("WorldBegin # WorldEnd\nShape \"WorldEnd\""));
}

}  // namespace
}  // namespace glowworm
