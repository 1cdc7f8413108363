#include "render/film.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/parallel.h"

namespace glowworm {

namespace {

template <typename Sum>
RGB mean_of(const std::array<Sum, 3>& sums, std::uint32_t count) {
  const double n = count;
  return {static_cast<float>(sums[0].value() / n), static_cast<float>(sums[1].value() / n),
          static_cast<float>(sums[2].value() / n)};
}

/// Counts samples of an id. Those that find no room are not counted.
void count(Film::IdCounts& ids, std::uint32_t id, std::uint32_t samples = 1) {
  for (Film::IdCount& entry : ids) {
    if (entry.count > 0 && entry.id != id) continue;
    entry.id = id;
    entry.count += samples;
    return;
  }
}

/// Whether the entries may have come from so many samples.
bool is_possible_count(const Film::IdCounts& ids, std::uint32_t samples) {
  std::uint64_t sum = 0;
  for (const Film::IdCount& entry : ids) sum += entry.count;
  return sum <= samples;
}

/// Pixels that one piece of parallel work adds samples to.
constexpr std::size_t kPixelsAtOnce = 4096;

/// What the luminance of light is divided by.
float shading_albedo(RGB albedo) { return std::max(luminance(albedo), Film::kMinAlbedo); }

}  // namespace

Film::Film(const PixelBounds& bounds, bool indirect_only, bool layers, PlaceLayers places, bool moments)
    : bounds_(bounds), indirect_only_(indirect_only), layers_(layers), places_(places) {
  const std::size_t n = bounds.pixel_count();
  for (int layer = 0; layer < (layers ? 4 : 1); ++layer) light_[layer].resize(n);
  albedo_.resize(layers ? n : 0);
  normal_.resize(layers ? n : 0);
  position_.resize(places.position ? n : 0);
  uv_.resize(places.uv ? n : 0);
  objects_.resize(places.objects ? n : 0);
  materials_.resize(places.materials ? n : 0);
  depth_sum_.resize(layers ? n : 0);
  depth_count_.resize(layers ? n : 0);
  count_.resize(n);
  square_sum_.resize(n);
  for (auto& sums : moments_) sums.resize(moments ? n : 0);
}

std::uint64_t Film::bytes(const PixelBounds& bounds, bool layers, PlaceLayers places, bool moments) {
  constexpr std::uint64_t kLight = 3 * sizeof(LightSum), kAlways = sizeof(SquareSum) + sizeof(std::uint32_t);
  constexpr std::uint64_t kFirstHit = 6 * sizeof(UnitSum) + sizeof(LightSum) + sizeof(std::uint32_t);
  const std::uint64_t of_places =
      (places.position + places.uv) * kLight + (places.objects + places.materials) * sizeof(IdCounts);
  return bounds.pixel_count() *
         (kAlways + of_places + (layers ? 4 * kLight + kFirstHit : kLight) + (moments ? 2 * sizeof(SquareSum) : 0));
}

template <typename Sum>
void Film::add(std::array<Sum, 3>& sums, RGB value) {
  for (int c = 0; c < 3; ++c) sums[static_cast<std::size_t>(c)] += value[c];
}

void Film::add_place(std::size_t pixel, const FirstHit& first_hit, std::size_t slot, const Geometry& geometry) {
  const std::uint32_t triangle = first_hit.triangle[slot];
  if (triangle == kNone) return;
  const Vec2 at = first_hit.barycentric[slot];
  const auto& vertices = geometry.triangles[triangle];
  const auto interpolated = [&](const auto& of) {
    return of[vertices[0]] * (1 - at.x - at.y) + of[vertices[1]] * at.x + of[vertices[2]] * at.y;
  };
  if (places_.position) {
    const Vec3 p = interpolated(geometry.positions);
    add(position_[pixel], RGB(p.x, p.y, p.z));
  }
  if (places_.uv) {
    const Vec2 uv = interpolated(geometry.uvs);
    add(uv_[pixel], RGB(uv.x, uv.y, 0));
  }
  if (places_.objects) count(objects_[pixel], geometry.object_of(triangle));
  if (places_.materials) count(materials_[pixel], geometry.material[triangle]);
}

void Film::add(const CameraTask& task, const SlotRadiance& radiance, const FirstHit& first_hit,
               const Geometry& geometry) {
  const std::size_t pixels = task.pixel_count();
  const int tile_width = task.x1 - task.x0;
  parallel_for(0, pixels, kPixelsAtOnce, [&](std::size_t first, std::size_t last) {
    for (std::size_t in_tile = first; in_tile < last; ++in_tile) {
      const int y = static_cast<int>(in_tile) / tile_width, x = static_cast<int>(in_tile) % tile_width;
      const std::size_t pixel = static_cast<std::size_t>(task.y0 - bounds_.y0 + y) * static_cast<std::size_t>(width()) +
                                static_cast<std::size_t>(task.x0 - bounds_.x0 + x);
      for (std::uint32_t sample = 0; sample < task.sample_count; ++sample) {
        if (count_[pixel] != task.first_sample + sample) continue;
        add(pixel, radiance, first_hit, sample * pixels + in_tile);
        if (layers_ && places_.any()) add_place(pixel, first_hit, sample * pixels + in_tile, geometry);
      }
    }
  });
}

void Film::add(std::size_t pixel, const SlotRadiance& radiance, const FirstHit& first_hit, std::size_t slot) {
  const RGB light[4] = {radiance.emitted[slot], radiance.direct[slot], radiance.indirect[slot], radiance.caustic[slot]};
  const RGB shown = indirect_only_ ? light[2] : light[0] + light[1] + light[2] + light[3];
  square_sum_[pixel] += luminance(shown) * luminance(shown);
  ++count_[pixel];
  if (!layers_) {
    add(light_[0][pixel], shown);
    return;
  }
  for (int layer = 0; layer < 4; ++layer) add(light_[layer][pixel], light[layer]);
  add(albedo_[pixel], first_hit.albedo[slot]);
  const Vec3 n = first_hit.normal[slot];
  add(normal_[pixel], RGB(n.x, n.y, n.z));
  if (std::isfinite(first_hit.depth[slot])) {
    depth_sum_[pixel] += first_hit.depth[slot];
    ++depth_count_[pixel];
  }
  if (!has_moments()) return;
  const float albedo = shading_albedo(first_hit.albedo[slot]);
  for (int i = 0; i < 2; ++i) {
    const float l = luminance(light[1 + i]);
    moments_[i][pixel] += l * l / albedo;
  }
}

void Film::merge(const Film& other) {
  const auto add_scalars = [](auto& sums, const auto& others) {
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += others[i];
  };
  const auto add_colors = [](auto& sums, const auto& others) {
    for (std::size_t i = 0; i < sums.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) sums[i][c] += others[i][c];
  };
  for (int layer = 0; layer < 4; ++layer) add_colors(light_[layer], other.light_[layer]);
  add_colors(albedo_, other.albedo_);
  add_colors(normal_, other.normal_);
  add_colors(position_, other.position_);
  add_colors(uv_, other.uv_);
  const auto add_ids = [](auto& ids, const auto& others) {
    for (std::size_t i = 0; i < ids.size(); ++i)
      for (const IdCount& entry : others[i])
        if (entry.count > 0) count(ids[i], entry.id, entry.count);
  };
  add_ids(objects_, other.objects_);
  add_ids(materials_, other.materials_);
  add_scalars(depth_sum_, other.depth_sum_);
  add_scalars(square_sum_, other.square_sum_);
  for (int i = 0; i < 2; ++i) add_scalars(moments_[i], other.moments_[i]);
  add_scalars(depth_count_, other.depth_count_);
  add_scalars(count_, other.count_);
  not_finite_ += other.not_finite_;
}

bool Film::has(const CameraTask& task) const {
  for (int y = task.y0; y < task.y1; ++y) {
    const auto row = count_.begin() + static_cast<std::ptrdiff_t>(y - bounds_.y0) * width();
    for (int x = task.x0; x < task.x1; ++x)
      if (row[x - bounds_.x0] < task.first_sample + task.sample_count) return false;
  }
  return true;
}

std::uint32_t Film::whole_passes() const { return *std::min_element(count_.begin(), count_.end()); }

bool Film::is_even() const {
  return std::all_of(count_.begin(), count_.end(), [&](std::uint32_t count) { return count == count_.front(); });
}

RGB Film::mean(Layer layer, std::size_t pixel) const {
  if (count_[pixel] == 0 || !layers_) return RGB();
  if (layer == Layer::albedo) return mean_of(albedo_[pixel], count_[pixel]);
  if (layer == Layer::normal) return mean_of(normal_[pixel], count_[pixel]);
  if (layer == Layer::position || layer == Layer::uv) {
    const auto& sums = layer == Layer::uv ? uv_ : position_;
    return sums.empty() || depth_count_[pixel] == 0 ? RGB() : mean_of(sums[pixel], depth_count_[pixel]);
  }
  return mean_of(light_[static_cast<int>(layer)][pixel], count_[pixel]);
}

float Film::depth(std::size_t pixel) const {
  if (!layers_ || depth_count_[pixel] == 0) return std::numeric_limits<float>::infinity();
  return static_cast<float>(depth_sum_[pixel].value() / depth_count_[pixel]);
}

float Film::coverage(std::size_t pixel) const {
  if (!layers_ || count_[pixel] == 0) return 0;
  return static_cast<float>(depth_count_[pixel]) / static_cast<float>(count_[pixel]);
}

RGB Film::radiance(std::size_t pixel, bool indirect_only) const {
  if (!layers_) return count_[pixel] == 0 ? RGB() : mean_of(light_[0][pixel], count_[pixel]);
  if (indirect_only) return mean(Layer::indirect, pixel);
  return mean(Layer::emitted, pixel) + mean(Layer::direct, pixel) + mean(Layer::indirect, pixel) +
         mean(Layer::caustic, pixel);
}

Film::Moments Film::moments(Layer layer, std::size_t pixel) const {
  if (count_[pixel] == 0) return {};
  const double n = count_[pixel];
  const double albedo = shading_albedo(mean(Layer::albedo, pixel));
  const double m = luminance(mean(layer, pixel)) / albedo;
  if (count_[pixel] < 2) return {static_cast<float>(m), 0};
  const double square = moments_[layer == Layer::indirect ? 1 : 0][pixel].value() / n / albedo;
  return {static_cast<float>(m), static_cast<float>(std::max(0.0, square - m * m) / (n - 1))};
}

float Film::variance(std::size_t pixel) const {
  if (count_[pixel] < 2) return 0;
  const double n = count_[pixel], m = luminance(radiance(pixel, indirect_only_));
  return static_cast<float>(std::max(0.0, square_sum_[pixel].value() / n - m * m) / (n - 1));
}

template <typename Self, typename Work>
void Film::for_arrays(Self& self, Work&& work) {
  for (auto& layer : self.light_) work(layer);
  work(self.albedo_);
  work(self.normal_);
  work(self.position_);
  work(self.uv_);
  work(self.objects_);
  work(self.materials_);
  work(self.depth_sum_);
  work(self.square_sum_);
  for (auto& sums : self.moments_) work(sums);
  work(self.depth_count_);
  work(self.count_);
}

std::vector<std::uint32_t> Film::save() const {
  std::vector<std::uint32_t> out(state_bytes() / sizeof(std::uint32_t) + 2);
  std::memcpy(out.data(), &not_finite_, sizeof not_finite_);
  std::size_t at = 2;
  for_arrays(*this, [&](const auto& array) {
    if (array.empty()) return;
    std::memcpy(&out[at], array.data(), array.size() * sizeof array[0]);
    at += array.size() * sizeof array[0] / sizeof(std::uint32_t);
  });
  return out;
}

bool Film::restore(const std::vector<std::uint32_t>& state) {
  if (state.size() != state_bytes() / sizeof(std::uint32_t) + 2) return false;
  std::memcpy(&not_finite_, state.data(), sizeof not_finite_);
  std::size_t at = 2;
  for_arrays(*this, [&](auto& array) {
    if (array.empty()) return;
    std::memcpy(static_cast<void*>(array.data()), &state[at], array.size() * sizeof array[0]);
    at += array.size() * sizeof array[0] / sizeof(std::uint32_t);
  });
  return is_possible();
}

bool Film::is_possible() const {
  const auto possible = [&](const auto& sums, std::size_t i) {
    return std::all_of(sums[i].begin(), sums[i].end(), [&](const auto& sum) { return sum.can_be_of(count_[i]); });
  };
  for (std::size_t i = 0; i < pixel_count(); ++i) {
    if (count_[i] > kMaxSamples || !square_sum_[i].can_be_of(count_[i]) || !possible(light_[0], i)) return false;
    for (const auto& sums : moments_)
      if (!sums.empty() && !sums[i].can_be_of(count_[i])) return false;
    if (!layers_) continue;
    for (int layer = 1; layer < 4; ++layer)
      if (!possible(light_[layer], i)) return false;
    if (!possible(albedo_, i) || !possible(normal_, i) || depth_count_[i] > count_[i] ||
        !depth_sum_[i].can_be_of(depth_count_[i]))
      return false;
    if ((places_.position && !possible(position_, i)) || (places_.uv && !possible(uv_, i))) return false;
    if (places_.objects && !is_possible_count(objects_[i], count_[i])) return false;
    if (places_.materials && !is_possible_count(materials_[i], count_[i])) return false;
  }
  return true;
}

}  // namespace glowworm
