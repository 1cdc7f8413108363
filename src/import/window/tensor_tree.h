// Scattering data as trees of variable resolution, as genBSDF and WINDOW write them ("TensorTree3", "TensorTree4").
#pragma once
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "bsdf/measured.h"

namespace glowworm {

/// A function of three or four coordinates in [0, 1), constant in cubes. A node is "{...}" of two to the power of the
/// rank further nodes, of which bit k of the number tells the half along coordinate k, or of a grid of values, the last
/// coordinate fastest (Radiance, src/common/bsdf_t.c).
class TensorTree {
 public:
  /// Throws Error, without a place, for a text that is no tree, and numbers that are not finite or above `most`; those
  /// below 0 become 0. @param rank 3 or 4
  TensorTree(std::string_view text, int rank, double most);

  int rank() const { return rank_; }
  using Position = std::array<double, 4>;
  float value(Position position) const;

 private:
  struct Node {
    int log2 = -1;            ///< of the grid's values along a side; below 0: branches
    std::uint32_t first = 0;  ///< into children_, or values_
  };
  std::uint32_t read(std::string_view& text, double most, int level);
  void read_grid(std::string_view& text, double most, Node& node);

  int rank_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> children_;
  std::vector<float> values_;
};

/// The means of a tree over patches of outgoing directions (rows) and of the ways of the light that comes (columns). Of
/// four coordinates, two are the way's and two the outgoing direction's projection on the surface, in the square that
/// the concentric map makes a disc; of three, the first is half of one minus the sine of the incidence, and the
/// direction is turned with the way.
std::vector<float> matrix_of_tree(const TensorTree& tree, const PatchBasis& basis);

}  // namespace glowworm
