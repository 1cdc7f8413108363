// Overlaps between faces of a chart.
#pragma once
#include <cstdint>
#include <vector>

#include "bake/chart.h"

namespace glowworm {

/// Removes faces that overlap earlier ones of the chart by more than a 256th of its longer side, and returns them. The
/// first face always stays.
std::vector<std::uint32_t> drop_overlaps(Chart& chart);

/// Share of the chart's covered cells that more than one face covers. @param cells along the longer side
double overlapping_share(const Chart& chart, int cells = 1024);

}  // namespace glowworm
