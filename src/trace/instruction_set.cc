#include "trace/instruction_set.h"

#include <embree3/rtcore.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/error.h"

namespace glowworm {

namespace {

struct Choice {
  std::string name, configuration;  // empty: the best
};

Choice& choice() {
  static Choice chosen;
  return chosen;
}

/// The best instruction set that Embree uses on this machine. Embree reports only the width of its vectors.
std::string best_set(RTCDevice device) {
  const auto has = [&](RTCDeviceProperty property) { return rtcGetDeviceProperty(device, property) != 0; };
  if (has(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return "avx512";
#if defined(__x86_64__)
  if (has(RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)) return __builtin_cpu_supports("avx2") ? "avx2" : "avx";
#endif
  return "sse";
}

}  // namespace

std::string ray_instruction_set() {
  RTCDevice device = rtcNewDevice(nullptr);
  if (!device) return "none";
  const auto version = [&](RTCDeviceProperty property) { return rtcGetDeviceProperty(device, property); };
  const std::string text = fmt::format(
      "Embree {}.{}.{}, {}", version(RTC_DEVICE_PROPERTY_VERSION_MAJOR), version(RTC_DEVICE_PROPERTY_VERSION_MINOR),
      version(RTC_DEVICE_PROPERTY_VERSION_PATCH), choice().name.empty() ? best_set(device) : choice().name);
  rtcReleaseDevice(device);
  return text;
}

std::vector<std::string> ray_instruction_sets() {
  RTCDevice device = rtcNewDevice(nullptr);
  if (!device) return {};
  const std::vector<std::string> all = {"avx512", "avx2", "avx", "sse"};
  const std::vector<std::string> here(std::find(all.begin(), all.end(), best_set(device)), all.end());
  rtcReleaseDevice(device);
  return here;
}

void set_ray_instruction_set(const std::string& name) {
  const std::vector<std::string> all = ray_instruction_sets();
  if (std::find(all.begin(), all.end(), name) == all.end())
    throw Error(fmt::format("rays cannot use the instruction set '{}' on this machine", name),
                fmt::format("Choose from: {}.", fmt::join(all, ", ")));
  choice() = name == all.front() ? Choice() : Choice{name, "isa=" + (name == "sse" ? "sse4.2" : name)};
}

const std::string& ray_device_configuration() { return choice().configuration; }

}  // namespace glowworm
