#include "import/pbrt/shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "import/mesh_tools.h"
#include "import/ply/reader.h"

namespace glowworm {

namespace {

constexpr std::size_t kMaxSubdivided = std::size_t{1} << 21;  // triangles of all subdivided meshes of a file

class ShapeBuilder {
 public:
  ShapeBuilder(PbrtContext& context, const PbrtParameters& parameters, bool emissive)
      : context_(context), parameters_(parameters), emissive_(emissive) {}

  std::optional<PbrtMesh> build(const std::string& kind) {
    if (kind == "trianglemesh") return triangle_mesh();
    if (kind == "plymesh") return ply_mesh();
    if (kind == "sphere") return sphere();
    if (kind == "disk") return disk();
    if (kind == "cylinder") return cylinder();
    if (kind == "bilinearmesh") return bilinear_mesh();
    if (kind == "loopsubdiv") return loop_subdivision();
    if (kind == "curve" || kind == "cone" || kind == "paraboloid" || kind == "hyperboloid" || kind == "heightfield" ||
        kind == "heightfield2" || kind == "nurbs") {
      parameters_.use_all();
      parameters_.note(fmt::format("not supported, left out: shape {}", in_quotes(kind)));
      return std::nullopt;
    }
    return fail(fmt::format("unknown shape {}", in_quotes(kind)),
                "Supported: trianglemesh, plymesh, bilinearmesh, loopsubdiv, sphere, disk and cylinder.");
  }

 private:
  std::optional<PbrtMesh> fail(const std::string& message, const std::string& remedy) {
    parameters_.error(message, remedy);
    return std::nullopt;
  }

  std::vector<Vec3> points(const char* name) {
    std::vector<Vec3> out;
    const auto numbers = parameters_.numbers(name, PbrtType::point3);
    out.reserve(numbers.size() / 3);
    for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
      out.push_back(
          {static_cast<float>(numbers[i]), static_cast<float>(numbers[i + 1]), static_cast<float>(numbers[i + 2])});
    }
    return out;
  }

  /// What `read` returns, which takes its positions from an origin. In a scene that lies far away, that is one near the
  /// shape. In others, shapes that share an edge must round its ends alike.
  template <typename Read>
  auto near_shape(Vec3& origin, const Read& read) {
    CoordinateOrigin near;
    const bool is_far = !(context_.origin.origin() == Vec3{0, 0, 0});
    auto out = is_far ? read_near(near, [&] { return read(near); }) : read(near);
    origin = is_far ? near.origin() : Vec3{0, 0, 0};
    if (near.is_rounded() && !(origin == Vec3{0, 0, 0})) context_.origin.set_rounded();
    return out;
  }

  /// The points "P". @param origin receives what they are relative to
  std::vector<Vec3> positions(Vec3& origin) {
    const auto numbers = parameters_.numbers("P", PbrtType::point3);
    return near_shape(origin, [&](CoordinateOrigin& near) {
      std::vector<Vec3> out;
      out.reserve(numbers.size() / 3);
      for (std::size_t i = 0; i + 2 < numbers.size(); i += 3)
        out.push_back(near.take({numbers[i], numbers[i + 1], numbers[i + 2]}));
      return out;
    });
  }

  std::vector<Vec2> texture_coordinates() {
    std::vector<Vec2> out;
    const char* name = parameters_.has("uv") ? "uv" : "st";
    const auto numbers = parameters_.numbers(name, PbrtType::point2);
    for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) {
      out.push_back({static_cast<float>(numbers[i]), static_cast<float>(numbers[i + 1])});
    }
    return out;
  }

  /// Checks and returns "indices": a multiple of `corners` of them, each below `vertices`. Empty after an error.
  std::optional<std::vector<std::uint32_t>> indices(std::size_t vertices, std::size_t corners) {
    std::vector<std::uint32_t> out;
    const PbrtParameter* given = parameters_.find("indices");
    if (!given) {
      if (vertices == corners) {
        for (std::uint32_t i = 0; i < corners; ++i) out.push_back(i);
        return out;
      }
      fail("a mesh without indices", "Give \"integer indices\".");
      return std::nullopt;
    }
    if (given->numbers.size() % corners != 0) {
      parameters_.error(*given, fmt::format("{} indices are not a multiple of {}", given->numbers.size(), corners),
                        "Add or remove indices.");
      return std::nullopt;
    }
    for (const double index : parameters_.numbers("indices", PbrtType::integer)) {
      if (!(index >= 0 && index < static_cast<double>(vertices)) || index != std::floor(index)) {
        parameters_.error(*given, fmt::format("index {} does not fit {} vertices", index, vertices),
                          "Indices count the points P from 0.");
        return std::nullopt;
      }
      out.push_back(static_cast<std::uint32_t>(index));
    }
    return out;
  }

  /// Checks that there is one value per vertex, or none. Reports an error otherwise.
  template <typename T>
  bool fits(const std::vector<T>& values, std::size_t vertices, const char* name) {
    if (values.empty() || values.size() == vertices) return true;
    fail(fmt::format("{} {} for {} points P", values.size(), name, vertices), "Give one per point, or none.");
    return false;
  }

  std::optional<PbrtMesh> triangle_mesh() {
    PbrtMesh mesh;
    Geometry& geometry = mesh.geometry;
    geometry.positions = positions(mesh.origin);
    geometry.normals = points("N");
    geometry.uvs = texture_coordinates();
    if (geometry.positions.empty()) return fail("a mesh without points", "Give \"point3 P\".");
    const std::size_t vertices = geometry.positions.size();
    if (!fits(geometry.normals, vertices, "normals N") || !fits(geometry.uvs, vertices, "uv")) return std::nullopt;
    const auto corners = indices(vertices, 3);
    if (!corners) return std::nullopt;
    for (std::size_t i = 0; i < corners->size(); i += 3) {
      geometry.triangles.push_back({(*corners)[i], (*corners)[i + 1], (*corners)[i + 2]});
    }
    one_patch_a_triangle(mesh);
    for (const char* ignored : {"S", "faceIndices"}) static_cast<void>(parameters_.find(ignored));
    return mesh;
  }

  static void one_patch_a_triangle(PbrtMesh& mesh) {
    mesh.patch.resize(mesh.geometry.triangles.size());
    for (std::size_t i = 0; i < mesh.patch.size(); ++i) mesh.patch[i] = static_cast<std::uint32_t>(i);
  }

  std::optional<PbrtMesh> ply_mesh() {
    const PbrtParameter* file = parameters_.find("filename");
    const std::string name = parameters_.string("filename", "");
    if (!file || name.empty()) return fail("a plymesh without a file name", "Give \"string filename\".");
    if (parameters_.has("displacement")) {
      parameters_.use_all();
      parameters_.note("not supported: displacement of a mesh");
    }
    PbrtMesh mesh;
    try {
      const std::string path = context_.resolve(name, parameters_.place());
      PlyMesh file_mesh =
          near_shape(mesh.origin, [&](CoordinateOrigin& near) { return read_ply(path, *context_.budget, near); });
      if (file_mesh.smaller_faces > 0) parameters_.note("left out: faces of fewer than three corners");
      mesh.patch = std::move(file_mesh.face_of);
      mesh.geometry = std::move(file_mesh);
    } catch (const Error& error) {
      parameters_.error(*file, fmt::format("cannot read {}: {}", in_quotes(name), error.what()), "");
      return std::nullopt;
    }
    if (context_.v3) one_patch_a_triangle(mesh);  // pbrt-v3 has no quads
    return mesh;
  }

  /// "phimax" in radians; empty after an error.
  std::optional<float> phi_max() {
    const float degrees = parameters_.real("phimax", 360);
    if (degrees > 0) return std::min(degrees, 360.0f) * (kPi / 180);
    fail("phimax must be positive", "Give it in degrees.");
    return std::nullopt;
  }

  std::optional<PbrtMesh> sphere() {
    const float radius = parameters_.real("radius", 1);
    const float a = parameters_.real("zmin", -radius), b = parameters_.real("zmax", radius);
    const auto phi = phi_max();
    if (!(radius > 0)) return fail("the radius of a sphere must be positive", "Give \"float radius\".");
    const float z_min = std::clamp(std::min(a, b), -radius, radius),
                z_max = std::clamp(std::max(a, b), -radius, radius);
    if (!(z_min < z_max)) return fail("zmin and zmax leave nothing of the sphere", "Give two heights within it.");
    if (!phi) return std::nullopt;
    return tessellate_sphere(radius, z_min, z_max, *phi, !emissive_);
  }

  std::optional<PbrtMesh> disk() {
    const float radius = parameters_.real("radius", 1), inner = parameters_.real("innerradius", 0);
    const float height = parameters_.real("height", 0);
    const auto phi = phi_max();
    if (!(radius > 0) || !(inner >= 0) || inner >= radius) {
      return fail("the radii of a disk enclose no area", "Give 0 <= innerradius < radius.");
    }
    if (!phi) return std::nullopt;
    return tessellate_disk(height, radius, inner, *phi);
  }

  std::optional<PbrtMesh> cylinder() {
    const float radius = parameters_.real("radius", 1);
    const float a = parameters_.real("zmin", -1), b = parameters_.real("zmax", 1);
    const auto phi = phi_max();
    if (!(radius > 0) || a == b) return fail("a cylinder without radius or height", "Give radius, zmin and zmax.");
    if (!phi) return std::nullopt;
    return tessellate_cylinder(radius, std::min(a, b), std::max(a, b), *phi);
  }

  std::optional<PbrtMesh> bilinear_mesh() {
    PbrtMesh mesh;
    const std::vector<Vec3> positions = this->positions(mesh.origin), normals = points("N");
    const std::vector<Vec2> uvs = texture_coordinates();
    if (positions.empty()) return fail("a mesh without points", "Give \"point3 P\".");
    if (!fits(normals, positions.size(), "normals N") || !fits(uvs, positions.size(), "uv")) return std::nullopt;
    const auto corners = indices(positions.size(), 4);
    if (!corners) return std::nullopt;
    if (parameters_.has("emissionfilename")) {
      parameters_.note("not supported: emissionfilename of a bilinearmesh");
    }
    Reservation held(*context_.budget, "meshes", 0);
    for (std::size_t i = 0; i < corners->size(); i += 4) {
      held.cover(mesh_bytes(mesh.geometry));
      Vec3 corner[4];
      std::vector<Vec3> patch_normals;
      std::vector<Vec2> patch_uvs;
      for (int c = 0; c < 4; ++c) {
        const std::uint32_t vertex = (*corners)[i + c];
        corner[c] = positions[vertex];
        if (!normals.empty()) patch_normals.push_back(normals[vertex]);
        if (!uvs.empty()) patch_uvs.push_back(uvs[vertex]);
      }
      append_bilinear_patch(corner, patch_normals, patch_uvs, mesh);
    }
    return mesh;
  }

  std::optional<PbrtMesh> loop_subdivision() {
    PbrtMesh mesh;
    Geometry control;
    control.positions = positions(mesh.origin);
    if (control.positions.empty()) return fail("a mesh without points", "Give \"point3 P\".");
    const auto corners = indices(control.positions.size(), 3);
    if (!corners) return std::nullopt;
    for (std::size_t i = 0; i < corners->size(); i += 3) {
      control.triangles.push_back({(*corners)[i], (*corners)[i + 1], (*corners)[i + 2]});
    }
    int levels = parameters_.integer(parameters_.has("nlevels") ? "nlevels" : "levels", 3);
    static_cast<void>(parameters_.find("scheme"));
    if (levels < 0) return fail(fmt::format("{} levels of subdivision", levels), "Give 0 or more; 3 is usual.");
    if (control.triangles.empty()) levels = 0;
    int most = 0;
    const std::size_t left = kMaxSubdivided - std::min(kMaxSubdivided, context_.subdivided_triangles);
    while (most < levels && (control.triangles.size() << (2 * (most + 1))) <= left) ++most;
    if (most < levels) {
      parameters_.note(fmt::format("subdivided {} times only, for size: loopsubdiv", most));
      levels = most;
    }
    // Memory of two meshes and the edges of one.
    constexpr std::uint64_t kBytesPerTriangle = 200;
    const Reservation held(*context_.budget, "subdivision",
                           (std::uint64_t{control.triangles.size()} << (2 * levels)) * kBytesPerTriangle);
    mesh.geometry = loop_subdivide(control, levels);
    context_.subdivided_triangles += mesh.geometry.triangles.size();
    one_patch_a_triangle(mesh);
    return mesh;
  }

  PbrtContext& context_;
  const PbrtParameters& parameters_;
  bool emissive_;
};

}  // namespace

std::optional<PbrtMesh> make_shape(PbrtContext& context, const std::string& kind, const PbrtParameters& parameters,
                                   bool emissive) {
  return ShapeBuilder(context, parameters, emissive).build(kind);
}

}  // namespace glowworm
