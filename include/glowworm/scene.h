// Scenes: read from files, built in, or made from your arrays.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "glowworm/error.h"
#include "glowworm/types.h"

namespace glowworm::api {

/// An immutable scene. Copies share it. Several threads may use it.
class Scene {
 public:
  /// Reads a file by its extension (.pbrt, .gltf, .glb, .obj, ...), or makes a built-in scene from "builtin:NAME".
  /// Throws Error with file, place and remedy.
  static Scene load(const std::string& path);

  const std::string& name() const;
  std::size_t triangle_count() const;
  /// Names of the cameras. There is at least one.
  std::vector<std::string> cameras() const;
  /// Features of the file that are not supported or had to be guessed, one a line.
  const std::vector<std::string>& notes() const;

  struct Implementation;  ///< private
  /// Private.
  explicit Scene(std::shared_ptr<const Implementation> implementation);
  const Implementation& implementation() const { return *implementation_; }

 private:
  std::shared_ptr<const Implementation> implementation_;
};

/// The material of a surface.
struct Material {
  enum class Kind : std::uint8_t {
    diffuse,  ///< Lambertian reflection of `color`
    metal,    ///< reflection of `color` at normal incidence, with `roughness`
    glass,    ///< refraction by `ior`, tinted by `color`, with `roughness`
    glossy,   ///< glTF's metallic-roughness: base `color`, `metallic`, `roughness`
  };
  Kind kind = Kind::diffuse;
  Rgb color{0.5f, 0.5f, 0.5f};  ///< each in [0, 1]
  float roughness = 0;  ///< GGX alpha in [0, 1]; 0 is smooth. glossy: glTF's roughness, the square root of alpha
  float metallic = 0;   ///< in [0, 1]
  float ior = 1.5f;     ///< index of refraction inside over outside
  std::string name;
};

/// Triangles. The arrays are copied.
struct Mesh {
  std::span<const Vec3> positions;      ///< n vertices, metres
  std::span<const Triangle> triangles;  ///< m, indices into positions
  std::span<const Vec3> normals;        ///< n, unit, for smooth shading; or empty
  std::uint32_t material = 0;           ///< returned by SceneBuilder::add_material()
  Rgb radiance;                         ///< W sr^-1 m^-2, emitted by the front; black: no light
  std::string name = "mesh";
};

/// A perspective camera.
struct Camera {
  Vec3 eye{0, 0, 5}, target{0, 0, 0}, up{0, 1, 0};  ///< metres
  float field_of_view = 40;                         ///< degrees, along the shorter side of the picture
  std::string name = "camera";
};

/// Makes a scene step by step.
class SceneBuilder {
 public:
  explicit SceneBuilder(const std::string& name = "scene");
  ~SceneBuilder();
  SceneBuilder(SceneBuilder&&) noexcept;
  SceneBuilder& operator=(SceneBuilder&&) noexcept;

  /// Returns the index for MeshArrays::material. Throws Error for a value out of range.
  std::uint32_t add_material(const Material& material);
  /// Throws Error for arrays of different lengths, an index out of range, an unknown material, or a vertex that is not
  /// finite. Drops triangles without area.
  void add_mesh(const Mesh& mesh);
  /// @param intensity W sr^-1
  void add_point_light(Vec3 position, Rgb intensity);
  /// @param direction direction of travel; @param irradiance W m^-2, on a surface that faces the light
  void add_directional_light(Vec3 direction, Rgb irradiance);
  /// The same radiance from all directions, W sr^-1 m^-2.
  void set_environment(Rgb radiance);
  void add_camera(const Camera& camera);

  /// Returns the scene. Adds a camera that frames it if there is none, and a sky if there is no light. Throws Error if
  /// there is no triangle. The builder is empty afterwards.
  Scene build();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace glowworm::api
