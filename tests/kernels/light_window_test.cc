// The vector kernel of the filter's window: the same bits as scalar code on every instruction set.
#include "kernels/light_window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "core/random.h"
#include "kernels/instruction_sets.h"
#include "kernels/light_window_reference.h"

namespace glowworm {
namespace {

/// A tile and what lies around it: three surfaces, gaps between them, black places and rare bright ones.
class WindowPixels {
 public:
  WindowPixels() {
    for (std::uint32_t i = 0; i < kPixels; ++i) {
      const std::uint32_t x = i % kWidth, y = i / kWidth, surface = (x / 13 + y / 17) % 4;
      const float level = surface == 2 ? 0 : 1 + 0.1f * number(i, 0) + (i % 97 == 0 ? 5 : 0);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        plane(axis)[i] = axis == surface || (surface == 3 && axis == 2) ? 1 - 0.1f * number(i, 9) : 0.05f;
        plane(5 + axis)[i] = level * (1 + static_cast<float>(axis));
      }
      if (surface == 1) plane(0)[i] = std::numeric_limits<float>::quiet_NaN();
      plane(3)[i] = surface == 1 ? 0 : surface == 3 ? 8 : 2 + 0.01f * static_cast<float>(x);
      plane(4)[i] = surface == 0 ? 0.01f : 0;
      plane(8)[i] = level;
      plane(9)[i] = surface == 2 ? 0 : 0.01f * number(i, 1);
      plane(10)[i] = surface == 2 ? 0 : number(i, 2) + (i % 97 == 0 ? 5 : 0);
      plane(11)[i] = x % 5 == 0 ? 0.01f : number(i, 3);
      plane(12)[i] = level + number(i, 4);
    }
  }

  WindowPlanes planes() {
    constexpr std::size_t kFirst = (kWindowReach + 1) * (kWidth + 1);
    WindowPlanes out;
    out.stride = kWidth;
    for (std::size_t c = 0; c < 3; ++c) {
      out.normal[c] = plane(c) + kFirst;
      out.light[c] = plane(5 + c) + kFirst;
    }
    out.depth = plane(3) + kFirst;
    out.slope = plane(4) + kFirst;
    out.level = plane(8) + kFirst;
    out.variance = plane(9) + kFirst;
    out.spread = plane(10) + kFirst;
    out.noise = plane(11) + kFirst;
    out.shown = plane(12) + kFirst;
    return out;
  }

 private:
  static constexpr int kWidth = WindowSums::kWidth + 2 * (kWindowReach + 1);
  static constexpr int kHeight = WindowSums::kHeight + 2 * (kWindowReach + 1);
  static constexpr std::size_t kPixels = kWidth * kHeight;
  static float number(std::uint32_t i, std::uint32_t which) { return to_unit_float(hash_combine(hash32(i), which)); }
  float* plane(std::size_t which) { return values_.data() + which * kPixels; }

  /// What lies after the last plane counts as nothing at all.
  std::vector<float> values_ =
      std::vector<float>(13 * kPixels + kWindowPadding, std::numeric_limits<float>::quiet_NaN());
};

TEST(LightWindow, SameBitsAsPlainLoops) {
  WindowPixels pixels;
  const WindowPlanes planes = pixels.planes();
  for (const int height : {WindowSums::kHeight, 5}) {
    WindowSums expected = {};
    add_window_reference(planes, height, expected);
    EXPECT_GT(expected.weight[WindowSums::at(3, 3)], 1);
    on_every_instruction_set([&] {
      WindowSums sums = {};
      add_window(planes, height, sums);
      const auto same_row = [&](const float* a, const float* b, int y) {
        return std::memcmp(a + WindowSums::at(0, y), b + WindowSums::at(0, y), WindowSums::kWidth * sizeof(float)) == 0;
      };
      for (int y = 0; y < WindowSums::kHeight; ++y) {
        for (int c = 0; c < 3; ++c) EXPECT_TRUE(same_row(sums.light[c], expected.light[c], y)) << y;
        for (const auto sum : {&WindowSums::weight, &WindowSums::variance, &WindowSums::surface, &WindowSums::level,
                               &WindowSums::any_weight})
          EXPECT_TRUE(same_row(sums.*sum, expected.*sum, y)) << y;
        for (const auto both : {&WindowSums::step, &WindowSums::slope, &WindowSums::any_step})
          for (int axis = 0; axis < 2; ++axis)
            EXPECT_TRUE(same_row((sums.*both)[axis], (expected.*both)[axis], y)) << y;
        for (int i = 0; i < 3; ++i) EXPECT_TRUE(same_row(sums.square[i], expected.square[i], y)) << y;
      }
    });
  }
}

TEST(LightWindow, FindsTheSameNoiseAsPlainLoops) {
  WindowPixels pixels;
  WindowPlanes planes = pixels.planes();
  constexpr int kWidth = WindowSums::kWidth;
  for (const bool lone : {true, false}) {
    planes.lone = lone;
    std::vector<float> expected(kWidth + kWindowPadding);
    find_noise_reference(planes, kWidth, expected.data());
    on_every_instruction_set([&] {
      std::vector<float> noise(kWidth + kWindowPadding);
      find_noise(planes, kWidth, noise.data());
      EXPECT_EQ(std::memcmp(noise.data(), expected.data(), kWidth * sizeof(float)), 0);
    });
  }
}

TEST(LightWindow, OctantsCoverTheWindowOnce) {
  using namespace light_window;
  std::set<std::pair<int, int>> places;
  for (int octant = 0; octant < kOctants; ++octant)
    for (int pixel = 0; pixel < kOctantPixels; ++pixel) {
      const OctantStep step = octant_step(octant, pixel);
      EXPECT_LE(std::max(std::abs(step.x), std::abs(step.y)), kWindowReach);
      EXPECT_TRUE(places.emplace(step.x, step.y).second) << step.x << ", " << step.y;
    }
  EXPECT_EQ(places.size(), (2 * kWindowReach + 1) * (2 * kWindowReach + 1) - 1);
}

}  // namespace
}  // namespace glowworm
