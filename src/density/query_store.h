// Query points on disk: the external cache of [HHS05], section 6.5, for tasks whose query points memory cannot hold.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "core/hilbert.h"
#include "density/paged_array.h"
#include "points/query_points.h"

namespace glowworm {

/// Takes query points portion by portion as their rays are traced, and gives them back by place: all that lie near one
/// another at once, so that each part of the photon map is looked at once and not once a portion. A_R of [HHS05] on
/// disk; its A_W needs no array here, since the points come back with their weights.
class QueryStore {
 public:
  /// @param bounds       where the query points lie, about: points outside are kept all the same
  /// @param most_points  that will be appended; throws Error where there are more
  /// @param cache_bytes  memory for the cache of the file
  /// Throws Error where no file can be made.
  QueryStore(const Box3& bounds, std::size_t most_points, std::uint64_t cache_bytes);

  /// Adds a portion. Throws Error where the disk is full.
  void append(const QueryPoints& portion);

  /// Hands out all points, run by run along a Hilbert curve, then forgets them. The same runs for the same portions.
  /// @param most_points of a run; a portion may not have had more
  void visit(std::size_t most_points, const std::function<void(const QueryPoints& run)>& work);

  std::size_t size() const { return size_; }
  /// What went through the caches of the files.
  PagedCounts counts() const;
  /// Bytes of the caches.
  std::uint64_t memory_bytes() const { return points_.memory_bytes() + bsdfs_.memory_bytes(); }

 private:
  struct Record {
    Vec3 position, normal;
    RGB reflectance, weight;
    std::uint32_t gather_point, bsdf;
  };
  /// A portion: its place in the file, and how many points each cell has there, in order.
  struct Portion {
    std::size_t next = 0;
    std::vector<std::uint32_t> cell_counts;
  };

  void read(std::size_t first, std::size_t count, QueryPoints& to);

  CubeGrid grid_;
  PagedArray<Record> points_;
  PagedArray<QueryBsdf> bsdfs_;
  std::size_t size_ = 0, bsdf_count_ = 0;
  std::vector<Portion> portions_;
  std::vector<Record> records_;  // on their way to or from the file
};

}  // namespace glowworm
