// The scene: immutable tables for all rooms.
#pragma once
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "core/box.h"
#include "core/distribution.h"
#include "core/transform_double.h"
#include "scene/camera.h"
#include "scene/diffuse_triangles.h"
#include "scene/geometry.h"
#include "scene/light.h"
#include "scene/light_selector.h"
#include "scene/material.h"
#include "scene/medium.h"
#include "scene/medium_emission.h"
#include "scene/texture.h"

namespace glowworm {

/// Picture settings of a file; 0 or empty if it has none.
struct FilmRequest {
  int width = 0, height = 0;
  float crop[4] = {0, 1, 0, 1};  ///< x0, x1, y0, y1 as fractions of the whole picture
  float scale = 1;               ///< factor on radiance (a sensor's imaging ratio)
  std::string file;              ///< name of the picture's file, without folders
  std::uint32_t samples = 0;     ///< samples of each pixel that its path tracer takes
};

/// A vector of axes with z up in axes with y up, and back; x stays.
template <typename Vector>
Vector y_up_from_z_up(Vector v) {
  return {v.x, v.z, -v.y};
}
template <typename Vector>
Vector z_up_from_y_up(Vector v) {
  return {v.x, -v.z, v.y};
}

/// The description that importers and built-in scenes fill in.
struct SceneDescription {
  std::string name;
  Geometry geometry;
  std::vector<Material> materials;
  std::vector<Medium> media;
  /// Index of the medium of space that no surface encloses by name; kNone: vacuum.
  std::uint32_t ambient_medium = kNone;
  std::vector<TextureNode> textures;
  std::vector<Emission> emissions;
  std::vector<Light> lights;
  std::optional<Environment> environment;
  std::vector<Camera> cameras;
  FilmRequest film;
  /// The z axis of the file points up. The description has y up; the user writes coordinates with z up.
  bool z_up = false;
  /// The point of the file's coordinates, with y up, that all positions are relative to, metres: the reader subtracted
  /// it in double precision (core/coordinate_origin.h).
  Vec3 origin{0, 0, 0};
  /// Positions have all digits of the file, however far the origin. If false, the file rounded them.
  bool origin_is_exact = false;
  /// Emission may be decoration for a viewer that adds its own light, unless the scene is a room.
  bool emission_may_be_decoration = false;
  bool studio_light = true;  ///< where the scene has no light
  /// Features of the file that are not supported or were guessed; one line each.
  std::vector<std::string> notes;
};

/// The powers of light sources, and how one is chosen by them.
struct LightPowers {
  std::vector<RGB> of_sources;  ///< W
  Distribution1D choice;        ///< Scene::light_power()

  /// Whether other powers are nearly the same, and black where these are.
  bool are_as(const std::vector<RGB>& others) const;
};

/// Changes that a user makes in a viewer. Everything else comes from the original scene. Positions are relative
/// to Scene::origin().
struct SceneEdit {
  std::vector<Emission> emissions;  ///< as many as the scene has
  std::vector<Light> lights;        ///< as many as the scene has, or more
  std::optional<Environment> environment;
  /// The same triangles with other positions, or without instances; null: the scene's own.
  std::shared_ptr<const Geometry> geometry;
  std::vector<Camera> more_cameras;  ///< in addition to the scene's own
  std::string name;                  ///< empty: the scene's own
  /// Of another moment of the scene: if the power of each light source is nearly the same there, light_power() is that
  /// moment's, so that photons of lamps that did not move stay as they are.
  std::optional<LightPowers> lit_as = {};
};

struct Sphere {
  Vec3 center;
  float radius = 0;  ///< metres
};

/// The box that a medium around a scene fills: its surfaces, cameras and lamps, and a margin.
Box3 box_of_air(const Box3& surfaces, const std::vector<Camera>& cameras, const std::vector<Light>& lights);

/// An immutable scene with the tables derived from its description. All its positions are relative to origin().
class Scene {
 public:
  /// Checks all indices, moves a distant scene to the origin, adds a camera that frames the scene if it has none, and
  /// the studio light if it has no light, unless the description refuses that. Where light comes from afar, which no
  /// endless medium would let through, the ambient medium fills box_of_air(). Throws Error for a scene without
  /// triangles.
  explicit Scene(SceneDescription description);
  /// The same scene with other lights; shares the geometry. Adds no sky if nothing emits: then light_power() has a
  /// total of 0, and no light may be sampled. Throws Error if the edit does not fit this scene.
  Scene(const Scene& scene, SceneEdit edit);

  const std::string& name() const { return d_.name; }
  const Geometry& geometry() const { return *geometry_; }
  std::shared_ptr<const Geometry> shared_geometry() const { return geometry_; }
  /// @param room holds the triangle if it is of an instance
  const DiffuseTriangle& diffuse_triangle(std::uint32_t triangle, DiffuseTriangleRoom& room) const {
    if (triangle < stored_triangles_) return (*diffuse_triangles_)[triangle];
    return *new (&room) DiffuseTriangle(make_diffuse_triangle(*geometry_, d_.materials, triangle));
  }
  DiffuseTriangle diffuse_triangle(std::uint32_t triangle) const {
    DiffuseTriangleRoom room;
    return diffuse_triangle(triangle, room);
  }
  /// Whether diffuse_triangle() is stored, and `triangle` is not kNone.
  bool stores(std::uint32_t triangle) const { return triangle < stored_triangles_; }
  /// Whether a triangle repeats an earlier one (repeated_triangles()). No ray hits it, and it emits no light.
  bool repeats(std::uint32_t triangle) const { return triangle < repeated_->size() && (*repeated_)[triangle]; }
  const std::vector<Material>& materials() const { return d_.materials; }
  /// Empty: there is vacuum everywhere.
  const std::vector<Medium>& media() const { return d_.media; }
  /// Index of the medium of space that no surface encloses by name, or kNone.
  std::uint32_t ambient_medium() const { return d_.ambient_medium; }
  const std::vector<TextureNode>& textures() const { return d_.textures; }
  const std::vector<Emission>& emissions() const { return d_.emissions; }
  const std::vector<Light>& lights() const { return d_.lights; }
  const std::optional<Environment>& environment() const { return d_.environment; }
  const std::vector<Camera>& cameras() const { return d_.cameras; }
  const FilmRequest& film() const { return d_.film; }
  const std::vector<std::string>& notes() const { return d_.notes; }

  /// The camera of that name; an empty name is the first. Throws Error, which lists the names, for another name.
  const Camera& camera(const std::string& name) const;

  /// The point of the user's coordinates, with y up, that is (0,0,0) in the scene's tables, metres. Each coordinate is
  /// 0 unless the scene lies so far away along it that rounding of intermediate positions would show.
  Vec3 origin() const { return origin_; }
  /// A position (metres) of the user's coordinates, with y up, in those of the tables, and back. Vertices return
  /// unchanged.
  Vec3 inside(Vec3 place) const { return place - origin_; }
  Vec3 inside(Vec3d place) const { return narrow(place - Vec3d(origin_)); }
  Vec3d outside(Vec3 place) const { return Vec3d(place) + Vec3d(origin_); }
  /// A direction in the axes of the user's file (SceneDescription::z_up) in those of the tables, and back.
  template <typename Vector>
  Vector from_file_axes(Vector d) const {
    return d_.z_up ? y_up_from_z_up(d) : d;
  }
  template <typename Vector>
  Vector to_file_axes(Vector d) const {
    return d_.z_up ? z_up_from_y_up(d) : d;
  }
  bool z_up() const { return d_.z_up; }

  /// Whether any vertex has a shading normal.
  bool smooth() const { return smooth_; }
  Box3 bounds() const { return bounds_; }  ///< of the surfaces, metres
  Vec3 center() const { return bounds_.center(); }
  /// Radius of a sphere around center() that contains the surfaces, metres.
  float radius() const { return radius_; }
  /// A sphere that contains all that light from afar may meet: the surfaces, and an ambient medium with bounds.
  const Sphere& lit_sphere() const { return lit_sphere_; }
  /// Emissive triangles, in order; without those whose emission texture is black all over them.
  const std::vector<std::uint32_t>& emissive_triangles() const { return emissive_triangles_; }
  /// Index of a triangle in emissive_triangles(), or kNone.
  std::uint32_t emissive_index(std::uint32_t triangle) const {
    return triangle < emissive_index_.size() ? emissive_index_[triangle] : kNone;
  }
  /// The media that emit.
  const std::vector<MediumEmission>& emissive_media() const { return emissive_media_; }
  /// Chooses a light source in proportion to its power: first the emissive triangles, then lights(), then
  /// emissive_media(), then the environment, of which all parts count as one here. Its total is the power of all light,
  /// in W (luminance).
  const Distribution1D& light_power() const { return light_power_; }
  /// Power of each light source in W, counted as in light_power(); an estimate for textured emission, and for media,
  /// which are taken to fill their boxes. The last entry may hold all parts of the environment.
  const std::vector<RGB>& source_powers() const { return source_powers_; }
  LightPowers light_powers() const { return {source_powers_, light_power_}; }
  /// Number of light sources, with each part of the environment.
  std::size_t light_source_count() const {
    const std::size_t of_environment = !d_.environment ? 0 : d_.environment->parts ? d_.environment->parts->count : 1;
    return first_environment_source() + of_environment;
  }
  /// The first sources of those kinds, counted as in light_power(): of emissive_media(), and of the environment.
  std::uint32_t first_medium_source() const {
    return static_cast<std::uint32_t>(emissive_triangles_.size() + d_.lights.size());
  }
  std::uint32_t first_environment_source() const {
    return first_medium_source() + static_cast<std::uint32_t>(emissive_media_.size());
  }
  /// The source of a medium's own light, or kNone. @param medium index into media()
  std::uint32_t source_of_medium(std::uint32_t medium) const;
  /// The medium whose light a source is, or null. @param source counted as in light_power()
  const MediumEmission* medium_of_source(std::uint32_t source) const {
    const std::uint32_t first = first_medium_source();
    return source >= first && source < first_environment_source() ? &emissive_media_[source - first] : nullptr;
  }
  /// Chooses a light source for a point.
  const LightSelector& light_selector() const { return light_selector_; }
  const Distribution2D& environment_distribution() const { return environment_distribution_; }
  /// Whether a material has an alpha that rays must test.
  bool has_alpha(std::uint32_t material) const { return material_has_alpha_[material]; }
  /// Whether a material may pass light on in a straight line, as a pane of glass does: shadow rays pass through it
  /// (straight_transmittance()).
  bool is_pane(std::uint32_t material) const { return material_is_pane_[material]; }
  /// Whether paths must look for media and interfaces on their way.
  bool crosses_media() const { return crosses_media_; }

 private:
  /// Gives the ambient medium bounds where it needs them. Returns whether it has changed.
  bool bound_ambient_medium();
  void measure();
  void find_repeated();
  void find_light_sources();

  SceneDescription d_;  // without its geometry, which scenes in other light share
  std::shared_ptr<const Geometry> geometry_;
  std::shared_ptr<const LargeVector<DiffuseTriangle>> diffuse_triangles_;  // shared like the geometry
  std::uint32_t stored_triangles_ = 0;
  std::shared_ptr<const std::vector<bool>> repeated_;  // empty: none is
  Vec3 origin_;
  bool smooth_ = false;
  Box3 bounds_;
  float radius_ = 0;
  Sphere lit_sphere_;
  std::vector<std::uint32_t> emissive_triangles_, emissive_index_;
  std::vector<MediumEmission> emissive_media_;
  std::vector<RGB> source_powers_;
  Distribution1D light_power_;
  LightSelector light_selector_;
  Distribution2D environment_distribution_;
  std::vector<bool> material_has_alpha_, material_is_pane_;
  bool crosses_media_ = false;
};

}  // namespace glowworm
