// The query points of the blocked engine: brought together in buckets, and sorted within a bucket.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/box.h"
#include "core/large_array.h"
#include "core/rgb.h"
#include "kernels/query_keys.h"
#include "points/query_points.h"

namespace glowworm {

/// What of a query point moves when points are brought together.
struct BucketPoint {
  Vec3 position;
  Vec3 normal;
  std::uint32_t bsdf;  ///< as in QueryPoints
  std::uint32_t key;   ///< of query_keys()
};

/// Memory that QueryBuckets work in. It only grows, and may serve one after another: memory that was used before need
/// not be cleared by the system.
struct QueryMemory {
  LargeArray<std::uint32_t> keys;
  LargeArray<std::uint32_t> places;  // by piece of the points and cell
  LargeArray<BucketPoint> points;
  LargeArray<RGB> answers;
};

/// Points of a task, moved so that those of one cell of space stand together.
class QueryBuckets {
 public:
  /// A run of points() that lie in one cell.
  struct Bucket {
    std::uint32_t first, last;
  };
  /// A bucket holds no more points than this.
  static constexpr std::size_t kMostPoints = std::size_t{1} << 17;

  /// Takes points first to last - 1, but for those with a position or normal that is not finite. On all threads; the
  /// same buckets for any number of them. The memory must outlive this.
  QueryBuckets(const QueryPoints& points, std::size_t first, std::size_t last, QueryMemory& memory);

  const std::vector<Bucket>& buckets() const { return buckets_; }
  std::span<const BucketPoint> points(const Bucket& bucket) const {
    return memory_.points.span().subspan(bucket.first, bucket.last - bucket.first);
  }
  /// The answer of point i of points(bucket), to be set by who works the bucket off.
  RGB& answer(const Bucket& bucket, std::size_t i) {
    const std::size_t place = bucket.first + i;
    return memory_.answers[origin_.size() == 0 ? place : origin_[place]];
  }
  /// Adds the answers, times the reflectance of points that are Lambertian, to radiance[i] of the points i they are
  /// for. Once only. (Answers are read bucket by bucket, so that memory is walked through in as many streams as there
  /// are buckets, not jumped about in.)
  void add_answers(const QueryPoints& points, std::span<RGB> radiance);

  /// Bytes held for so many points.
  static std::uint64_t bytes(std::size_t points);

 private:
  void divide(Bucket bucket, int rounds_left);

  QueryMemory& memory_;
  std::size_t first_, last_;  // of the QueryPoints
  std::size_t cells_ = 0;
  std::size_t taken_ = 0;             // points that are finite
  LargeArray<std::uint32_t> origin_;  // of each of points_ before large buckets were divided; empty where none was
  std::vector<Bucket> buckets_;
};

/// The points of one bucket, sorted by group and along the curve. Keeps its arrays from one bucket to the next; belongs
/// to one thread.
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
