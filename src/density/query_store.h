// Query points on disk ([HHS05], section 6.5), for tasks whose query points exceed memory.
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <type_traits>
#include <vector>

#include "core/hilbert.h"
#include "core/unnamed_file.h"
#include "points/query_points.h"

namespace glowworm {

/// What went through temporary files, in bytes.
struct DiskTraffic {
  std::uint64_t read = 0, written = 0;
};

/// Records of a plain type in a file without a name. [HHS05] reads its files through a software cache. Records here
/// are read and written in runs, each about once, so there is nothing to keep.
template <typename T>
class RecordFile {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// Copies records from `first` on, which were written before. Throws Error if the disk fails.
  void read(std::size_t first, std::span<T> to, DiskTraffic& traffic) const {
    file_.read(std::uint64_t{first} * sizeof(T), std::as_writable_bytes(to));
    traffic.read += to.size_bytes();
  }
  /// Replaces records from `first` on. Throws Error if the disk fails or is full.
  void write(std::size_t first, std::span<const T> from, DiskTraffic& traffic) {
    file_.write(std::uint64_t{first} * sizeof(T), std::as_bytes(from));
    traffic.written += from.size_bytes();
  }

 private:
  UnnamedFile file_;
};

/// Takes query points portion by portion as their rays are traced, and looks them up in spatial order, so that each
/// part of the photon map is visited once and not once per portion. A second file holds the results until they are
/// added up in the order of the points: A_R and A_W of [HHS05] on disk.
class QueryStore {
 public:
  /// @param bounds       approximate bounds of the query points; points outside are kept, too
  /// @param most_points  maximum number of points; throws Error if there are more
  /// Throws Error if no file can be made.
  QueryStore(const Box3& bounds, std::size_t most_points) : grid_(bounds, kGridBits), most_points_(most_points) {}

  /// Adds a portion. Throws Error if the disk is full.
  void append(const QueryPoints& portion);

  /// Sets radiance[i], which is black, to the radiance that leaves point i of the run.
  using LookUp = std::function<void(const QueryPoints& run, std::span<RGB> radiance)>;
  /// Looks up all points, run by run along a Hilbert curve. Then adds weight times radiance to `target` at each point's
  /// gather_point, in the order in which the points were appended, and removes the points. The sums equal those without
  /// a file, bit for bit.
  /// @param most_points of a run
  void complete(std::size_t most_points, const LookUp& look_up, std::span<RGB> target);

  std::size_t size() const { return size_; }
  const DiskTraffic& traffic() const { return traffic_; }

 private:
  // Cells an axis, as a power of two: few enough for a small directory of each portion, many enough for even runs.
  static constexpr int kGridBits = 4;
  static constexpr std::size_t kCells = std::size_t{1} << (3 * kGridBits);

  struct Record {
    Vec3 position, normal;
    RGB reflectance, weight;
    std::uint32_t gather_point, bsdf, number;
  };
  /// Contribution of a point to its target.
  struct Answer {
    RGB light;
    std::uint32_t target;
    std::uint32_t number;  ///< of the point in its portion, in the order of appending
  };
  /// A portion: its place in the files, the number of points looked up so far, and the number of points in each cell,
  /// in order.
  struct Portion {
    std::size_t first = 0, next = 0;
    std::vector<std::uint32_t> cell_counts;
  };
  /// Points that are adjacent in the files.
  struct Piece {
    std::size_t first, count;
  };

  void look_up_all(std::size_t most_points, const LookUp& look_up);
  void read(const Piece& piece, QueryPoints& to);
  void answer(std::span<const Piece> pieces, const QueryPoints& run, std::span<const RGB> radiance);
  void add_answers(const Portion& portion, std::span<RGB> target);

  CubeGrid grid_;
  std::size_t most_points_;
  RecordFile<Record> points_;
  RecordFile<QueryBsdf> bsdfs_;  // in the order of the points that have them
  RecordFile<Answer> answers_;   // each where its point is in points_
  DiskTraffic traffic_;
  std::size_t size_ = 0, bsdf_count_ = 0;
  std::vector<Portion> portions_;
  std::vector<Record> records_;         // on their way to or from the file
  std::vector<QueryBsdf> some_bsdfs_;   // of records_
  std::vector<std::uint32_t> numbers_;  // of the points of a run in their portions
  std::vector<Answer> some_answers_;
};

}  // namespace glowworm
