// Glare of views in every hour of a year, from luminances.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "measure/find_year.h"
#include "measure/glare.h"
#include "scene/camera.h"

namespace glowworm {

/// Glare of a view in every hour of a weather file; 0 in hours without light.
struct ViewYear {
  std::vector<float> dgp;          ///< daylight glare probability
  std::vector<float> illuminance;  ///< lx, on the plane across the view
  /// Standard errors of both, by student_factor(): the truth lies within twice the error with a chance of 95%. What the
  /// number of pixels and the sky's patches leave out is not part of them.
  std::vector<float> dgp_error, illuminance_error;

  explicit ViewYear(std::size_t hours) : dgp(hours), illuminance(hours), dgp_error(hours), illuminance_error(hours) {}
};

/// Pixels along a side of pictures that are rated.
inline constexpr std::uint32_t kViewSide = 128;

/// Independent renders of a view.
inline constexpr std::uint32_t kRoundsOfView = 4;

/// Throws MemoryError if the pictures of a view take more than half of the budget.
void check_view_room(std::uint32_t side, const YearModel& model, std::uint64_t memory_bytes);

/// Rates views of a scene in some of the lit hours, and fills these hours of `out`. Throws as check_view_room().
///
/// Each view is rendered for all patches of the sky and all places of the sun, of which every pixel keeps its light
/// apart. Pictures of hours are sums over patches and places, to which are added what no coefficient blurs: the sky as
/// pixels see it, by its formula, in place of its patches; sunlight that surfaces reflect to the eye, by rays towards
/// the actual sun; and the sun itself and its mirror images, as sources (measure/sky_rays.h).
/// Several renders have photons and samples of their own. The jackknife over them gives the standard errors: B. Efron
/// and C. Stein, "The jackknife estimate of variance", Annals of Statistics 9(3), 1981.
/// @param views fisheye or hemispherical, in the coordinates of the scene
/// @param hours as indices into YearSky::lit
/// @param watch as of find_state(); a view has kRoundsOfView times one or two Jobs
/// @return false if `watch` cancelled a Job
bool rate_views(const Scene& plain, std::span<const Camera> views, std::uint32_t side, const YearModel& model,
                std::span<const std::uint32_t> hours, const RenderSettings& asked, const YearWatch& watch,
                std::span<ViewYear> out);

}  // namespace glowworm
