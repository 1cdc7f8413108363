// Light that photons bring to points in air, where no surface holds any: the density of those that pass.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "gather/point_pass.h"
#include "kernels/kernel_shape.h"
#include "points/disc_tree.h"
#include "points/gather_points.h"
#include "points/photon_segment.h"
#include "trace/tracer.h"
#include "transport/light_images.h"

namespace glowworm {

/// A point of a PointGrid in air.
struct AirPoint {
  Vec3 position;           ///< metres, where gather rays start: a little before a surface that the point may lie on
  Vec3 normal;             ///< unit
  std::uint32_t slot = 0;  ///< of its task
};

/// The point of a cell.
AirPoint air_point(const Scene& scene, const PointGrid& grid, std::size_t cell, std::uint32_t slot);
/// Gather points of a grid as such points.
std::vector<AirPoint> air_points(const GatherPoints& points);
/// Discs of one radius around the points of a grid: photons that miss all of them are of no use.
DiscTree air_discs(const Scene& scene, const PointGrid& grid, float radius);

/// The photons that pass points in air, and how they are looked up.
struct AirLight {
  std::vector<PhotonSegment> segments;  ///< those that cross air_discs() of `most_radius`
  float most_radius = 0;                ///< metres
  std::uint32_t nearest = 1;            ///< photons of an estimate, unless more than `most_radius` would hold them
  KernelShape kernel = KernelShape::epanechnikov;
  float radius_scale = 1;                     ///< factor on the radii
  bool extrapolates = false;                  ///< to discs without radius, as PassSettings::extrapolates
  std::shared_ptr<const LightImages> images;  ///< whose light photons leave to rays; null where no photons are traced
};

/// The largest radius of a lookup: four times the one that holds `nearest` of photons that cross the scene evenly.
float most_air_radius(const Scene& scene, std::uint64_t photons, std::uint32_t nearest);

/// Photons that cross discs of that radius, if photons cross the scene evenly and no discs overlap.
double even_air_photons(std::size_t discs, std::uint32_t nearest);

/// Adds to `part` of the radiance the irradiance at the points, W m^-2. A photon counts where it crosses the plane of a
/// point from the front, and nothing is between the crossing and the point; an estimate compensates for the part of its
/// disc that the point does not see. Runs on all threads; counts occlusion_rays. The light of a point does not depend
/// on the others.
void add_air_light(const Tracer& tracer, const AirLight& light, std::span<const AirPoint> points,
                   SlotRadiance& radiance, std::vector<RGB>& part, Statistics& statistics);

}  // namespace glowworm
