#include "kernels/blocked.h"

#include <algorithm>
#include <bit>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/blocked.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "kernels/blocked_glossy-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

void sum_run(const BlockTree& tree, const QueryRun& run, BlockedScratch& scratch, BlockedCounts& counts) {
  switch (tree.profile) {
    case BlockedProfile::box:
      return RunSummer<Group<BlockedProfile::box>>(tree, run, scratch, counts).run();
    case BlockedProfile::cone:
      return RunSummer<Group<BlockedProfile::cone>>(tree, run, scratch, counts).run();
    case BlockedProfile::epanechnikov:
      return RunSummer<Group<BlockedProfile::epanechnikov>>(tree, run, scratch, counts).run();
    case BlockedProfile::gaussian:
      return RunSummer<Group<BlockedProfile::gaussian>>(tree, run, scratch, counts).run();
  }
}

void sum_glossy_run(const BlockTree& tree, const QueryRun& run, const GlossyPoints& glossy, BlockedScratch& scratch,
                    BlockedCounts& counts) {
  switch (glossy.model) {
    case GlossyModel::coated:
      return RunSummer<GlossyGroup<GlossyModel::coated>>(tree, run, scratch, counts, &glossy).run();
    case GlossyModel::conductor:
      return RunSummer<GlossyGroup<GlossyModel::conductor>>(tree, run, scratch, counts, &glossy).run();
    case GlossyModel::schlick:
      return RunSummer<GlossyGroup<GlossyModel::schlick>>(tree, run, scratch, counts, &glossy).run();
  }
}

void find_photons(const BlockTree& tree, const float position[3], const float normal[3], BlockedScratch& scratch,
                  std::vector<FoundPhoton>& found, BlockedCounts& counts) {
  switch (tree.profile) {
    case BlockedProfile::box:
      return find<BlockedProfile::box>(tree, position, normal, scratch, found, counts);
    case BlockedProfile::cone:
      return find<BlockedProfile::cone>(tree, position, normal, scratch, found, counts);
    case BlockedProfile::epanechnikov:
      return find<BlockedProfile::epanechnikov>(tree, position, normal, scratch, found, counts);
    case BlockedProfile::gaussian:
      return find<BlockedProfile::gaussian>(tree, position, normal, scratch, found, counts);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {
HWY_EXPORT(sum_run);
HWY_EXPORT(sum_glossy_run);
HWY_EXPORT(find_photons);
}  // namespace

void blocked_sum(const BlockTree& tree, const QueryRun& run, BlockedScratch& scratch, BlockedCounts& counts) {
  HWY_DYNAMIC_DISPATCH(sum_run)(tree, run, scratch, counts);
}

void blocked_sum_glossy(const BlockTree& tree, const QueryRun& run, const GlossyPoints& glossy, BlockedScratch& scratch,
                        BlockedCounts& counts) {
  HWY_DYNAMIC_DISPATCH(sum_glossy_run)(tree, run, glossy, scratch, counts);
}

void blocked_find(const BlockTree& tree, const float position[3], const float normal[3], BlockedScratch& scratch,
                  std::vector<FoundPhoton>& found, BlockedCounts& counts) {
  HWY_DYNAMIC_DISPATCH(find_photons)(tree, position, normal, scratch, found, counts);
}

}  // namespace glowworm
#endif  // HWY_ONCE
