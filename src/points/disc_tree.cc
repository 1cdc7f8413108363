#include "points/disc_tree.h"

namespace glowworm {

DiscTree::DiscTree(std::vector<Disc> discs) : discs_(std::move(discs)) {
  std::vector<Box3> boxes;
  for (const Disc& disc : discs_) {
    const Vec3 reach{disc.radius, disc.radius, disc.radius};
    boxes.push_back({disc.center - reach, disc.center + reach});
  }
  boxes_ = BoxTree(boxes);
}

}  // namespace glowworm
