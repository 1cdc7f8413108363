// The path tracer: unbiased, and the reference for everything else.
#pragma once
#include "core/statistics.h"
#include "gather/camera_pass.h"
#include "points/gather_points.h"
#include "render/settings.h"
#include "trace/tracer.h"

namespace glowworm {

/// Traces all camera samples of a task by unidirectional path tracing with next-event estimation and multiple
/// importance sampling (balance heuristic, Veach 1997, chapter 9), Russian roulette after a few bounces. Light is told
/// apart as photon mapping does it: emitted (seen through sharp bounces alone), direct, caustic (light, sharp bounces,
/// gather point), indirect (all else). Both outputs are sized by the call. The same for any number of threads.
void trace_paths(const Tracer& tracer, const Camera& camera, const CameraTask& task, const RenderSettings& settings,
                 SlotRadiance& radiance, FirstHit& first_hit, Statistics& statistics);

}  // namespace glowworm
