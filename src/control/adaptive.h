// Adaptive sampling: more camera samples for the pixels whose noise is worth them.
#pragma once
#include <cstdint>
#include <vector>

#include "film/film.h"
#include "film/filtered.h"
#include "points/gather_points.h"

namespace glowworm {

/// Camera samples that every pixel has before the first round: few may not have found some light yet.
inline constexpr std::uint32_t kEvenSamples = 4;

/// Samples of a round, as a share of all before.
inline constexpr double kRoundGrowth = 0.5;

/// Number of samples that each square of CameraTask::kSquare pixels shall have after a round, row by row over the
/// blocks of the film.
using SquareSamples = std::vector<std::uint32_t>;

/// Chooses squares whose samples the next round doubles: those that lower relative_error() most for each sample, until
/// the error is predicted to reach the target, or the round is half as long as all before. The noise of a square is
/// that of the squares around it: what its own samples found does not decide their number, which would bias their mean.
/// Squares with few samples take part in any case, because they may have found none of their light.
/// @param picture of the film, whose pixels have kEvenSamples or more
/// @param target  relative error to reach; 0: none
/// @param most    samples of a pixel
/// @return empty if no square may have more samples
SquareSamples next_round(const Film& film, const FilmPicture& picture, double target, std::uint32_t most);

/// One more sample for every square, where the time left is too short to choose squares.
/// @return empty if no square may have more samples
SquareSamples even_round(const Film& film, std::uint32_t most);

/// The tasks that bring every square of the film to its number of samples. Those of squares that have it are left out,
/// so a round may be continued.
std::vector<CameraTask> tasks_of_round(const Film& film, const SquareSamples& wanted);

/// Whether the numbers can describe a round of a film with these bounds.
bool is_round_of(const PixelBounds& bounds, const SquareSamples& wanted);

}  // namespace glowworm
