// The filter of edges, on a slanted edge of two surfaces with known noise.
#include "filter/edge_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/parallel.h"

namespace glowworm {
namespace {

constexpr int kEdgeSide = 48;
constexpr std::uint32_t kEdgeSamples = 16;
/// What the light filter leaves of the noise of pixels that see one surface.
constexpr float kLeft = 0.1f;

/// Share of the left surface in a pixel.
float left_share(std::size_t i) {
  const auto x = static_cast<float>(i % kEdgeSide), y = static_cast<float>(i / kEdgeSide);
  return std::clamp(kEdgeSide / 2.0f + 0.3f * (y - kEdgeSide / 2.0f) - x, 0.0f, 1.0f);
}

bool at_edge(std::size_t i) { return left_share(i) > 0 && left_share(i) < 1; }

/// Light of a sample's standard error `error`, and the picture without noise.
struct SlantedEdge {
  EdgePicture picture;
  std::vector<RGB> truth, radiance;
  std::vector<float> variance;

  /// @param rim light of the pixels at the edge alone, in addition
  SlantedEdge(float error, float rim) {
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    picture.width = picture.height = kEdgeSide;
    for (std::size_t i = 0; i < kEdgeSide * kEdgeSide; ++i) {
      const float a = left_share(i), b = 1 - a;
      picture.normal.push_back({b, 0, a});
      picture.depth.push_back(2 * a + 3 * b);
      picture.albedo.push_back(RGB(0.8f * a + 0.3f * b));
      truth.push_back(RGB(a + 0.3f * b) + (at_edge(i) ? RGB(rim) : RGB(0.0f)));
      const float left = at_edge(i) ? error : kLeft * error;
      radiance.push_back(truth[i] + RGB(left * normal(random)));
      variance.push_back(left * left);
      picture.variance.push_back(error * error);
      picture.samples.push_back(kEdgeSamples);
    }
  }

  /// Root of the mean squared error at the edge.
  double error() const {
    return root_at_edge([&](std::size_t i) { return std::pow(radiance[i].g - truth[i].g, 2); });
  }
  /// The error that the variances say.
  double said() const {
    return root_at_edge([&](std::size_t i) { return variance[i]; });
  }

  void filter() { filter_edges(picture, radiance, variance); }

 private:
  template <typename Square>
  double root_at_edge(Square&& square) const {
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (!at_edge(i)) continue;
      sum += square(i);
      ++count;
    }
    return std::sqrt(sum / count);
  }
};

TEST(EdgeFilter, RemovesNoiseOfPixelsThatSeeTwoSurfaces) {
  SlantedEdge edge(0.3f, 0);
  const double before = edge.error();
  edge.filter();
  EXPECT_LT(edge.error(), 0.1 * before);
  // The variance is cautious.
  EXPECT_GT(edge.said(), edge.error());
  EXPECT_LT(edge.said(), 0.2 * before);
}

TEST(EdgeFilter, LeavesPixelsWithLittleNoise) {
  SlantedEdge edge(0.1f, 0);
  const std::vector<RGB> before = edge.radiance;
  edge.filter();
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_TRUE(at_edge(i) || edge.radiance[i].g == before[i].g) << i;
}

/// Light that no linear function of the features is remains when the noise is smaller than it.
TEST(EdgeFilter, ConvergesToTheSamples) {
  for (const float error : {0.01f, 0.001f}) {
    SlantedEdge edge(error, 0.3f);
    const double before = edge.error();
    edge.filter();
    EXPECT_LT(edge.error(), 1.01 * before) << error;
  }
}

/// A sample that meets rare light is far beyond the noise of the pixels around.
TEST(EdgeFilter, SpreadsTheLightOfARareSampleAlongTheEdge) {
  SlantedEdge edge(0.1f, 0), other = edge;
  constexpr std::size_t kSpeck = (kEdgeSide / 2 + 1) * kEdgeSide + kEdgeSide / 2;
  ASSERT_TRUE(at_edge(kSpeck));
  edge.radiance[kSpeck] += RGB(1);
  edge.variance[kSpeck] = edge.picture.variance[kSpeck] = 1;
  edge.filter();
  other.filter();
  double sum = 0, largest = 0;
  for (std::size_t i = 0; i < edge.radiance.size(); ++i) {
    const double added = edge.radiance[i].g - other.radiance[i].g;
    sum += added;
    largest = std::max(largest, added);
  }
  EXPECT_NEAR(sum, 1, 0.1);
  EXPECT_LT(largest, 0.5);
}

/// Beside a lamp that nearly touches a surface, the light filter leaves noise, too, but few pixels are lit there.
TEST(EdgeFilter, LeavesRareLightWhereASurfaceHasNoEdge) {
  SlantedEdge lamp(0.1f, 0);
  constexpr std::size_t kSpeck = 8 * kEdgeSide + 6;
  for (std::size_t i = kSpeck - 4; i <= kSpeck + 4; ++i) {
    ASSERT_FALSE(at_edge(i));
    lamp.variance[i] = lamp.picture.variance[i];
  }
  SlantedEdge other = lamp;
  lamp.radiance[kSpeck] += RGB(1);
  lamp.variance[kSpeck] = lamp.picture.variance[kSpeck] = 1;
  lamp.filter();
  other.filter();
  EXPECT_GT(lamp.radiance[kSpeck].g, 1.9);
  float added = 0;
  for (std::size_t i = 0; i < lamp.radiance.size(); ++i)
    if (i != kSpeck) added = std::max(added, std::abs(lamp.radiance[i].g - other.radiance[i].g));
  EXPECT_LT(added, 0.01f);
}

TEST(EdgeFilter, LeavesPicturesOfOneSample) {
  SlantedEdge edge(0.1f, 0);
  edge.picture.samples[7] = 1;
  const double before = edge.error();
  edge.filter();
  EXPECT_EQ(edge.error(), before);
}

TEST(EdgeFilter, GivesTheSameBitsForAnyNumberOfThreads) {
  SlantedEdge one(0.1f, 0.02f), three(0.1f, 0.02f);
  set_thread_count(1);
  one.filter();
  set_thread_count(3);
  three.filter();
  set_thread_count(0);
  EXPECT_EQ(one.variance, three.variance);
  EXPECT_EQ(one.error(), three.error());
}

}  // namespace
}  // namespace glowworm
