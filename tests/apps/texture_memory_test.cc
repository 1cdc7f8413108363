// Textures larger than their memory limit.
#include <fmt/format.h>

#include <chrono>
#include <fstream>

#include "core/random.h"
#include "image/image.h"
#include "program.h"

namespace glowworm {
namespace {

class SlowTextureMemoryTest : public ProgramTest {
 protected:
  static constexpr int kTextures = 12;

  struct Render {
    double peak_mib = 0, beside_scene_mib = 0, seconds = 0;
  };

  /// A row of floors, each with a texture of so many pixels of noise a side, which nothing can compress.
  void write_scene(const std::string& name, int side) {
    std::ofstream scene(path(name + ".pbrt"));
    scene << "LookAt 0 0 10  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 40\nWorldBegin\n"
             "LightSource \"infinite\" \"rgb L\" [1 1 1]\n";
    for (int t = 0; t < kTextures; ++t) {
      Image image(side, side);
      std::vector<RGB> pixels(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
      for (std::uint32_t i = 0; i < pixels.size(); ++i) {
        const std::uint32_t bits = hash_combine(static_cast<std::uint32_t>(t), i);
        pixels[i] = {static_cast<float>(bits & 255) / 255, static_cast<float>(bits >> 8 & 255) / 255,
                     static_cast<float>(bits >> 16 & 255) / 255};
      }
      image.add_rgb("", pixels);
      write_png(path(fmt::format("{}{}.png", name, t)), image, ToneCurve::srgb);
      scene << fmt::format(
          "Texture \"t{0}\" \"spectrum\" \"imagemap\" \"string filename\" \"{1}{0}.png\"\n"
          "Material \"diffuse\" \"texture reflectance\" \"t{0}\"\n"
          "Shape \"trianglemesh\" \"point3 P\" [{2} -3 0 {3} -3 0 {3} 3 0 {2} 3 0] \"integer indices\" [0 1 2 0 2 3]\n"
          "  \"point2 uv\" [0 0 1 0 1 1 0 1]\n",
          t, name, t * 0.5 - 3, t * 0.5 - 2.5);
    }
  }

  Render render_scene(const std::string& scene, const char* memory, const std::string& picture) {
    const auto start = std::chrono::steady_clock::now();
    const Outcome outcome = run({"render", scene + ".pbrt", "--memory", memory,      "--size", "48x48",    "--samples",
                                 "1",      "--gather",      "4",        "--photons", "10000",  "--engine", "reverse",
                                 "--disk", "never",         "--stats",  "s.json",    "-o",     picture,    "-q"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const nlohmann::json bytes = read_json("s.json")["memory_bytes"];
    return {bytes["peak_rss"].get<double>() / (1 << 20), bytes["peak_beside_scene"].get<double>() / (1 << 20),
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()};
  }
};

TEST_F(SlowTextureMemoryTest, OfManyLargeFilesIsWithinTheBudget) {
  constexpr int kSide = 1500, kBudget = 64;
  write_scene("small", 4);
  write_scene("large", kSide);
  const Render small = render_scene("small", "64M", "small.exr");
  const Render ample = render_scene("large", "2G", "ample.exr");
  const Render large = render_scene("large", "64M", "large.exr");
  constexpr double kTexels = kTextures * 3.0 * kSide * kSide / (1 << 20);
  fmt::print(
      "{:.0f} MiB of texels: peak {:.1f} MiB in {:.1f} s with 2G; {:.1f} MiB in {:.1f} s with 64M ({:.1f} beside the "
      "scene), where small textures take {:.1f} MiB\n",
      kTexels, ample.peak_mib, ample.seconds, large.peak_mib, large.seconds, large.beside_scene_mib, small.peak_mib);
  EXPECT_GT(ample.peak_mib - small.peak_mib, kTexels / 2) << "the textures are too small to show anything";
  // A quarter of the budget is for texels; what one file's decoding takes comes for a while.
  EXPECT_LT(large.peak_mib - small.peak_mib, kBudget / 2);
  EXPECT_LE(large.beside_scene_mib, kBudget);
  EXPECT_LT(large.seconds, 20);
  const Image a = read_image(path("ample.exr")), b = read_image(path("large.exr"));
  ASSERT_EQ(a.channels().size(), b.channels().size());
  for (std::size_t c = 0; c < a.channels().size(); ++c) EXPECT_EQ(a.channels()[c].samples, b.channels()[c].samples);
}

}  // namespace
}  // namespace glowworm
