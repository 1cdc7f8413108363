// The state of an interactive session: plain data, which a window, a script or a test changes.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/vec.h"
#include "scene/camera.h"
#include "scene/light_rig.h"
#include "settings/settings.h"
#include "trace/tracer.h"

namespace glowworm {

/// Meaning of a view's pixels.
enum class ViewMode : std::uint8_t {
  gather,   ///< light by final gathering
  photons,  ///< the photon map shown directly, without gathering
  albedo,   ///< of the first surface
  normal,   ///< shading normal of the first surface, (n + 1) / 2
  density,  ///< photons per m^2, false colour
  radius,   ///< mean radius of the photons that count, metres, false colour
  cost      ///< shader operations for each pixel, false colour
};

/// Which part of the light the modes gather and photons show.
enum class LightPart : std::uint8_t { all, direct, indirect, caustic };

/// A view of a scene. Equal states give the same picture, which is refined further.
struct ViewState {
  Camera camera;
  float pivot_distance = 1;       ///< from the camera along its axis to the point that it orbits, metres
  std::vector<LightEdit> lights;  ///< one for each of LightRig::lights()
  double seconds = 0;             ///< moment of the scene's animation
  ViewMode mode = ViewMode::gather;
  LightPart part = LightPart::all;
  std::uint32_t gather = 16;    ///< final gather rays of each camera sample
  std::string engine = "auto";  ///< density engine; auto: kAutomaticEngine
  KernelShape kernel = KernelShape::epanechnikov;
  std::uint64_t photons = 500'000;  ///< in the global map
  std::uint32_t nearest = 50;       ///< k: target number of photons in an estimate
  int width = 512, height = 512;    ///< pixels
  bool secondary_gather = true;     ///< sharper corners, slower
  bool filter = true;               ///< filter gathered light as renders do; frames in motion by filter_preview()
  bool reuse = true;                ///< reuse earlier frames where they show the same surface
};

/// The view as settings of a render, without camera, lights and effort.
RenderSettings render_settings(const ViewState& state);

/// ViewState::pivot_distance of a new view: to the surface in the middle of the picture, or the scene's radius.
float pivot_distance(const Tracer& tracer, const Camera& camera);

/// Whether a mode shows light, as opposed to surfaces and counts.
bool shows_light(ViewMode mode);
/// Whether a mode needs photons.
bool needs_photons(ViewMode mode);
/// Whether a mode needs PhotonMapSettings::diagnosed.
bool needs_diagnosis(ViewMode mode);

/// Whether two states show the same light of the same size, but for the camera, the lights, filter and reuse.
bool same_picture(const ViewState& a, const ViewState& b);

/// Names for menus, scripts and the command line; the index is the value of the enumeration.
const std::vector<std::string>& view_mode_names();
const std::vector<std::string>& light_part_names();

}  // namespace glowworm
