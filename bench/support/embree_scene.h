// A scene in Embree itself, with settings of the caller's: what the benchmarks of rays compare.
#pragma once
#include <embree3/rtcore.h>

#include <vector>

#include "scene/scene.h"
#include "trace/tracer.h"

namespace glowworm::bench {

/// How rays go to Embree.
enum class Way { single, packet4, packet8, packet16, stream };
inline constexpr Way kWays[] = {Way::single, Way::packet4, Way::packet8, Way::packet16, Way::stream};
/// "packets of 8"
const char* name(Way way);

/// A scene in Embree, with settings of our choice.
class EmbreeScene {
 public:
  /// @param config of the device, as rtcNewDevice() takes it; null: as Embree is by itself
  /// @param as_quads pairs of triangles that share an edge become quadrilaterals
  EmbreeScene(const Scene& scene, const char* config, RTCBuildQuality quality, RTCSceneFlags flags,
              bool as_quads = false);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  /// Whether Embree took the settings.
  bool usable() const { return rtcGetDeviceError(device_) == RTC_ERROR_NONE; }
  /// The closest hits of the rays, in their order; `hits` is as long as they. Triangles are numbers of Embree's.
  void trace(const std::vector<Ray>& rays, std::vector<Hit>& hits, Way way, bool coherent) const;

 private:
  RTCDevice device_;
  RTCScene world_;
};

}  // namespace glowworm::bench
