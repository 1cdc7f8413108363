// Building meshes from simple solids, for the built-in scenes and tests.
#pragma once
#include <cstdint>
#include <functional>
#include <span>

#include "core/transform.h"
#include "scene/geometry.h"

namespace glowworm {

/// Adds shapes to a Geometry. Lengths are in metres; y points up. Every shape is placed by the current transform, which
/// must not mirror. Triangles are wound counter-clockwise seen from the side that the shape's description calls its
/// front or outside. Flat faces get zero normals (use the triangle's own), curved ones smooth normals.
class MeshBuilder {
 public:
  explicit MeshBuilder(Geometry& geometry) : geometry_(geometry) {}

  /// Sets the material, and optionally the emission, of shapes added from now on.
  void set_material(std::uint32_t material, std::uint32_t emission = kNone) {
    material_ = material;
    emission_ = emission;
  }
  /// Sets the transform of shapes added from now on.
  void set_transform(const Transform& transform) { transform_ = transform; }
  const Transform& transform() const { return transform_; }

  /// A flat triangle, and a flat quadrilateral split along a-c. The front is the side from which the vertices run
  /// counter-clockwise.
  void triangle(Vec3 a, Vec3 b, Vec3 c);
  void quad(Vec3 a, Vec3 b, Vec3 c, Vec3 d);
  /// A flat convex polygon, counter-clockwise seen from its front.
  void polygon(std::span<const Vec3> points);

  /// Faces of a box. Leave out those that another solid covers.
  enum Face : unsigned { kMinX = 1, kMaxX = 2, kMinY = 4, kMaxY = 8, kMinZ = 16, kMaxZ = 32, kAllFaces = 63 };
  /// A box seen from outside.
  void box(Vec3 min, Vec3 max, unsigned faces = kAllFaces);
  /// A box seen from inside: a closed room.
  void room(Vec3 min, Vec3 max);

  /// A sphere of 2 * segments * (rings - 1) triangles, seen from outside (or from inside). The vertices lie on it.
  void sphere(Vec3 center, float radius, int segments, int rings, bool inside = false);

  /// A point of the outline of a solid of revolution around the y axis.
  struct ProfilePoint {
    float radius;  ///< distance from the axis, >= 0; 0 only at the two ends
    float y;
    bool crease = false;  ///< an edge: normals are not smooth across it
  };
  /// A solid of revolution around the y axis through the transform's origin. The outside is to the right of the outline
  /// in the (radius, y) half-plane, so an outline that goes upwards faces away from the axis.
  /// @param arc_begin, arc_end part of the turn in radians, from +x towards -z; a whole turn closes without a seam
  void lathe(std::span<const ProfilePoint> profile, int segments, float arc_begin = 0, float arc_end = 2 * kPi);

  /// A smooth patch of nu x nv cells over the unit square. The front is the side of d/du x d/dv; normals come from
  /// central differences. The borders v = 0 and v = 1 may shrink to a point. Opposite borders join exactly only if
  /// `surface` gives the same bits there.
  void patch(const std::function<Vec3(float u, float v)>& surface, int nu, int nv);

  /// A quadrilateral with a quadrilateral hole: both counter-clockwise seen from the front, corner by corner.
  void frame(const Vec3 (&outer)[4], const Vec3 (&hole)[4]);

  /// A tube around a curve, seen from outside: circles of radius(t) around center(t) for t in [0, 1], across the
  /// curve's direction. A radius of 0 closes an end.
  /// @param reference unit, a direction that the curve never runs along; the normal of its plane, if it has one
  void tube(const std::function<Vec3(float t)>& center, const std::function<float(float t)>& radius, Vec3 reference,
            int around, int along);

  /// Adds an existing mesh with the current transform and material, without its emission.
  void instance(const Geometry& mesh);

  Geometry& geometry() { return geometry_; }

 private:
  std::uint32_t vertex(Vec3 position, Vec3 normal, Vec2 uv);
  void face(std::uint32_t a, std::uint32_t b, std::uint32_t c);

  Geometry& geometry_;
  Transform transform_;
  std::uint32_t material_ = 0;
  std::uint32_t emission_ = kNone;
};

/// A map that rotates by `angle` radians around the y axis (from +z towards +x) and then translates by `offset` metres.
Transform place(Vec3 offset, float angle = 0);

}  // namespace glowworm
