#include "trace/instruction_set.h"

#include <embree3/rtcore.h>
#include <fmt/format.h>

namespace glowworm {

std::string ray_instruction_set() {
  RTCDevice device = rtcNewDevice(nullptr);
  if (!device) return "none";
  const auto has = [&](RTCDeviceProperty property) { return rtcGetDeviceProperty(device, property) != 0; };
  const auto version = [&](RTCDeviceProperty property) { return rtcGetDeviceProperty(device, property); };
  // Embree reports only the width of its vectors.
  const char* name = has(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) ? "avx512" : "sse";
#if defined(__x86_64__)
  if (!has(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) && has(RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED))
    name = __builtin_cpu_supports("avx2") ? "avx2" : "avx";
#endif
  const std::string text =
      fmt::format("Embree {}.{}.{}, {}", version(RTC_DEVICE_PROPERTY_VERSION_MAJOR),
                  version(RTC_DEVICE_PROPERTY_VERSION_MINOR), version(RTC_DEVICE_PROPERTY_VERSION_PATCH), name);
  rtcReleaseDevice(device);
  return text;
}

}  // namespace glowworm
