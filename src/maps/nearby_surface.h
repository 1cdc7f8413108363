// Short segments through all the surface near a cluster of photons.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "core/frame.h"
#include "core/vec.h"
#include "kernels/boundary.h"
#include "maps/boundary_clusters.h"
#include "maps/lit_sides.h"
#include "trace/tracer.h"

namespace glowworm {

/// Most segments at once.
inline constexpr std::size_t kMostSegments = 400;
/// Tracing of segments ends at this many hits of each on average, which bounds the time in stacks of sheets.
inline constexpr std::size_t kMostHitsOfSegment = 64;

/// Segments from `origin` to `origin` + `direction`, in metres and in a cluster's frame: from its center, z along its
/// normal.
struct Segments {
  using Axis = std::array<float, kMostSegments + kBoundaryPadding>;

  std::size_t count = 0;
  Axis origin[3], direction[3];

  void push_back(Vec3 from, Vec3 along) {
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis][count] = from[axis];
      direction[axis][count] = along[axis];
    }
    ++count;
  }
};

/// A hit of a segment.
struct Meeting {
  std::uint32_t segment;
  float distance;  ///< as a share of the segment
  std::uint32_t triangle;
  bool takes_flux;  ///< as that of NearbySurface::Triangle
  LitSide lit;      ///< as that
};

/// The surface, but for interfaces, that lies in the cylinder around a cluster: within `reach` of the axis along its
/// normal, from `low` to `high`. A few triangles are copied here, since testing all of them is faster than tracing
/// rays; where they are many, or textures cut holes into them, Embree traces the segments.
class NearbySurface {
 public:
  /// @param on_all_surfaces whether photons lie on mirrors, glass and black, too (PhotonPassSettings)
  /// @param sides of the triangles; must outlive this
  NearbySurface(const Tracer& tracer, bool on_all_surfaces, const LitSides& sides)
      : tracer_(tracer),
        sides_(sides),
        takes_flux_(tracer.scene().materials().size(), on_all_surfaces ? kYes : kUnknown) {}

  /// Finds the surface near another cluster. The cluster must outlive the use of meetings().
  void approach(const BoundaryCluster& cluster);

  /// The axes of the cluster's frame.
  const Frame& frame() const { return frame_; }

  /// Whether tracing has ended with hits left since approach().
  bool crowded() const { return crowded_; }

  /// A triangle, in the cluster's frame.
  struct Triangle {
    CornerAndEdges place;
    float highest;  ///< z of a corner, metres
    std::uint32_t index;
    bool takes_flux;  ///< whether photons and query points may lie on it: some point of its material has a broad lobe
    LitSide lit;
  };
  /// The triangles in the cylinder, and possibly some near it; none where they are too many to copy.
  std::span<const Triangle> triangles() const { return copied_ ? std::span(triangles_) : std::span<const Triangle>(); }

  /// All hits of segments that lie in the cylinder, by segment and then distance; fewer if it is crowded().
  /// @param first least distance of a hit; @param step least distance between hits: both shares of a segment, for
  /// surface that takes flux. Other hits may be as close to it, and to each other, as rounding allows.
  const std::vector<Meeting>& meetings(const Segments& segments, float first, float step);

 private:
  enum Answer : std::uint8_t { kUnknown, kNo, kYes };

  bool takes_flux(std::uint32_t triangle);
  LitSide lit_side(std::uint32_t triangle) const { return sides_.of(tracer_.scene().geometry(), triangle); }
  bool copy(std::uint32_t triangle);
  std::array<Vec3, 3> local_triangle(std::uint32_t triangle) const;
  bool reaches(const std::array<Vec3, 3>& corner) const;
  void meet_copied(const Segments& segments, float first);
  void order(std::size_t segments, float step);
  void trace(const Segments& segments, float first, float step);
  /// Share of a segment, which has at least half the cylinder's length, in which rounding may hit a surface again.
  float rounding() const { return 2 * cluster_->step + 0x1p-21f; }

  const Tracer& tracer_;
  const LitSides& sides_;
  const BoundaryCluster* cluster_ = nullptr;
  Frame frame_;
  float reach_squared_ = 0, lowest_ = 0, highest_ = 0;  ///< of the cylinder, with room for rounding
  bool copied_ = false, crowded_ = false;
  std::vector<Answer> takes_flux_;   ///< for each material
  std::vector<Triangle> triangles_;  ///< if copied
  std::vector<Meeting> found_, meetings_;
  std::array<std::uint32_t, kMostSegments + kBoundaryPadding> segment_;
  Segments::Axis distance_;
  std::array<std::uint32_t, kMostSegments + 1> begin_;
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
};

}  // namespace glowworm
