#pragma once
#include <algorithm>
#include <cmath>

#include "kernels/volume.h"

namespace glowworm {

/// A crossing, as sum_volume() takes it: kernel's integral, place on the segment, variance of the place.
struct PlainCrossing {
  bool inside = false;
  float weight = 0, t = 0, variance = 0;
};

inline float plain_dot(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// The way from a place to the segment's line; returns the distance of its foot along the segment.
inline float plain_way(const SegmentTile& tile, std::size_t i, const float* place, float* way) {
  float d[3];
  for (int axis = 0; axis < 3; ++axis) {
    d[axis] = tile.direction[axis][i];
    way[axis] = tile.origin[axis][i] - place[axis];
  }
  const float back = plain_dot(way, d);
  for (int axis = 0; axis < 3; ++axis) way[axis] -= back * d[axis];
  return -back;
}

inline PlainCrossing plain_cross(const SegmentTile& tile, std::size_t i, const VolumePhotonBlock& block, int lane) {
  const float place[3] = {block.x[lane], block.y[lane], block.z[lane]};
  float way[3];
  const float t = plain_way(tile, i, place, way);
  const float u = plain_dot(way, way) * block.inverse_radius_squared[lane];
  const float d[3] = {tile.direction[0][i], tile.direction[1][i], tile.direction[2][i]};
  float further[2], gap = 0, across[2][3], slopes[2];
  bool inside = u < 1 && t >= 0 && t <= tile.length[i];
  for (int n = 0; n < 2; ++n) {
    const float wall[3] = {block.wall[n][0][lane], block.wall[n][1][lane], block.wall[n][2][lane]};
    const float before = 1 - plain_dot(wall, way), along = plain_dot(wall, d);
    slopes[n] = std::sqrt(std::max(plain_dot(wall, wall) - along * along, 1e-30f));
    gap += std::sqrt(block.inverse_radius_squared[lane]) / slopes[n];
    for (int axis = 0; axis < 3; ++axis) across[n][axis] = (wall[axis] - along * d[axis]) / slopes[n];
    further[n] = 4 * before / (slopes[n] * slopes[n]);
    further[n] *= block.inverse_radius_squared[lane];
    inside &= before > 0;
  }
  float weight = 1 - u;
  for (const float image : {further[0], further[1], further[0] + further[1]}) weight += std::max(1 - u - image, 0.0f);
  if (gap < kNarrowGap && plain_dot(across[0], across[1]) < kFacing) {
    const float x = plain_dot(across[0], way);
    weight = 4 * std::pow(1 - u + x * x * block.inverse_radius_squared[lane], 1.5f) / (3 * gap);
  }
  return {inside, weight, t, 0};
}

inline PlainCrossing plain_cross(const SegmentTile& tile, std::size_t i, const BeamBlock& block, int lane) {
  const float place[3] = {block.x[lane], block.y[lane], block.z[lane]};
  const float beam[3] = {block.dx[lane], block.dy[lane], block.dz[lane]};
  const float d[3] = {tile.direction[0][i], tile.direction[1][i], tile.direction[2][i]};
  const float r2 = block.radius_squared[lane];
  float way[3], across[3];
  const float foot = plain_way(tile, i, place, way), cosine = plain_dot(d, beam), s = plain_dot(way, beam);
  for (int axis = 0; axis < 3; ++axis) {
    way[axis] -= s * beam[axis];
    across[axis] = d[axis] - cosine * beam[axis];
  }
  const float a = plain_dot(way, way), b = plain_dot(way, across), c = std::max(plain_dot(across, across), 1e-30f);
  const float discriminant = b * b + c * (r2 - a);
  if (!(discriminant > 0)) return {};
  const float root = std::sqrt(discriminant), steep = std::copysign(std::max(std::abs(cosine), 1e-30f), cosine);
  const float begin = -s / steep, end = (block.length[lane] - s) / steep;
  const float low = std::max({-(b + root) / c, std::min(begin, end), -foot});
  const float high = std::min({(root - b) / c, std::max(begin, end), tile.length[i] - foot});
  const float half = (high - low) / 2, middle = (low + high) / 2;
  const float p0 = 1 - (a + 2 * b * middle + c * middle * middle) / r2, p1 = -2 * (b + c * middle) / r2, p2 = -c / r2;
  const float mean = p0 + p2 * half * half / 3;
  if (!(low < high) || !(mean > 0)) return {};
  const float shift = p1 * half * half / 3 / mean;
  const float square = half * half * (p0 / 3 + p2 * half * half / 5) / mean;
  return {true, 2 * half * mean, middle + shift + foot, std::max(square - shift * shift, 0.0f)};
}

/// sum_volume() in plain C++, everything in the blocks against every segment, in single precision: the reference for
/// tests of the vector code. Does not count steps.
template <class Block>
void sum_volume_reference(const Block* blocks, std::size_t count, SegmentTile& tile, VolumeCounts& counts) {
  for (std::size_t i = 0; i < tile.count; ++i) {
    for (auto& sum : tile.sum) sum[i] = 0;
    for (std::size_t n = 0; n < count; ++n)
      for (int lane = 0; lane < kVolumeBlock; ++lane) {
        const Block& block = blocks[n];
        const PlainCrossing at = plain_cross(tile, i, block, lane);
        ++counts.tested;
        if (!at.inside) continue;
        ++counts.evaluated;
        const float d[3] = {tile.direction[0][i], tile.direction[1][i], tile.direction[2][i]};
        const float travel[3] = {block.dx[lane], block.dy[lane], block.dz[lane]};
        const float g = tile.g[i], x = 1 + g * g + 2 * g * plain_dot(d, travel);
        const float flux[3] = {block.r[lane], block.g[lane], block.b[lane]};
        for (int c = 0; c < 3; ++c) {
          const float sigma = tile.sigma_t[c][i];
          tile.sum[c][i] += at.weight / (x * std::sqrt(x)) * std::exp(-sigma * at.t) *
                            (1 + sigma * sigma * at.variance / 2) * flux[c];
        }
      }
  }
}

}  // namespace glowworm
