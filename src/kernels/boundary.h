// Inner loops of boundary correction: many segments against one triangle, and a photon's kernel over many places.
#pragma once
#include <cstddef>
#include <cstdint>

#include "kernels/kernel_shape.h"

namespace glowworm {

/// Lanes of the widest vector. Arrays for these kernels have so many elements after the last one, which may be read and
/// written and have no meaning.
inline constexpr std::size_t kBoundaryPadding = 16;

/// Segments from origin to origin + direction. Arrays of `count` elements and the padding, in metres.
struct SegmentArrays {
  std::size_t count = 0;
  const float* origin[3] = {};
  const float* direction[3] = {};
};

/// A triangle: its first corner and the edges from there to the others, in metres.
struct CornerAndEdges {
  float corner[3];
  float edge[2][3];
};

/// Finds the segments that the triangle cuts, at a distance of at least `first` and at most 1, as a share of the
/// segment (Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997). Segments in the triangle's
/// plane do not hit it. Runs on the instruction set of set_simd().
/// @param segment, distance  take the indices of those segments, in their order, and where they are cut; both arrays
///        have room for all segments and the padding
/// @return their number
std::size_t segment_hits(const SegmentArrays& segments, const CornerAndEdges& triangle, float first,
                         std::uint32_t* segment, float* distance);

/// A photon's kernel: its center, its normal, and one over the square of its radius (m^-2).
struct KernelBall {
  float position[3];
  float normal[3];
  float inverse_squared_radius;
};

/// Places on surfaces. Arrays of `count` elements and the padding.
struct WeightedPlaces {
  std::size_t count = 0;
  const float* position[3] = {};  ///< metres
  const float* normal[3] = {};    ///< unit
  const float* weight = nullptr;
};

/// The sum of weight times kernel_profile() over the places within the ball whose normals have a dot product above
/// min_cosine with the ball's. Runs on the instruction set of set_simd().
float sum_at_places(KernelShape shape, const WeightedPlaces& places, const KernelBall& ball, float min_cosine);

/// The sum of kernel_profile() over the points of the ball's tangent plane above (x, y), within the ball. Arrays of
/// `count` elements and the padding, in metres. The z of the ball's normal is above 0.
float sum_on_plane(KernelShape shape, const float* x, const float* y, std::size_t count, const KernelBall& ball);

}  // namespace glowworm
