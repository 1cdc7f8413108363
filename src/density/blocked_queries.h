// The query points of the blocked engine: brought together in buckets, and sorted within a bucket.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/box.h"
#include "core/large_array.h"
#include "core/rgb.h"
#include "gather/query_points.h"
#include "kernels/blocked.h"

namespace glowworm {

/// What of a query point moves when points are brought together.
struct BucketPoint {
  Vec3 position;
  Vec3 normal;
  std::uint32_t bsdf;   ///< as in QueryPoints
  std::uint32_t place;  ///< where its answer goes: an index into QueryBuckets::answers()
};

/// Points of a task, moved so that those of one cell of space stand together.
class QueryBuckets {
 public:
  /// A run of points() that lie in one cell.
  struct Bucket {
    std::uint32_t first, last;
  };
  /// A bucket holds no more points than this.
  static constexpr std::size_t kMostPoints = std::size_t{1} << 15;

  /// Takes points first to last - 1, but for those with a position or normal that is not finite. On all threads; the
  /// same buckets for any number of them.
  QueryBuckets(const QueryPoints& points, std::size_t first, std::size_t last);

  const std::vector<Bucket>& buckets() const { return buckets_; }
  std::span<const BucketPoint> points(const Bucket& bucket) const {
    return points_.span().subspan(bucket.first, bucket.last - bucket.first);
  }
  /// One for each point, to be set by who works the buckets off.
  std::span<RGB> answers() { return answers_.span(); }
  /// Adds the answers, times the reflectance of points that are Lambertian, to radiance[i] of the points i they are
  /// for. Once only. (Answers are read bucket by bucket, so that memory is walked through in as many streams as there
  /// are buckets, not jumped about in.)
  void add_answers(const QueryPoints& points, std::span<RGB> radiance);

  /// Bytes held for so many points.
  static std::uint64_t bytes(std::size_t points);

 private:
  void divide(Bucket bucket, int rounds_left);

  std::size_t first_;
  std::size_t cells_ = 0;
  LargeArray<std::uint16_t> cell_of_;
  LargeArray<std::uint32_t> places_;  // by piece of the points and cell
  LargeArray<BucketPoint> points_;
  LargeArray<RGB> answers_;
  std::vector<Bucket> buckets_;
};

/// The points of one bucket, sorted along the Hilbert curve within each group of like normals, and cut into runs for
/// the kernels. Keeps its arrays from one bucket to the next; belongs to one thread.
class BucketOrder {
 public:
  /// The most directions that normals are told apart by, and one more group for points that are not Lambertian.
  static constexpr std::size_t kGroups = 7;

  void sort(std::span<const BucketPoint> points);

  /// Places in the bucket, in order; group g is group(g) of them.
  std::span<const std::uint32_t> group(std::size_t g) const {
    return std::span(order_).subspan(first_[g], first_[g + 1] - first_[g]);
  }
  static constexpr std::size_t kNotLambertian = 6;

 private:
  struct Entry {
    std::uint32_t key, place;
  };
  std::vector<Entry> entries_, other_;
  std::vector<std::uint32_t> order_;
  std::array<std::uint32_t, kGroups + 1> first_{};
};

}  // namespace glowworm
