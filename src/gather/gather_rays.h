// Final gather rays under way, and how they are made: BRDF-sampled, one in each stratum of every gather point.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "points/gather_points.h"
#include "trace/tracer.h"

namespace glowworm {

/// Which part of its path a gather ray is.
enum class Segment : std::uint8_t {
  first,            ///< straight from the gather point
  chain,            ///< behind a sharp bounce: lights seen through it are the caustic map's
  secondary,        ///< straight from the end of a short ray (secondary gather); direct light is sampled there
  secondary_chain,  ///< behind a sharp bounce after that: lights seen through it count where there is no caustic map
  to_patch          ///< straight from the gather point to a bright patch
};

/// Rays under way. Arrays of one length, index i one ray; the caller that traces them sizes `hits`.
struct GatherRays {
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  std::vector<RGB> weight;             ///< factor on the radiance that the ray brings: throughput f_r cos / (pdf N)
  std::vector<float> pdf;              ///< of the direction from the gather point, per steradian
  std::vector<std::uint32_t> point;    ///< index of the gather point
  std::vector<std::uint32_t> stratum;  ///< 0 to N - 1
  std::vector<Segment> segment;
  std::vector<std::uint8_t> bounces;  ///< sharp ones so far
  std::vector<RGB> absorption;        ///< of the volume that the last bounce led into

  std::size_t size() const { return rays.size(); }
  void reserve(std::size_t n);
  void clear();
  /// Puts ray `from` in the place of ray `to`.
  void move(std::size_t from, std::size_t to);
  /// Keeps the first n rays.
  void shrink(std::size_t n);
  /// Makes it n rays; what is new is of stratum `cell`, straight from the gather point, and says nothing else yet.
  void resize(std::size_t n, std::uint32_t cell);
  void push_back(const Ray& ray, RGB w, float density, std::uint32_t gather_point, std::uint32_t cell);
};

/// The order of gather points [first, last) in which rays of one stratum are coherent: points whose shading frames
/// point alike come together, else as before.
void coherent_order(const GatherPoints& points, std::size_t first, std::size_t last, std::vector<std::uint32_t>& order);

/// Makes the rays of some gather points, stratum by stratum: `rays_each` of every point, neighbours in `order`
/// neighbours within a stratum. Diffuse points go through the kernel diffuse_rays(), others one by one.
class GatherRayMaker {
 public:
  /// @param points must outlive the maker; @param order which of them, and in what order
  void prepare(const GatherPoints& points, std::span<const std::uint32_t> order, std::uint32_t rays_each,
               std::uint32_t seed);
  /// Appends the rays of strata [first, last), last <= rays_each. Samples without a direction leave none.
  void create(std::uint32_t first, std::uint32_t last, GatherRays& out);

 private:
  void prepare_diffuse(std::size_t place);
  Ray diffuse_ray(std::size_t place) const;
  /// Appends the rays of a stratum where all points are diffuse.
  void add_diffuse(std::uint32_t cell, GatherRays& out) const;
  void add_other(std::size_t place, std::uint32_t cell, GatherRays& out) const;

  const GatherPoints* points_ = nullptr;
  std::span<const std::uint32_t> order_;
  std::uint32_t rays_each_ = 0, seed_ = 0;
  // Of each place in the order: arrays as the kernel wants them.
  std::vector<std::uint32_t> sequence_, sample_;
  std::array<std::vector<float>, 9> frame_;
  std::array<std::vector<float>, 3> normal_, direction_;
  std::vector<float> cosine_;
  std::vector<Vec3> origin_;
  std::vector<RGB> weight_;  // of a diffuse ray
  std::vector<std::uint8_t> diffuse_;
  bool any_diffuse_ = false, all_diffuse_ = false;
};

/// A number in [0, 1) that belongs to one final gather ray and `what` it is for.
float gather_ray_number(const GatherPoints& points, std::size_t point, std::uint32_t stratum, std::uint32_t seed,
                        std::uint32_t what);

/// The ray that leaves a surface. @param side the geometric normal, on the side where the ray leaves
/// @param offset how far along it the ray begins (offset_origin()), metres
Ray leave_surface(Vec3 position, Vec3 side, float offset, Vec3 direction);

}  // namespace glowworm
