#include "import/obj/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <set>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/input_file.h"
#include "core/parallel.h"
#include "import/glass_sheets.h"
#include "import/mesh_tools.h"
#include "import/obj/lines.h"
#include "import/obj/mtl.h"
#include "import/obj/smooth.h"
#include "import/polygon.h"
#include "import/texture_cache.h"

namespace glowworm {

namespace {

/// Bytes of a mesh per triangle, without shared vertices.
constexpr std::size_t kMeshBytes = 3 * (2 * sizeof(Vec3) + sizeof(Vec2)) + 3 * sizeof(std::uint32_t);
constexpr std::size_t kNamedMaterials = 8;  ///< number of undefined materials that notes name

class ObjParser {
 public:
  ObjParser(const std::string& file, const ObjFiles& files, NoteCounter& notes, MemoryBudget& budget,
            CoordinateOrigin& origin)
      : origin_(origin),
        file_(file),
        files_(files),
        notes_(notes),
        budget_(budget),
        lists_(budget, "meshes", 0),
        faces_held_(budget, "meshes", 0),
        materials_held_(budget, "materials", 0),
        triangles_(budget, "triangles", 0) {}

  SceneDescription run(std::string_view text) {
    material_ = material_index("");
    LineReader lines(text);
    while (lines.next()) {
      line_ = lines.number();
      if (line_ % 1024 == 0) check_cancelled();
      visit(lines.line());
      lists_.cover((positions_.capacity() + normals_.capacity()) * sizeof(Vec3) + uvs_.capacity() * sizeof(Vec2));
    }
    end_part();
    end_object();
    if (faces_ == 0) {
      throw Error({file_}, "has no faces", "Is it an OBJ file? Export triangles or polygons, not curves or points.");
    }
    if (smoothed_) notes_.add("smoothing groups without normals: edges under 60 degrees are made smooth");
    add_materials();
    make_panes_of_glass_sheets(description_, notes_);
    return std::move(description_);
  }

 private:
  /// One corner of a face: indices into the file's lists; kNone if absent.
  struct Corner {
    std::uint32_t index[3] = {kNone, kNone, kNone};  ///< vertex, texture vertex, normal
  };

  struct Part {
    std::size_t end = 0;  ///< number of triangles of mesh_ up to here
    std::string name;
    std::uint32_t material = 0;
  };

  void visit(std::string_view rest) {
    const std::string_view key = take_word(rest);
    if (key == "v") {
      visit_vertex(rest);
    } else if (key == "vt") {
      const auto u = float_of(take_word(rest)), v = float_of(take_word(rest));
      uvs_.push_back({u.value_or(0), v.value_or(0)});
    } else if (key == "vn") {
      const auto x = float_of(take_word(rest)), y = float_of(take_word(rest)), z = float_of(take_word(rest));
      normals_.push_back(unit_or_zero({x.value_or(0), y.value_or(0), z.value_or(0)}));
    } else if (key == "f" || key == "fo") {
      visit_face(rest);
    } else if (key == "s") {
      const std::string_view group = take_word(rest);
      smooth_ = group != "off" && group != "0";
    } else if (key == "usemtl") {
      use_material(name_of(rest));
    } else if (key == "o" || key == "g") {
      end_part();
      if (key == "o") end_object();
      object_ = std::string(name_of(rest));
    } else if (key == "mtllib") {
      visit_library(trimmed(rest));
    } else if (key == "l" || key == "p") {
      notes_.add(key == "l" ? "line element (l), left out" : "point element (p), left out");
    } else if (key == "vp" || key == "curv" || key == "curv2" || key == "surf" || key == "cstype") {
      notes_.add(fmt::format("free-form geometry ({}), left out", key));
    }
  }

  void visit_vertex(std::string_view rest) {
    double value[4] = {0, 0, 0, 1};
    int numbers = 0;
    for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
      const auto number = number_of(word);
      if (!number) throw Error({file_, line_}, fmt::format("'{}' is not a number", word), "Expected: v x y z");
      if (numbers < 4) value[numbers] = *number;
      ++numbers;
    }
    if (numbers < 3) {
      throw Error({file_, line_}, fmt::format("vertex with {} coordinates", numbers), "Expected: v x y z");
    }
    if (numbers >= 6) notes_.add("vertex with a colour of its own, not used");
    const double w = numbers == 4 ? value[3] : 1;  // a fourth number is a weight; the last of six or seven are a colour
    positions_.push_back(origin_.relative(Vec3d{value[0], value[1], value[2]} * (1 / w)));
  }

  void visit_face(std::string_view rest) {
    corners_.clear();
    for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
      corners_.push_back(corner_of(word));
    }
    if (corners_.size() < 3) return notes_.add("face of fewer than three corners, left out");
    ++faces_;
    add_face();
  }

  void add_face() {
    places_.clear();
    cut_.clear();
    bool has_normals = true;
    for (const Corner& corner : corners_) {
      places_.push_back(positions_[corner.index[0]]);
      origin_.cover(Vec3d(places_.back()) + Vec3d(origin_.origin()));  // not where no face uses a vertex
      has_normals = has_normals && corner.index[2] != kNone;
    }
    if (!cut_polygon(places_, cut_))
      notes_.add("polygon that crosses itself or has too many corners: cut as if convex");
    for (const auto& triangle : cut_) {
      if (smooth_ && !has_normals) smooth_triangles_.push_back(static_cast<std::uint32_t>(mesh_.triangles.size()));
      std::array<std::uint32_t, 3> vertices;
      for (int i = 0; i < 3; ++i) {
        const Corner& corner = corners_[triangle[i]];
        vertices[i] = static_cast<std::uint32_t>(mesh_.positions.size());
        mesh_.positions.push_back(positions_[corner.index[0]]);
        mesh_.uvs.push_back(corner.index[1] != kNone ? uvs_[corner.index[1]] : Vec2{});
        mesh_.normals.push_back(corner.index[2] != kNone ? normals_[corner.index[2]] : Vec3{0, 0, 0});
      }
      mesh_.triangles.push_back(vertices);
    }
    faces_held_.cover(mesh_.triangles.capacity() * kMeshBytes + corners_.capacity() * sizeof(Corner));
  }

  /// Parses a corner: v, v/vt, v//vn or v/vt/vn.
  Corner corner_of(std::string_view word) const {
    static constexpr std::string_view kNames[3] = {"vertex", "texture vertex", "normal"};
    const std::size_t counts[3] = {positions_.size(), uvs_.size(), normals_.size()};
    Corner corner;
    std::string_view rest = word;
    for (int field = 0; field < 3; ++field) {
      const std::size_t slash = rest.find('/');
      const std::string_view text = rest.substr(0, slash);
      if (!text.empty()) {
        corner.index[field] = index_of(text, kNames[field], counts[field]);
      } else if (field == 0) {
        throw Error({file_, line_}, fmt::format("face corner '{}' is not a vertex", word),
                    "Expected: f 1/1/1 2/2/2 ...");
      }
      if (slash == std::string_view::npos) break;
      rest.remove_prefix(slash + 1);
    }
    return corner;
  }

  std::uint32_t index_of(std::string_view text, std::string_view what, std::size_t size) const {
    std::int64_t index = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
    const bool number = end == text.data() + text.size() && error != std::errc::invalid_argument;
    if (!number) throw Error({file_, line_}, fmt::format("'{}' is not an index", text), "Expected: f 1/1/1 2/2/2 ...");
    const auto count = static_cast<std::int64_t>(size);
    const bool inside = error == std::errc() && ((index >= 1 && index <= count) || (index <= -1 && index >= -count));
    if (!inside || count >= std::int64_t{kNone}) {
      throw Error({file_, line_}, fmt::format("{} index {} is out of range: {} defined so far", what, text, count),
                  "Indices count from 1, or from -1 backwards. Export the file again.");
    }
    return static_cast<std::uint32_t>(index > 0 ? index - 1 : count + index);
  }

  /// The index of a material in the file.
  std::uint32_t material_index(std::string_view name) {
    const auto [place, fresh] = indices_.try_emplace(std::string(name), static_cast<std::uint32_t>(materials_.size()));
    if (fresh) {
      materials_held_.grow(2 * sizeof(PhongMaterial));
      PhongMaterial& material = materials_.emplace_back();
      material.name = name.empty() ? "DefaultMaterial" : name;
      if (name.empty()) material.diffuse = RGB(kDefaultAlbedo);
      is_defined_.push_back(name.empty());
    }
    return place->second;
  }

  void use_material(std::string_view name) {
    const std::uint32_t index = material_index(name);
    if (index != material_) end_part();
    material_ = index;
  }

  /// Ends the part of an object that has one material and one name. Smoothing goes on over the parts of an object.
  void end_part() {
    if (mesh_.triangles.size() > (parts_.empty() ? 0 : parts_.back().end)) {
      parts_.push_back({mesh_.triangles.size(), object_, material_});
    }
    if (smooth_triangles_.empty()) end_object();
  }

  /// Adds the triangles since the last object to the scene. They keep the file's material indices until all materials
  /// are known.
  void end_object() {
    if (!smooth_triangles_.empty()) smooth_normals(mesh_, smooth_triangles_);
    smoothed_ = smoothed_ || !smooth_triangles_.empty();
    std::size_t first = 0;
    for (const Part& part : parts_) {
      const Reservation held(budget_, "meshes", parts_.size() > 1 ? (part.end - first) * kMeshBytes : 0);
      add_part(part, parts_.size() > 1 ? part_of_mesh(first, part.end) : std::move(mesh_));
      first = part.end;
    }
    mesh_ = {};
    parts_.clear();
    smooth_triangles_.clear();
  }

  /// A copy of triangles of mesh_. Each has three vertices of its own, in order.
  Geometry part_of_mesh(std::size_t first, std::size_t end) const {
    const auto slice = [&](const auto& values) {
      using Values = std::decay_t<decltype(values)>;
      const auto begin = values.begin();
      return Values(begin + static_cast<std::ptrdiff_t>(3 * first), begin + static_cast<std::ptrdiff_t>(3 * end));
    };
    Geometry out;
    out.positions = slice(mesh_.positions);
    out.normals = slice(mesh_.normals);
    out.uvs = slice(mesh_.uvs);
    out.triangles.assign(mesh_.triangles.begin(), mesh_.triangles.begin() + static_cast<std::ptrdiff_t>(end - first));
    return out;
  }

  void add_part(const Part& part, Geometry mesh) {
    merge_identical_vertices(mesh);
    notes_.add("triangle wound against its normals, reversed", wind_by_normals(mesh));
    triangles_.grow(scene_bytes(mesh));
    if (!part.name.empty()) description_.geometry.begin_object(part.name);
    append_counted(description_.geometry, mesh, file_, part.material, kNone, notes_);
  }

  /// @param line the names of libraries, or one name, which may contain blanks
  void visit_library(std::string_view line) {
    const std::string name(name_of(line));
    if (!libraries_.insert(name).second) return;
    const std::optional<std::string> text = files_.library(name);
    if (!text) {
      std::vector<std::string> names;
      for (std::string_view word = next_name(line); !word.empty(); word = next_name(line)) names.emplace_back(word);
      // Of several libraries, the first one that defines a material counts.
      if (names.size() > 1) {
        std::for_each(names.rbegin(), names.rend(), [this](const std::string& one) { visit_library(one); });
        return;
      }
      notes_.add("material library '" + name + "' cannot be opened: its materials are grey");
      return;
    }
    // Those of the library, in an array that grows, and beside them.
    std::uint64_t definitions = 0;
    for (std::size_t at = text->find("newmtl"); at != std::string::npos; at = text->find("newmtl", at + 1))
      ++definitions;
    const Reservation held(budget_, "materials", 2 * definitions * sizeof(PhongMaterial));
    for (PhongMaterial& material : parse_mtl(*text, notes_)) {
      const std::uint32_t index = material_index(material.name);
      if (material.name.empty()) continue;
      materials_[index] = std::move(material);
      is_defined_[index] = true;
    }
  }

  /// Adds the materials that triangles use, in the order of their definition.
  void add_materials() {
    Geometry& geometry = description_.geometry;
    std::vector<bool> is_used(materials_.size());
    for (const std::uint32_t material : geometry.material) is_used[material] = true;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> added(materials_.size());  // material and emission
    const PhongContext context{files_.texture, notes_, description_};
    std::size_t undefined = 0;
    for (std::size_t i = 0; i < materials_.size(); ++i) {
      if (!is_used[i]) continue;
      if (!is_defined_[i] && ++undefined <= kNamedMaterials) {
        notes_.add("material '" + materials_[i].name +
                   "' is used but not defined in any material library: grey instead");
      }
      materials_held_.grow(material_bytes());
      added[i].first = static_cast<std::uint32_t>(description_.materials.size());
      added[i].second = add_phong_material(materials_[i], context);
    }
    if (undefined > kNamedMaterials) {
      notes_.add(fmt::format("{} more materials are used but not defined: grey instead", undefined - kNamedMaterials));
    }
    for (std::size_t t = 0; t < geometry.triangle_count(); ++t) {
      geometry.emission[t] = added[geometry.material[t]].second;
      geometry.material[t] = added[geometry.material[t]].first;
    }
  }

  static Vec3 unit_or_zero(Vec3 n) {
    const float l = length(n);
    return l > 0 && std::isfinite(l) ? n / l : Vec3{0, 0, 0};
  }

  CoordinateOrigin& origin_;
  const std::string& file_;
  const ObjFiles& files_;
  NoteCounter& notes_;
  MemoryBudget& budget_;
  /// For the file's lists, mesh_, materials, and the scene's triangles.
  Reservation lists_, faces_held_, materials_held_, triangles_;
  SceneDescription description_;
  int line_ = 0;
  std::string object_;  // name; empty before the first object
  std::size_t faces_ = 0;
  bool smooth_ = false, smoothed_ = false;
  std::vector<Vec3> positions_, normals_;
  std::vector<Vec2> uvs_;
  std::vector<PhongMaterial> materials_;
  std::vector<bool> is_defined_;
  std::unordered_map<std::string, std::uint32_t> indices_;  ///< materials by name
  std::set<std::string> libraries_;
  std::uint32_t material_ = 0;
  Geometry mesh_;                                  ///< since the last object; no vertices are shared yet
  std::vector<Part> parts_;                        ///< of mesh_
  std::vector<std::uint32_t> smooth_triangles_;    ///< triangles of mesh_
  std::vector<Corner> corners_;                    ///< of one face
  std::vector<Vec3> places_;                       ///< positions of these corners
  std::vector<std::array<std::uint32_t, 3>> cut_;  ///< triangles of this face
};

}  // namespace

SceneDescription parse_obj(std::string_view text, const std::string& file, const ObjFiles& files, NoteCounter& notes,
                           MemoryBudget& budget, CoordinateOrigin& origin) {
  return ObjParser(file, files, notes, budget, origin).run(text);
}

SceneDescription load_obj(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin) {
  NoteCounter notes;
  TextureCache textures(options, notes);
  const std::filesystem::path full(path);
  const std::string folder = full.parent_path().string();
  Reservation held(*options.budget, "scene files", 0);
  ObjFiles files;
  files.library = [&](const std::string& name) -> std::optional<std::string> {
    try {
      return read_input_file(find_texture_file(folder, name), held);
    } catch (const MemoryError&) {
      throw;
    } catch (const Error&) {
      return std::nullopt;  // this becomes a note
    }
  };
  files.texture = [&](const PhongTexture& texture, const TextureOptions& texture_options, StandIn stand_in) {
    return textures.load_file(find_texture_file(folder, texture.name), texture_options, stand_in);
  };
  SceneDescription description = parse_obj(read_input_file(path, held), path, files, notes, *options.budget, origin);
  description.name = full.stem().string();
  if (description.geometry.triangles.empty()) {
    throw Error({path}, "has no triangles that can be shown", "Export meshes, not curves or points.");
  }
  notes.write_to(description.notes);
  return description;
}

}  // namespace glowworm
