// The radius of all photons for renders with one radius.
#pragma once

#include "core/memory_budget.h"
#include "maps/pass.h"
#include "maps/photon_maps.h"
#include "settings/settings.h"
#include "trace/tracer.h"

namespace glowworm {

/// Finds the radius with which the query points of a picture, or of points, have `wanted.nearest` photons within reach
/// on average: from the radius that `wanted` gives, in rounds, which scale it by how far the mean of a sample of query
/// points is off and by the power of the radius with which the mean grew. Leaves the maps with other settings. Throws
/// as PhotonMaps::update() and render_pass().
/// @param wanted settings of the maps, with a fixed radius
/// @param part   of the picture
/// @param passes settings of its passes; their guide places the query points
/// @return metres
float fixed_radius_for(const Tracer& tracer, PhotonMaps& maps, PhotonMapSettings wanted, const View& view,
                       const PixelBounds& part, const PassSettings& passes, MemoryBudget& budget);

}  // namespace glowworm
