// Pixels where the light that surface samples find has an edge.
#pragma once
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "gather/camera_pass.h"
#include "points/gather_points.h"
#include "scene/camera.h"
#include "trace/tracer.h"

namespace glowworm {

/// Pixels of a block (CameraTask::kBlock), by index_in_block().
using BlockPixels = std::bitset<std::size_t{CameraTask::kBlock} * CameraTask::kBlock>;
inline std::size_t index_in_block(int x, int y) {
  return static_cast<std::size_t>(y % CameraTask::kBlock * CameraTask::kBlock + x % CameraTask::kBlock);
}

/// Pixels at edges of light that passes of one view have found, by block. Threads may share it.
class KnownLightEdges {
 public:
  /// @param width, height of the picture, pixels
  KnownLightEdges(int width, int height)
      : columns_(blocks(width)), edges_(columns_ * blocks(height)), found_(new std::once_flag[edges_.size()]) {}
  /// The pixels of a block. @param x0, y0 its upper left corner @param find finds them, the first time
  template <typename Find>
  const BlockPixels& of_block(int x0, int y0, const Find& find) {
    const std::size_t block = blocks(y0) * columns_ + blocks(x0);
    std::call_once(found_[block], [&] { edges_[block] = find(); });
    return edges_[block];
  }

 private:
  static std::size_t blocks(int pixels) {
    return static_cast<std::size_t>((pixels + CameraTask::kBlock - 1) / CameraTask::kBlock);
  }

  std::size_t columns_;
  std::vector<BlockPixels> edges_;
  std::unique_ptr<std::once_flag[]> found_;
};

/// Finds the pixels at whose corners emission, with the light of a sun at first hits, differs by a factor of two. The
/// corners alone decide: so samples that depend on the answer have no bias, and it is the same for all of a pixel.
class LightEdges {
 public:
  std::uint64_t rays = 0, shadow_rays = 0;  ///< traced

  LightEdges(const Tracer& tracer, const Camera& camera, const CameraPassSettings& settings)
      : tracer_(tracer), camera_(camera), settings_(settings) {}
  /// @param x0, y0 upper left corner of the block
  BlockPixels find(int x0, int y0);

 private:
  const Tracer& tracer_;
  const Camera& camera_;
  const CameraPassSettings& settings_;
};

}  // namespace glowworm
