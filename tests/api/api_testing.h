// What tests of the public interface share.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "glowworm/glowworm.h"

namespace gw = glowworm::api;

/// A white square of side 2 at z = 0, facing +z.
inline gw::Mesh square(std::uint32_t material) {
  static const std::vector<gw::Vec3> positions{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  static const std::vector<gw::Triangle> triangles{{0, 1, 2}, {0, 2, 3}};
  gw::Mesh mesh;
  mesh.positions = positions;
  mesh.triangles = triangles;
  mesh.material = material;
  return mesh;
}

inline gw::Scene lit_square() {
  gw::SceneBuilder builder("square");
  gw::Material paint;
  paint.color = {0.5f, 0.25f, 1.0f};
  builder.add_mesh(square(builder.add_material(paint)));
  builder.set_environment({1, 1, 1});
  gw::Camera camera;
  camera.eye = {0, 0, 2};
  camera.field_of_view = 20;
  builder.add_camera(camera);
  return builder.build();
}

inline std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const gw::Error& error) {
    return error.what();
  }
  return "no error";
}
