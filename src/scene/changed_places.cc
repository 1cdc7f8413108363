#include "scene/changed_places.h"

#include <algorithm>
#include <cstring>

#include "scene/placed_box.h"
#include "scene/scene_hash.h"

namespace glowworm {

namespace {

/// Most boxes: neighbours of the file share one where more triangles move.
constexpr std::size_t kMostBoxes = 4096;

template <typename Array>
bool same_bytes(const Array& a, const Array& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0);
}

bool same_vertex(const Geometry& a, std::uint32_t i, const Geometry& b, std::uint32_t k) {
  const auto same = [&](const auto& x, const auto& y) {
    if (x.empty() || y.empty()) return x.empty() == y.empty();
    return std::memcmp(&x[i], &y[k], sizeof(x[i])) == 0;
  };
  return same(a.positions, b.positions) && same(a.normals, b.normals) && same(a.uvs, b.uvs) &&
         same(a.second_uvs, b.second_uvs) && same(a.colors, b.colors);
}

/// Whether triangle i of a and triangle k of b look the same and are in the same place.
bool same_triangle(const Geometry& a, std::uint32_t i, const Geometry& b, std::uint32_t k) {
  if (a.material[i] != b.material[k] || a.emission[i] != b.emission[k]) return false;
  for (std::size_t corner = 0; corner < 3; ++corner)
    if (!same_vertex(a, a.triangles[i][corner], b, b.triangles[k][corner])) return false;
  return true;
}

/// Where the triangles of each object start, without those of instances, then the number of triangles.
std::vector<std::uint32_t> object_starts(const Geometry& g) {
  const auto count = static_cast<std::uint32_t>(g.triangles.size());
  std::vector<std::uint32_t> out = {0};
  for (const ObjectStart& object : g.objects)
    if (object.first_triangle > out.back() && object.first_triangle < count) out.push_back(object.first_triangle);
  out.push_back(count);
  return out;
}

/// Boxes around triangles that are elsewhere, or look different: where they were, and where they are.
struct MovedBoxes {
  std::vector<Box3> old, now;
};

Box3 box_of(const Geometry& g, std::uint32_t triangle) {
  Box3 box;
  for (const Vec3 p : g.corners(triangle)) box.grow(p);
  return box;
}

/// Adds the triangles of an object. An object may have other triangles where it moves: a thin one has an area or none
/// by rounding, and readers leave out those without. Then all of it has moved.
/// @param i, k the first of the object's triangles, of `in_before` and `in_now` ones
void add_object(const Geometry& before, std::uint32_t i, std::uint32_t in_before, const Geometry& now, std::uint32_t k,
                std::uint32_t in_now, MovedBoxes& boxes) {
  const bool same_count = in_before == in_now;
  for (std::uint32_t t = 0; t < std::max(in_before, in_now); ++t) {
    if (same_count && same_triangle(before, i + t, now, k + t)) continue;
    if (t < in_before) boxes.old.push_back(box_of(before, i + t));
    if (t < in_now) boxes.now.push_back(box_of(now, k + t));
  }
}

bool same_mesh(const Geometry& a, const Geometry& b) {
  return &a == &b ||
         (same_bytes(a.positions, b.positions) && same_bytes(a.normals, b.normals) && same_bytes(a.uvs, b.uvs) &&
          same_bytes(a.second_uvs, b.second_uvs) && same_bytes(a.colors, b.colors) &&
          same_bytes(a.triangles, b.triangles) && same_bytes(a.material, b.material));
}

/// Whether both have the same instances of the same meshes, though maybe elsewhere.
bool same_instances(const Geometry& a, const Geometry& b) {
  if (a.instances.size() != b.instances.size() || a.meshes.size() != b.meshes.size()) return false;
  for (std::size_t i = 0; i < a.meshes.size(); ++i)
    if (!same_mesh(*a.meshes[i], *b.meshes[i])) return false;
  for (std::size_t i = 0; i < a.instances.size(); ++i)
    if (a.instances[i].mesh != b.instances[i].mesh) return false;
  return true;
}

/// At most kMostBoxes boxes around the given ones.
std::vector<Box3> few_boxes(const std::vector<Box3>& boxes) {
  const std::size_t run = (boxes.size() + kMostBoxes - 1) / kMostBoxes;
  std::vector<Box3> out;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (i % run == 0) out.emplace_back();
    out.back().grow(boxes[i]);
  }
  return out;
}

template <typename T>
std::uint64_t array_bytes(const std::vector<T>& array) {
  return array.capacity() * sizeof(T);
}

std::uint64_t geometry_bytes(const Geometry& g) {
  std::uint64_t bytes = array_bytes(g.positions) + array_bytes(g.normals) + array_bytes(g.uvs) +
                        array_bytes(g.second_uvs) + array_bytes(g.colors) + array_bytes(g.triangles) +
                        array_bytes(g.material) + array_bytes(g.emission) + array_bytes(g.objects) +
                        array_bytes(g.instances) + array_bytes(g.instance_objects);
  for (const std::shared_ptr<const Geometry>& mesh : g.meshes) bytes += geometry_bytes(*mesh);
  return bytes;
}

}  // namespace

SceneMoment::SceneMoment(const Scene& scene) : geometry_(scene.shared_geometry()), look_(hash_look(scene)) {
  for (const TextureNode& node : scene.textures()) images_.push_back(node.image);
}

std::optional<std::vector<Box3>> SceneMoment::places_changed_in(const Scene& other) const {
  const Geometry &before = *geometry_, &now = other.geometry();
  // Images that are kept have addresses that no other image gets.
  if (look_ != hash_look(other) || !same_instances(before, now)) return std::nullopt;
  const std::vector<std::uint32_t> starts = object_starts(before), starts_now = object_starts(now);
  if (starts.size() != starts_now.size()) return std::nullopt;
  MovedBoxes moved;
  for (std::size_t i = 0; &before != &now && i + 1 < starts.size(); ++i)
    add_object(before, starts[i], starts[i + 1] - starts[i], now, starts_now[i], starts_now[i + 1] - starts_now[i],
               moved);
  std::vector<Box3> bounds(now.meshes.size());  // of meshes that move
  for (std::size_t i = 0; i < now.instances.size(); ++i) {
    const Instance &a = before.instances[i], &b = now.instances[i];
    if (std::memcmp(&a.to_world, &b.to_world, sizeof a.to_world) == 0 && a.rounding == b.rounding) continue;
    Box3& mesh = bounds[b.mesh];
    if (mesh.empty()) mesh = now.meshes[b.mesh]->bounds();
    moved.old.push_back(placed_box(a.to_world, mesh));
    moved.now.push_back(placed_box(b.to_world, mesh));
  }
  std::vector<Box3> out = few_boxes(moved.old);
  const std::vector<Box3> more = few_boxes(moved.now);
  out.insert(out.end(), more.begin(), more.end());
  Box3 all = other.bounds();
  for (const Box3& box : out) all.grow(box);
  const float margin = kMarginOfChanges * length(all.diagonal());
  for (Box3& box : out) {
    box.min -= Vec3{margin, margin, margin};
    box.max += Vec3{margin, margin, margin};
  }
  return out;
}

std::uint64_t SceneMoment::bytes() const { return geometry_bytes(*geometry_); }

}  // namespace glowworm
