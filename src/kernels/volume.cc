#include "kernels/volume.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/volume.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "kernels/volume-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

void sum_volume_tile(const VolumeTree& tree, SegmentTile& tile, VolumeScratch& scratch, VolumeCounts& counts) {
  if (tree.beams)
    TileSummer<BeamBlock>(tree.beams, tree, tile, scratch, counts).run();
  else
    TileSummer<VolumePhotonBlock>(tree.photons, tree, tile, scratch, counts).run();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(sum_volume_tile);
}  // namespace

void sum_volume(const VolumeTree& tree, SegmentTile& tile, VolumeScratch& scratch, VolumeCounts& counts) {
  HWY_DYNAMIC_DISPATCH(sum_volume_tile)(tree, tile, scratch, counts);
}

}  // namespace glowworm
#endif  // HWY_ONCE
