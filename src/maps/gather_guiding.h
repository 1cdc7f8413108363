// The pilot pass of gather rays, from which their guide learns.
#pragma once
#include "core/memory_budget.h"
#include "core/shared_work.h"
#include "gather/gather_guide.h"
#include "maps/pass.h"

namespace glowworm {

/// Bytes that learn_gather_guide() reserves in a picture or grid of so many pixels, for the rays that it learns from.
std::uint64_t gather_guide_bytes(double pixels, std::uint32_t gather, bool of_points);

/// Traces gather rays from a coarse picture of the view, or from its points, and learns where they find light. There
/// are half as many as for one sample of the whole picture, at least 65,536 from points, and at most half a million. A
/// quarter of them is traced first; if the guide would gain little by them, the others are not traced, and rays are not
/// guided. The guide depends neither on the part of the picture that is rendered nor on the number of threads or the
/// budget. Points have none unless PointGrid::learns.
/// @param maps up to date @param settings of the passes that the guide is for
/// @param shared processes that divide the work; null: none
GatherGuide learn_gather_guide(const Tracer& tracer, const PhotonMaps& maps, const View& view,
                               const PassSettings& settings, MemoryBudget& budget, Statistics& statistics,
                               SharedWork* shared = nullptr);

}  // namespace glowworm
