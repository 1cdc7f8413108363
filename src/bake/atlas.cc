#include "bake/atlas.h"

#include <fmt/format.h>

#define STB_RECT_PACK_IMPLEMENTATION
#define STBRP_STATIC
#include <stb/stb_rect_pack.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace glowworm {

namespace {

constexpr int kDefaultSide = 1024, kMaxDefaultSide = 4096;
constexpr int kMinRect = 2 + 2 * kGutter;  ///< side of a chart that covers next to nothing
constexpr int kMaxAtlases = 256;

/// Intervals between texels along a side of a chart.
int intervals(float metres, double density, int most) {
  const double n = std::clamp(std::round(static_cast<double>(metres) * density), 1.0, 1e9);
  return std::min(static_cast<int>(n), most);
}

std::vector<stbrp_rect> rects_of(std::span<const Chart> charts, double density, int side) {
  const int most = side - 1 - 2 * kGutter;
  std::vector<stbrp_rect> rects(charts.size());
  for (std::size_t i = 0; i < charts.size(); ++i) {
    rects[i].id = static_cast<int>(i);
    rects[i].w = intervals(charts[i].size.x, density, most) + 1 + 2 * kGutter;
    rects[i].h = intervals(charts[i].size.y, density, most) + 1 + 2 * kGutter;
  }
  return rects;
}

/// Packs what fits into one atlas; returns whether all did.
bool pack_one(std::vector<stbrp_rect>& rects, int side) {
  std::vector<stbrp_node> nodes(static_cast<std::size_t>(side));
  stbrp_context context;
  stbrp_init_target(&context, side, side, nodes.data(), side);
  return stbrp_pack_rects(&context, rects.data(), static_cast<int>(rects.size())) != 0;
}

/// Whether every chart keeps its size, and all fit into one atlas.
bool fits(std::span<const Chart> charts, double density, int side) {
  const double most = side - 1 - 2 * kGutter;
  double area = 0;
  for (const Chart& chart : charts) {
    if (std::round(std::max(chart.size.x, chart.size.y) * density) > most) return false;
    area += (chart.size.x * density + 1) * (chart.size.y * density + 1);
  }
  if (area > static_cast<double>(side) * side) return false;
  std::vector<stbrp_rect> rects = rects_of(charts, density, side);
  return pack_one(rects, side);
}

/// The largest density at which one atlas holds all charts; 0 where none does.
double best_density(std::span<const Chart> charts, int side) {
  double area = 0;
  for (const Chart& chart : charts) area += static_cast<double>(chart.size.x) * chart.size.y;
  double high = area > 0 ? side / std::sqrt(area) : 1, low = 0;
  constexpr int kSteps = 14;
  for (int i = 0; i < kSteps; ++i) {
    const double middle = low > 0 ? std::sqrt(low * high) : 0.8 * high;
    (fits(charts, middle, side) ? low : high) = middle;
  }
  return low;
}

/// A density for charts whose gutters alone fill an atlas: as many texels again for their surface.
double density_of_several(std::span<const Chart> charts, int side) {
  double area = 0;
  for (const Chart& chart : charts) area += static_cast<double>(chart.size.x) * chart.size.y;
  const double gutters = static_cast<double>(charts.size()) * kMinRect * kMinRect;
  return area > 0 ? std::sqrt(std::max(gutters, static_cast<double>(side) * side) / area) : 1;
}

/// A side whose atlas is not filled by gutters alone.
int default_side(std::size_t charts) {
  const double needed = std::sqrt(4.0 * kMinRect * kMinRect * static_cast<double>(charts));
  int side = kDefaultSide;
  while (side < needed && side < kMaxDefaultSide) side *= 2;
  return side;
}

ChartPlace place_of(const Chart& chart, const stbrp_rect& rect, int atlas) {
  ChartPlace place;
  place.atlas = atlas;
  place.x0 = rect.x;
  place.y0 = rect.y;
  place.width = rect.w;
  place.height = rect.h;
  place.origin = {static_cast<float>(rect.x + kGutter) + 0.5f, static_cast<float>(rect.y + kGutter) + 0.5f};
  const auto scale = [](int rect_side, float metres) {
    return metres > 0 ? static_cast<float>(rect_side - 1 - 2 * kGutter) / metres : 0;
  };
  place.scale = {scale(rect.w, chart.size.x), scale(rect.h, chart.size.y)};
  return place;
}

}  // namespace

Atlas pack(std::span<const Chart> charts, const AtlasRequest& request) {
  Atlas atlas;
  atlas.side = request.side > 0 ? request.side : default_side(charts.size());
  atlas.places.resize(charts.size());
  double density = request.texels_per_metre > 0 ? request.texels_per_metre : best_density(charts, atlas.side);
  if (!(density > 0)) density = density_of_several(charts, atlas.side);
  atlas.texels_per_metre = density;
  const double most = atlas.side - 1 - 2 * kGutter;
  for (const Chart& chart : charts) atlas.shrunk += std::round(std::max(chart.size.x, chart.size.y) * density) > most;
  std::vector<stbrp_rect> pending = rects_of(charts, density, atlas.side);
  while (!pending.empty()) {
    pack_one(pending, atlas.side);
    const auto unplaced =
        std::stable_partition(pending.begin(), pending.end(), [](const stbrp_rect& r) { return r.was_packed != 0; });
    if (unplaced == pending.begin() || atlas.count == kMaxAtlases)
      throw Error(fmt::format("{} charts of surface do not fit into {} atlases of {} texels a side", charts.size(),
                              kMaxAtlases, atlas.side),
                  "Give a larger --atlas, or fewer --texels-per-metre.");
    for (auto r = pending.begin(); r != unplaced; ++r) {
      const auto i = static_cast<std::size_t>(r->id);
      atlas.places[i] = place_of(charts[i], *r, atlas.count);
    }
    pending.erase(pending.begin(), unplaced);
    ++atlas.count;
  }
  return atlas;
}

}  // namespace glowworm
