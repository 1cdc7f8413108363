// The edge-aware filter of frames in motion.
#pragma once
#include "session/view_image.h"

namespace glowworm {

/// Smooths noise of image.light and keeps its edges: an a-trous wavelet filter (Dammertz et al., "Edge-Avoiding A-Trous
/// Wavelet Transform for fast Global Illumination Filtering", HPG 2010) over light divided by albedo, weighted by how
/// alike albedo, normal and plane are. Biased; for pictures of one sample, whose noise is not known. Positions must be
/// set. The same for any number of threads.
/// @param passes each doubles the reach: the last taps are 2^(passes - 1) pixels away
void filter_preview(ViewImage& image, int passes = 4);

}  // namespace glowworm
