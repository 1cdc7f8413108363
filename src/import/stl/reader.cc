#include "import/stl/reader.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <cstring>

#include "core/error.h"
#include "core/lines.h"
#include "core/parallel.h"
#include "core/text.h"
#include "import/obj/lines.h"

namespace glowworm {

namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kHeaderBytes = 84, kFacetBytes = 50;
/// Bytes of a mesh per facet.
constexpr std::uint64_t kMeshBytes = 3 * (2 * sizeof(Vec3) + sizeof(Vec2)) + 3 * sizeof(std::uint32_t);
constexpr const char* kDamaged = "The file may be damaged or cut off.";

void add_facet(Geometry& mesh, const Vec3 vertices[3], Vec3 normal) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (int i = 0; i < 3; ++i) {
    mesh.positions.push_back(vertices[i]);
    mesh.normals.push_back(normal);
    mesh.uvs.push_back({});
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
}

std::uint32_t facet_count(std::string_view bytes) {
  std::uint32_t count = 0;
  if (bytes.size() >= kHeaderBytes) std::memcpy(&count, bytes.data() + kHeaderBytes - sizeof count, sizeof count);
  return count;
}

Geometry parse_binary(std::string_view bytes, const std::string& file, MemoryBudget& budget, CoordinateOrigin& origin) {
  if (bytes.size() < kHeaderBytes) throw Error({file}, "is not an STL file: it ends within the header", kDamaged);
  const std::uint32_t count = facet_count(bytes);
  if (count > (bytes.size() - kHeaderBytes) / kFacetBytes) {
    throw Error({file}, fmt::format("the header promises {} facets, but the file ends before them", count), kDamaged);
  }
  if (count > kNone / 3) throw Error({file}, fmt::format("{} facets are too many", count), "Split the mesh.");
  const Reservation held(budget, "meshes", count * kMeshBytes);
  origin.set_rounded();  // the file has floats
  Geometry mesh;
  mesh.positions.reserve(3 * std::size_t{count});
  mesh.normals.reserve(3 * std::size_t{count});
  mesh.uvs.reserve(3 * std::size_t{count});
  mesh.triangles.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    Vec3 values[4];  // the normal and three vertices
    std::memcpy(values, bytes.data() + kHeaderBytes + kFacetBytes * i, sizeof values);
    for (int v = 1; v < 4; ++v) values[v] = origin.take(Vec3d(values[v]));
    add_facet(mesh, values + 1, values[0]);
  }
  return mesh;
}

class AsciiParser {
 public:
  AsciiParser(const std::string& file, MemoryBudget& budget, CoordinateOrigin& origin)
      : file_(file), origin_(origin), held_(budget, "meshes", 0) {}

  Geometry run(std::string_view text) {
    LineReader lines(text);
    while (lines.next()) {
      line_ = lines.number();
      if (line_ % 1024 == 0) check_cancelled();
      std::string_view rest = lines.line();
      for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
        const std::string known = lower(word);
        if (known == "solid" || known == "endsolid") break;  // a name follows
        visit(known, rest);
      }
    }
    if (inside_) fail("the file ends within a facet");
    return std::move(mesh_);
  }

 private:
  void visit(const std::string& word, std::string_view& rest) {
    if (word == "facet") {
      if (lower(take_word(rest)) != "normal") fail("'facet' without 'normal'");
      normal_ = narrow(vector(rest));
      inside_ = true;
      count_ = 0;
    } else if (word == "vertex") {
      if (!inside_ || count_ == 3) fail("a vertex that belongs to no facet of three");
      vertices_[count_++] = origin_.take(vector(rest));
    } else if (word == "endfacet") {
      if (!inside_ || count_ != 3) fail(fmt::format("a facet of {} vertices", count_));
      if (mesh_.positions.size() > kNone - 3) fail("more vertices than can be indexed");
      add_facet(mesh_, vertices_, normal_);
      held_.cover(mesh_.triangles.capacity() * kMeshBytes);
      inside_ = false;
    } else if (word != "outer" && word != "loop" && word != "endloop") {
      fail(fmt::format("unknown word '{}'", word.substr(0, 60)));
    }
  }

  Vec3d vector(std::string_view& rest) const {
    Vec3d out;
    for (int i = 0; i < 3; ++i) {
      const auto number = number_of(take_word(rest));
      if (!number) fail("expected three numbers");
      out[i] = *number;
    }
    return out;
  }

  [[noreturn]] void fail(const std::string& message) const { throw Error({file_, line_}, message, kDamaged); }

  const std::string& file_;
  CoordinateOrigin& origin_;
  Reservation held_;
  Geometry mesh_;
  int line_ = 0, count_ = 0;
  bool inside_ = false;
  Vec3 normal_, vertices_[3];
};

}  // namespace

Geometry parse_stl(std::string_view bytes, const std::string& file, MemoryBudget& budget, CoordinateOrigin& origin) {
  // Binary files may begin with "solid", too.
  const bool has_binary_size =
      bytes.size() >= kHeaderBytes && bytes.size() - kHeaderBytes == kFacetBytes * std::size_t{facet_count(bytes)};
  const std::string_view begin = trimmed(without_byte_order_mark(bytes).substr(0, 256));
  if (!has_binary_size && lower(begin).starts_with("solid")) return AsciiParser(file, budget, origin).run(bytes);
  return parse_binary(bytes, file, budget, origin);
}

}  // namespace glowworm
