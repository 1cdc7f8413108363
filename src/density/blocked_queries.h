// The query points of the blocked engine: grouped into buckets, and sorted within each bucket.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/box.h"
#include "core/large_array.h"
#include "core/rgb.h"
#include "points/query_points.h"

namespace glowworm {

/// A grid of equal cubes. Points outside belong to the cells at the border.
struct KeyGrid {
  Vec3 origin{};  ///< metres
  float cells_per_metre = 0;
  std::uint32_t cells[3] = {1, 1, 1};  ///< number along each axis
};

/// Number of times a key halves a cell along each axis.
inline constexpr int kKeyLevels = 6;
/// Bits of a key, from the lowest: position on the curve, slab, group, cell. At most 2^14 - 1 cells.
inline constexpr int kKeyCurveBits = 2 * kKeyLevels;
inline constexpr int kKeySlabBits = 3;
inline constexpr int kKeyGroupShift = kKeyCurveBits + kKeySlabBits;
inline constexpr int kKeyCellShift = kKeyGroupShift + 3;
/// Groups 0 to 5 are Lambertian points, by the axis closest to their normal (2 axis + 1 if it points in the negative
/// direction); the last group is for all other points.
inline constexpr std::uint32_t kKeyGroups = 7;
inline constexpr std::uint32_t kNotLambertianGroup = 6;
/// The key of points whose position or normal is not finite.
inline constexpr std::uint32_t kNoKey = 0xffffffffu;

/// The sort key of a query point: the cell of a grid, the axis of the normal, and the position on the surface. A
/// surface perpendicular to an axis is close to a plane of the other two axes, so a curve through that plane orders its
/// points as well as one through space, with a third fewer bits. A few slabs along the axis separate parallel surfaces.
std::uint32_t query_key(const KeyGrid& grid, Vec3 position, Vec3 normal, bool lambertian);

/// The part of a query point that moves when points are grouped.
struct BucketPoint {
  Vec3 position;
  Vec3 normal;
  std::uint32_t bsdf;  ///< as in QueryPoints
  std::uint32_t key;   ///< query_key()
};

/// Working memory of QueryBuckets. It only grows and serves one QueryBuckets after another, because the system need not
/// clear memory that is reused.
struct QueryMemory {
  LargeArray<std::uint32_t> keys;
  LargeArray<std::uint32_t> places;  // by piece of the points and cell
  LargeArray<BucketPoint> points;
  LargeArray<RGB> answers;
};

/// Points of a task, reordered so that the points of one cell of space are adjacent.
class QueryBuckets {
 public:
  /// A run of points() in one cell.
  struct Bucket {
    std::uint32_t first, last;
  };
  /// Maximum number of points in a bucket.
  static constexpr std::size_t kMaxPoints = std::size_t{1} << 17;

  /// Takes points first to last - 1, except those with a position or normal that is not finite. Uses all threads; the
  /// buckets do not depend on their number. The memory must outlive this object.
  QueryBuckets(const QueryPoints& points, std::size_t first, std::size_t last, QueryMemory& memory);

  const std::vector<Bucket>& buckets() const { return buckets_; }
  std::span<const BucketPoint> points(const Bucket& bucket) const {
    return memory_.points.span().subspan(bucket.first, bucket.last - bucket.first);
  }
  /// The answer of point i of points(bucket); the code that processes the bucket sets it.
  RGB& answer(const Bucket& bucket, std::size_t i) {
    const std::size_t place = bucket.first + i;
    return memory_.answers[origin_.size() == 0 ? place : origin_[place]];
  }
  /// Adds each answer, times the reflectance if the point is Lambertian, to radiance[i] of its query point i. Call it
  /// once. (Answers are read bucket by bucket: memory is read as one sequential stream for each bucket, without random
  /// access.)
  void add_answers(const QueryPoints& points, std::span<RGB> radiance);

 private:
  void divide(Bucket bucket, int rounds_left);

  QueryMemory& memory_;
  std::size_t first_, last_;  // of the QueryPoints
  std::size_t cells_ = 0;
  std::size_t taken_ = 0;             // points that are finite
  LargeArray<std::uint32_t> origin_;  // index of each of points_ before large buckets were divided; empty if none was
  std::vector<Bucket> buckets_;
};

/// Sorts the points of one bucket by group and along the curve. Keeps its arrays from one bucket to the next; for one
/// thread only.
class BucketOrder {
 public:
  void sort(std::span<const BucketPoint> points);

  /// Indices of the points of a group (kKeyGroups of them), in order.
  std::span<const std::uint32_t> group(std::size_t g) const {
    return std::span(order_).subspan(first_[g], first_[g + 1] - first_[g]);
  }

 private:
  std::vector<std::uint32_t> keys_, places_, order_;
  std::array<std::uint32_t, kKeyGroups + 1> first_{};
};

}  // namespace glowworm
