// Gather points: the first surfaces on camera paths for which light is gathered.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "bsdf/bsdf.h"
#include "core/frame.h"
#include "core/rgb.h"
#include "core/vec.h"
#include "points/batch.h"

namespace glowworm {

/// The medium around a path.
struct PathMedium {
  std::uint32_t index = ~0u;  ///< into Scene::media(); kNone: vacuum
  bool named = false;         ///< by the surface that the path left; if not, the next one may name another
  bool operator==(const PathMedium&) const = default;
};

/// The media on the two sides of a place of a surface.
struct MediumSides {
  PathMedium front;  ///< on the viewer's side
  PathMedium back;

  /// @param normal geometric, on the viewer's side
  PathMedium towards(Vec3 direction, Vec3 normal) const { return dot(direction, normal) > 0 ? front : back; }
};

/// A rectangle of pixels, or of cells of a grid of points, and their samples in a task. A slot is one camera sample of
/// one pixel: slot = (sample - first_sample) * pixels + pixel of the tile, row by row.
struct CameraTask {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< pixels [x0, x1) x [y0, y1) of the picture
  std::uint32_t first_sample = 0, sample_count = 1;
  /// Squares of pixels that get samples, of a task within one block: bit = 4 row + column. The slots of others stay
  /// empty.
  std::uint32_t squares = kAllSquares;

  static constexpr std::uint32_t kAllSquares = 0xffff;
  /// Sides of squares and blocks of pixels, which are aligned to the picture.
  static constexpr int kSquare = 4, kBlock = 16;

  /// Whether a pixel of the rectangle gets samples.
  bool has(int x, int y) const {
    return (squares >> ((y % kBlock) / kSquare * (kBlock / kSquare) + (x % kBlock) / kSquare) & 1) != 0;
  }
  std::size_t pixel_count() const { return static_cast<std::size_t>(x1 - x0) * static_cast<std::size_t>(y1 - y0); }
  std::size_t slot_count() const { return pixel_count() * sample_count; }
  bool operator==(const CameraTask&) const = default;
};

/// Tasks of one pass. Their slots follow one another.
class CameraTasks : public std::span<const CameraTask> {
 public:
  CameraTasks(const CameraTask& task) : span(&task, 1) {}
  CameraTasks(const std::vector<CameraTask>& tasks) : span(tasks) {}
  std::size_t slot_count() const {
    std::size_t slots = 0;
    for (const CameraTask& task : *this) slots += task.slot_count();
    return slots;
  }
};

/// First hits of camera paths on surfaces with a broad lobe, after any chain of specular bounces; at most one a slot.
/// Arrays of one length, index i one gather point.
struct GatherPoints : Batch<GatherPoints> {
  LargeVector<std::uint32_t> slot;      ///< camera sample of the task
  LargeVector<std::uint32_t> sequence;  ///< pixel number in the picture: selects its random numbers
  LargeVector<std::uint32_t> sample;    ///< camera sample number of the pixel
  LargeVector<Vec3> position;           ///< metres
  LargeVector<Vec3> normal;             ///< unit, geometric, on the viewer's side
  LargeVector<float> offset;       ///< distance along the normal, or against it, at which leaving rays begin, metres
  LargeVector<Frame> frame;        ///< shading frame
  LargeVector<Vec3> wo;            ///< unit, world space, towards the viewer
  LargeVector<Bsdf> bsdf;          ///< only its broad lobes are evaluated, but for the sun's glints
  LargeVector<RGB> throughput;     ///< of the camera path up to the point
  LargeVector<MediumSides> media;  ///< around the point; empty in scenes without media

  template <class Any>
  static auto arrays(Any& points) {
    return std::tie(points.slot, points.sequence, points.sample, points.position, points.normal, points.offset,
                    points.frame, points.wo, points.bsdf, points.throughput, points.media);
  }
};

/// Light of a task, one entry a slot; W sr^-1 m^-2.
struct SlotRadiance {
  std::vector<RGB> emitted;          ///< seen directly or through specular bounces
  std::vector<RGB> direct;           ///< one broad bounce (or a rough specular one) between light and viewer
  std::vector<RGB> indirect;         ///< all that is gathered from surfaces
  std::vector<RGB> caustic;          ///< light through specular bounces only
  std::vector<RGB> medium;           ///< scattered or emitted by media between the viewer and the first broad bounce;
                                     ///< empty in scenes without media
  std::vector<RGB> surface_emitted;  ///< as `emitted`, by surface samples (gather/camera_pass.h); empty without them
  /// The share of `direct` that surface samples find at first hits, of a sun that is the only one; empty without it.
  std::vector<RGB> sun;
  /// Light of each group of light sources, all four parts together; empty without light groups.
  std::vector<std::vector<RGB>> groups;
  std::span<const std::uint32_t> group_of_source;  ///< index into `groups` of each light source

  /// Sizes all parts, black, but `surface_emitted` and `sun`, which it empties. @param media whether the scene has some
  void resize(std::size_t slots, bool media = false);
  /// Adds light of one source to a part, and to the source's group.
  void add(std::vector<RGB>& part, std::size_t slot, RGB light, std::uint32_t source) {
    part[slot] += light;
    if (!groups.empty() && source < group_of_source.size()) groups[group_of_source[source]][slot] += light;
  }
};

}  // namespace glowworm
