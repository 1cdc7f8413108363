// Guided emission: photons go where the image needs them.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace glowworm {

/// The random numbers in [0, 1) of an emitted photon: choice of the light, place (2), direction (2).
using EmissionNumbers = std::array<float, 5>;

/// A path of a pilot pass: its emission numbers, its score, and the density of the numbers.
struct PilotPath {
  EmissionNumbers numbers;
  float score = 0;    ///< contribution to the image, as if emitted without guiding; not negative
  float density = 1;  ///< over [0, 1)^5, of all pilot passes together
};

/// A piecewise constant density over the five random numbers of an emitted photon, learnt from pilot paths. One tree
/// serves all lights of any kind, because all use these numbers. A path of density p carries 1 / p of its flux, so the
/// estimate stays unbiased. (Guiding in primary sample space: Guo, Bauszat, Bikker, Eisemann, "Primary Sample Space
/// Path Guiding", EGSR 2018.)
class EmissionGuide {
 public:
  static constexpr float kFloor = 0.05f;

  EmissionGuide();  ///< the uniform density: no guiding

  /// Learns a density. Splits minimise the variance of the mean score within both parts. The density is proportional to
  /// the root of the mean score, which minimises the variance of the sum of contributions that photons make at random;
  /// it is never less than `floor`, in (0, 1], so a path never carries more than 1 / floor times its flux.
  static EmissionGuide learn(std::span<const PilotPath> paths, float floor = kFloor);

  /// Turns uniform numbers into guided ones, strata into strata, and returns 1 / density there: the factor on the
  /// path's flux.
  float warp(EmissionNumbers& numbers) const;
  float density(const EmissionNumbers& numbers) const;

  /// Mean score of guided paths over the mean score of unguided ones, from the pilot paths.
  double gain() const { return gain_; }
  std::size_t cell_count() const { return (nodes_.size() + 1) / 2; }

  /// Throws InvalidArchive (core/archive.h) if no guide can hold what is read.
  template <typename Archive>
  void transfer(Archive& archive);

 private:
  struct Node {
    std::uint32_t child = 0;  // the left one; the right one follows; 0: a cell
    std::uint8_t axis = 0;
    float split = 0;        // place of the plane, in numbers
    float left_share = 0;   // probability of the left child
    float probability = 0;  // of the whole node
    EmissionNumbers low{}, high{};

    template <typename Archive>
    void transfer(Archive& archive);
  };
  class Learner;
  void check() const;

  std::vector<Node> nodes_;
  double gain_ = 1;
};

}  // namespace glowworm
