// What pairs of a photon and a query point cost the reverse engine's kernels where there is nothing to search.
#pragma once
#include <optional>

#include "kernels/glossy.h"

namespace glowworm::bench {

/// Nanoseconds of a thread for each pair, when all threads work and every photon reaches every point, all of it in the
/// nearest cache: tests of distance and normal alone.
double nanoseconds_of_a_test();

/// The same with the pair's contribution added up, box kernel.
/// @param model of glossy points; none: Lambertian ones
double nanoseconds_of_a_sum(std::optional<GlossyModel> model);

}  // namespace glowworm::bench
