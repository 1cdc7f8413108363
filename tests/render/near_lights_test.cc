// Lights close to surfaces, near the origin and far from it, against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "core/frame.h"
#include "photon/photon_tracer.h"
#include "render/render_testing.h"
#include "scene/scene_parts.h"
#include "support/chi_squared.h"

namespace glowworm {
namespace {

constexpr double kWallAlbedo = 0.5;

/// A patch of 2 x 2 metres and a light of the same size above it, which reflects nothing.
struct Pair {
  Vec3 center, normal;
  float distance;  ///< wanted; metres
};

/// The gap between the two that float leaves of what is wanted, along the normal.
double gap(const Pair& pair) {
  const Vec3 light = pair.center + pair.normal * pair.distance;
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += (static_cast<double>(light[k]) - pair.center[k]) * pair.normal[k];
  return sum;
}

/// Whether floats around the patch are fine enough for a gap: 32 units in the last place of its coordinates.
bool is_resolved(const Pair& pair) {
  const float largest = std::max({1.0f, std::abs(pair.center.x), std::abs(pair.center.y), std::abs(pair.center.z)});
  return pair.distance > 32 * (std::nextafter(largest, 2 * largest) - largest);
}

SceneDescription describe(const Pair& pair) {
  SceneDescription d;
  d.materials.resize(2);
  d.materials[0].reflectance.value = RGB(kWallAlbedo);
  d.materials[1].reflectance.value = RGB(0.0f);
  const Frame frame = Frame::from_normal(pair.normal);
  const Vec3 corner = pair.center - frame.s - frame.t;
  add_quad(d, corner, frame.s * 2, frame.t * 2);
  add_quad(d, corner + pair.normal * pair.distance, frame.t * 2, frame.s * 2, 1, add_emission(d, RGB(1.0f)));
  // From within the gap at the middle of the patch.
  d.cameras.push_back(square_view(pair.center, pair.normal, pair.distance / 2, 0.01f * std::min(pair.distance, 1.0f)));
  return d;
}

/// Form factor from the middle of the patch to the light (Howell, "Radiation configuration factors", B-4).
double factor_of_middle(double distance) {
  const double x = 1 / distance, root = std::sqrt(1 + x * x);
  return 4 / M_PI * (x / root) * std::atan(x / root);
}

/// Form factor between two parallel squares (the same, C-11).
double factor_of_squares(double distance) {
  const double x = 2 / distance, square = 1 + x * x, root = std::sqrt(square);
  return 2 / (M_PI * x * x) *
         (std::log(std::sqrt(square * square / (1 + 2 * x * x))) + 2 * x * root * std::atan(x / root) -
          2 * x * std::atan(x));
}

/// Light at all distances over patches at all coordinates, upright and not.
std::vector<Pair> pairs() {
  std::vector<Pair> out;
  for (const float at : {0.0f, 3.0f, 100.0f, 1e4f})
    for (const Vec3 normal : {Vec3{1, 0, 0}, Vec3{0, 0, -1}, normalize({0.6f, -0.3f, 0.5f})})
      for (const float distance : {1e-4f, 1e-3f, 1e-2f, 0.1f, 0.3f, 1.0f, 10.0f, 100.0f}) {
        const Pair pair{{at, at * -0.5f, at * 0.75f}, normal, distance};
        if (is_resolved(pair)) out.push_back(pair);
      }
  return out;
}

std::string text(const Pair& pair) {
  return "light " + std::to_string(pair.distance) + " m from a patch at x = " + std::to_string(pair.center.x) +
         ", normal x = " + std::to_string(pair.normal.x);
}

TEST(NearLights, CasesCoverNearAndFar) {
  EXPECT_NEAR(factor_of_middle(0.3) * kWallAlbedo, 0.4658, 1e-4);
  std::size_t near = 0, far = 0;
  for (const Pair& pair : pairs()) {
    near += pair.distance == 1e-4f;
    far += pair.center.x == 1e4f;
  }
  EXPECT_EQ(near, 6u);
  EXPECT_EQ(far, 15u);
}

TEST(NearLights, LightPatchesByPathsAndByGatherRays) {
  for (const Pair& pair : pairs()) {
    const Stage stage(describe(pair));
    const double expected = kWallAlbedo * factor_of_middle(gap(pair));
    RenderSettings by_gather_rays = by_photons(4, 4, 64, 100);
    by_gather_rays.guiding = false;
    // Rounding moves the light by a few units in the last place.
    const double tolerance = (0.01 + 0.1 * std::abs(gap(pair) - pair.distance) / pair.distance) * expected;
    EXPECT_NEAR(mean(stage.render(by_path(4, 64))).luminance(), expected, tolerance) << text(pair);
    EXPECT_NEAR(mean(stage.render(by_gather_rays)).luminance(), expected, tolerance) << text(pair);
  }
}

TEST(NearLights, SendPhotonsToPatches) {
  for (const Pair& pair : pairs()) {
    const Stage stage(describe(pair));
    PhotonPassSettings settings;
    settings.photons = 2000;
    settings.max_emitted = 20000;
    settings.max_bounces = 1;
    Statistics statistics;
    const PhotonPass pass = trace_photons(*stage.tracer, settings, statistics);
    const auto emitted = static_cast<double>(pass.emitted);
    const double expected = factor_of_squares(gap(pair)), error = std::sqrt(expected * (1 - expected) / emitted);
    // 4.5 standard errors, and one path in ten thousand beside the edges.
    EXPECT_NEAR(pass.balance.arrived[0] / pass.balance.emitted[0], expected, 4.5 * error + 1e-4) << text(pair);
  }
}

}  // namespace
}  // namespace glowworm
