// Triangles that lie exactly upon others change nothing.
#include <gtest/gtest.h>

#include "builtin/builtin.h"
#include "render/render_testing.h"

namespace glowworm {
namespace {

TEST(RepeatedTriangles, LeaveThePictureAsItIsToTheBit) {
  const SceneDescription once = builtin_scene("cornell");
  SceneDescription thrice = once;
  for (int i = 0; i < 2; ++i) {
    thrice.geometry.triangles.insert(thrice.geometry.triangles.end(), once.geometry.triangles.begin(),
                                     once.geometry.triangles.end());
    thrice.geometry.material.insert(thrice.geometry.material.end(), once.geometry.material.begin(),
                                    once.geometry.material.end());
    thrice.geometry.emission.insert(thrice.geometry.emission.end(), once.geometry.emission.begin(),
                                    once.geometry.emission.end());
  }
  for (const RenderSettings& settings : {by_path(16, 4), by_photons(16, 1, 16, 20'000, "blocked")}) {
    const std::vector<RGB> picture = pixels(Stage(once).render(settings));
    EXPECT_GT(mean(picture).luminance(), 0);
    EXPECT_EQ(pixels(Stage(thrice).render(settings)), picture);
  }
}

}  // namespace
}  // namespace glowworm
