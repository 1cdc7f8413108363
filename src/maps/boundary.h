// Boundary correction for kernels that extend over the edge of a surface.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "core/shared_work.h"
#include "density/engine.h"
#include "maps/lit_sides.h"
#include "points/photon_batch.h"
#include "points/query_points.h"
#include "trace/tracer.h"

namespace glowworm {

/// A photon's kernel is normalised over a whole disc. At an edge or on a small surface, part of the disc is empty or
/// cannot contain query points (a floor continues beneath a carpet, a cupboard, a wall), and that part of the flux is
/// lost ("boundary bias": Jensen, Realistic Image Synthesis Using Photon Mapping, 2001, section 7.3); between close
/// parallel surfaces flux counts more than once. Returns for each photon the factor on its flux that corrects this: one
/// over the kernel's integral over all surface where query points count the photon, estimated with lines along its
/// normal. At least 1/4; 1 on plain surfaces; on thin parts the mean over photons is right. Uses all threads;
/// deterministic.
/// @param sides  of the triangles: nothing counts behind the dark ones
/// @param cuts   receives the kernel_cuts() of the same kernels, which are found on the way; null: not wanted
/// @param shared processes that divide the work; null: none @param name of the work, for SharedWork::divide()
/// @param on_all_surfaces PhotonPassSettings::on_all_surfaces of the photons: else mirrors, glass and black have none
std::vector<float> boundary_factors(const Tracer& tracer, const PhotonBatch& photons, const RadiusPolicy& policy,
                                    const LitSides& sides, std::vector<PhotonCuts>* cuts = nullptr,
                                    SharedWork* shared = nullptr, const std::string& name = "",
                                    bool on_all_surfaces = false);

/// Corrects estimates of single query points: multiplies each by one over the integral of a kernel around the point, of
/// the same radius, over all surface where photons count there. The factors of photons conserve flux, but leave an
/// estimate of 0.72 at an edge and 0.5 at a corner, and more than 1 beyond; these leave 1. They cost lines for each
/// point, so they serve estimates that are seen, and the photons' factors serve those that gather rays average.
/// At least 1/4; 1 on plain surfaces. Uses all threads; the factor of a point depends on that point alone.
/// @param radii for each point: metres; 0 where there is no photon @param sides as for boundary_factors()
/// @param on_all_surfaces PhotonPassSettings::on_all_surfaces of the photons
void correct_estimates(const Tracer& tracer, const QueryPoints& points, std::span<const float> radii,
                       KernelShape kernel, const LitSides& sides, std::span<RGB> radiance,
                       bool on_all_surfaces = false);

}  // namespace glowworm
