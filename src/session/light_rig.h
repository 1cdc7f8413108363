// The lights of a scene as a person changes them: listed, edited, and made into the tables of a scene in that light.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "session/view_state.h"

namespace glowworm {

enum class RigLightKind : std::uint8_t { area, point, spot, directional, environment };

/// A light that can be edited: an emission with all its triangles, a light without extent, or the environment.
struct RigLight {
  std::string name;  ///< of its own in the list
  RigLightKind kind = RigLightKind::area;
  std::uint32_t index = 0;               ///< into the emissions or the lights
  Vec3 center{0, 0, 0};                  ///< metres, before any edit; unused for what is infinitely far
  Vec3 direction{0, 0, 0};               ///< spot, directional: the way the light travels, before any edit
  std::vector<std::uint32_t> triangles;  ///< of an area light

  bool has_place() const { return kind != RigLightKind::directional && kind != RigLightKind::environment; }
};

/// The lights of a scene. The scene must outlive what is made of it.
class LightRig {
 public:
  explicit LightRig(std::shared_ptr<const Scene> scene);

  const std::vector<RigLight>& lights() const { return lights_; }
  /// Place of the light of that name, or of that number written in digits; throws Error that lists the names.
  std::size_t find(const std::string& name) const;
  /// Triangles that an edit may move.
  std::vector<std::uint32_t> movable_triangles() const;

  /// Whether the two differ in where triangles are.
  bool same_geometry(const std::vector<LightEdit>& a, const std::vector<LightEdit>& b) const;
  /// The scene in the edited light. @param edits one for each of lights(), or none: the scene as it is
  std::shared_ptr<const Scene> edited(const std::vector<LightEdit>& edits) const;

 private:
  std::shared_ptr<const Geometry> moved_geometry(const std::vector<LightEdit>& edits) const;

  std::shared_ptr<const Scene> scene_;
  std::vector<RigLight> lights_;
};

/// Where a light's direction points from, as people say it of the sun: radians.
struct SunAngles {
  float azimuth = 0;    ///< about `up`, from -pi to pi
  float elevation = 0;  ///< above the horizon
};
/// @param direction the way the light travels, unit; @param up unit
SunAngles sun_angles(Vec3 direction, Vec3 up);
/// The direction the light of such a sun travels.
Vec3 sun_direction(SunAngles angles, Vec3 up);
/// The rotation vector that turns one direction into another by the shortest way.
Vec3 rotation_between(Vec3 from, Vec3 to);

/// An edit as one word of a command line: "NAME,off", "NAME,scale=2,move=0:1:0,turn=0:0.5:0".
std::string light_edit_text(const std::string& name, const LightEdit& edit);
/// Reads such a word; throws Error with an example where it is none.
std::pair<std::string, LightEdit> parse_light_edit(const std::string& text);

}  // namespace glowworm
