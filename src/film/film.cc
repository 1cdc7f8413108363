#include "film/film.h"

#include <algorithm>
#include <atomic>
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

/// Whether an entry of the film may have come from so many samples.
bool is_possible_of(const Film::IdCounts& ids, std::uint32_t samples) {
  std::uint64_t sum = 0;
  for (const Film::IdCount& entry : ids) sum += entry.count;
  return sum <= samples;
}
bool is_possible_of(std::uint32_t count, std::uint32_t samples) { return count <= samples; }
template <typename Integer, int kBits>
bool is_possible_of(const ExactSum<Integer, kBits>& sum, std::uint32_t samples) {
  return sum.can_be_of(samples);
}
template <typename Sum>
bool is_possible_of(const std::array<Sum, 3>& sums, std::uint32_t samples) {
  return std::all_of(sums.begin(), sums.end(), [&](const Sum& sum) { return sum.can_be_of(samples); });
}

/// Adds an entry of another film to one of the same pixel.
template <typename Entry>
void add_entry(Entry& to, const Entry& from) {
  to += from;
}
template <typename Sum>
void add_entry(std::array<Sum, 3>& to, const std::array<Sum, 3>& from) {
  for (std::size_t c = 0; c < 3; ++c) to[c] += from[c];
}
void add_entry(Film::IdCounts& to, const Film::IdCounts& from) {
  for (const Film::IdCount& entry : from)
    if (entry.count > 0) count(to, entry.id, entry.count);
}

template <typename Entry>
void add_all(std::vector<Entry>& to, const std::vector<Entry>& from) {
  for (std::size_t i = 0; i < to.size(); ++i) add_entry(to[i], from[i]);
}

/// Bytes that one piece of parallel work touches, so that arrays on disk leave memory in time (core/disk_memory.h).
constexpr std::size_t kBytesAtOnce = std::size_t{1} << 20;
/// Pixels whose entries merge_state() holds at once.
constexpr std::size_t kPixelsRead = std::size_t{1} << 18;

/// What the luminance of light is divided by.
float shading_albedo(RGB albedo) { return std::max(luminance(albedo), Film::kMinAlbedo); }

}  // namespace

Film::Film(const PixelBounds& bounds, bool indirect_only, bool layers, PlaceLayers places, bool moments,
           std::size_t light_groups, SampleBatches batches)
    : bounds_(bounds),
      indirect_only_(indirect_only),
      layers_(layers),
      has_moments_(moments),
      places_(places),
      batches_(batches) {
  const std::size_t n = bounds.pixel_count();
  for (int layer = 0; layer < (layers ? 4 : 1); ++layer) light_[layer].resize(n);
  groups_.resize(light_groups);
  for (auto& group : groups_) group.resize(n);
  albedo_.resize(layers ? n : 0);
  normal_.resize(layers ? n : 0);
  surface_albedo_.resize(places.surface_samples ? n : 0);
  surface_emitted_.resize(places.surface_samples ? n : 0);
  sun_.resize(places.surface_samples ? n : 0);
  medium_.resize(layers && places.medium ? n : 0);
  position_.resize(places.position ? n : 0);
  uv_.resize(places.uv ? n : 0);
  objects_.resize(places.objects ? n : 0);
  materials_.resize(places.materials ? n : 0);
  for (std::size_t i = 0; i < kSlotValues; ++i) {
    value_sum_[i].resize(places.values.has(i) ? n : 0);
    value_count_[i].resize(places.values.has(i) ? n : 0);
  }
  depth_sum_.resize(layers ? n : 0);
  depth_count_.resize(layers ? n : 0);
  count_.resize(n);
  square_sum_.resize(batches.count > 1 ? 0 : n);
  batch_sum_.resize(batches.count > 1 ? batches.count : 0);
  for (auto& batch : batch_sum_) batch.resize(n);
  for (auto& sums : moments_) sums.resize(moments ? n : 0);
  if (medium_.empty()) moments_[2].clear();
}

std::uint64_t Film::bytes(const PixelBounds& bounds, bool layers, PlaceLayers places, bool moments,
                          std::size_t light_groups, std::uint32_t batches) {
  constexpr std::uint64_t kLight = 3 * sizeof(LightSum);
  constexpr std::uint64_t kFirstHit = 6 * sizeof(UnitSum) + sizeof(LightSum) + sizeof(std::uint32_t);
  const std::uint64_t of_places =
      (places.position + places.uv + (layers && places.medium)) * kLight +
      (places.surface_samples ? 2 * kLight + 3 * sizeof(UnitSum) : 0) +
      (places.objects + places.materials) * sizeof(IdCounts) +
      static_cast<std::uint64_t>(places.values.count()) * (sizeof(LightSum) + sizeof(std::uint32_t));
  const std::uint64_t of_spread = batches > 1 ? batches * sizeof(LightSum) : sizeof(SquareSum);
  return bounds.pixel_count() * (sizeof(std::uint32_t) + of_spread + of_places + light_groups * kLight +
                                 (layers ? 4 * kLight + kFirstHit : kLight) +
                                 (moments ? 2 + (layers && places.medium) : 0) * sizeof(SquareSum));
}

template <typename Sum>
void Film::add(std::array<Sum, 3>& sums, RGB value) {
  for (int c = 0; c < 3; ++c) sums[static_cast<std::size_t>(c)] += value[c];
}

void Film::add_place(std::size_t pixel, const FirstHit& first_hit, std::size_t slot, const Geometry& geometry) {
  const std::uint32_t triangle = first_hit.triangle[slot];
  if (triangle == kNone) return;
  const Vec2 at = first_hit.barycentric[slot];
  const auto interpolated = [&](const auto& a, const auto& b, const auto& c) {
    return a * (1 - at.x - at.y) + b * at.x + c * at.y;
  };
  if (places_.position) {
    const auto [a, b, c] = geometry.corners(triangle);
    const Vec3 p = interpolated(a, b, c);
    add(position_[pixel], RGB(p.x, p.y, p.z));
  }
  if (places_.uv) {
    const StoredTriangle stored = geometry.stored(triangle);
    const auto& [a, b, c] = stored.mesh->triangles[stored.index];
    const std::vector<Vec2>& uvs = stored.mesh->uvs;
    const Vec2 uv = interpolated(uvs[a], uvs[b], uvs[c]);
    add(uv_[pixel], RGB(uv.x, uv.y, 0));
  }
  if (places_.objects) count(objects_[pixel], geometry.object_of(triangle));
  if (places_.materials) count(materials_[pixel], geometry.material_of(triangle));
}

void Film::add(const CameraTask& task, const SlotRadiance& radiance, const FirstHit& first_hit,
               const Geometry& geometry, std::size_t first_slot) {
  const std::size_t pixels = task.pixel_count();
  const int tile_width = task.x1 - task.x0;
  parallel_for(0, pixels, kBytesAtOnce * bounds_.pixel_count() / state_bytes(),
               [&](std::size_t first, std::size_t last) {
                 for (std::size_t in_tile = first; in_tile < last; ++in_tile) {
                   const int y = task.y0 + static_cast<int>(in_tile) / tile_width;
                   const int x = task.x0 + static_cast<int>(in_tile) % tile_width;
                   if (!task.has(x, y)) continue;
                   const std::size_t pixel = pixel_at(x, y);
                   for (std::uint32_t sample = 0; sample < task.sample_count; ++sample) {
                     if (count_[pixel] != task.first_sample + sample) continue;
                     const std::size_t slot = first_slot + sample * pixels + in_tile;
                     add(pixel, radiance, first_hit, slot);
                     if (layers_ && places_.of_triangles()) add_place(pixel, first_hit, slot, geometry);
                   }
                 }
               });
}

void Film::add(std::size_t pixel, const SlotRadiance& radiance, const FirstHit& first_hit, std::size_t slot) {
  const RGB light[4] = {radiance.emitted[slot], radiance.direct[slot], radiance.indirect[slot], radiance.caustic[slot]};
  RGB shown = indirect_only_ ? light[2] : light[0] + light[1] + light[2] + light[3];
  if (!radiance.medium.empty() && !indirect_only_) shown += radiance.medium[slot];
  const float level = luminance(shown);
  if (batches_.count > 1)
    batch_sum_[(batches_.first_sample + count_[pixel]) % batches_.count][pixel] += level;
  else
    square_sum_[pixel] += level * level;
  ++count_[pixel];
  if (!layers_) {
    add(light_[0][pixel], shown);
    return;
  }
  for (int layer = 0; layer < 4; ++layer) add(light_[layer][pixel], light[layer]);
  if (!medium_.empty() && !radiance.medium.empty()) add(medium_[pixel], radiance.medium[slot]);
  for (std::size_t group = 0; group < groups_.size(); ++group) add(groups_[group][pixel], radiance.groups[group][slot]);
  add(albedo_[pixel], first_hit.albedo[slot]);
  const Vec3 n = first_hit.normal[slot];
  add(normal_[pixel], RGB(n.x, n.y, n.z));
  if (places_.surface_samples) {
    // A pass without surface samples gives the values of its camera samples.
    add(surface_albedo_[pixel], (first_hit.surface_albedo.empty() ? first_hit.albedo : first_hit.surface_albedo)[slot]);
    add(surface_emitted_[pixel],
        (radiance.surface_emitted.empty() ? radiance.emitted : radiance.surface_emitted)[slot]);
    if (!radiance.sun.empty()) add(sun_[pixel], radiance.sun[slot]);
  }
  if (std::isfinite(first_hit.depth[slot])) {
    depth_sum_[pixel] += first_hit.depth[slot];
    ++depth_count_[pixel];
  }
  for (std::size_t i = 0; i < kSlotValues; ++i) {
    // The path tracer has no photons.
    const std::vector<float>& values = first_hit.values[i];
    if (!places_.values.has(i) || values.empty() || !std::isfinite(values[slot])) continue;
    value_sum_[i][pixel] += values[slot];
    ++value_count_[i][pixel];
  }
  if (!has_moments()) return;
  const float albedo = shading_albedo(first_hit.albedo[slot]);
  const RGB filtered[2] = {radiance.sun.empty() ? light[1] : light[1] - radiance.sun[slot], light[2]};
  for (int i = 0; i < 2; ++i) {
    const float l = luminance(filtered[i]);
    moments_[i][pixel] += l * l / albedo;
  }
  if (moments_[2].empty() || radiance.medium.empty()) return;
  const float l = luminance(radiance.medium[slot]);
  moments_[2][pixel] += l * l;
}

void Film::add(const CameraTask& task, const Film& samples) {
  for (int y = task.y0; y < task.y1; ++y)
    for (int x = task.x0; x < task.x1; ++x) {
      const std::size_t to = pixel_at(x, y), from = samples.pixel_at(x, y);
      if (!task.has(x, y) || count_[to] != task.first_sample) continue;
      for_arrays(
          [&](auto& own, const auto& others) {
            if (!own.empty()) add_entry(own[to], others[from]);
          },
          *this, samples);
    }
  not_finite_ += samples.not_finite_;
}

bool Film::awaits(const CameraTask& task) const {
  for (int y = task.y0; y < task.y1; ++y)
    for (int x = task.x0; x < task.x1; ++x)
      if (task.has(x, y) && count_[pixel_at(x, y)] != task.first_sample) return false;
  return true;
}

bool Film::is_of(const CameraTask& task) const {
  for (int y = bounds_.y0; y < bounds_.y1; ++y)
    for (int x = bounds_.x0; x < bounds_.x1; ++x)
      if (count_[pixel_at(x, y)] != (task.has(x, y) ? task.sample_count : 0)) return false;
  return bounds_ == PixelBounds{task.x0, task.y0, task.x1, task.y1};
}

int Film::first_row_to_do(const CameraTask& task) const {
  for (int y = task.y0; y < task.y1; ++y) {
    const auto row = count_.begin() + static_cast<std::ptrdiff_t>(y - bounds_.y0) * width();
    for (int x = task.x0; x < task.x1; ++x)
      if (task.has(x, y) && row[x - bounds_.x0] < task.first_sample + task.sample_count) return y;
  }
  return task.y1;
}

std::uint32_t Film::whole_passes() const { return *std::min_element(count_.begin(), count_.end()); }

std::uint32_t Film::most_samples() const { return *std::max_element(count_.begin(), count_.end()); }

double Film::mean_samples() const {
  std::uint64_t sum = 0;
  for (const std::uint32_t count : count_) sum += count;
  return static_cast<double>(sum) / static_cast<double>(count_.size());
}

bool Film::is_even() const {
  return std::all_of(count_.begin(), count_.end(), [&](std::uint32_t count) { return count == count_.front(); });
}

RGB Film::mean(Layer layer, std::size_t pixel) const {
  if (count_[pixel] == 0 || !layers_) return RGB();
  if (layer == Layer::albedo) return mean_of(albedo_[pixel], count_[pixel]);
  const bool by_surface = places_.surface_samples && count_[pixel] > 1;
  if (layer == Layer::surface_albedo) return mean_of((by_surface ? surface_albedo_ : albedo_)[pixel], count_[pixel]);
  if (layer == Layer::surface_emitted)
    return mean_of((by_surface ? surface_emitted_ : light_[0])[pixel], count_[pixel]);
  if (layer == Layer::sun) return sun_.empty() ? RGB() : mean_of(sun_[pixel], count_[pixel]);
  if (layer == Layer::medium) return medium_.empty() ? RGB() : mean_of(medium_[pixel], count_[pixel]);
  if (layer == Layer::normal) return mean_of(normal_[pixel], count_[pixel]);
  if (layer == Layer::position || layer == Layer::uv) {
    const auto& sums = layer == Layer::uv ? uv_ : position_;
    return sums.empty() || depth_count_[pixel] == 0 ? RGB() : mean_of(sums[pixel], depth_count_[pixel]);
  }
  return mean_of(light_[static_cast<int>(layer)][pixel], count_[pixel]);
}

RGB Film::light_of_group(std::size_t group, std::size_t pixel) const {
  return count_[pixel] == 0 ? RGB() : mean_of(groups_[group][pixel], count_[pixel]);
}

float Film::depth(std::size_t pixel) const {
  if (!layers_ || depth_count_[pixel] == 0) return std::numeric_limits<float>::infinity();
  return static_cast<float>(depth_sum_[pixel].value() / depth_count_[pixel]);
}

float Film::value(SlotValue value, std::size_t pixel) const {
  const auto i = static_cast<std::size_t>(value);
  if (!places_.values.has(value) || value_count_[i][pixel] == 0) return 0;
  return static_cast<float>(value_sum_[i][pixel].value() / value_count_[i][pixel]);
}

float Film::coverage(std::size_t pixel) const {
  if (!layers_ || count_[pixel] == 0) return 0;
  return static_cast<float>(depth_count_[pixel]) / static_cast<float>(count_[pixel]);
}

RGB Film::radiance(std::size_t pixel, bool indirect_only) const {
  if (!layers_) return count_[pixel] == 0 ? RGB() : mean_of(light_[0][pixel], count_[pixel]);
  if (indirect_only) return mean(Layer::indirect, pixel);
  return mean(Layer::emitted, pixel) + mean(Layer::direct, pixel) + mean(Layer::indirect, pixel) +
         mean(Layer::caustic, pixel) + mean(Layer::medium, pixel);
}

Film::Moments Film::moments(Layer layer, std::size_t pixel) const {
  if (count_[pixel] == 0) return {};
  const double n = count_[pixel];
  const bool in_medium = layer == Layer::medium;
  const double albedo = in_medium ? 1 : shading_albedo(mean(Layer::albedo, pixel));
  const RGB light = layer == Layer::direct ? mean(layer, pixel) - mean(Layer::sun, pixel) : mean(layer, pixel);
  const double m = luminance(light) / albedo;
  if (count_[pixel] < 2) return {static_cast<float>(m), 0};
  const double square = moments_[in_medium ? 2 : layer == Layer::indirect ? 1 : 0][pixel].value() / n / albedo;
  return {static_cast<float>(m), static_cast<float>(std::max(0.0, square - m * m) / (n - 1))};
}

float Film::variance(std::size_t pixel) const {
  if (count_[pixel] < 2) return 0;
  const double n = count_[pixel], m = luminance(radiance(pixel, indirect_only_));
  if (batches_.count == 1) return static_cast<float>(std::max(0.0, square_sum_[pixel].value() / n - m * m) / (n - 1));
  double spread = 0;
  const std::uint32_t batches = std::min(batches_.count, count_[pixel]);
  for (std::uint32_t i = 0; i < batches; ++i) {
    // Those with samples, beginning with the one of the first.
    const std::uint32_t samples = (count_[pixel] - i + batches_.count - 1) / batches_.count;
    const double sum = batch_sum_[(batches_.first_sample + i) % batches_.count][pixel].value();
    spread += (sum / samples - m) * (sum / samples - m) * samples;
  }
  return static_cast<float>(spread / (batches - 1) / n);
}

template <typename Work, typename... Films>
void Film::for_arrays(Work&& work, Films&... films) {
  // The counts first: readers check the sums by them.
  work(films.count_...);
  work(films.depth_count_...);
  for (int i = 0; i < 4; ++i) work(films.light_[i]...);
  const std::size_t groups = std::min({films.groups_.size()...});
  for (std::size_t i = 0; i < groups; ++i) work(films.groups_[i]...);
  work(films.albedo_...);
  work(films.normal_...);
  work(films.surface_albedo_...);
  work(films.surface_emitted_...);
  work(films.sun_...);
  work(films.medium_...);
  work(films.position_...);
  work(films.uv_...);
  work(films.objects_...);
  work(films.materials_...);
  work(films.depth_sum_...);
  for (std::size_t i = 0; i < kSlotValues; ++i) {
    work(films.value_sum_[i]...);
    work(films.value_count_[i]...);
  }
  work(films.square_sum_...);
  const std::size_t batches = std::min({films.batch_sum_.size()...});
  for (std::size_t i = 0; i < batches; ++i) work(films.batch_sum_[i]...);
  for (int i = 0; i < 3; ++i) work(films.moments_[i]...);
}

void Film::take_rows(const Film& other) {
  const int first = std::max(bounds_.y0, other.bounds_.y0), end = std::min(bounds_.y1, other.bounds_.y1);
  if (first >= end) return;
  const auto from = static_cast<std::ptrdiff_t>(other.pixel_at(bounds_.x0, first));
  const auto to = static_cast<std::ptrdiff_t>(pixel_at(bounds_.x0, first));
  const std::size_t pixels = static_cast<std::size_t>(end - first) * static_cast<std::size_t>(width());
  for_arrays(
      [&](auto& own, const auto& others) {
        if (!own.empty()) std::copy_n(others.begin() + from, pixels, own.begin() + to);
      },
      *this, other);
}

Film Film::like(const PixelBounds& bounds, std::uint32_t first_sample) const {
  return Film(bounds, indirect_only_, layers_, places_, has_moments_, groups_.size(),
              {batches_.count, batches_.first_sample + first_sample});
}

Film Film::rows(int first, int end) const {
  Film out = like({bounds_.x0, first, bounds_.x1, end});
  out.take_rows(*this);
  return out;
}

Film Film::sketch_of_rows(int first, int end) const {
  Film out = rows(first, end);
  for (std::uint32_t& count : out.count_) count = std::max(count, 2u);
  return out;
}

std::vector<std::uint32_t> Film::save() const {
  std::vector<std::uint32_t> out;
  out.reserve((sizeof not_finite_ + state_bytes()) / sizeof out[0]);
  write_state([&](std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    const std::size_t at = out.size();
    out.resize(at + bytes.size() / sizeof out[0]);
    std::byte* const to = std::as_writable_bytes(std::span(out)).data() + at * sizeof out[0];
    parallel_for(0, bytes.size(), kBytesAtOnce, [&](std::size_t first, std::size_t last) {
      std::memcpy(to + first, bytes.data() + first, last - first);
    });
  });
  return out;
}

bool Film::restore(const std::vector<std::uint32_t>& state) {
  std::span<const std::byte> left = std::as_bytes(std::span(state));
  const auto read = [&](std::span<std::byte> to) {
    if (to.size() > left.size()) return false;
    std::copy_n(left.begin(), to.size(), to.begin());
    left = left.subspan(to.size());
    return true;
  };
  return merge_state(read, kMaxSamples) && left.empty();
}

void Film::write_state(const std::function<void(std::span<const std::byte>)>& write) const {
  write(std::as_bytes(std::span(&not_finite_, 1)));
  for_arrays([&](const auto& entries) { write(std::as_bytes(std::span(entries))); }, *this);
}

template <typename Entry>
bool Film::merge_array(std::vector<Entry>& sums, const std::vector<std::uint32_t>& counts,
                       const std::function<bool(std::span<std::byte>)>& read) {
  std::vector<Entry> others;
  for (std::size_t at = 0; at < sums.size(); at += kPixelsRead) {
    others.resize(std::min(kPixelsRead, sums.size() - at));
    if (!read(std::as_writable_bytes(std::span(others)))) return false;
    std::atomic<bool> possible = true;
    parallel_for(0, others.size(), even_grain(others.size()), [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        if (!is_possible_of(others[i], counts[at + i])) {
          possible = false;
          return;
        }
        add_entry(sums[at + i], others[i]);
      }
    });
    if (!possible) return false;
  }
  return true;
}

bool Film::merge_state(const std::function<bool(std::span<std::byte>)>& read, std::uint32_t most_samples) {
  std::uint64_t not_finite = 0;
  std::vector<std::uint32_t> counts(count_.size()), hits(depth_count_.size());
  if (!read(std::as_writable_bytes(std::span(&not_finite, 1))) || !read(std::as_writable_bytes(std::span(counts))) ||
      !read(std::as_writable_bytes(std::span(hits))))
    return false;
  for (std::size_t i = 0; i < counts.size(); ++i)
    if (counts[i] > most_samples || (layers_ && hits[i] > counts[i])) return false;
  add_all(count_, counts);
  add_all(depth_count_, hits);
  not_finite_ += not_finite;
  bool good = true;
  for_arrays(
      [&](auto& entries) {
        const void* const which = &entries;
        if (!good || which == &count_ || which == &depth_count_) return;
        good = merge_array(entries, which == &depth_sum_ ? hits : counts, read);
      },
      *this);
  return good;
}

}  // namespace glowworm
