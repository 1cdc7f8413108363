#include "import/ply/reader.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <utility>

#include "core/error.h"
#include "core/lines.h"
#include "import/pbrt/file.h"
#include "import/ply/header.h"
#include "import/polygon.h"

namespace glowworm {

namespace {

constexpr const char* kCutOff = "The file may be damaged or cut off.";
/// Bytes per corner of a face: its index, and its position while the face is triangulated.
constexpr std::size_t kCornerBytes = sizeof(std::uint32_t) + sizeof(Vec3);

/// Reads the file's values one after another, in any format. Every value fits a double exactly.
class ValueReader {
 public:
  ValueReader(std::string_view bytes, const PlyHeader& header, const std::string& file)
      : bytes_(bytes), at_(header.data_begin), format_(header.format), file_(file) {}

  bool is_ascii() const { return format_ == PlyFormat::ascii; }
  double value(PlyType type) { return format_ == PlyFormat::ascii ? ascii_value() : binary_value(type); }

  /// Reads a list's length. Throws if the rest of the file is too short for it.
  std::uint64_t length(const PlyProperty& property) {
    const double count = value(property.count_type);
    const std::uint64_t each = format_ == PlyFormat::ascii ? 1 : size_of(property.type);
    if (!(count >= 0) || count > static_cast<double>((bytes_.size() - at_) / each)) {
      fail("a list is longer than the rest of the file");
    }
    return static_cast<std::uint64_t>(count);
  }

  /// Skips several values of one type, at once if possible.
  void skip(PlyType type, std::uint64_t count) {
    if (format_ == PlyFormat::ascii) {
      for (std::uint64_t i = 0; i < count; ++i) ascii_value();
      return;
    }
    if (count > (bytes_.size() - at_) / size_of(type)) fail("the file ends inside its data");
    at_ += count * size_of(type);
  }

  [[noreturn]] void fail(const std::string& message) const {
    throw Error({file_}, fmt::format("{} (byte {})", message, at_), kCutOff);
  }

 private:
  template <typename T>
  double binary(std::size_t size) {
    if (bytes_.size() - at_ < size) fail("the file ends inside its data");
    unsigned char raw[8];
    for (std::size_t i = 0; i < size; ++i) {
      const bool same_order =
          (format_ == PlyFormat::binary_little_endian) == (std::endian::native == std::endian::little);
      raw[same_order ? i : size - 1 - i] = static_cast<unsigned char>(bytes_[at_ + i]);
    }
    at_ += size;
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return static_cast<double>(value);
  }

  double binary_value(PlyType type) {
    switch (type) {
      case PlyType::int8:
        return binary<std::int8_t>(1);
      case PlyType::uint8:
        return binary<std::uint8_t>(1);
      case PlyType::int16:
        return binary<std::int16_t>(2);
      case PlyType::uint16:
        return binary<std::uint16_t>(2);
      case PlyType::int32:
        return binary<std::int32_t>(4);
      case PlyType::uint32:
        return binary<std::uint32_t>(4);
      case PlyType::float32:
        return binary<float>(4);
      case PlyType::float64:
        return binary<double>(8);
    }
    return 0;
  }

  double ascii_value() {
    while (at_ < bytes_.size() &&
           (bytes_[at_] == ' ' || bytes_[at_] == '\n' || bytes_[at_] == '\r' || bytes_[at_] == '\t')) {
      ++at_;
    }
    double number = 0;
    std::string_view rest = bytes_.substr(at_);
    if (!take_number(rest, number)) fail(at_ < bytes_.size() ? "expected a number" : "the file ends inside its data");
    at_ = bytes_.size() - rest.size();
    return number;
  }

  std::string_view bytes_;
  std::size_t at_;
  PlyFormat format_;
  const std::string& file_;
};

/// The meaning of a vertex property: an index into {x, y, z, nx, ny, nz, u, v}, or -1.
int vertex_role(std::string_view name) {
  constexpr std::pair<std::string_view, int> kRoles[] = {
      {"x", 0}, {"y", 1}, {"z", 2},  {"nx", 3}, {"ny", 4},        {"nz", 5},        {"u", 6},         {"v", 7},
      {"s", 6}, {"t", 7}, {"tx", 6}, {"ty", 7}, {"texture_u", 6}, {"texture_v", 7}, {"texture_s", 6}, {"texture_t", 7}};
  for (const auto& [known, role] : kRoles) {
    if (known == name) return role;
  }
  return -1;
}

void read_vertices(ValueReader& reader, const PlyElement& element, const std::string& file, Reservation& held,
                   PlyMesh& mesh, CoordinateOrigin& origin) {
  bool present[8] = {};
  std::vector<int> roles;
  for (const PlyProperty& property : element.properties) {
    const int role = property.is_list ? -1 : vertex_role(property.name);
    roles.push_back(role);
    mesh.has_colors = mesh.has_colors || property.name == "red" || property.name == "diffuse_red";
    if (role >= 0) present[role] = true;
    if (role >= 0 && role < 3 && !reader.is_ascii() && property.type == PlyType::float32) origin.set_rounded();
  }
  if (!present[0] || !present[1] || !present[2]) {
    throw Error({file}, "the vertices lack x, y or z", "Export the mesh with positions.");
  }
  if (element.count >= 0xffffffffu) {
    throw Error({file}, fmt::format("{} vertices are more than can be indexed", element.count), "Split the mesh.");
  }
  const auto count = static_cast<std::size_t>(element.count);
  const bool has_normals = present[3] && present[4] && present[5];
  const bool has_uvs = present[6] && present[7];
  held.grow(count * (sizeof(Vec3) * (has_normals ? 2 : 1) + (has_uvs ? sizeof(Vec2) : 0)));
  mesh.positions.reserve(count);
  if (has_normals) mesh.normals.reserve(count);
  if (has_uvs) mesh.uvs.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    double value[8] = {};
    for (std::size_t p = 0; p < roles.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (property.is_list) {
        reader.skip(property.type, reader.length(property));
      } else {
        const double number = reader.value(property.type);
        if (roles[p] >= 0) value[roles[p]] = number;
      }
    }
    mesh.positions.push_back(origin.take({value[0], value[1], value[2]}));
    if (has_normals) mesh.normals.push_back(narrow({value[3], value[4], value[5]}));
    if (has_uvs) mesh.uvs.push_back({static_cast<float>(value[6]), static_cast<float>(value[7])});
  }
}

void add_quad(const std::uint32_t corner[4], PlyMesh& mesh) {
  ++mesh.quads;
  Vec3 p[4];
  for (int i = 0; i < 4; ++i) p[i] = mesh.positions[corner[i]];
  const Vec3 across = p[2] - p[0], other = p[3] - p[1], normal = cross(across, other);
  // Only the diagonal through a reflex corner is inside.
  const auto is_reflex = [&](int i) { return dot(cross(p[i] - p[(i + 3) % 4], p[(i + 1) % 4] - p[i]), normal) < 0; };
  const bool by_first = is_reflex(0) || is_reflex(2), by_second = is_reflex(1) || is_reflex(3);
  if (by_first != by_second ? by_first : length_squared(across) <= length_squared(other)) {
    mesh.triangles.push_back({corner[0], corner[1], corner[2]});
    mesh.triangles.push_back({corner[0], corner[2], corner[3]});
  } else {
    mesh.triangles.push_back({corner[0], corner[1], corner[3]});
    mesh.triangles.push_back({corner[1], corner[2], corner[3]});
  }
}

void add_larger_face(const std::vector<std::uint32_t>& corners, PlyMesh& mesh) {
  ++mesh.larger_faces;
  std::vector<Vec3> places;
  for (const std::uint32_t vertex : corners) places.push_back(mesh.positions[vertex]);
  const std::size_t first = mesh.triangles.size();
  cut_polygon(places, mesh.triangles);
  for (std::size_t t = first; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t& corner : mesh.triangles[t]) corner = corners[corner];
  }
}

/// Reads the faces of a mesh whose vertices are complete.
class FaceReader {
 public:
  /// @param vertices number of vertices that faces may name
  FaceReader(ValueReader& reader, std::size_t vertices, Reservation& held, PlyMesh& mesh)
      : reader_(reader), vertices_(vertices), held_(held), mesh_(mesh) {}

  void read(const PlyElement& element) {
    for (std::uint64_t i = 0; i < element.count; ++i) {
      corners_.clear();
      uvs_.clear();
      for (const PlyProperty& property : element.properties) read_property(property);
      // MeshLab writes texture coordinates of corners, which differ where charts of the texture meet.
      if (corners_.size() >= 3 && uvs_.size() == 2 * corners_.size()) separate_corners();
      if (corners_.size() < 3) ++mesh_.smaller_faces;
      if (corners_.size() == 3) mesh_.triangles.push_back({corners_[0], corners_[1], corners_[2]});
      if (corners_.size() == 4) add_quad(corners_.data(), mesh_);
      if (corners_.size() > 4) add_larger_face(corners_, mesh_);
      end_face();
    }
  }

  /// Reads triangle strips: in each list, every vertex after the second ends a triangle with the two before it, and -1
  /// begins another strip. Every other triangle of a strip is turned over, so that all face the same way.
  void read_strips(const PlyElement& element) {
    for (std::uint64_t i = 0; i < element.count; ++i) {
      for (const PlyProperty& property : element.properties) {
        const std::uint64_t count = property.is_list ? reader_.length(property) : 1;
        if (!is_indices(property)) {
          reader_.skip(property.type, count);
          continue;
        }
        corners_.clear();
        for (std::uint64_t at = 0; at < count; ++at) read_strip_vertex(reader_.value(property.type));
      }
    }
  }

 private:
  static bool is_indices(const PlyProperty& property) {
    return property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index");
  }

  void end_face() {
    const std::uint32_t face = mesh_.face_of.empty() ? 0 : mesh_.face_of.back() + 1;
    mesh_.face_of.resize(mesh_.triangles.size(), face);
  }

  void read_strip_vertex(double value) {
    if (value == -1) return corners_.clear();
    add_corner(value);
    if (corners_.size() < 3) return;
    const std::uint32_t* last = corners_.data() + corners_.size() - 3;
    const bool turned = corners_.size() % 2 == 0;
    mesh_.triangles.push_back({last[turned ? 1 : 0], last[turned ? 0 : 1], last[2]});
    end_face();
    cover();
  }

  void add_corner(double value) {
    if (!(value >= 0 && value < static_cast<double>(vertices_)))
      reader_.fail(fmt::format("a face has vertex {}, but there are {} vertices", value, vertices_));
    corners_.push_back(static_cast<std::uint32_t>(value));
  }

  void read_property(const PlyProperty& property) {
    const std::uint64_t count = property.is_list ? reader_.length(property) : 1;
    const bool indices = is_indices(property);
    const bool uvs = property.is_list && property.name == "texcoord" && !mesh_.texture.empty();
    if (!indices && !uvs) return reader_.skip(property.type, count);
    for (std::uint64_t i = 0; i < count; ++i) {
      const double value = reader_.value(property.type);
      if (uvs)
        uvs_.push_back(static_cast<float>(value));
      else
        add_corner(value);
      cover();
    }
  }

  /// Gives each corner a vertex of its own, with its texture coordinates.
  void separate_corners() {
    if (mesh_.positions.size() + corners_.size() >= kNone) {
      reader_.fail("the corners of all faces are more vertices than can be indexed");
    }
    mesh_.uvs.resize(mesh_.positions.size());
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const std::uint32_t shared = std::exchange(corners_[i], static_cast<std::uint32_t>(mesh_.positions.size()));
      mesh_.positions.push_back(mesh_.positions[shared]);
      if (!mesh_.normals.empty()) mesh_.normals.push_back(mesh_.normals[shared]);
      mesh_.uvs.push_back({uvs_[2 * i], uvs_[2 * i + 1]});
      cover();
    }
  }

  void cover() {
    held_.cover((mesh_.positions.capacity() + mesh_.normals.capacity()) * sizeof(Vec3) +
                mesh_.uvs.capacity() * sizeof(Vec2) + mesh_.triangles.capacity() * sizeof mesh_.triangles[0] +
                mesh_.face_of.capacity() * sizeof(std::uint32_t) + corners_.capacity() * kCornerBytes +
                uvs_.capacity() * sizeof(float));
  }

  ValueReader& reader_;
  std::size_t vertices_;
  Reservation& held_;
  PlyMesh& mesh_;
  std::vector<std::uint32_t> corners_;  ///< of one face, as indices
  std::vector<float> uvs_;              ///< "texcoord" of this face: two for each corner, or something else
};

void skip_element(ValueReader& reader, const PlyElement& element) {
  if (element.properties.empty()) return;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      reader.skip(property.type, property.is_list ? reader.length(property) : 1);
    }
  }
}

}  // namespace

PlyMesh parse_ply(std::string_view bytes, const std::string& file, MemoryBudget& budget, CoordinateOrigin& origin) {
  const PlyHeader header = read_ply_header(bytes, file);
  ValueReader reader(bytes, header, file);
  Reservation held(budget, "meshes", 0);
  PlyMesh mesh;
  mesh.texture = header.texture;
  mesh.textures = header.textures;
  bool has_vertices = false, has_faces = false;
  std::size_t vertices = 0;
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex" && !has_vertices) {
      has_vertices = true;
      read_vertices(reader, element, file, held, mesh, origin);
      vertices = mesh.positions.size();
    } else if ((element.name == "face" || element.name == "tristrips") && !element.properties.empty()) {
      if (!has_vertices) throw Error({file}, "the faces come before the vertices", "Export the mesh again.");
      has_faces = true;
      FaceReader faces(reader, vertices, held, mesh);
      if (element.name == "face")
        faces.read(element);
      else
        faces.read_strips(element);
    } else {
      skip_element(reader, element);
    }
  }
  if (!has_vertices || !has_faces) {
    throw Error({file}, "holds no mesh: vertices or faces are missing", "Point clouds and lines cannot be rendered.");
  }
  return mesh;
}

PlyMesh read_ply(const std::string& path, MemoryBudget& budget, CoordinateOrigin& origin) {
  Reservation held(budget, "scene files", 0);
  return parse_ply(read_pbrt_file(path, held), path, budget, origin);
}

}  // namespace glowworm
