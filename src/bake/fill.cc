#include "bake/fill.h"

namespace glowworm {

namespace {

/// Neighbours of a texel among the eight around it.
template <typename Visit>
void for_each_neighbour(const TexelMap& map, std::size_t texel, const Visit& visit) {
  const int x = static_cast<int>(texel % static_cast<std::size_t>(map.width));
  const int y = static_cast<int>(texel / static_cast<std::size_t>(map.width));
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const int nx = x + dx, ny = y + dy;
      const bool inside = nx >= 0 && ny >= 0 && nx < map.width && ny < map.height;
      if (inside && (dx != 0 || dy != 0)) visit(map.index(nx, ny));
    }
}

/// Spreads values inside charts, one ring of texels after another.
void spread(const TexelMap& map, std::vector<std::uint8_t>& known, std::vector<RGB>& texels) {
  enum : std::uint8_t { kUnknown, kKnown, kWaiting };
  std::vector<std::size_t> ring, next;
  const auto queue = [&](std::size_t texel) {
    if (map.chart[texel] == kNone) return;
    for_each_neighbour(map, texel, [&](std::size_t n) {
      if (known[n] == kUnknown && map.chart[n] == map.chart[texel]) {
        known[n] = kWaiting;
        next.push_back(n);
      }
    });
  };
  for (std::size_t i = 0; i < known.size(); ++i)
    if (known[i] == kKnown) queue(i);
  while (!next.empty()) {
    ring.swap(next);
    next.clear();
    for (const std::size_t texel : ring) {
      RGB sum;
      int count = 0;
      for_each_neighbour(map, texel, [&](std::size_t n) {
        if (known[n] != kKnown || map.chart[n] != map.chart[texel]) return;
        sum += texels[n];
        ++count;
      });
      texels[texel] = sum / static_cast<float>(count);
    }
    for (const std::size_t texel : ring) known[texel] = kKnown;
    for (const std::size_t texel : ring) queue(texel);
  }
}

struct Level {
  int width = 0, height = 0;
  std::vector<RGB> sum;  ///< of known texels
  std::vector<float> weight;
};

Level halved(const Level& fine) {
  Level out{(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}};
  const auto size = static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height);
  out.sum.resize(size);
  out.weight.resize(size);
  for (int y = 0; y < fine.height; ++y)
    for (int x = 0; x < fine.width; ++x) {
      const auto from =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(fine.width) + static_cast<std::size_t>(x);
      const auto to =
          static_cast<std::size_t>(y / 2) * static_cast<std::size_t>(out.width) + static_cast<std::size_t>(x / 2);
      out.sum[to] += fine.sum[from];
      out.weight[to] += fine.weight[from];
    }
  return out;
}

/// Gives texels between charts the mean of the smallest square of 2^n texels around them that has known ones.
void fill_between(const TexelMap& map, const std::vector<std::uint8_t>& known, std::vector<RGB>& texels) {
  std::vector<Level> levels(1);
  levels[0] = {map.width, map.height, std::vector<RGB>(texels.size()), std::vector<float>(texels.size())};
  for (std::size_t i = 0; i < texels.size(); ++i)
    if (known[i]) {
      levels[0].sum[i] = texels[i];
      levels[0].weight[i] = 1;
    }
  while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(halved(levels.back()));
  for (std::size_t i = 0; i < texels.size(); ++i) {
    if (known[i]) continue;
    std::size_t x = i % static_cast<std::size_t>(map.width), y = i / static_cast<std::size_t>(map.width);
    for (const Level& level : levels) {
      const std::size_t at = y * static_cast<std::size_t>(level.width) + x;
      if (level.weight[at] > 0) {
        texels[i] = level.sum[at] / level.weight[at];
        break;
      }
      x /= 2;
      y /= 2;
    }
  }
}

}  // namespace

void fill_gaps(const TexelMap& map, std::vector<std::uint8_t> known, std::vector<RGB>& texels) {
  for (std::uint8_t& k : known) k = k != 0;
  spread(map, known, texels);
  fill_between(map, known, texels);
}

}  // namespace glowworm
