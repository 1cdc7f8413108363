// Scattering by matrices over patches of directions, as programs for windows give it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/vec.h"

namespace glowworm {

/// A division of the hemisphere into patches: rings around the normal, of patches alike. The first patch of a ring has
/// its middle at azimuth 0, along x; the next follow towards y. Patches are numbered ring by ring. (J. H. Klems, "A New
/// Method for Predicting the Solar Heat Gain of Complex Fenestration Systems", ASHRAE Transactions 100, 1994.)
class PatchBasis {
 public:
  struct Ring {
    double upper = 90;  ///< degrees from the normal, where it ends
    int patches = 1;    ///< 1, or an even number: the opposite of a patch is a patch
  };
  /// @param rings from the normal outwards; the last ends at 90 degrees
  explicit PatchBasis(const std::vector<Ring>& rings);

  std::size_t size() const { return ring_of_.size(); }
  /// The patch of a unit direction; the sign of its z does not count.
  std::size_t patch_of(Vec3 direction) const;
  /// The patch at the other azimuth.
  std::size_t opposite(std::size_t patch) const;
  /// The integral of the cosine over a patch, steradians.
  float projected(std::size_t patch) const { return rings_[ring_of_[patch]].projected; }
  /// A direction with z > 0, distributed by the cosine within the patch.
  Vec3 sample(std::size_t patch, Vec2 u) const;

 private:
  struct Bounds {
    float least_sine2, most_sine2;  ///< squares of the sines of its angles
    float projected;
    std::size_t first, count;  ///< its patches
  };
  std::vector<Bounds> rings_;
  std::vector<std::uint8_t> ring_of_;
};

/// A surface that scatters by matrices. In its own space z is the front, and values are per steradian. It is
/// reciprocal: where the given matrices are not, it has their mean.
class MeasuredBsdf {
 public:
  /// What was changed of the given values.
  struct Corrections {
    double asymmetry = 0;  ///< share of the light by which the matrices differ from reciprocal ones
    double scale = 1;      ///< factor on all values, below 1 where more light left than came
  };
  /// Matrices of basis.size() squared values; value[a * size + b] for directions of patches a and b, on these sides.
  struct Values {
    std::vector<float> front, back;         ///< reflection: both in front, or both behind
    std::vector<float> onwards, backwards;  ///< transmission: a in front and b behind. Light goes from b to a, and from
                                            ///< a to b; one may be empty: the other counts for both
  };
  MeasuredBsdf(PatchBasis basis, Values values);

  const Corrections& corrections() const { return corrections_; }
  /// f for two unit directions, sr^-1. @param back the side of wo; @param passes wi is on the other side
  float evaluate(bool back, bool passes, Vec3 wo, Vec3 wi) const {
    return sides_[back][passes].values[basis_.patch_of(wo) * basis_.size() + basis_.patch_of(wi)];
  }
  /// Share of the light from wo that it reflects, or passes.
  float albedo(bool back, bool passes, Vec3 wo) const { return sides_[back][passes].albedo[basis_.patch_of(wo)]; }
  bool is_black(bool passes) const;
  /// Samples by f times the cosine. @return a direction with z > 0
  Vec3 sample(bool back, bool passes, Vec3 wo, Vec2 u) const;
  /// A hash of all values.
  std::uint64_t hash() const;

 private:
  struct Side {
    std::vector<float> values;  ///< f, by the patches of wo and wi
    std::vector<float> sums;    ///< of f times the projected angle, up to and with each patch of wi
    std::vector<float> albedo;  ///< of each patch of wo
  };
  void make_reciprocal(Values& values);
  void conserve_energy();
  void add_up(Side& side);

  PatchBasis basis_;
  Side sides_[2][2];  ///< of wo in front and behind, reflecting and passing
  Corrections corrections_;
};

}  // namespace glowworm
