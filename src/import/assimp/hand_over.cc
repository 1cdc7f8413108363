#include "import/assimp/hand_over.h"

#include <cstring>
#include <optional>
#include <type_traits>

#include "core/error.h"

namespace glowworm {

namespace {

constexpr std::uint32_t kMagic = 0x32617767, kEnd = 0x646e6567;

/// The reason why bytes are not a valid scene.
struct Unsound {
  const char* what;
};

[[noreturn]] void fail(const char* what) { throw Unsound{what}; }

/// Types that are copied bitwise.
template <typename T>
concept Plain = std::is_same_v<T, float> || std::is_same_v<T, std::uint32_t> || std::is_same_v<T, std::int32_t> ||
    std::is_same_v<T, Vec2> || std::is_same_v<T, Vec3> || std::is_same_v<T, RGB> ||
    std::is_same_v<T, TransformDouble> || std::is_same_v<T, std::array<std::uint32_t, 3>>;
static_assert(sizeof(Vec2) == 8 && sizeof(Vec3) == 12 && sizeof(RGB) == 12 && sizeof(TransformDouble) == 96);

class Writer {
 public:
  static constexpr bool kReads = false;
  explicit Writer(const std::function<void(const void*, std::size_t)>& write) : write_(write) {}

  void bytes(const void* data, std::size_t size) { write_(data, size); }
  /// Number of elements, of at least `size` bytes each.
  std::size_t count(std::size_t size, std::size_t) {
    const std::uint64_t value = size;
    bytes(&value, sizeof value);
    return size;
  }

 private:
  const std::function<void(const void*, std::size_t)>& write_;
};

class Reader {
 public:
  static constexpr bool kReads = true;
  explicit Reader(std::string_view rest) : rest_(rest) {}

  void bytes(void* data, std::size_t size) {
    if (size > rest_.size()) fail("it ends too early");
    if (size > 0) std::memcpy(data, rest_.data(), size);
    rest_.remove_prefix(size);
  }
  std::size_t count(std::size_t, std::size_t bytes_each) {
    std::uint64_t value = 0;
    bytes(&value, sizeof value);
    if (value > rest_.size() / bytes_each) fail("it holds less than it says");
    return static_cast<std::size_t>(value);
  }
  bool at_end() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

// Each transfer() lists the members of a structure, for both reading and writing.

template <typename Archive, Plain T>
void transfer(Archive& archive, T& value) {
  archive.bytes(&value, sizeof value);
}

template <typename Archive>
void transfer(Archive& archive, bool& value) {
  auto byte = static_cast<std::uint8_t>(value);
  archive.bytes(&byte, 1);
  if (byte > 1) fail("a flag is neither 0 nor 1");
  value = byte == 1;
}

template <typename Archive, typename Enum>
void transfer_enum(Archive& archive, Enum& value, Enum last) {
  auto byte = static_cast<std::uint8_t>(value);
  archive.bytes(&byte, 1);
  if (byte > static_cast<std::uint8_t>(last)) fail("it holds an unknown kind");
  value = static_cast<Enum>(byte);
}

template <typename Archive>
void transfer(Archive& archive, std::string& text) {
  text.resize(archive.count(text.size(), 1));
  archive.bytes(text.data(), text.size());
}

template <typename Archive>
void transfer(Archive& archive, std::optional<float>& value) {
  bool given = value.has_value();
  transfer(archive, given);
  if (!given) return;
  if (!value) value.emplace();
  transfer(archive, *value);
}

template <typename Archive, typename T>
void transfer(Archive& archive, std::vector<T>& values) {
  if constexpr (Plain<T>) {
    values.resize(archive.count(values.size(), sizeof(T)));
    archive.bytes(values.data(), values.size() * sizeof(T));
  } else {
    // An element in memory takes about ten times its minimum size in the encoding.
    const std::size_t count = archive.count(values.size(), 8);
    for (std::size_t i = 0; i < count; ++i) {
      if constexpr (Archive::kReads) values.emplace_back();
      transfer(archive, values[i]);
    }
  }
}

template <typename Archive, typename... Members>
void transfer_all(Archive& archive, Members&... members) {
  (transfer(archive, members), ...);
}

template <typename Archive>
void transfer(Archive& archive, PhongTexture& t) {
  transfer_all(archive, t.name, t.embedded);
  transfer_enum(archive, t.wrap_u, TextureWrap::black);
  transfer_enum(archive, t.wrap_v, TextureWrap::black);
  transfer(archive, t.by_second_uvs);
}

template <typename Archive>
void transfer(Archive& archive, PhongMaterial& m) {
  transfer_all(archive, m.name, m.diffuse, m.specular, m.emissive, m.filter, m.exponent, m.opacity, m.ior, m.model,
               m.metallic, m.roughness, m.diffuse_map, m.opacity_map, m.emissive_map, m.normal_map, m.has_metal_maps);
}

template <typename Archive>
void transfer(Archive& archive, ForeignMesh& m) {
  transfer_all(archive, m.name, m.material, m.has_points_or_lines, m.has_bones, m.has_colors, m.positions, m.normals,
               m.uvs, m.triangles);
}

template <typename Archive>
void transfer(Archive& archive, ForeignInstance& i) {
  transfer_all(archive, i.mesh, i.to_world);
}

template <typename Archive>
void transfer(Archive& archive, ForeignCamera& c) {
  transfer_all(archive, c.name, c.to_world, c.position, c.look_at, c.up, c.aspect, c.horizontal_fov,
               c.orthographic_width);
}

template <typename Archive>
void transfer(Archive& archive, ForeignLight& l) {
  transfer_all(archive, l.name, l.to_world);
  transfer_enum(archive, l.kind, ForeignLightKind::other);
  transfer_all(archive, l.intensity, l.position, l.direction, l.inner_angle, l.outer_angle);
}

template <typename Archive>
void transfer_mark(Archive& archive, std::uint32_t expected) {
  std::uint32_t mark = expected;
  transfer(archive, mark);
  if (mark != expected) fail("it is not of this version of the program");
}

template <typename Archive>
void transfer(Archive& archive, ForeignScene& scene) {
  transfer_mark(archive, kMagic);
  transfer_all(archive, scene.files, scene.embedded, scene.materials, scene.meshes, scene.instances, scene.cameras,
               scene.lights, scene.animations);
  transfer_mark(archive, kEnd);
}

void check_indices(const ForeignScene& scene) {
  for (const PhongMaterial& m : scene.materials) {
    for (const PhongTexture* map : {&m.diffuse_map, &m.opacity_map, &m.emissive_map, &m.normal_map}) {
      if (map->embedded != kNone && map->embedded >= scene.embedded.size()) fail("a texture is not there");
    }
  }
  for (const ForeignMesh& mesh : scene.meshes) {
    const std::size_t count = mesh.positions.size();
    if (mesh.material >= scene.materials.size()) fail("a mesh has a material that is not there");
    if (count >= kNone) fail("a mesh has more vertices than can be indexed");
    if (!mesh.normals.empty() && mesh.normals.size() != count) fail("a mesh has not one normal for each vertex");
    if (!mesh.uvs.empty() && mesh.uvs.size() != count) fail("a mesh has not one texture vertex for each vertex");
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t vertex : triangle) {
        if (vertex >= count) fail("a triangle has a vertex that is not there");
      }
    }
  }
  for (const ForeignInstance& instance : scene.instances) {
    if (instance.mesh >= scene.meshes.size()) fail("a node has a mesh that is not there");
  }
}

}  // namespace

void write_foreign_scene(const ForeignScene& scene, const std::function<void(const void*, std::size_t)>& write) {
  Writer writer(write);
  transfer(writer, const_cast<ForeignScene&>(scene));  // a writer does not change the scene
}

ForeignScene read_foreign_scene(std::string_view bytes, const std::string& file) try {
  Reader reader(bytes);
  ForeignScene scene;
  transfer(reader, scene);
  if (!reader.at_end()) fail("it does not end where it should");
  check_indices(scene);
  return scene;
} catch (const Unsound& unsound) {
  throw Error({file}, std::string("Assimp's output is invalid: ") + unsound.what,
              "Open it in the program that wrote it and export it again, as glTF if possible.");
}

}  // namespace glowworm
