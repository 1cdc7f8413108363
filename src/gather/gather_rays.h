// Final gather rays, BRDF-sampled with one ray in each stratum of every gather point.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "gather/gather_guide.h"
#include "points/gather_points.h"
#include "trace/tracer.h"
#include "transport/step.h"

namespace glowworm {

/// The part of its path that a gather ray is on.
enum class Segment : std::uint8_t {
  first,            ///< straight from the gather point
  through_panes,    ///< the same after panes, which light samples pass, too
  chain,            ///< after a specular bounce; lights seen through it belong to the caustic map
  secondary,        ///< by a secondary gather, through panes or not
  secondary_chain,  ///< after a specular bounce of a secondary ray; lights count only without a caustic map
  to_patch          ///< straight from the gather point to a bright patch
};

/// A gather ray under way. Its throughput is the factor on the radiance along the ray: that of the camera path times
/// f_r cos / (pdf N).
struct GatherPath : PathState {
  std::uint32_t point = 0, stratum = 0;  ///< index of the gather point; 0 to N - 1
  Segment segment = Segment::first;
  std::uint32_t bounces = 0;    ///< specular bounces so far
  float chain = 1;              ///< factor of these bounces on the throughput
  std::uint32_t patch = kNone;  ///< Segment::to_patch: the bright patch that the ray must hit to count
};
using GatherPaths = std::vector<GatherPath>;

/// Appends a ray that starts at a gather point. @param pdf of its direction, per steradian
inline GatherPath& add_gather_path(GatherPaths& out, const Ray& ray, RGB weight, float pdf, std::uint32_t point,
                                   std::uint32_t stratum) {
  return out.emplace_back(GatherPath{{ray, weight, pdf}, point, stratum});
}

/// Sorts gather points [first, last) by the direction of their normals, stably, so that the rays of one stratum are
/// coherent.
void coherent_order(const GatherPoints& points, std::size_t first, std::size_t last, std::vector<std::uint32_t>& order);

/// The density of the gather rays of a point.
class GatherDensity {
 public:
  GatherDensity() = default;
  /// @param points must outlive the density; @param guide null: none
  GatherDensity(const GatherPoints& points, std::size_t point, const GatherGuide* guide);

  /// A density by which rays are weighted against light samples: between that of rays that are guided and that of rays
  /// that are not. Per steradian, of a direction in the world (unit).
  float weighing_pdf(Vec3 direction) const;
  /// Per steradian, of a direction of the BSDF of a guided point: before those on the wrong side of the surface are
  /// mirrored (bsdf/shaded_surface.h).
  float guided_pdf(Vec3 w) const;
  /// Share of diffuse reflection in the rays.
  float diffuse_share() const { return diffuse_share_; }
  /// The region of the guide, or kNone.
  std::uint32_t region() const { return region_; }
  /// The frame of guided directions: its normal is the shading normal on the viewer's side.
  const Frame& frame() const { return frame_; }
  /// The viewer's direction that the BSDF uses, in shading coordinates.
  Vec3 view() const { return view_; }

 private:
  const GatherPoints* points_ = nullptr;
  const GatherGuide* guide_ = nullptr;
  std::size_t point_ = 0;
  std::uint32_t region_ = kNone;
  Frame frame_;
  Vec3 view_;
  float diffuse_share_ = 1;
};

/// Makes the rays of some gather points stratum by stratum: `rays_each` for every point. Neighbours in `order` are
/// neighbours within a stratum. Diffuse points use the kernel diffuse_rays(), others are handled one by one.
class GatherRayMaker {
 public:
  /// @param points must outlive the maker; @param order the points to use, which follow each other, and their order
  /// @param guide null: none
  void prepare(const GatherPoints& points, std::span<const std::uint32_t> order, std::uint32_t rays_each,
               std::uint32_t seed, const GatherGuide* guide);
  /// Of one of the points.
  const GatherDensity& density(std::uint32_t point) const { return density_[point - first_point_]; }
  /// Appends the rays of strata [first, last), last <= rays_each. Samples without a direction make no ray.
  void create(std::uint32_t first, std::uint32_t last, GatherPaths& out);

 private:
  void prepare_diffuse(std::size_t place);
  Ray diffuse_ray(std::size_t place) const;
  void add_other(std::size_t place, std::uint32_t cell, GatherPaths& out) const;
  void add_guided(std::size_t place, std::uint32_t cell, GatherPaths& out) const;

  const GatherPoints* points_ = nullptr;
  std::span<const std::uint32_t> order_;
  std::uint32_t rays_each_ = 0, seed_ = 0;
  const GatherGuide* guide_ = nullptr;
  // For each position in the order: arrays for the kernel.
  std::vector<std::uint32_t> sequence_, sample_;
  std::array<std::vector<float>, 9> frame_;
  std::array<std::vector<float>, 3> normal_, direction_;
  std::vector<float> cosine_;
  std::array<std::vector<float>, 2> square_;
  std::vector<std::uint32_t> region_;  // of the guide
  std::vector<float> factor_;          // on the weight, by the guide
  std::vector<Vec3> origin_;
  std::vector<RGB> weight_;            // weight of a diffuse ray
  std::vector<std::uint8_t> diffuse_;  // whether the point only reflects diffusely
  std::uint32_t first_point_ = 0;
  std::vector<GatherDensity> density_;  // of each point from the first on
  bool any_square_ = false;
};

/// The point of the unit square of ray `cell` of `rays_each`, before a guide warps it.
Vec2 gather_square(std::uint32_t sequence, std::uint32_t sample, std::uint32_t rays_each, std::uint32_t cell,
                   std::uint32_t seed);

/// A random number in [0, 1) of one final gather ray, for the purpose `what`.
float gather_ray_number(const GatherPoints& points, std::size_t point, std::uint32_t stratum, std::uint32_t seed,
                        std::uint32_t what);

}  // namespace glowworm
