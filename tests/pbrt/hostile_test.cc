// Damaged or malicious files: an error with its place, within little time and memory.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "pbrt/pbrt_testing.h"
#include "support/sanitizers.h"

namespace glowworm {
namespace {

using pbrt_testing::error_of;
using pbrt_testing::kTriangle;
using pbrt_testing::load_text;

// The sanitizers reserve address space without end.
constexpr bool kLimitsMemory = !kAddressSanitizer && !kThreadSanitizer;

/// Whether `path` fails to load with an Error that holds `message`, in a process of its own that may take no more than
/// `megabytes` of address space above what this one has, and 100 seconds.
bool fails_within(const std::string& path, const std::string& message, std::size_t megabytes) {
  const pid_t child = ::fork();
  if (child == 0) {
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t bytes = pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) + (megabytes << 20);
    const rlimit memory{bytes, bytes}, seconds{100, 100};
    if (kLimitsMemory) ::setrlimit(RLIMIT_AS, &memory);
    ::setrlimit(RLIMIT_CPU, &seconds);
    int status = 1;
    try {
      load_scene(path);
    } catch (const Error& error) {
      status = std::string(error.what()).find(message) == std::string::npos ? 2 : 0;
      if (status != 0) std::fprintf(stderr, "%s\n", error.what());
    } catch (...) {
      status = 3;
    }
    ::_exit(status);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 0) << "1: no error, 2: another error, 3: another exception";
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

ImportOptions within(std::uint64_t bytes) {
  ImportOptions options;
  options.budget = loading_budget(bytes);
  return options;
}

TEST(PbrtHostile, SubdivisionOfNothingEnds) {
  const auto d = load_text(std::string(kTriangle) +
                           "Shape \"loopsubdiv\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [] "
                           "\"integer levels\" [2147483647]\n");
  EXPECT_EQ(d.geometry.triangle_count(), 1u);
}

TEST(PbrtHostile, MissingVertices) {
  const TemporaryFolder folder;
  const std::string vertex = "element vertex 1000000000\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1000000000\nproperty list uchar int vertex_indices\n";
  const struct {
    const char* name;
    std::string text;
  } kFiles[] = {
      {"binary.ply", "ply\nformat binary_little_endian 1.0\n" + vertex + face + "end_header\nabc"},
      {"ascii.ply", "ply\nformat ascii 1.0\n" + vertex + face + "end_header\n1 2 3"},
      {"empty.ply", "ply\nformat ascii 1.0\nelement vertex 1000000000\n" + face + "end_header\n1 2 3"},
      {"huge.ply",
       "ply\nformat binary_big_endian 1.0\nelement vertex 18446744073709551615\nproperty double x\n"
       "property double y\nproperty double z\n" +
           face + "end_header\n"},
  };
  for (const auto& [name, text] : kFiles) {
    folder.write(name, text);
    const std::string scene =
        folder.write("s.pbrt", std::string("WorldBegin Shape \"plymesh\" \"string filename\" \"") + name + "\"");
    EXPECT_TRUE(fails_within(scene, "s.pbrt:1:28: cannot read", 64)) << name;
  }
}

TEST(PbrtHostile, IncludeCycles) {
  const TemporaryFolder folder;
  folder.write("b.pbrt", "Identity\n Include \"a.pbrt\"");
  const std::string a = folder.write("a.pbrt", "Include \"b.pbrt\"");
  try {
    load_scene(a);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("b.pbrt:2:2: \"a.pbrt\" includes itself"), std::string::npos)
        << error.what();
  }
  EXPECT_NE(error_of("Include \"./scene.pbrt\"").find("scene.pbrt:1:1: \"./scene.pbrt\" includes itself"),
            std::string::npos);
}

TEST(PbrtHostile, IncludesAreBoundedInDepthAndNumber) {
  const TemporaryFolder folder;
  for (int i = 0; i < 100; ++i) {
    const std::string next = "Include \"" + std::to_string(i + 1) + ".pbrt\"\n";
    folder.write(std::to_string(i) + ".pbrt", next);
  }
  EXPECT_THROW(
      {
        try {
          load_scene(folder.path("0.pbrt"));
        } catch (const Error& error) {
          EXPECT_NE(std::string(error.what()).find("64.pbrt:1:1: files are included more than 64 deep"),
                    std::string::npos)
              << error.what();
          throw;
        }
      },
      Error);
  // Each file includes the next one twice: 2^40 files if nothing stopped it.
  for (int i = 0; i < 40; ++i) {
    const std::string next = "Include \"" + std::to_string(i + 1) + ".pbrt\"\n";
    folder.write(std::to_string(i) + ".pbrt", next + next);
  }
  folder.write("40.pbrt", "");
  EXPECT_TRUE(fails_within(folder.path("0.pbrt"), "more than 16384 included files", 512));
}

TEST(PbrtHostile, IncludedFoldersAndMissingFilesAreErrors) {
  EXPECT_NE(error_of("Include \".\"").find("scene.pbrt:1:1: cannot include \".\""), std::string::npos);
  EXPECT_NE(error_of("Include \"gone.pbrt\"").find("scene.pbrt:1:1: cannot include \"gone.pbrt\""), std::string::npos);
  EXPECT_NE(error_of("Include \"/dev/zero\"").find("is not a regular file"), std::string::npos);
}

TEST(PbrtHostile, AbsurdNesting) {
  std::string text;
  for (int i = 0; i < 300000; ++i) text += "AttributeBegin\n";
  const TemporaryFolder folder;
  EXPECT_TRUE(
      fails_within(folder.write("s.pbrt", text), "s.pbrt:10001:1: AttributeBegin is nested more than 10000 deep", 512));
  for (int i = 0; i < 300000; ++i) text += "AttributeEnd\n";
  // The ends match, so there is one error alone.
  EXPECT_EQ(error_of(text).find("without its"), std::string::npos);
}

TEST(PbrtHostile, UnbalancedBlocks) {
  EXPECT_NE(error_of("AttributeEnd").find("scene.pbrt:1:1: AttributeEnd without its AttributeBegin: no block is open"),
            std::string::npos);
  EXPECT_NE(
      error_of("AttributeBegin\nTransformEnd")
          .find("scene.pbrt:2:1: TransformEnd without its TransformBegin: AttributeBegin at scene.pbrt:1:1 is open"),
      std::string::npos);
  EXPECT_NE(error_of("Identity AttributeBegin").find("scene.pbrt:1:10: AttributeBegin is never closed"),
            std::string::npos);
  EXPECT_NE(error_of("ObjectBegin \"o\" ObjectBegin \"p\"").find("scene.pbrt:1:17: ObjectBegin inside of an object"),
            std::string::npos);
  EXPECT_NE(error_of("ObjectBegin \"o\" ObjectInstance \"o\" ObjectEnd").find("the object \"o\" contains itself"),
            std::string::npos);
  EXPECT_NE(error_of("ObjectInstance \"o\"").find("scene.pbrt:1:1: no object \"o\""), std::string::npos);
  EXPECT_NE(error_of(std::string(kTriangle) + "WorldBegin").find("scene.pbrt:2:1: WorldBegin comes after shapes"),
            std::string::npos);
}

TEST(PbrtHostile, NamesWithNul) {
  const std::string_view text("Material \"dif\0fuse\"\nNamedMaterial \"\x01\x7f\"", 44);
  const std::string error = error_of(text.substr(0, 38));
  EXPECT_NE(error.find("scene.pbrt:1:10: the string \"dif\\x00fuse\" holds a NUL byte"), std::string::npos) << error;
  EXPECT_NE(error.find("\\x01\\x7f"), std::string::npos) << error;
}

TEST(PbrtHostile, BinaryAndEmptyFiles) {
  EXPECT_NE(error_of(std::string_view("\x7f"
                                      "ELF\x02\x01\x01\0\0\0\0",
                                      11)),
            "");
  EXPECT_NE(error_of(std::string(100000, '\xff')), "");
  EXPECT_EQ(error_of(""), "");
  EXPECT_EQ(error_of("# only a comment"), "");
}

TEST(PbrtHostile, EnormousParameterLists) {
  std::string many = "Shape \"sphere\"";
  for (int i = 0; i < 200000; ++i) many += " \"float p" + std::to_string(i) + "\" 1";
  EXPECT_NE(error_of(many).find("more than 1000 parameters"), std::string::npos);
  std::string values = "Shape \"sphere\" \"float radius\" [";
  for (int i = 0; i < 2000000; ++i) values += " 1";
  EXPECT_NE(error_of(values + "]").find("parameter \"radius\" has 2000000 values, expected 1"), std::string::npos);
  const TemporaryFolder folder;
  EXPECT_TRUE(fails_within(folder.write("s.pbrt", values), "the list of values of \"radius\" has no end", 256));
}

TEST(PbrtHostile, ListsOfNumbersAreWithinTheBudget) {
  std::string list = "[";
  for (int i = 0; i < 150000; ++i) list += "0 ";
  list += "]";
  // 0.6 MB of text and 2.4 MB of numbers, in two lists.
  const std::string text = "WorldBegin Shape \"trianglemesh\" \"point3 P\" " + list + " \"normal N\" " + list;
  EXPECT_THAT(error_of(text, within(std::uint64_t{8} << 20)), testing::HasSubstr("a mesh without indices"));
  EXPECT_THAT(error_of(text, within(std::uint64_t{3} << 20)), testing::HasSubstr("of parameters (held: "));
}

/// A texture on top of `levels` others, and a material whose roughness is its mean.
std::string nested_textures(int levels, const std::string& kind, const char* other_operand) {
  std::string text = "WorldBegin Texture \"t0\" \"float\" \"checkerboard\"\n";
  for (int i = 1; i <= levels; ++i) {
    const std::string below = "\"t" + std::to_string(i - 1) + "\"";
    text += "Texture \"t" + std::to_string(i) + "\" \"float\" \"" + kind + "\" \"texture tex1\" " + below + " " +
            (other_operand ? other_operand + below : "") + "\n";
  }
  return text + "Material \"coateddiffuse\" \"texture roughness\" \"t" + std::to_string(levels) + "\"\n" + kTriangle;
}

TEST(PbrtHostile, NestedTexturesAreBoundedInCostAndDepth) {
  const TemporaryFolder folder;
  // 2^40 evaluations, and a recursion of 100,000 calls, if nothing stopped them.
  EXPECT_TRUE(fails_within(folder.write("cost.pbrt", nested_textures(40, "scale", "\"texture tex2\" ")),
                           "cost.pbrt:12:1: texture \"t11\" is nested too deeply: 13 levels, 8191 nodes", 256));
  EXPECT_TRUE(fails_within(folder.write("depth.pbrt", nested_textures(100'000, "mix", nullptr)),
                           "depth.pbrt:256:1: texture \"t255\" is nested too deeply: 257 levels", 512));
  EXPECT_EQ(error_of(nested_textures(10, "scale", "\"texture tex2\" ")), "");
  EXPECT_EQ(error_of(nested_textures(200, "mix", nullptr)), "");
}

TEST(PbrtHostile, LongNamesAreCutInMessages) {
  const std::string error = error_of("Material \"" + std::string(1 << 20, 'x') + "\"");
  EXPECT_LT(error.size(), 500u);
}

TEST(PbrtHostile, InstancesAreBounded) {
  std::string text = "WorldBegin ObjectBegin \"o\"\n";
  for (int i = 0; i < 20; ++i) text += "Shape \"sphere\"\n";
  text += "ObjectEnd\n";
  for (int i = 0; i < 20; ++i) text += "ObjectInstance \"o\"\n";
  EXPECT_EQ(error_of(text), "");
  // 20 times 20 spheres of some 4,000 triangles; each takes 200 bytes and more.
  const std::string error = error_of(text, within(std::uint64_t{64} << 20));
  EXPECT_THAT(error, testing::StartsWith("scene.pbrt:2"));
  EXPECT_THAT(error, testing::HasSubstr("of triangles (held: "));
  EXPECT_THAT(error, testing::HasSubstr("--memory"));
}

TEST(PbrtHostile, NestedObjectsAreBounded) {
  // Each object holds the one before twice.
  std::string text = "WorldBegin ObjectBegin \"0\" Shape \"sphere\" ObjectEnd\n";
  for (int i = 1; i < 40; ++i)
    text += fmt::format("ObjectBegin \"{0}\" ObjectInstance \"{1}\" ObjectInstance \"{1}\" ObjectEnd\n", i, i - 1);
  EXPECT_THAT(error_of(text + "ObjectInstance \"39\"", within(std::uint64_t{16} << 20)),
              testing::HasSubstr("of triangles (held: "));
  std::string deep = "WorldBegin ObjectBegin \"0\" Shape \"sphere\" ObjectEnd\n";
  for (int i = 1; i < 1100; ++i) deep += fmt::format("ObjectBegin \"{}\" ObjectInstance \"{}\" ObjectEnd\n", i, i - 1);
  EXPECT_THAT(error_of(deep), testing::HasSubstr("nested more than 1000 deep"));
}

TEST(PbrtHostile, ObjectsWithoutTrianglesTakeNoTime) {
  std::string text =
      "WorldBegin Shape \"sphere\" ObjectBegin \"0\" Shape \"trianglemesh\" \"integer indices\" [] "
      "\"point3 P\" [0 0 0 1 0 0 0 1 0] ObjectEnd\n";
  for (int i = 1; i < 40; ++i)
    text += fmt::format("ObjectBegin \"{0}\" ObjectInstance \"{1}\" ObjectInstance \"{1}\" ObjectEnd\n", i, i - 1);
  EXPECT_NO_THROW(load_text(text + "ObjectInstance \"39\""));
}

TEST(PbrtHostile, ObjectsDefinedTwiceDoNotContainThemselves) {
  const std::string triangle = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] ";
  EXPECT_THAT(error_of("WorldBegin ObjectBegin \"B\" " + triangle +
                       "ObjectEnd ObjectBegin \"A\" ObjectInstance \"B\" ObjectEnd "
                       "ObjectBegin \"B\" ObjectInstance \"A\" ObjectEnd ObjectInstance \"A\""),
              testing::HasSubstr("\"B\" is defined twice"));
}

TEST(PbrtHostile, AttributesAreBounded) {
  const TemporaryFolder folder;
  std::string other_names, other_values;
  std::string values = "Attribute \"shape\" \"float list\" [";
  for (int i = 0; i < 100000; ++i) values += "1 ";
  other_values = values + "]\n";
  for (int i = 0; i < 9000; ++i) {
    const std::string number = std::to_string(i);
    other_names += "AttributeBegin Attribute \"shape\" \"float p" + number + "\" 1\n";
    other_values += "AttributeBegin Attribute \"shape\" \"float radius\" " + number + "\n";
  }
  EXPECT_TRUE(fails_within(folder.write("names.pbrt", other_names),
                           "names.pbrt:257:16: more than 256 Attribute directives are in force", 64));
  // What an inner Attribute hides is not kept for it.
  EXPECT_TRUE(
      fails_within(folder.write("values.pbrt", other_values), "values.pbrt:9001:1: AttributeBegin is never", 64));
}

TEST(PbrtHostile, InnerAttributesHideOuterOnes) {
  const SceneDescription scene = load_text(
      "WorldBegin Attribute \"shape\" \"float radius\" 3 \"float zmin\" 0\n"
      "AttributeBegin Attribute \"shape\" \"float radius\" 2 Shape \"sphere\" AttributeEnd\n"
      "AttributeBegin Translate 100 0 0 Shape \"sphere\" AttributeEnd\n"
      "AttributeBegin Attribute \"light\" \"rgb L\" [1 1 1] Translate 200 0 0 Shape \"sphere\" \"float radius\" 1 "
      "AttributeEnd\n");
  float highest[3] = {}, lowest[3] = {};
  for (const Vec3& p : scene.geometry.positions) {
    const int which = static_cast<int>((p.x + 50) / 100);
    highest[which] = std::max(highest[which], p.z);
    lowest[which] = std::min(lowest[which], p.z);
  }
  EXPECT_NEAR(highest[0], 2, 0.1);
  EXPECT_NEAR(highest[1], 3, 0.1);
  EXPECT_NEAR(highest[2], 1, 0.1);
  for (const float z : lowest) EXPECT_NEAR(z, 0, 0.1);
}

TEST(PbrtHostile, ObjectsAndSubdivisionsAreWithinTheBudget) {
  std::string objects = "WorldBegin ObjectBegin \"o\"\n";
  for (int i = 0; i < 1000; ++i) objects += "Shape \"sphere\"\n";
  EXPECT_THAT(error_of(objects + "ObjectEnd", within(std::uint64_t{16} << 20)),
              testing::HasSubstr("of object meshes (held: "));
  const std::string subdivided =
      "WorldBegin Shape \"loopsubdiv\" \"integer levels\" 10 \"integer indices\" [0 1 2] "
      "\"point3 P\" [0 0 0  1 0 0  0 1 0]";
  EXPECT_THAT(error_of(subdivided, within(std::uint64_t{16} << 20)), testing::HasSubstr("of subdivision"));
}

TEST(PbrtHostile, HugeNumbers) {
  const SceneDescription scene = load_text(
      "WorldBegin Scale 1e30 1e30 1e30 Scale 1e30 1e30 1e30\n"
      "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] Identity Shape \"sphere\" \"float radius\" 1e-30\n"
      "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1e200 0 0 0 1 0]");
  for (const Vec3& p : scene.geometry.positions) EXPECT_TRUE(is_finite(p));
  EXPECT_EQ(scene.geometry.triangle_count(), 0u);
  EXPECT_EQ(scene.notes.size(), 2u);
}

TEST(PbrtHostile, ErrorsOfVerticesAndLightsHaveAPlace) {
  EXPECT_THAT(error_of("WorldBegin\nScale 1e19 1 1 Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]"),
              testing::HasSubstr("scene.pbrt:2:16: trianglemesh: vertex 1 is at (1e+19, 0, 0)"));
  EXPECT_THAT(error_of("WorldBegin\n LightSource \"point\" \"rgb I\" [-1 -2 -3]"),
              testing::HasSubstr("scene.pbrt:2:2: the light is negative: (-1, -2, -3)"));
  EXPECT_THAT(error_of("WorldBegin AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] \"float scale\" -2"),
              testing::HasSubstr("scene.pbrt:1:12: the light is negative: (-2, -2, -2)"));
}

TEST(PbrtHostile, EveryTruncationOfASceneIsAnErrorOrAScene) {
  const std::string whole = std::string(R"(LookAt 0 0 5 0 0 0 0 1 0 Camera "perspective" "float fov" [30]
WorldBegin AttributeBegin Texture "t" "spectrum" "checkerboard" "float uscale" 2
Material "coateddiffuse" "texture reflectance" "t" "float roughness" .1
AreaLightSource "diffuse" "blackbody L" 4000 Shape "disk" "float radius" 2 AttributeEnd
LightSource "infinite" "rgb L" [1 2 3]
)") + kTriangle;
  EXPECT_EQ(error_of(whole), "");
  std::size_t errors = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) errors += !error_of(whole.substr(0, size)).empty();
  EXPECT_GT(errors, whole.size() / 2);
}

}  // namespace
}  // namespace glowworm
