// The lights of a scene in an editor: listed, edited, and converted to the tables of an edited scene.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace glowworm {

enum class RigLightKind : std::uint8_t { area, point, spot, directional, environment };

/// Difference of a light from the scene file. Applied about the light's own centre.
struct LightEdit {
  bool on = true;
  float scale = 1;     ///< factor on its radiance or intensity
  Vec3 move{0, 0, 0};  ///< metres; no effect on lights infinitely far away
  Vec3 turn{0, 0, 0};  ///< rotation vector: axis times radians
  bool operator==(const LightEdit&) const = default;
};

/// A light that can be edited: an emission with all its triangles, a light without extent, or the environment.
struct RigLight {
  std::string name;  ///< unique in the list
  RigLightKind kind = RigLightKind::area;
  std::uint32_t index = 0;  ///< into the emissions or the lights
  Vec3 center{0, 0, 0};  ///< metres, as in the scene's tables, before any edit; unused for lights infinitely far away
  Vec3 direction{0, 0, 0};               ///< spot, directional: direction of travel, before any edit
  std::vector<std::uint32_t> triangles;  ///< of an area light

  bool has_place() const { return kind != RigLightKind::directional && kind != RigLightKind::environment; }
};

/// The lights of a scene. The scene must outlive this object and the edited scenes.
class LightRig {
 public:
  explicit LightRig(std::shared_ptr<const Scene> scene);

  const std::vector<RigLight>& lights() const { return lights_; }
  /// Index of the light with that name, or of that number in digits; throws Error, which lists the names, if there is
  /// none.
  std::size_t find(const std::string& name) const;
  /// Triangles that an edit may move.
  std::vector<std::uint32_t> movable_triangles() const;

  /// The edits of another rig's lights for the lights of the same names here. Other lights stay unedited: a light that
  /// is black at a moment of an animation is not in that scene's rig.
  std::vector<LightEdit> edits_of(const LightRig& other, const std::vector<LightEdit>& edits) const;
  /// Whether positions of triangles differ between the two.
  bool same_geometry(const std::vector<LightEdit>& a, const std::vector<LightEdit>& b) const;
  /// The scene with edited lights. @param edits one for each of lights(), or none: the scene unchanged
  std::shared_ptr<const Scene> edited(const std::vector<LightEdit>& edits) const;

 private:
  void check_count(const std::vector<LightEdit>& edits) const;
  std::shared_ptr<const Geometry> moved_geometry(const std::vector<LightEdit>& edits) const;

  std::shared_ptr<const Scene> scene_;
  std::vector<RigLight> lights_;
};

/// Position of a light in the sky, as for the sun: radians.
struct SunAngles {
  float azimuth = 0;    ///< about `up`, from -pi to pi
  float elevation = 0;  ///< above the horizon
};
/// @param direction direction of travel, unit; @param up unit
SunAngles sun_angles(Vec3 direction, Vec3 up);
/// Direction of travel of the light of such a sun.
Vec3 sun_direction(SunAngles angles, Vec3 up);
/// The rotation vector that turns one direction into another by the shortest way.
Vec3 rotation_between(Vec3 from, Vec3 to);

/// An edit as one word of a command line: "NAME,off", "NAME,scale=2,move=0:1:0,turn=0:0.5:0".
std::string light_edit_text(const std::string& name, const LightEdit& edit);
/// Parses such a word; throws Error with an example if it is not valid.
std::pair<std::string, LightEdit> parse_light_edit(const std::string& text);

}  // namespace glowworm
