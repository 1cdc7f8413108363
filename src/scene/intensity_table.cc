#include "scene/intensity_table.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "core/content_hash.h"
#include "core/error.h"

namespace glowworm {

namespace {

constexpr double kTurn = 2 * M_PI;
/// Angles of files are rounded; as many radians do not matter.
constexpr float kAngleTolerance = 1e-4f;

void check_ascending(const std::vector<float>& angles, const char* what, float low, float span) {
  for (std::size_t i = 0; i < angles.size(); ++i)
    if (!std::isfinite(angles[i]) || angles[i] < low - kAngleTolerance || (i > 0 && !(angles[i] > angles[i - 1])))
      throw Error(std::string("the ") + what + " angles of an intensity table do not ascend");
  if (angles.back() - angles.front() > span + kAngleTolerance)
    throw Error(std::string("the ") + what + " angles of an intensity table span too much");
}

void check_tilt(const TiltFactors& tilt) {
  bool good = tilt.angles.size() == tilt.factors.size();
  for (std::size_t i = 0; good && i < tilt.angles.size(); ++i)
    good = std::isfinite(tilt.angles[i]) && (i == 0 || tilt.angles[i] > tilt.angles[i - 1]) && tilt.factors[i] >= 0 &&
           std::isfinite(tilt.factors[i]);
  if (!good) throw Error("the factors of tilt are negative or not finite, or their angles do not ascend");
}

/// Integral from a to t of (p + q (x - a)) sin(x) dx.
double sine_integral(double a, double t, double p, double q) {
  return p * (std::cos(a) - std::cos(t)) + q * (std::sin(t) - std::sin(a) - (t - a) * std::cos(t));
}

/// The t of [a, b] where sine_integral(a, t, p, q) is the share u of that up to b: Newton's method between bounds.
double inverse_sine_integral(double a, double b, double p, double q, double u) {
  const double wanted = u * sine_integral(a, b, p, q);
  double low = a, high = b, t = a + u * (b - a);
  for (int i = 0; i < 60 && high - low > 1e-9; ++i) {
    const double excess = sine_integral(a, t, p, q) - wanted;
    (excess > 0 ? high : low) = t;
    const double slope = (p + q * (t - a)) * std::sin(t);
    const double step = slope > 0 ? excess / slope : HUGE_VAL;
    const double next = t - step;
    if (std::abs(step) < 1e-10) break;
    t = next > low && next < high ? next : (low + high) / 2;
  }
  return t;
}

/// A number of [0, 1] by a density in proportion to p + (q - p) x.
double inverse_linear(double p, double q, double u) {
  const double root = std::sqrt(p * p + u * (q * q - p * p));
  return p + root > 0 ? u * (p + q) / (p + root) : u;
}

/// The step of ascending numbers that x lies in.
std::size_t step_of(const std::vector<float>& numbers, float x) {
  const auto above = std::upper_bound(numbers.begin() + 1, numbers.end() - 1, x);
  return static_cast<std::size_t>(above - numbers.begin()) - 1;
}

}  // namespace

IntensityTable::IntensityTable(TablePole pole, std::vector<float> azimuths, std::vector<float> polar_angles,
                               std::vector<float> values, TiltFactors tilt)
    : pole_(pole),
      azimuths_(std::move(azimuths)),
      polar_(std::move(polar_angles)),
      values_(std::move(values)),
      tilt_(std::move(tilt)) {
  if (azimuths_.empty() || polar_.size() < 2 || values_.size() != azimuths_.size() * polar_.size())
    throw Error("an intensity table needs a value for each pair of angles, and two polar angles at least");
  check_ascending(azimuths_, "azimuth", -HUGE_VALF, static_cast<float>(kTurn));
  check_ascending(polar_, "polar", 0, kPi);
  // Angles that only rounding separates would be equal.
  for (float& angle : polar_) angle = std::clamp(angle, 0.0f, kPi);
  check_ascending(polar_, "polar", 0, kPi);
  check_tilt(tilt_);
  if (azimuths_.size() == 1) {
    azimuths_ = {0, static_cast<float>(kTurn)};
    values_.insert(values_.end(), values_.begin(), values_.end());
  }
  for (const float value : values_) {
    if (!(value >= 0 && std::isfinite(value))) throw Error("an intensity is negative or not finite");
    greatest_ = std::max(greatest_, value);
  }
  std::vector<float> weights;
  for (std::size_t a = 0; a + 1 < azimuths_.size(); ++a)
    for (std::size_t p = 0; p + 1 < polar_.size(); ++p) {
      const double weight = cell_integral(a, p);
      integral_ += weight;
      weights.push_back(static_cast<float>(weight));
    }
  cells_ = Distribution2D(weights, static_cast<int>(polar_.size() - 1), static_cast<int>(azimuths_.size() - 1));
  ContentHash hash;
  hash.add(pole_);
  for (const std::vector<float>* part : {&azimuths_, &polar_, &values_, &tilt_.angles, &tilt_.factors})
    hash.add_array(std::span<const float>(*part));
  hash_ = hash.value();
}

IntensityTable IntensityTable::mirrored() const {
  const bool from_y = pole_ == TablePole::up;
  const auto turned = [](std::vector<float> angles, float sum) {
    std::reverse(angles.begin(), angles.end());
    for (float& angle : angles) angle = sum - angle;
    return angles;
  };
  std::vector<float> values;
  for (std::size_t a = 0; a < azimuths_.size(); ++a)
    for (std::size_t p = 0; p < polar_.size(); ++p)
      values.push_back(from_y ? value(a, polar_.size() - 1 - p) : value(azimuths_.size() - 1 - a, p));
  return {pole_, from_y ? azimuths_ : turned(azimuths_, 0), from_y ? turned(polar_, kPi) : polar_, std::move(values),
          tilt_};
}

double IntensityTable::cell_integral(std::size_t azimuth, std::size_t polar) const {
  const double a = polar_[polar], b = polar_[polar + 1];
  const double first = 0.5 * (double{value(azimuth, polar)} + value(azimuth + 1, polar));
  const double second = 0.5 * (double{value(azimuth, polar + 1)} + value(azimuth + 1, polar + 1));
  return (double{azimuths_[azimuth + 1]} - azimuths_[azimuth]) * sine_integral(a, b, first, (second - first) / (b - a));
}

float IntensityTable::tilt_factor(Vec3 aim) const {
  if (tilt_.angles.empty()) return 1;
  const float angle = std::atan2(std::sqrt(aim.x * aim.x + aim.z * aim.z), -aim.y);
  if (angle <= tilt_.angles.front()) return tilt_.factors.front();
  if (angle >= tilt_.angles.back()) return tilt_.factors.back();
  const std::size_t i = step_of(tilt_.angles, angle);
  const float t = (angle - tilt_.angles[i]) / (tilt_.angles[i + 1] - tilt_.angles[i]);
  return (1 - t) * tilt_.factors[i] + t * tilt_.factors[i + 1];
}

float IntensityTable::intensity(Vec3 d) const {
  if (pole_ == TablePole::up) d = {d.z, d.x, d.y};
  if (pole_ == TablePole::right) d = {d.z, d.y, d.x};
  // By atan2 of the sine and the cosine, since acos loses the pole to rounding.
  const float polar = std::atan2(std::sqrt(d.x * d.x + d.y * d.y), d.z);
  const auto turn = static_cast<float>(kTurn);
  float azimuth = std::atan2(d.y, d.x) - azimuths_.front();
  azimuth = azimuths_.front() + azimuth - turn * std::floor(azimuth / turn);
  if (azimuth > azimuths_.back() + kAngleTolerance) {
    // Just before the first azimuth counts as on it.
    if (azimuth - turn < azimuths_.front() - kAngleTolerance) return 0;
    azimuth = azimuths_.front();
  }
  if (polar < polar_.front() - kAngleTolerance || polar > polar_.back() + kAngleTolerance) return 0;
  const std::size_t a = step_of(azimuths_, azimuth), p = step_of(polar_, polar);
  const float s = std::clamp((azimuth - azimuths_[a]) / (azimuths_[a + 1] - azimuths_[a]), 0.0f, 1.0f);
  const float t = std::clamp((polar - polar_[p]) / (polar_[p + 1] - polar_[p]), 0.0f, 1.0f);
  return (1 - s) * ((1 - t) * value(a, p) + t * value(a, p + 1)) +
         s * ((1 - t) * value(a + 1, p) + t * value(a + 1, p + 1));
}

Vec3 IntensityTable::sample(Vec2 u) const {
  const Distribution2D::Sample cell = cells_.sample(u);
  const std::size_t p = cell.x, a = cell.y;
  const auto inside = [](float point, std::size_t size, std::size_t index) {
    return std::clamp(double{point} * static_cast<double>(size) - static_cast<double>(index), 0.0, 1.0);
  };
  const double u_polar = inside(cell.point.x, polar_.size() - 1, p);
  const double u_azimuth = inside(cell.point.y, azimuths_.size() - 1, a);
  const double low = polar_[p], high = polar_[p + 1];
  const double first = double{value(a, p)} + value(a + 1, p), second = double{value(a, p + 1)} + value(a + 1, p + 1);
  const double polar = inverse_sine_integral(low, high, first, (second - first) / (high - low), u_polar);
  const double t = (polar - low) / (high - low);
  const double left = (1 - t) * value(a, p) + t * value(a, p + 1);
  const double right = (1 - t) * value(a + 1, p) + t * value(a + 1, p + 1);
  const double azimuth =
      azimuths_[a] + inverse_linear(left, right, u_azimuth) * (double{azimuths_[a + 1]} - azimuths_[a]);
  return direction(azimuth, polar);
}

Vec3 IntensityTable::direction(double azimuth, double polar) const {
  const auto sine = static_cast<float>(std::sin(polar));
  const Vec3 d{sine * static_cast<float>(std::cos(azimuth)), sine * static_cast<float>(std::sin(azimuth)),
               static_cast<float>(std::cos(polar))};
  if (pole_ == TablePole::up) return {d.y, d.z, d.x};
  if (pole_ == TablePole::right) return {d.z, d.y, d.x};
  return d;
}

Vec3 IntensityTable::brightest() const {
  const auto at = static_cast<std::size_t>(std::max_element(values_.begin(), values_.end()) - values_.begin());
  return direction(azimuths_[at / polar_.size()], polar_[at % polar_.size()]);
}

}  // namespace glowworm
