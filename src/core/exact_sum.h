// Sums of floats that do not depend on the order or grouping of their terms.
#pragma once
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace glowworm {

__extension__ using Int128 = __int128;

/// A sum in fixed point: an integer in units of 2^-kFractionBits. Each term is rounded to a whole number of units;
/// adding integers is exact, so partial sums in any order give the same bits. Terms are clamped to +-kMaxTerm, and NaN
/// counts as 0, so 2^24 terms cannot overflow.
template <typename Integer, int kFractionBits>
class ExactSum {
 public:
  static constexpr int kTermBits = 24;  ///< bits reserved for the number of terms
  static constexpr float kMaxTerm =
      static_cast<float>(std::uint64_t{1} << (8 * sizeof(Integer) - 2 - kTermBits - kFractionBits));

  ExactSum() = default;
  /// Makes a sum from units().
  explicit ExactSum(Integer units) : units_(units) {}

  ExactSum& operator+=(float term) {
    units_ += units_of(std::isnan(term) ? 0.0f : std::clamp(term, -kMaxTerm, kMaxTerm));
    return *this;
  }
  ExactSum& operator+=(const ExactSum& other) {
    units_ += other.units_;
    return *this;
  }
  double value() const { return std::ldexp(static_cast<double>(units_), -kFractionBits); }
  Integer units() const { return units_; }
  /// Whether this sum is possible for so many terms.
  bool can_be_of(std::uint32_t terms) const {
    const Integer most = units_of(kMaxTerm) * static_cast<Integer>(terms);
    return units_ >= -most && units_ <= most;
  }
  bool operator==(const ExactSum&) const = default;

 private:
  /// The term in units, rounded to nearest, halves away from zero.
  static Integer units_of(float term) {
    const auto bits = std::bit_cast<std::uint32_t>(term);
    const int exponent = static_cast<int>(bits >> 23 & 255);
    const std::uint32_t digits = (bits & 0x7fffff) | (exponent > 0 ? 0x800000 : 0);
    const int shift = std::max(exponent, 1) - 150 + kFractionBits;
    Integer units = 0;
    if (shift >= 0)
      units = static_cast<Integer>(digits) << shift;
    else if (shift >= -24)
      units = (digits + (1u << (-shift - 1))) >> -shift;
    return bits >> 31 ? -units : units;
  }

  Integer units_ = 0;
};

}  // namespace glowworm
