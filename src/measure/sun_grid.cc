#include "measure/sun_grid.h"

#include <algorithm>
#include <cmath>

namespace glowworm {

namespace {

constexpr double kSunDegree = M_PI / 180;
/// Least altitude of a node.
constexpr double kHorizon = 1 * kSunDegree;

}  // namespace

SunGrid::SunGrid(const SkyMoment& site, std::span<const Vec3> suns, std::span<const float> beam, double step) {
  const double up = std::sin(site.latitude * kSunDegree), across = std::cos(site.latitude * kSunDegree);
  const double c = std::cos(site.turn * kSunDegree), s = std::sin(site.turn * kSunDegree);
  pole_ = {-s * across, up, -c * across};
  meridian_ = {s * up, across, c * up};
  west_ = {-c, 0, s};
  shares_.resize(suns.size());
  std::vector<std::size_t> shining;
  std::vector<double> declination, hour_angle;
  for (std::size_t i = 0; i < suns.size(); ++i) {
    if (!(beam[i] > 0)) continue;
    const Vec3d d(suns[i]);
    shining.push_back(i);
    declination.push_back(std::asin(std::clamp(dot(d, pole_), -1.0, 1.0)));
    hour_angle.push_back(std::atan2(dot(d, west_), dot(d, meridian_)));
  }
  if (shining.empty()) return;
  const auto [least, most] = std::minmax_element(declination.begin(), declination.end());
  const double wanted = step * kSunDegree, range = *most - *least;
  const int rows = std::max(static_cast<int>(std::ceil(range / wanted)), 1);
  const double row_step = std::max(range / rows, 1e-9);
  // Columns go around the pole, so that none ends at midnight.
  const int columns = static_cast<int>(std::ceil(2 * M_PI / wanted));
  const double column_step = 2 * M_PI / columns;
  for (std::size_t i = 0; i < shining.size(); ++i) {
    const double v = (declination[i] - *least) / row_step, u = (hour_angle[i] + M_PI) / column_step;
    const int row = std::clamp(static_cast<int>(v), 0, rows - 1), column = static_cast<int>(u);
    const double fv = std::clamp(v - row, 0.0, 1.0), fu = std::clamp(u - column, 0.0, 1.0);
    Shares& shares = shares_[shining[i]];
    for (int k = 0; k < 4; ++k) {
      const int r = row + k / 2, c = column + k % 2;
      const double weight = (k / 2 ? fv : 1 - fv) * (k % 2 ? fu : 1 - fu);
      shares[static_cast<std::size_t>(k)] = {
          weight > 0 ? node(r, c % columns, *least + r * row_step, c * column_step - M_PI) : 0,
          static_cast<float>(weight)};
    }
  }
}

std::uint32_t SunGrid::node(int row, int column, double declination, double hour_angle) {
  const auto [found, added] = node_of_.try_emplace({row, column}, static_cast<std::uint32_t>(places_.size()));
  if (!added) return found->second;
  Vec3d d = pole_ * std::sin(declination) +
            (meridian_ * std::cos(hour_angle) + west_ * std::sin(hour_angle)) * std::cos(declination);
  if (d.y < std::sin(kHorizon)) {
    const double flat = std::max(std::hypot(d.x, d.z), 1e-9);
    d = {d.x / flat * std::cos(kHorizon), std::sin(kHorizon), d.z / flat * std::cos(kHorizon)};
  }
  places_.push_back(normalize(Vec3(narrow(d))));
  return found->second;
}

}  // namespace glowworm
