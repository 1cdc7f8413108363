// The path tracer, the reference for photon mapping. It is unbiased, except for light that mirrors or glass bend from
// lights without size: no path from the viewer meets such a light, and shadow rays end at the surface that bends it.
// Photons bring it, looked up at each broad bounce and along the ways through media; a render with new photons and
// smaller radii for each sample converges to it, too.
#pragma once
#include "core/statistics.h"
#include "gather/point_pass.h"
#include "maps/photon_maps.h"
#include "points/gather_points.h"
#include "settings/settings.h"
#include "trace/tracer.h"

namespace glowworm {

/// Traces all samples of the tasks, over pixels or points, with unidirectional path tracing, next-event estimation and
/// multiple importance sampling (balance heuristic, Veach 1997, chapter 9).
/// Light is divided into the parts of photon mapping: emitted (seen through specular bounces only), direct, caustic
/// (light, specular bounces, gather point), indirect (the rest). Sizes both outputs. The result does not depend on the
/// number of threads.
/// @param maps of PhotonChoice::unseen_by_paths; null: without that light
void trace_paths(const Tracer& tracer, const View& view, CameraTasks tasks, const RenderSettings& settings,
                 const PhotonMaps* maps, SlotRadiance& radiance, FirstHit& first_hit, Statistics& statistics);

}  // namespace glowworm
