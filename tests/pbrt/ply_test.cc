#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "core/error.h"
#include "import/pbrt/file.h"
#include "import/ply/reader.h"
#include "pbrt/pbrt_testing.h"

namespace glowworm {
namespace {

constexpr const char* kAscii = R"(ply
format ascii 1.0
comment a quad and a triangle
element vertex 5
property float x
property float y
property float z
property float nx
property float ny
property float nz
property float u
property float v
property uchar red
element face 2
property list uchar int vertex_indices
property int material
end_header
0 0 0 0 0 1 0 0 255
1 0 0 0 0 1 1 0 255
1 1 0 0 0 1 1 1 255
0 1 0 0 0 1 0 1 255
2 2.5e0 0 0 0 1 +.5 .5 255
4 0 1 2 3 7
3 1 4 2 8
)";

void expect_quad_and_triangle(const PlyMesh& mesh) {
  ASSERT_EQ(mesh.positions.size(), 5u);
  ASSERT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(mesh.quads, 1u);
  EXPECT_TRUE(mesh.positions[4] == (Vec3{2, 2.5f, 0}));
  EXPECT_TRUE(mesh.normals.at(0) == (Vec3{0, 0, 1}));
  EXPECT_EQ(mesh.uvs.at(4).x, 0.5f);
  EXPECT_EQ(mesh.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
  EXPECT_EQ(mesh.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
  EXPECT_EQ(mesh.triangles[2], (std::array<std::uint32_t, 3>{1, 4, 2}));
}

template <typename T>
void put(std::string& bytes, T value, bool big_endian) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

/// The mesh of kAscii in binary, with doubles and other types among them.
std::string binary(bool big_endian) {
  std::string bytes = std::string("ply\nformat ") + (big_endian ? "binary_big_endian" : "binary_little_endian") +
                      " 1.0\nelement vertex 5\nproperty double x\nproperty float32 y\nproperty short z\n"
                      "property list uchar ushort extra\nproperty float nx\nproperty float ny\nproperty float nz\n"
                      "property float s\nproperty float t\nelement edge 1\nproperty int a\n"
                      "element face 2\nproperty uint8 flags\nproperty list uint uint vertex_index\nend_header\n";
  const float xyuv[5][4] = {{0, 0, 0, 0}, {1, 0, 1, 0}, {1, 1, 1, 1}, {0, 1, 0, 1}, {2, 2.5f, 0.5f, 0.5f}};
  for (const auto& v : xyuv) {
    put<double>(bytes, v[0], big_endian);
    put<float>(bytes, v[1], big_endian);
    put<std::int16_t>(bytes, 0, big_endian);
    put<std::uint8_t>(bytes, 2, big_endian);
    put<std::uint16_t>(bytes, 11, big_endian);
    put<std::uint16_t>(bytes, 12, big_endian);
    for (const float n : {0.0f, 0.0f, 1.0f}) put<float>(bytes, n, big_endian);
    put<float>(bytes, v[2], big_endian);
    put<float>(bytes, v[3], big_endian);
  }
  put<std::int32_t>(bytes, -1, big_endian);
  const std::vector<std::vector<std::uint32_t>> faces = {{0, 1, 2, 3}, {1, 4, 2}};
  for (const auto& face : faces) {
    put<std::uint8_t>(bytes, 1, big_endian);
    put<std::uint32_t>(bytes, static_cast<std::uint32_t>(face.size()), big_endian);
    for (const std::uint32_t i : face) put<std::uint32_t>(bytes, i, big_endian);
  }
  return bytes;
}

std::string gzip(const std::string& bytes) {
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

PlyMesh parse(std::string_view bytes, const std::string& file) {
  MemoryBudget budget;
  CoordinateOrigin origin;
  return parse_ply(bytes, file, budget, origin);
}

PlyMesh read(const std::string& path) {
  MemoryBudget budget;
  CoordinateOrigin origin;
  return read_ply(path, budget, origin);
}

std::string ply_error_of(std::string_view bytes) {
  try {
    parse(bytes, "f.ply");
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(Ply, Ascii) { expect_quad_and_triangle(parse(kAscii, "f.ply")); }
TEST(Ply, LittleEndian) { expect_quad_and_triangle(parse(binary(false), "f.ply")); }
TEST(Ply, BigEndian) { expect_quad_and_triangle(parse(binary(true), "f.ply")); }

TEST(Ply, Gzipped) {
  const TemporaryFolder folder;
  expect_quad_and_triangle(read(folder.write("a.ply.gz", gzip(kAscii))));
  expect_quad_and_triangle(read(folder.write("b.ply", gzip(binary(true)))));
}

TEST(Ply, GzippedInSeveralMembers) {
  const TemporaryFolder folder;
  const std::string whole = kAscii, first = gzip(whole.substr(0, 100)), second = gzip(whole.substr(100));
  expect_quad_and_triangle(read(folder.write("a.ply.gz", first + second)));
  expect_quad_and_triangle(read(folder.write("b.ply.gz", first + gzip("") + second + std::string(512, '\0'))));
  const std::string cut = folder.write("c.ply.gz", first + second.substr(0, second.size() / 2));
  EXPECT_THAT([&] { read(cut); }, testing::ThrowsMessage<Error>(testing::HasSubstr("gzip data is truncated")));
  // Members without content take little time, however many they are.
  const std::string empty = gzip("");
  std::string many;
  for (int i = 0; i < 100'000; ++i) many += empty;
  expect_quad_and_triangle(read(folder.write("d.ply.gz", first + many + second)));
}

TEST(Ply, InAScene) {
  const TemporaryFolder folder;
  folder.write("models/quad.ply.gz", gzip(kAscii));
  const SceneDescription scene = load_scene(folder.write(
      "scene.pbrt", "WorldBegin Scale 2 2 2 Shape \"plymesh\" \"string filename\" \"models/quad.ply.gz\""));
  EXPECT_EQ(scene.geometry.triangle_count(), 3u);
  EXPECT_EQ(scene.geometry.bounds().max.y, 5);
}

TEST(Ply, LargeFacesBecomeFans) {
  const PlyMesh mesh = parse(
      "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 3\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0 1 0 0 2 1 0 1 2 0 0 2 0 -1 1 0 6 0 1 2 3 4 5 2 0 1 5 0 1 2 3 4",
      "f.ply");
  EXPECT_EQ(mesh.larger_faces, 2u);
  ASSERT_EQ(mesh.triangles.size(), 7u);
  for (std::uint32_t i = 0; i < 4; ++i) {
    EXPECT_EQ(mesh.triangles[i], (std::array<std::uint32_t, 3>{0, i + 1, i + 2})) << i;
  }
}

TEST(Ply, QuadsAreCutAlongTheShorterDiagonal) {
  const PlyMesh mesh = parse(
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 -.1 0 5 0 0 1 .1 0 4 0 1 2 3",
      "f.ply");
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 3}));
  EXPECT_EQ(mesh.triangles[1], (std::array<std::uint32_t, 3>{1, 2, 3}));
}

TEST(Ply, ConcaveQuadsAreCutAtTheirReflexCorner) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  for (const char* face : {"4 0 1 2 3", "4 1 2 3 0", "4 2 3 0 1", "4 3 2 1 0"}) {
    const PlyMesh mesh = parse(header + "0 10 0 -1 0 0 0 1 0 1 0 0 " + face, "f.ply");
    EXPECT_FLOAT_EQ(static_cast<float>(pbrt_testing::total_area(mesh)), 9) << face;
  }
}

TEST(Ply, TrianglesKnowTheirFaces) {
  const PlyMesh mesh = parse(kAscii, "f.ply");
  EXPECT_EQ(mesh.face_of, (std::vector<std::uint32_t>{0, 0, 1}));
}

TEST(Ply, MistakesNameFileAndLine) {
  const std::string head = "ply\nformat ascii 1.0\n";
  const std::string vertex = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  const std::string points = "0 0 0 1 0 0 0 1 0 ";
  EXPECT_EQ(ply_error_of(head + vertex + face + "end_header\n" + points + "3 0 1 2"), "");
  const struct {
    std::string text, message;
  } kCases[] = {
      {"", "f.ply:1: the PLY header has no end"},
      {"hello\n", "f.ply:1: is not a PLY file"},
      {"ply\n", "f.ply:2: the PLY header has no end"},
      {"ply\nformat xml 1.0\n", "f.ply:2: unknown PLY format"},
      {"ply\nend_header\n", "f.ply:2: the header has no format line"},
      {head + "elephant 3\n", "f.ply:3: unknown word in the header"},
      {head + "property float x\n", "f.ply:3: a property comes before any element"},
      {head + "element vertex -3\n", "f.ply:3: malformed element line"},
      {head + "element vertex\n", "f.ply:3: malformed element line"},
      {head + "element vertex 3\nproperty quaternion x\n", "f.ply:4: unknown property type"},
      {head + "element vertex 3\nproperty list float int x\n", "f.ply:4: the length of a list must be an integer"},
      {head + "element vertex 3\nproperty float\n", "f.ply:4: a property without a name"},
      {head + "element vertex 3\nproperty float x\nend_header\n1 2 3", "the vertices lack x, y or z"},
      {head + vertex + "end_header\n" + points, "holds no mesh"},
      {head + face + vertex + "end_header\n" + points + "3 0 1 2", "the faces come before the vertices"},
      {head + vertex + face + "end_header\n" + points, "the header promises 1 elements 'face'"},
      {head + vertex + face + "end_header\n" + points + "3 0 1", "the file ends inside its data"},
      {head + vertex + face + "end_header\n" + points + "3 0 1 3", "a face has vertex 3, but there are 3 vertices"},
      {head + vertex + face + "end_header\n" + points + "3 0 1 -1", "a face has vertex -1"},
      {head + vertex + face + "end_header\n" + points + "-3 0 1 2", "a list is longer than the rest of the file"},
      {head + vertex + face + "end_header\n" + points + "99 0 1 2", "a list is longer than the rest of the file"},
      {head + vertex + face + "end_header\n0 0 x 1 0 0 0 1 0 3 0 1 2", "expected a number"},
  };
  for (const auto& [text, message] : kCases) {
    EXPECT_NE(ply_error_of(text).find(message), std::string::npos) << text << "\n" << ply_error_of(text);
  }
}

TEST(Ply, EveryTruncationIsAnErrorNotACrash) {
  for (const bool big_endian : {false, true}) {
    const std::string whole = binary(big_endian);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      ASSERT_NE(ply_error_of(std::string_view(whole).substr(0, size)), "") << size;
    }
  }
  const TemporaryFolder folder;
  const std::string packed = gzip(kAscii);
  for (std::size_t size = 2; size < packed.size(); size += 7) {
    const std::string path = folder.write("cut.ply.gz", std::string_view(packed).substr(0, size));
    EXPECT_THROW(read(path), Error) << size;
  }
}

TEST(Ply, InflatingIsBounded) {
  const TemporaryFolder folder;
  const auto inflated = [&](const std::string& path, std::uint64_t budget_bytes) -> std::string {
    MemoryBudget budget(budget_bytes);
    Reservation held(budget, "scene files", 0);
    try {
      return std::to_string(read_pbrt_file(path, held).size());
    } catch (const Error& error) {
      return error.what();
    }
  };
  const std::string small = folder.write("small.ply.gz", gzip(std::string(8 << 20, '0')));
  EXPECT_EQ(inflated(small, 0), "8388608");
  EXPECT_THAT(inflated(small, 4 << 20), testing::HasSubstr("of scene files"));
  // 32 MiB of 32 KiB.
  const std::string bomb = folder.write("bomb.ply.gz", gzip(std::string(32 << 20, '0')));
  EXPECT_THAT(inflated(bomb, 0), testing::HasSubstr("inflates to more than 16 MiB"));
}

TEST(Ply, VerticesOfFacesAreWithinTheBudget) {
  constexpr std::size_t kFaces = 1 << 16;
  std::string file =
      "ply\nformat binary_little_endian 1.0\ncomment TextureFile a.png\nelement vertex 3\nproperty uchar x\n"
      "property uchar y\nproperty uchar z\nelement face 65536\nproperty list uchar uchar vertex_indices\n"
      "property list uchar uchar texcoord\nend_header\n" +
      std::string("\0\0\0\1\0\0\0\1\0", 9);
  for (std::size_t i = 0; i < kFaces; ++i) file += std::string("\3\0\1\2\6", 5) + std::string(6, '\0');
  CoordinateOrigin origin;
  MemoryBudget ample, tight(2 << 20);  // the triangles take 0.8 MB, their vertices 3.9 MB
  EXPECT_EQ(parse_ply(file, "f.ply", ample, origin).positions.size(), 3 + 3 * kFaces);
  EXPECT_THROW(parse_ply(file, "f.ply", tight, origin), MemoryError);
}

TEST(Ply, AMeshIsWithinTheBudget) {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty uchar x\nproperty uchar y\nproperty uchar z\n"
      "element face 4\nproperty list uint uchar vertex_indices\nend_header\n";
  std::string file = header + std::string("\0\0\0\1\0\0\0\1\0", 9);
  // A corner of a polygon takes a byte of the file, and a triangle of the mesh.
  for (int face = 0; face < 4; ++face) file += std::string("\0\0\2\0", 4) + std::string(1 << 17, '\1');
  CoordinateOrigin origin;
  MemoryBudget ample, tight(2 << 20);
  EXPECT_EQ(parse_ply(file, "f.ply", ample, origin).triangles.size(), 4u * ((1 << 17) - 2));
  EXPECT_THROW(parse_ply(file, "f.ply", tight, origin), MemoryError);
  EXPECT_EQ(tight.available(), tight.limit()) << "all is given back";
}

}  // namespace
}  // namespace glowworm
