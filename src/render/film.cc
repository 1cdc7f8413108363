#include "render/film.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace glowworm {

namespace {
constexpr int kLayers = 6;
}

Film::Film(int width, int height, bool indirect_only, bool layers)
    : width_(width), height_(height), indirect_only_(indirect_only), layers_(layers) {
  const std::size_t n = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  for (int layer = 0; layer < (layers ? kLayers : 1); ++layer) sums_[layer].resize(n);
  depth_sum_.resize(layers ? n : 0);
  depth_count_.resize(layers ? n : 0);
  count_.resize(n);
  square_sum_.resize(n);
}

std::uint64_t Film::bytes(int width, int height, bool layers) {
  return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) *
         (layers ? kLayers * sizeof(RGB) + 4 * sizeof(float) : sizeof(RGB) + 2 * sizeof(float));
}

void Film::add(const CameraTask& task, const SlotRadiance& radiance, const FirstHit& first_hit) {
  const std::size_t pixels = task.pixel_count();
  const int tile_width = task.x1 - task.x0;
  for (std::size_t slot = 0; slot < task.slot_count(); ++slot) {
    const auto in_tile = static_cast<int>(slot % pixels);
    const std::size_t pixel = static_cast<std::size_t>(task.y0 + in_tile / tile_width) * width_ +
                              static_cast<std::size_t>(task.x0 + in_tile % tile_width);
    if (count_[pixel] != task.first_sample + slot / pixels) continue;
    const RGB light[4] = {radiance.emitted[slot], radiance.direct[slot], radiance.indirect[slot],
                          radiance.caustic[slot]};
    const RGB shown = indirect_only_ ? light[2] : light[0] + light[1] + light[2] + light[3];
    square_sum_[pixel] += luminance(shown) * luminance(shown);
    ++count_[pixel];
    if (!layers_) {
      sums_[0][pixel] += shown;
      continue;
    }
    for (int layer = 0; layer < 4; ++layer) sums_[layer][pixel] += light[layer];
    sums_[4][pixel] += first_hit.albedo[slot];
    const Vec3 n = first_hit.normal[slot];
    sums_[5][pixel] += RGB(n.x, n.y, n.z);
    if (std::isfinite(first_hit.depth[slot])) {
      depth_sum_[pixel] += first_hit.depth[slot];
      ++depth_count_[pixel];
    }
  }
}

bool Film::has(const CameraTask& task) const {
  for (int y = task.y0; y < task.y1; ++y) {
    const auto row = count_.begin() + static_cast<std::ptrdiff_t>(y) * width_;
    for (int x = task.x0; x < task.x1; ++x)
      if (row[x] < task.first_sample + task.sample_count) return false;
  }
  return true;
}

std::uint32_t Film::whole_passes() const { return *std::min_element(count_.begin(), count_.end()); }

bool Film::is_even() const {
  return std::all_of(count_.begin(), count_.end(), [&](std::uint32_t count) { return count == count_.front(); });
}

RGB Film::mean(Layer layer, std::size_t pixel) const {
  if (count_[pixel] == 0 || !layers_) return RGB();
  return sums_[static_cast<int>(layer)][pixel] / static_cast<float>(count_[pixel]);
}

float Film::depth(std::size_t pixel) const {
  if (!layers_ || depth_count_[pixel] == 0) return std::numeric_limits<float>::infinity();
  return depth_sum_[pixel] / static_cast<float>(depth_count_[pixel]);
}

RGB Film::radiance(std::size_t pixel, bool indirect_only) const {
  if (!layers_) return count_[pixel] == 0 ? RGB() : sums_[0][pixel] / static_cast<float>(count_[pixel]);
  if (indirect_only) return mean(Layer::indirect, pixel);
  return mean(Layer::emitted, pixel) + mean(Layer::direct, pixel) + mean(Layer::indirect, pixel) +
         mean(Layer::caustic, pixel);
}

double Film::noise() const {
  double image_mean = 0;
  for (std::size_t i = 0; i < pixel_count(); ++i) {
    if (count_[i] < 2) return std::numeric_limits<double>::infinity();
    image_mean += luminance(radiance(i, indirect_only_));
  }
  image_mean /= static_cast<double>(pixel_count());
  double sum = 0;
  for (std::size_t i = 0; i < pixel_count(); ++i) {
    const double n = count_[i], m = luminance(radiance(i, indirect_only_));
    const double variance = std::max(0.0, square_sum_[i] / n - m * m) / (n - 1);
    const double scale = m * m + 0.01 * image_mean * image_mean;
    if (scale > 0) sum += variance / scale;
  }
  return std::sqrt(sum / static_cast<double>(pixel_count()));
}

std::vector<float> Film::save() const {
  std::vector<float> out;
  out.reserve(bytes(width_, height_, layers_) / sizeof(float));
  for (const auto& layer : sums_)
    for (const RGB& v : layer) out.insert(out.end(), {v.r, v.g, v.b});
  out.insert(out.end(), depth_sum_.begin(), depth_sum_.end());
  out.insert(out.end(), square_sum_.begin(), square_sum_.end());
  // Counts stay below 2^24, so floats hold them exactly.
  for (const auto* counts : {&depth_count_, &count_})
    for (const std::uint32_t c : *counts) out.push_back(static_cast<float>(c));
  return out;
}

bool Film::restore(const std::vector<float>& state) {
  if (state.size() != bytes(width_, height_, layers_) / sizeof(float)) return false;
  std::size_t at = 0;
  for (auto& layer : sums_)
    for (RGB& v : layer) {
      v = {state[at], state[at + 1], state[at + 2]};
      at += 3;
    }
  for (auto* plane : {&depth_sum_, &square_sum_})
    for (float& v : *plane) v = state[at++];
  for (auto* counts : {&depth_count_, &count_})
    for (std::uint32_t& c : *counts) c = static_cast<std::uint32_t>(state[at++]);
  return true;
}

}  // namespace glowworm
