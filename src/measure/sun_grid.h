// Places of the sun that stand for all places of a year.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "core/transform_double.h"
#include "core/vec.h"
#include "import/daylight.h"

namespace glowworm {

/// Nodes of a grid of declination and hour angle around the sun's paths. A place of the sun lies among four of them,
/// and light that changes smoothly with the sun's place is interpolated bilinearly. Nodes below the horizon are raised
/// to it, since light from below would enter rooms through ground that a scene need not have.
class SunGrid {
 public:
  struct Share {
    std::uint32_t place = 0;  ///< into places()
    float weight = 0;
  };
  using Shares = std::array<Share, 4>;  ///< weights add up to 1

  /// @param site any moment there @param suns unit, towards the sun; y is up
  /// @param beam irradiance of each of them: those of 0 get no nodes @param step degrees between nodes
  SunGrid(const SkyMoment& site, std::span<const Vec3> suns, std::span<const float> beam, double step);

  /// Unit, towards the sun.
  std::span<const Vec3> places() const { return places_; }
  /// The nodes around each of the suns; weights of 0 for those without irradiance.
  std::span<const Shares> shares() const { return shares_; }

 private:
  std::uint32_t node(int row, int column, double declination, double hour_angle);

  // Unit: towards the celestial pole, where the equator culminates, and west.
  Vec3d pole_, meridian_, west_;
  std::map<std::pair<int, int>, std::uint32_t> node_of_;
  std::vector<Vec3> places_;
  std::vector<Shares> shares_;
};

}  // namespace glowworm
