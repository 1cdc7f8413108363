// The path tracer: unbiased, and the reference for photon mapping.
#pragma once
#include "core/statistics.h"
#include "gather/point_pass.h"
#include "points/gather_points.h"
#include "render/settings.h"
#include "trace/tracer.h"

namespace glowworm {

/// Traces all samples of the tasks, over pixels or points, with unidirectional path tracing, next-event estimation and
/// multiple importance sampling (balance heuristic, Veach 1997, chapter 9), and Russian roulette after a few bounces.
/// Light is divided into the parts of photon mapping: emitted (seen through sharp bounces only), direct, caustic
/// (light, sharp bounces, gather point), indirect (the rest). Sizes both outputs. The result does not depend on the
/// number of threads.
void trace_paths(const Tracer& tracer, const View& view, CameraTasks tasks, const RenderSettings& settings,
                 SlotRadiance& radiance, FirstHit& first_hit, Statistics& statistics);

}  // namespace glowworm
