// The radii of points in media that make the error along segments least.
#include "maps/volume_blur.h"

#include <gtest/gtest.h>

#include <iterator>

#include "density/volume_map.h"
#include "maps/medium_parts.h"
#include "media/media_testing.h"

namespace glowworm {
namespace {

/// Points in the cube from -1 to 1, where light is scattered as 1 + contrast sin(waves pi x), and lines through it.
struct Waves {
  float contrast = 0, waves = 0;
  MediaPhotons photons;

  Waves(float contrast, float waves, std::uint32_t count, std::uint32_t seed) : contrast(contrast), waves(waves) {
    Sampler sampler(SamplerKind::independent, seed, 1, 0);
    const auto place = [&] { return Vec3{sampler.next1(), sampler.next1(), sampler.next1()} * 2 - Vec3{1, 1, 1}; };
    const auto direction = [&] {
      const float z = 2 * sampler.next1() - 1, phi = 2 * kPi * sampler.next1(), r = std::sqrt(1 - z * z);
      return Vec3{r * std::cos(phi), r * std::sin(phi), z};
    };
    const RGB flux(32 * kPi / static_cast<float>(count));
    while (photons.points.size() < count) {
      const Vec3 p = place();
      if (sampler.next1() * (1 + contrast) < light(p)) photons.points.push_back(p, direction(), flux, 0, 0);
    }
    while (photons.beams.size() < 500) {
      const Vec3 p = place(), d = direction();
      if (std::max({std::abs(p.x + d.x), std::abs(p.y + d.y), std::abs(p.z + d.z)}) < 1)
        photons.beams.push_back(p, d, 1, RGB(1.0f), 0, 0);
    }
  }

  float light(Vec3 p) const { return 1 + contrast * std::sin(waves * kPi * p.x); }

  /// Mean square error along the lines with radii times a factor.
  double error(const Tracer& tracer, PhotonKernels kernels, float factor) const {
    VolumePhotons points = photons.points;
    correct_photons(tracer, factor, points, kernels);
    VolumeMap map;
    Statistics statistics;
    map.build(points, points.flux, kernels, factor, statistics);
    VolumeSegments segments;
    const VolumeBeams& lines = photons.beams;
    for (std::size_t i = 0; i < lines.size(); ++i)
      segments.push_back(lines.origin[i], lines.direction[i], 1, {RGB(0.0f), RGB(1.0f), 0, 0}, RGB(1.0f), 0);
    std::vector<RGB> found(segments.size(), RGB(0.0f));
    map.estimate(segments, found, statistics);
    double sum = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      double right = 0;
      constexpr int kSteps = 64;
      for (int n = 0; n < kSteps; ++n)
        right +=
            double{light(lines.origin[i] + lines.direction[i] * ((static_cast<float>(n) + 0.5f) / kSteps))} / kSteps;
      sum += (found[i].g - right) * (found[i].g - right) / static_cast<double>(lines.size());
    }
    return sum;
  }
};

/// @param sigma_t of its air, m^-1
Scene cube_of_air(float sigma_t = 0) {
  SceneDescription d;
  Medium medium = medium_of(sigma_t, 1);
  medium.bounds = Box3{{-1, -1, -1}, {1, 1, 1}};
  d.media.push_back(medium);
  d.ambient_medium = 0;
  add_box(d, {-3, -3, -3}, {3, 3, 3}, add_material(d, 0));
  return Scene(std::move(d));
}

/// Over four seeds, no factor that is tried has much less error than the chosen ones. Waves are longer than a kernel is
/// wide: shorter ones are lost either way.
TEST(SlowBestRadiusFactors, MakeTheErrorLeast) {
  const Scene scene = cube_of_air();
  const Tracer tracer(scene);
  constexpr float kTried[] = {0.5f, 0.7f, 1, 1.4f, 2};
  for (const float waves : {0.0f, 2.0f, 4.0f}) {
    double chosen = 0, tried[std::size(kTried)] = {};
    float least = 10, most = 0;
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
      const Waves scattered(0.9f, waves, 20'000, seed);
      const PhotonKernels kernels = volume_photon_kernels(scattered.photons.points, 50);
      const float factor = best_radius_factors(tracer, scattered.photons, kernels)[0];
      least = std::min(least, factor);
      most = std::max(most, factor);
      chosen += scattered.error(tracer, kernels, factor);
      for (std::size_t i = 0; i < std::size(kTried); ++i) tried[i] += scattered.error(tracer, kernels, kTried[i]);
    }
    for (const double error : tried) EXPECT_LT(chosen, 1.2 * error) << waves;
    EXPECT_LT(most, 1.25 * least) << waves;
  }
}

/// Even light asks for the widest radii. In a cube four free paths thick they change the transmittance within them by
/// no more than 0.5%: by (sigma_t r)^2 / 6.
TEST(BestRadiusFactors, AreLimitedByTheFreePath) {
  const Waves even(0, 0, 100'000, 0);
  const PhotonKernels kernels = volume_photon_kernels(even.photons.points, 16);
  double radius = 0;
  for (const float r : kernels.radii) radius += r / static_cast<double>(kernels.size());
  const auto factor = [&](float sigma_t) {
    const Scene scene = cube_of_air(sigma_t);
    return best_radius_factors(Tracer(scene), even.photons, kernels)[0];
  };
  const float free = factor(0), limited = factor(2);
  EXPECT_GT(std::pow(2 * radius * double{free}, 2) / 6, 0.0075);
  EXPECT_NEAR(std::pow(2 * radius * double{limited}, 2) / 6, 0.005, 0.0002);
  EXPECT_GT(limited, 1);
  // Nor do they shrink where they are wider than that.
  EXPECT_EQ(factor(8), 1);
}

TEST(BestRadiusFactors, AreOneWithoutPoints) {
  const Scene scene = cube_of_air();
  const Tracer tracer(scene);
  EXPECT_EQ(best_radius_factors(tracer, {}, {}), std::vector<float>{1});
}

}  // namespace
}  // namespace glowworm
