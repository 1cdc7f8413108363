#include "film/earlier_frames.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/parallel.h"
#include "kernels/light_window.h"
#include "scene/projection.h"

namespace glowworm {

namespace {

/// Most of the expected squares of differences that the same light shows.
constexpr float kMostOfPatch = 2, kMostOfSum = 4;

/// Pixels of a view.
class Pixels {
 public:
  Pixels(const FrameView& view, const FilterGuides& guides) : view_(view), guides_(guides) {}

  bool has(int x, int y) const { return x >= 0 && y >= 0 && x < guides_.width && y < guides_.height; }
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(guides_.width) + static_cast<std::size_t>(x);
  }
  float depth(int x, int y) const { return guides_.depth[at(x, y)]; }
  Vec3 normal(int x, int y) const { return guides_.normal[at(x, y)]; }
  /// The place that the middle of a pixel shows.
  Vec3 place(int x, int y) const {
    const Vec2 film{static_cast<float>(x + view_.bounds.x0) + 0.5f, static_cast<float>(y + view_.bounds.y0) + 0.5f};
    return unproject(view_.camera, film, view_.width, view_.height, depth(x, y));
  }
  /// Change of depth to the next pixels, metres: at edges, which have short mean normals, the largest; elsewhere that
  /// on the flatter side.
  float slope(int x, int y) const {
    const bool edge = shows_edge(normal(x, y));
    float slope = 0;
    for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{0, 1}}) {
      float sides[2];
      for (int side = 0; side < 2; ++side) {
        const int u = x + (side ? dx : -dx), v = y + (side ? dy : -dy);
        const float change = has(u, v) ? std::abs(depth(u, v) - depth(x, y)) : INFINITY;
        sides[side] = std::isfinite(change) ? change : edge ? 0 : INFINITY;
      }
      const float change = edge ? std::max(sides[0], sides[1]) : std::min(sides[0], sides[1]);
      if (std::isfinite(change)) slope = std::max(slope, change);
    }
    return slope;
  }
  /// The pixel that a place falls on; within the frame or not.
  Projection find(Vec3 place, int& x, int& y) const {
    const Projection found = project(view_.camera, place, view_.width, view_.height);
    const float far = 1e6f;
    const auto whole = [=](float v) { return static_cast<int>(std::floor(std::clamp(v, -far, far))); };
    x = whole(std::isfinite(found.film.x) ? found.film.x : -far) - view_.bounds.x0;
    y = whole(std::isfinite(found.film.y) ? found.film.y : -far) - view_.bounds.y0;
    return found;
  }

 private:
  const FrameView& view_;
  const FilterGuides& guides_;
};

/// Whether the light around two pixels is the same.
/// @param a with quiet_variance(). If `b` shows the same light, its samples have the same variance.
bool same_light(const LightEstimate& a, const Pixels& of_a, int x, int y, const LightEstimate& b, const Pixels& of_b,
                int u, int v) {
  float squares = 0, sum = 0, variance = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      if (!of_a.has(x + dx, y + dy) || !of_b.has(u + dx, v + dy)) continue;
      const std::size_t i = of_a.at(x + dx, y + dy), j = of_b.at(u + dx, v + dy);
      const float difference = a.level[i] - b.level[j];
      squares += difference * difference;
      sum += difference;
      variance +=
          a.variance[i] * (1 + static_cast<float>(a.samples[i]) / static_cast<float>(std::max(b.samples[j], 1u)));
    }
  return squares <= kMostOfPatch * variance && sum * sum <= kMostOfSum * variance;
}

/// The least share of a variance that the spread of so many samples is by chance: two standard deviations below it, by
/// Wilson and Hilferty's approximation of the chi-squared distribution.
float least_by_chance(std::uint32_t samples) {
  const float share = 2 / (9 * static_cast<float>(std::max(samples, 2u) - 1));
  const float root = std::max(1 - share - 2 * std::sqrt(share), 0.0f);
  return root * root * root;
}

/// Variances for same_light(), from the pixels on the quieter side. At edges of light a pixel's own variance is far too
/// large, because its samples are stratified. Beside such an edge the pixels around give too much, so a pixel's own
/// variance counts where it is smaller than chance explains. At edges of surfaces few pixels are alike, and its own
/// variance counts wherever it is smaller.
std::vector<float> quiet_variance(const LightEstimate& estimate, const FilterGuides& guides) {
  std::vector<float> out = expected_variance(estimate, guides);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const float own = estimate.variance[i];
    if (own < out[i] * (shows_edge(guides.normal[i]) ? 1 : least_by_chance(estimate.samples[i]))) out[i] = own;
  }
  return out;
}

/// The mean of a pixel's samples and of others.
class SampleMean {
 public:
  SampleMean(const LightEstimate& own, std::size_t pixel) { add(own, pixel); }
  void add(const LightEstimate& other, std::size_t pixel) {
    const auto more = static_cast<float>(other.samples[pixel]);
    light_ += other.light[pixel] * more;
    level_ += other.level[pixel] * more;
    variance_ += other.variance[pixel] * more * more;
    samples_ += other.samples[pixel];
  }
  void put(LightEstimate& estimate, std::size_t pixel) const {
    const auto samples = static_cast<float>(samples_);
    estimate.light[pixel] = light_ / samples;
    estimate.level[pixel] = level_ / samples;
    estimate.variance[pixel] = variance_ / (samples * samples);
    estimate.samples[pixel] = samples_;
  }

 private:
  RGB light_;
  float level_ = 0, variance_ = 0;
  std::uint32_t samples_ = 0;
};

/// The pixel of a frame that shows the same place of a surface in the same light; nothing if none does.
/// @param own with quiet_variance()
std::optional<std::size_t> same_place(const LightEstimate& own, const Pixels& pixels, int x, int y,
                                      const FrameLight& frame, const LightEstimate& other) {
  const Pixels others(frame.view, frame.guides);
  int u = 0, v = 0;
  const Projection found = others.find(pixels.place(x, y), u, v);
  if (!(found.depth > 0) || !others.has(u, v)) return std::nullopt;
  // The place may lie a hundredth of its distance beside the one found again, beside the slope of the surface.
  const bool same = length_squared(others.normal(u, v) - pixels.normal(x, y)) <= kNormalDifference &&
                    std::abs(others.depth(u, v) - found.depth) <= 0.01f * found.depth + pixels.slope(x, y);
  if (!same || !same_light(own, pixels, x, y, other, others, u, v)) return std::nullopt;
  return others.at(u, v);
}

}  // namespace

FrameLights EarlierFrames::of_same_view() const {
  FrameLights out;
  std::copy_if(frames.begin(), frames.end(), std::back_inserter(out), [&](const auto& frame) {
    return same_view(frame->view.camera, view.camera) && frame->view.bounds == view.bounds;
  });
  return out;
}

void add_same_view(const FrameLights& same_view, LightEstimate FrameLight::*layer, LightEstimate& estimate) {
  if (same_view.empty()) return;
  parallel_for_each(estimate.samples.size(), 4096, [&](std::size_t i) {
    if (estimate.samples[i] == 0) return;
    SampleMean mean(estimate, i);
    for (const std::shared_ptr<const FrameLight>& frame : same_view) mean.add((*frame).*layer, i);
    mean.put(estimate, i);
  });
}

PixelSurface with_same_view(const FrameLights& same_view, std::size_t pixel, PixelSurface own, std::uint32_t& samples) {
  PixelSurface sum = {};
  std::uint32_t all = 0;
  const auto add = [&](const PixelSurface& other, std::uint32_t count) {
    const auto n = static_cast<float>(count);
    sum.albedo += other.albedo * n;
    sum.shown += other.shown * n;
    sum.caustic += other.caustic * n;
    sum.emitted += other.emitted * n;
    sum.variance += other.variance * n * n;
    all += count;
  };
  if (same_view.empty() || samples == 0) return own;
  add(own, samples);
  for (const std::shared_ptr<const FrameLight>& frame : same_view)
    add(frame->surfaces[pixel], frame->direct.samples[pixel]);
  samples = all;
  const auto n = static_cast<float>(all);
  return {sum.albedo / n, sum.shown / n, sum.caustic / n, sum.emitted / n, sum.variance / (n * n)};
}

void add_earlier_samples(const EarlierFrames& earlier, const FilterGuides& guides, LightEstimate FrameLight::*layer,
                         LightEstimate& estimate) {
  LightEstimate own = estimate;
  own.variance = quiet_variance(estimate, guides);
  const Pixels pixels(earlier.view, guides);
  const FrameLights same = earlier.of_same_view();
  add_same_view(same, layer, estimate);
  const auto add_to = [&](int x, int y) {
    const std::size_t i = pixels.at(x, y);
    if (!std::isfinite(pixels.depth(x, y)) || own.samples[i] == 0) return;
    SampleMean mean(estimate, i);
    for (const std::shared_ptr<const FrameLight>& frame : earlier.frames) {
      if (std::find(same.begin(), same.end(), frame) != same.end()) continue;
      const LightEstimate& other = (*frame).*layer;
      if (const std::optional<std::size_t> j = same_place(own, pixels, x, y, *frame, other)) mean.add(other, *j);
    }
    mean.put(estimate, i);
  };
  parallel_for_each(static_cast<std::size_t>(guides.height), 4, [&](std::size_t y) {
    for (int x = 0; x < guides.width; ++x) add_to(x, static_cast<int>(y));
  });
}

}  // namespace glowworm
