#include "kernels/simd.h"

#include <algorithm>
#include <cctype>

#include "core/error.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/simd.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace glowworm {
namespace HWY_NAMESPACE {
namespace {

std::int64_t target() { return HWY_TARGET; }
int lanes() { return static_cast<int>(hwy::HWY_NAMESPACE::Lanes(hwy::HWY_NAMESPACE::ScalableTag<float>())); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace glowworm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace glowworm {

namespace {

HWY_EXPORT(target);
HWY_EXPORT(lanes);

// Targets that differ only in instructions that no kernel uses share one name.
std::string target_name(std::int64_t target) {
  std::string name = hwy::TargetName(target);
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (name == "emu128") return "scalar";
  if (name == "avx3" || name == "avx3_dl") return "avx512";
  return name;
}

std::int64_t& disabled_targets() {
  static std::int64_t disabled = 0;
  return disabled;
}

void disable_targets(std::int64_t targets) {
  disabled_targets() = targets;
  hwy::DisableTargets(targets);
  // Makes the next call of a kernel detect the machine again.
  hwy::GetChosenTarget().DeInit();
}

// All targets of the machine, including those disabled by set_simd(), best first.
std::vector<std::int64_t> machine_targets() {
  const std::int64_t disabled = disabled_targets();
  hwy::DisableTargets(0);
  std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  hwy::DisableTargets(disabled);
  hwy::GetChosenTarget().DeInit();
  return targets;
}

}  // namespace

std::vector<std::string> simd_names() {
  std::vector<std::string> names;
  for (const std::int64_t target : machine_targets()) {
    const std::string name = target_name(target);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

void set_simd(const std::string& name) {
  std::int64_t disabled = 0;
  bool found = name == "auto";
  if (!found) {
    for (const std::int64_t target : machine_targets()) {
      if (target_name(target) == name) {
        found = true;
        break;
      }
      disabled |= target;
    }
  }
  if (!found) {
    std::string choices = "auto";
    for (const std::string& there : simd_names()) choices += ", " + there;
    throw Error("this machine has no instruction set \"" + name + "\"", "Choose one of: " + choices);
  }
  disable_targets(disabled);
}

std::string simd_name() { return target_name(HWY_DYNAMIC_DISPATCH(target)()); }

int simd_lanes() { return HWY_DYNAMIC_DISPATCH(lanes)(); }

}  // namespace glowworm
#endif  // HWY_ONCE
