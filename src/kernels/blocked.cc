#include "kernels/blocked.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/blocked.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

#include "kernels/blocked_glossy-inl.h"

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

void sum_run(const BlockTree& tree, const QueryRun& run, BlockedScratch& scratch, BlockedCounts& counts) {
  with_kernel_shape(tree.kernel, [&](auto shape) HWY_ATTR {
    RunSummer<Group<decltype(shape)::value>>(tree, run, scratch, counts).run();
  });
}

void sum_glossy_run(const BlockTree& tree, const QueryRun& run, const GlossyPoints& glossy, BlockedScratch& scratch,
                    BlockedCounts& counts) {
  with_glossy_model(glossy.model, [&](auto model) HWY_ATTR {
    RunSummer<GlossyGroup<decltype(model)::value>>(tree, run, scratch, counts, &glossy).run();
  });
}

void find_photons(const BlockTree& tree, const float position[3], const float normal[3], BlockedScratch& scratch,
                  std::vector<BlockedPhoton>& found, BlockedCounts& counts) {
  with_kernel_shape(tree.kernel, [&](auto shape) HWY_ATTR {
    find<decltype(shape)::value>(tree, position, normal, scratch, found, counts);
  });
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
                  std::vector<BlockedPhoton>& found, BlockedCounts& counts) {
  HWY_DYNAMIC_DISPATCH(find_photons)(tree, position, normal, scratch, found, counts);
}

}  // namespace glowworm
#endif  // HWY_ONCE
