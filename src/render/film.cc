#include "render/film.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace glowworm {

namespace {

template <typename Sum>
RGB mean_of(const std::array<Sum, 3>& sums, std::uint32_t count) {
  const double n = count;
  return {static_cast<float>(sums[0].value() / n), static_cast<float>(sums[1].value() / n),
          static_cast<float>(sums[2].value() / n)};
}

/// Counts a sample of an id. One that finds no room is not counted.
void count(Film::IdCounts& ids, std::uint32_t id) {
  for (Film::IdCount& entry : ids) {
    if (entry.count > 0 && entry.id != id) continue;
    entry.id = id;
    ++entry.count;
    return;
  }
}

/// Whether the entries may have come from so many samples.
bool is_possible_count(const Film::IdCounts& ids, std::uint32_t samples) {
  std::uint64_t sum = 0;
  for (const Film::IdCount& entry : ids) sum += entry.count;
  return sum <= samples;
}

}  // namespace

Film::Film(const PixelBounds& bounds, bool indirect_only, bool layers, PlaceLayers places)
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
}

std::uint64_t Film::bytes(const PixelBounds& bounds, bool layers, PlaceLayers places) {
  constexpr std::uint64_t kLight = 3 * sizeof(LightSum), kAlways = sizeof(SquareSum) + sizeof(std::uint32_t);
  constexpr std::uint64_t kFirstHit = 6 * sizeof(UnitSum) + sizeof(LightSum) + sizeof(std::uint32_t);
  const std::uint64_t of_places =
      (places.position + places.uv) * kLight + (places.objects + places.materials) * sizeof(IdCounts);
  return bounds.pixel_count() * (kAlways + of_places + (layers ? 4 * kLight + kFirstHit : kLight));
}

template <typename Sum>
void Film::add(std::array<Sum, 3>& sums, RGB value) {
  for (int c = 0; c < 3; ++c) sums[static_cast<std::size_t>(c)] += value[c];
}

void Film::add_place(std::size_t pixel, const FirstHit& first_hit, std::size_t slot, const Geometry& geometry) {
  const std::uint32_t triangle = first_hit.triangle[slot];
  if (triangle == kNone) return;
  const Vec2 at = first_hit.barycentric[slot];
  const auto& [a, b, c] = geometry.triangles[triangle];
  const auto interpolated = [&](const auto& of) { return of[a] * (1 - at.x - at.y) + of[b] * at.x + of[c] * at.y; };
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
  for (std::size_t slot = 0; slot < task.slot_count(); ++slot) {
    const auto in_tile = static_cast<int>(slot % pixels);
    const std::size_t pixel =
        static_cast<std::size_t>(task.y0 - bounds_.y0 + in_tile / tile_width) * static_cast<std::size_t>(width()) +
        static_cast<std::size_t>(task.x0 - bounds_.x0 + in_tile % tile_width);
    if (count_[pixel] != task.first_sample + slot / pixels) continue;
    const RGB light[4] = {radiance.emitted[slot], radiance.direct[slot], radiance.indirect[slot],
                          radiance.caustic[slot]};
    const RGB shown = indirect_only_ ? light[2] : light[0] + light[1] + light[2] + light[3];
    square_sum_[pixel] += luminance(shown) * luminance(shown);
    ++count_[pixel];
    if (!layers_) {
      add(light_[0][pixel], shown);
      continue;
    }
    for (int layer = 0; layer < 4; ++layer) add(light_[layer][pixel], light[layer]);
    add(albedo_[pixel], first_hit.albedo[slot]);
    const Vec3 n = first_hit.normal[slot];
    add(normal_[pixel], RGB(n.x, n.y, n.z));
    if (places_.any()) add_place(pixel, first_hit, slot, geometry);
    if (std::isfinite(first_hit.depth[slot])) {
      depth_sum_[pixel] += first_hit.depth[slot];
      ++depth_count_[pixel];
    }
  }
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
    const double variance = std::max(0.0, square_sum_[i].value() / n - m * m) / (n - 1);
    const double scale = m * m + 0.01 * image_mean * image_mean;
    if (scale > 0) sum += variance / scale;
  }
  return std::sqrt(sum / static_cast<double>(pixel_count()));
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
  work(self.depth_count_);
  work(self.count_);
}

std::vector<std::uint32_t> Film::save() const {
  std::vector<std::uint32_t> out(bytes(bounds_, layers_, places_) / sizeof(std::uint32_t) + 2);
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
  if (state.size() != bytes(bounds_, layers_, places_) / sizeof(std::uint32_t) + 2) return false;
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
    if (count_[i] > kMostSamples || !square_sum_[i].can_be_of(count_[i]) || !possible(light_[0], i)) return false;
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
