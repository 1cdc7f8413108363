// The vector kernel for diffuse scattering: the same bits as scalar code on every instruction set.
#include "kernels/diffuse_scatter.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "core/random.h"
#include "core/vec.h"
#include "kernels/diffuse_scatter_reference.h"
#include "kernels/instruction_sets.h"

namespace glowworm {
namespace {

float lane_number(std::uint32_t i, std::uint32_t which) { return to_unit_float(hash_combine(hash32(i), which)); }
Vec3 triple(std::uint32_t i, std::uint32_t which) {
  return {2 * lane_number(i, which) - 1, 2 * lane_number(i, which + 1) - 1, 2 * lane_number(i, which + 2) - 1};
}

/// Paths that arrive anywhere on any triangle: flat ones, smooth ones, ones without area, black ones, some seen at a
/// grazing angle, some with one black channel or hardly any flux.
struct Arrived {
  std::array<std::vector<float>, 36> arrays;

  explicit Arrived(std::size_t n) {
    for (auto& array : arrays) array.resize(n + kDiffuseScatterPadding);
    for (std::uint32_t i = 0; i < n; ++i) {
      const Vec3 a = triple(i, 1) * 3, b = a + triple(i, 4), c = i % 41 == 5 ? b : a + triple(i, 7);
      const Vec3 scaled = cross(b - a, c - a);
      const Vec3 normal = length(scaled) > 0 ? normalize(scaled) : Vec3{0, 0, 1};
      const bool flat = i % 3 == 0;
      set(0, i, a);
      set(3, i, b - a);
      set(6, i, c - a);
      set(32, i, normal);
      arrays[35][i] = 1e-6f * (1 + lane_number(i, 35));
      for (std::uint32_t corner = 0; corner < 3; ++corner) {
        set(9 + 3 * corner, i, flat ? Vec3{0, 0, 0} : normalize(normal + triple(i, 10 + 3 * corner) * 0.6f));
      }
      arrays[18][i] = lane_number(i, 20) * 0.5f;
      arrays[19][i] = lane_number(i, 21) * 0.5f;
      const Vec3 along = normalize(cross(normal, Vec3{0.3f, 0.5f, 0.8f}));
      set(20, i,
          i % 13 == 0 ? normalize(along + normal * (4e-3f * lane_number(i, 22) - 2e-3f)) : normalize(triple(i, 23)));
      const float brightness = i % 17 == 0 ? 1e-31f : 4;
      set(23, i, Vec3{lane_number(i, 26), lane_number(i, 27), lane_number(i, 28)} * brightness);
      set(26, i,
          i % 7 == 0 ? Vec3{0, 0, 0}
                     : Vec3{lane_number(i, 29), i % 5 == 0 ? 0 : lane_number(i, 30), lane_number(i, 31)});
      arrays[29][i] = lane_number(i, 32);
      // The middle of the square is a special case of the concentric map.
      arrays[30][i] = i % 97 == 0 ? 0.5f : lane_number(i, 33);
      arrays[31][i] = i % 97 == 0 ? 0.5f : lane_number(i, 34);
    }
  }

  ArrivedPaths view(std::size_t n) const {
    ArrivedPaths out;
    out.count = n;
    for (std::size_t k = 0; k < 3; ++k) out.corner[k] = arrays[k].data();
    for (std::size_t k = 0; k < 6; ++k) out.edges[k] = arrays[3 + k].data();
    for (std::size_t k = 0; k < 3; ++k) out.geometric[k] = arrays[32 + k].data();
    for (std::size_t k = 0; k < 9; ++k) out.vertex_normals[k] = arrays[9 + k].data();
    for (std::size_t k = 0; k < 2; ++k) out.barycentric[k] = arrays[18 + k].data();
    for (std::size_t k = 0; k < 3; ++k) out.back[k] = arrays[20 + k].data();
    for (std::size_t k = 0; k < 3; ++k) out.flux[k] = arrays[23 + k].data();
    for (std::size_t k = 0; k < 3; ++k) out.reflectance[k] = arrays[26 + k].data();
    out.offset = arrays[35].data();
    out.roulette = arrays[29].data();
    for (std::size_t k = 0; k < 2; ++k) out.square[k] = arrays[30 + k].data();
    return out;
  }

 private:
  void set(std::size_t first, std::size_t i, Vec3 v) {
    for (int axis = 0; axis < 3; ++axis) arrays[first + static_cast<std::size_t>(axis)][i] = v[axis];
  }
};

/// Arrays of the photon, then of the path that goes on, its flux at last.
struct Scattered {
  std::vector<std::uint32_t> outcome;
  std::array<std::vector<float>, 18> arrays;

  explicit Scattered(std::size_t n) : outcome(n + kDiffuseScatterPadding) {
    for (auto& array : arrays) array.resize(n + kDiffuseScatterPadding);
  }
  ScatteredPaths view() {
    ScatteredPaths out;
    out.outcome = outcome.data();
    float** const of[6] = {out.position, out.normal, out.photon_flux, out.origin, out.direction, out.flux};
    for (std::size_t k = 0; k < 18; ++k) of[k / 3][k % 3] = arrays[k].data();
    return out;
  }
  /// Whether array k says something of path i.
  bool says(std::size_t k, std::size_t i) const {
    const std::uint32_t bit = k < 9 ? kPhotonLeft : kPathGoesOn;
    return k >= 15 || (outcome[i] & bit);
  }
};

TEST(DiffuseScatter, IsThatOfPlainLoopsBitForBit) {
  for (const std::size_t n : {1u, 5u, 8u, 16u, 4000u}) {
    const Arrived arrived(n);
    Scattered expected(n);
    diffuse_scatter_reference(arrived.view(n), expected.view());
    on_every_instruction_set([&] {
      Scattered made(n);
      diffuse_scatter(arrived.view(n), made.view());
      for (std::size_t i = 0; i < n; ++i) {
        ASSERT_EQ(made.outcome[i], expected.outcome[i]) << i << " of " << n;
        for (std::size_t k = 0; k < 18; ++k) {
          if (!expected.says(k, i)) continue;
          ASSERT_EQ(std::memcmp(&made.arrays[k][i], &expected.arrays[k][i], sizeof(float)), 0)
              << i << " of " << n << ", array " << k << ": " << made.arrays[k][i] << ", " << expected.arrays[k][i];
        }
      }
    });
  }
}

TEST(DiffuseScatter, EndsAndContinuesPaths) {
  constexpr std::size_t kPaths = 20000;
  const Arrived arrived(kPaths);
  Scattered made(kPaths);
  diffuse_scatter(arrived.view(kPaths), made.view());
  std::size_t refused = 0, ended = 0, on = 0;
  for (std::size_t i = 0; i < kPaths; ++i) {
    const auto value = [&](std::size_t k) {
      return Vec3{made.arrays[k][i], made.arrays[k + 1][i], made.arrays[k + 2][i]};
    };
    const Vec3 back{arrived.arrays[20][i], arrived.arrays[21][i], arrived.arrays[22][i]};
    ended += made.outcome[i] == kPhotonLeft;
    if (i % 7 == 0) {
      EXPECT_EQ(made.outcome[i], 0u) << "black surfaces leave nothing";
    } else {
      // What comes from behind the shading normal.
      refused += made.outcome[i] == 0;
    }
    if (made.outcome[i] & kPhotonLeft) {
      EXPECT_GE(dot(value(3), back), 0);
    }
    if (!(made.outcome[i] & kPathGoesOn)) {
      EXPECT_EQ(value(15), (Vec3{0, 0, 0}));
      continue;
    }
    ++on;
    EXPECT_NEAR(length(value(12)), 1, 1e-6f);
    // Reflected: to the side that the path came from, and off the surface on that side.
    EXPECT_GT(dot(value(12), value(3)), 0);
    EXPECT_GT(dot(value(9) - value(0), value(3)), 0);
  }
  EXPECT_GT(refused, 100u);
  EXPECT_GT(ended, 1000u);
  EXPECT_GT(on, 1000u);
}

}  // namespace
}  // namespace glowworm
