// Scenes: read from files, built in, or made from your arrays.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "glowworm/error.h"
#include "glowworm/types.h"

namespace glowworm::api {

/// A camera.
struct Camera {
  Vec3 eye{0, 0, 5}, target{0, 0, 0}, up{0, 1, 0};  ///< metres
  float field_of_view = 40;                         ///< degrees, along the shorter side of the picture
  /// Greater than 0: an orthographic camera; metres that the shorter side of the picture shows.
  float orthographic_size = 0;
  float lens_radius = 0;     ///< metres; 0: a pinhole
  float focal_distance = 0;  ///< metres from the eye at which a lens is sharp; 0: at the target
  std::string name = "camera";
  enum class Projection : std::uint8_t {
    perspective,    ///< field_of_view below 180
    fisheye,        ///< equidistant: distances in the picture are angles; field_of_view up to 360
    hemispherical,  ///< distances in the picture are sines; field_of_view up to 180
    panorama,       ///< equirectangular: longitude and latitude; field_of_view up to 180
  };
  Projection projection = Projection::perspective;
};

/// Changes of a scene while it is read. The defaults change nothing.
struct LoadOptions {
  bool z_up = false;         ///< the file's z axis points up, as always in .rad, instead of y; the scene has y up
  float scale = 1;           ///< metres per unit of the file; lights keep their power
  std::string environment;   ///< in place of the scene's own: an image file, or a radiance "R,G,B", W sr^-1 m^-2
  std::string sky;           ///< in place of the environment, as the option --sky
  bool studio_light = true;  ///< light a scene without lights as in a studio; false: it stays black
  /// Further options of the command line's heading "Scene", by name without dashes, with their text: {"fov", "40"}.
  /// They overrule the members above.
  std::vector<std::pair<std::string, std::string>> more;
};
/// Names for LoadOptions::more.
std::vector<std::string> load_option_names();

/// Difference of a light from the scene's. Applied about the light's own centre.
struct LightEdit {
  std::string light;  ///< one of Scene::lights()
  bool on = true;
  float scale = 1;     ///< factor on its radiance or intensity, 0 or more
  Vec3 move{0, 0, 0};  ///< metres; no effect on lights infinitely far away
  Vec3 turn{0, 0, 0};  ///< rotation vector: axis times radians
};

/// An immutable scene. Copies share it. Several threads may use it.
class Scene {
 public:
  /// Reads a file by its extension (.pbrt, .gltf, .glb, .obj, ...), or makes a built-in scene from "builtin:NAME".
  /// Throws Error with file, place and remedy, and for options that make no sense.
  static Scene load(const std::string& path, const LoadOptions& options = {});

  const std::string& name() const;
  std::size_t triangle_count() const;
  /// Vertices of all triangles in world space, metres. The arrays live as long as the scene or a copy of it.
  std::span<const Vec3> positions() const;
  /// Indices into positions().
  std::span<const Triangle> triangles() const;
  /// Index of the material of each triangle.
  std::span<const std::uint32_t> triangle_materials() const;
  /// Names of the materials.
  std::vector<std::string> materials() const;
  /// Names of the cameras. There is at least one.
  std::vector<std::string> cameras() const;
  /// Names of the lights, each once: of area lights, of lights without extent, of the environment.
  std::vector<std::string> lights() const;
  /// The same scene with changed lights. It shares all else unless area lights move. Throws Error for an unknown light
  /// and numbers that are not finite.
  Scene with_lights(std::span<const LightEdit> edits) const;
  /// The same scene with one more camera. It shares all else. Throws Error for a camera that shows nothing, or whose
  /// name is taken.
  Scene with_camera(const Camera& camera) const;
  /// The same with several more.
  Scene with_cameras(std::span<const Camera> cameras) const;
  /// Features of the file that are not supported or had to be guessed, one a line.
  const std::vector<std::string>& notes() const;

  struct Implementation;  ///< private
  /// Private.
  explicit Scene(std::shared_ptr<const Implementation> implementation);
  const Implementation& implementation() const { return *implementation_; }

 private:
  std::shared_ptr<const Implementation> implementation_;
};

/// Names of the built-in scenes, for Scene::load("builtin:NAME").
std::vector<std::string> builtin_scenes();

/// What fills space between surfaces: it absorbs, scatters and emits light.
struct Medium {
  Rgb absorption{0, 0, 0};  ///< coefficient sigma_a, m^-1; a factor on the grid's values
  Rgb scattering{0, 0, 0};  ///< coefficient sigma_s, m^-1; a factor on the grid's values
  float mean_cosine = 0;    ///< g of Henyey and Greenstein's phase function, in (-1, 1)
  Rgb emission{0, 0, 0};    ///< W sr^-1 m^-2: it emits this times sigma_a; a factor on the grid's values
  /// Two opposite corners of the box that the medium fills, metres; with none, it fills all space that it is in.
  std::optional<std::pair<Vec3, Vec3>> box;
  /// Number of cells of a grid across the box, along x, y and z; 0: no grid. The arrays below hold one value a cell, x
  /// fastest, then y; an empty one counts as 1.
  std::array<int, 3> cells{0, 0, 0};
  std::span<const float> density_grid;  ///< factor on both coefficients
  std::span<const Rgb> absorption_grid, scattering_grid, emission_grid;
  std::string name = "medium";
};
/// In place of the index of a medium.
inline constexpr std::uint32_t kVacuum = 0xffffffff;

/// The material of a surface.
struct Material {
  enum class Kind : std::uint8_t {
    diffuse,    ///< Lambertian reflection of `color`
    metal,      ///< reflection of `color` at normal incidence, with `roughness`
    glass,      ///< refraction by `ior`, tinted by `color`, with `roughness`
    glossy,     ///< glTF's metallic-roughness: base `color`, `metallic`, `roughness`
    pane,       ///< a pane of glass of `ior` without thickness, tinted by `color`: transmits and mirrors, does not bend
    plastic,    ///< Lambertian reflection of `color` under a clear coat of `ior` with `roughness`
    interface,  ///< parts two media; light passes it straight, unchanged
  };
  Kind kind = Kind::diffuse;
  Rgb color{0.5f, 0.5f, 0.5f};  ///< each in [0, 1]
  /// Returned by SceneBuilder::add_texture(): a factor on `color`, looked up at Mesh::uvs.
  std::optional<std::uint32_t> color_texture;
  float roughness = 0;  ///< GGX alpha in [0, 1]; 0 is smooth. glossy: glTF's roughness, the square root of alpha
  float metallic = 0;   ///< in [0, 1]
  float ior = 1.5f;     ///< index of refraction inside over outside
  std::string name;
  /// Media on the two sides, returned by SceneBuilder::add_medium(), or kVacuum. Normals point outside. Where neither
  /// is given, the medium around fills both, glass, too; where only inside is, the ambient medium is outside.
  std::optional<std::uint32_t> inside, outside;
  /// Cameras do not see the surface, as if it were not there; mirrors, glass and all other light meet it.
  bool unseen = false;
};

/// Triangles. The arrays are copied.
struct Mesh {
  std::span<const Vec3> positions;      ///< n vertices, metres
  std::span<const Triangle> triangles;  ///< m, indices into positions
  std::span<const Vec3> normals;        ///< n, unit, for smooth shading; or empty
  std::span<const Vec2> uvs;            ///< n, texture coordinates; or empty: all (0, 0)
  std::uint32_t material = 0;           ///< returned by SceneBuilder::add_material()
  Rgb radiance;                         ///< W sr^-1 m^-2, emitted by the front; black: no light
  bool two_sided = false;               ///< the back emits, too
  std::string name = "mesh";
};

/// A place of a mesh: the rows of the matrix that maps a point (x, y, z, 1) of the mesh to the world, metres.
using Placement = std::array<std::array<float, 4>, 3>;

/// A light that shines from a point into a cone.
struct SpotLight {
  Vec3 position{0, 0, 0};    ///< metres
  Vec3 direction{0, 0, -1};  ///< of travel
  Rgb intensity{1, 1, 1};    ///< W sr^-1 along the axis
  float inner_angle = 30;    ///< degrees from the axis up to which the intensity is full
  float outer_angle = 40;    ///< degrees from the axis at which it is 0
};

/// Makes a scene step by step.
class SceneBuilder {
 public:
  explicit SceneBuilder(const std::string& name = "scene");
  ~SceneBuilder();
  SceneBuilder(SceneBuilder&&) noexcept;
  SceneBuilder& operator=(SceneBuilder&&) noexcept;

  /// Returns the index for Material::color_texture. The image is filtered bilinearly and repeats; (u, v) = (0, 0) is
  /// its lower left corner, (1, 1) its upper right one.
  /// @param pixels width * height, row by row from the top, linear, each channel in [0, 1]. Throws Error if there are
  /// more or fewer, and for others
  std::uint32_t add_texture(int width, int height, std::span<const Rgb> pixels);
  /// Returns the index for Material::inside and outside. Throws Error for numbers out of range, and arrays of another
  /// length than the grid.
  std::uint32_t add_medium(const Medium& medium);
  /// The medium of all space that no surface encloses by name. Without a box, it lets no light from infinity through.
  void set_ambient_medium(std::uint32_t medium);
  /// Returns the index for Mesh::material. Throws Error for a value out of range, an unknown texture or
  /// medium.
  std::uint32_t add_material(const Material& material);
  /// Throws Error for arrays of different lengths, an index out of range, an unknown material, or a vertex that is not
  /// finite. Drops triangles without area.
  void add_mesh(const Mesh& mesh);
  /// Adds a mesh at each of some places, as objects that have its name and a number. Instances cost little memory
  /// unless they emit light. A place that mirrors leaves the outside outside. Throws Error as add_mesh() does, and for
  /// a place that is not finite.
  void add_instances(const Mesh& mesh, std::span<const Placement> places);
  /// @param intensity W sr^-1
  void add_point_light(Vec3 position, Rgb intensity);
  /// @param direction direction of travel; @param irradiance W m^-2, on a surface that faces the light
  void add_directional_light(Vec3 direction, Rgb irradiance);
  void add_spot_light(const SpotLight& light);
  /// The same radiance from all directions, W sr^-1 m^-2.
  void set_environment(Rgb radiance);
  /// Radiance from an image of all directions, row by row from the top (+y); the middle column looks along -z.
  /// @param pixels width * height, W sr^-1 m^-2. Throws Error if there are more or fewer
  void set_environment(int width, int height, std::span<const Rgb> pixels);
  void add_camera(const Camera& camera);

  /// Returns the scene. Adds a camera that frames it if there is none, and a sky if there is no light. Throws Error if
  /// there is no triangle. The builder is empty afterwards.
  Scene build();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace glowworm::api
