// The path tracer with two kinds of random numbers: both give unbiased estimates of one picture.
#include <gtest/gtest.h>

#include <vector>

#include "builtin/builtin.h"
#include "render/render_testing.h"
#include "support/scene_test_name.h"
#include "support/z_test.h"

namespace glowworm {
namespace {

struct Estimates {
  std::vector<float> mean, variance_of_mean;
  EstimateSpan span() const { return {mean, variance_of_mean}; }
};

/// Mean over renders of seeds of their own, for each pixel and channel, and the variance of that mean.
Estimates render_often(const Stage& stage, RenderSettings settings, std::uint32_t renders) {
  std::vector<double> sum, squares;
  for (std::uint32_t i = 0; i < renders; ++i) {
    settings.seed = 1000 + i;
    const std::vector<RGB> picture = pixels(stage.render(settings));
    sum.resize(3 * picture.size());
    squares.resize(sum.size());
    for (std::size_t k = 0; k < sum.size(); ++k) {
      const double v = picture[k / 3][static_cast<int>(k % 3)];
      sum[k] += v;
      squares[k] += v * v;
    }
  }
  Estimates out;
  for (std::size_t k = 0; k < sum.size(); ++k) {
    const double m = sum[k] / renders;
    out.mean.push_back(static_cast<float>(m));
    out.variance_of_mean.push_back(static_cast<float>(std::max(0.0, squares[k] / renders - m * m) / (renders - 1)));
  }
  return out;
}

class Samplers : public testing::TestWithParam<const char*> {};

/// A chance of 1 in 100 of a false alarm over all pixels together.
TEST_P(Samplers, GiveOnePictureByPixel) {
  const Stage stage(builtin_scene(GetParam()));
  RenderSettings settings = by_path(8, 16);
  settings.sampler = SamplerKind::sobol;
  const Estimates sobol = render_often(stage, settings, 100);
  settings.sampler = SamplerKind::independent;
  const Estimates independent = render_often(stage, settings, 100);
  const ZTest test = z_test(sobol.span(), independent.span(), 0.01);
  EXPECT_TRUE(test.passed()) << test.rejected << " of " << test.entries << " rejected, smallest p " << test.smallest_p;
}

INSTANTIATE_TEST_SUITE_P(Scenes, Samplers, testing::Values("furnace-box", "cornell", "window-room"), scene_test_name);

}  // namespace
}  // namespace glowworm
