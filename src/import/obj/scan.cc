#include "import/obj/scan.h"

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace glowworm {

namespace {

constexpr std::string_view kBlank = " \t\r\v\f";

/// Takes the next word off the front of `rest`; empty at the end of the line.
std::string_view next_word(std::string_view& rest) {
  const std::size_t begin = rest.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) {
    rest = {};
    return {};
  }
  const std::size_t end = std::min(rest.find_first_of(kBlank, begin), rest.size());
  const std::string_view word = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return word;
}

/// What is left of a line, without the blanks around it: names of files and materials may hold spaces.
std::string remainder(std::string_view rest) {
  const std::size_t begin = rest.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return std::string(rest.substr(begin, rest.find_last_not_of(kBlank) - begin + 1));
}

/// Calls visit(line number, line) for each logical line; a backslash at the end joins two. Comments are cut off.
template <typename Visit>
void for_each_line(std::istream& in, const Visit& visit) {
  std::string line, joined;
  int number = 0;
  while (std::getline(in, line)) {
    ++number;
    const std::size_t last = line.find_last_not_of("\r");
    line.resize(last == std::string::npos ? 0 : last + 1);
    if (!line.empty() && line.back() == '\\') {
      joined.append(line, 0, line.size() - 1).push_back(' ');
      continue;
    }
    joined += line;
    const std::string_view whole = joined;
    visit(number, whole.substr(0, whole.find('#')));
    joined.clear();
  }
}

class ObjScanner {
 public:
  ObjScanner(const std::string& path, NoteCounter& notes) : path_(path), notes_(notes) {}

  ObjScan run() {
    std::ifstream in(path_, std::ios::binary);
    if (!in) throw Error({path_}, "cannot be opened", "Check that you may read it.");
    for_each_line(in, [this](int number, std::string_view line) { visit(number, line); });
    if (in.bad()) throw Error({path_, line_}, "reading stopped half-way", "Check the disk the file is on.");
    if (faces_ == 0) {
      throw Error({path_}, "has no faces", "Is it an OBJ file? Export triangles or polygons, not curves or points.");
    }
    for (const std::string& name : used_materials_) {
      if (!defined_materials_.contains(name)) {
        notes_.add("material '" + name + "' is used but not defined in any material library: grey instead");
      }
    }
    return result_;
  }

 private:
  void visit(int number, std::string_view line) {
    line_ = number;
    std::string_view rest = line;
    const std::string_view key = next_word(rest);
    if (key == "v") {
      visit_vertex(rest);
    } else if (key == "vt") {
      ++texture_vertices_;
    } else if (key == "vn") {
      ++normals_;
      result_.has_normals = true;
    } else if (key == "f" || key == "fo") {
      visit_face(rest);
    } else if (key == "s") {
      const std::string_view group = next_word(rest);
      if (group != "off" && group != "0") result_.has_smoothing_groups = true;
    } else if (key == "usemtl") {
      used_materials_.insert(remainder(rest));
    } else if (key == "mtllib") {
      visit_library(remainder(rest));
    } else if (key == "l" || key == "p") {
      notes_.add(key == "l" ? "line element (l), left out" : "point element (p), left out");
    } else if (key == "vp" || key == "curv" || key == "curv2" || key == "surf" || key == "cstype") {
      notes_.add(fmt::format("free-form geometry ({}), left out", key));
    }
  }

  void visit_vertex(std::string_view rest) {
    ++vertices_;
    int numbers = 0;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
      const std::string text(word);
      char* end = nullptr;
      std::strtod(text.c_str(), &end);
      if (end != text.c_str() + text.size()) {
        throw Error({path_, line_}, fmt::format("'{}' is not a number", text), "Expected: v x y z");
      }
      ++numbers;
    }
    if (numbers < 3) {
      throw Error({path_, line_}, fmt::format("vertex with {} coordinates", numbers), "Expected: v x y z");
    }
    if (numbers >= 6) notes_.add("vertex with a colour of its own, not used");
  }

  void visit_face(std::string_view rest) {
    int corners = 0;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
      visit_corner(word);
      ++corners;
    }
    if (corners < 3) {
      throw Error({path_, line_}, fmt::format("face with {} corners", corners), "A face needs three or more.");
    }
    ++faces_;
  }

  /// One corner: v, v/vt, v//vn or v/vt/vn.
  void visit_corner(std::string_view word) {
    static constexpr std::string_view kNames[3] = {"vertex", "texture vertex", "normal"};
    const std::int64_t counts[3] = {vertices_, texture_vertices_, normals_};
    std::string_view rest = word;
    for (int field = 0; field < 3; ++field) {
      const std::size_t slash = rest.find('/');
      const std::string_view text = rest.substr(0, slash);
      if (!text.empty()) {
        check_index(text, kNames[field], counts[field]);
      } else if (field == 0) {
        throw Error({path_, line_}, fmt::format("face corner '{}' names no vertex", word),
                    "Expected: f 1/1/1 2/2/2 ...");
      }
      if (slash == std::string_view::npos) return;
      rest.remove_prefix(slash + 1);
    }
  }

  void check_index(std::string_view text, std::string_view what, std::int64_t count) {
    std::int64_t index = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
    const bool number = end == text.data() + text.size() && error != std::errc::invalid_argument;
    if (!number) throw Error({path_, line_}, fmt::format("'{}' is not an index", text), "Expected: f 1/1/1 2/2/2 ...");
    const bool inside = error == std::errc() && ((index >= 1 && index <= count) || (index <= -1 && index >= -count));
    if (!inside) {
      throw Error({path_, line_}, fmt::format("{} index {} is out of range: {} defined so far", what, text, count),
                  "Indices count from 1, or from -1 backwards. Export the file anew.");
    }
  }

  void visit_library(const std::string& name) {
    const std::filesystem::path library = std::filesystem::path(path_).parent_path() / name;
    std::ifstream in(library, std::ios::binary);
    std::error_code error;
    if (!in || std::filesystem::is_directory(library, error)) {
      notes_.add("material library '" + name + "' cannot be opened: its materials are grey");
      return;
    }
    for_each_line(in, [this](int, std::string_view line) { visit_material_line(line); });
  }

  void visit_material_line(std::string_view rest) {
    const std::string_view key = next_word(rest);
    if (key == "newmtl") {
      defined_materials_.insert(remainder(rest));
      return;
    }
    static constexpr std::string_view kUnsupported[] = {"map_bump", "map_Bump", "bump",   "disp",   "map_disp", "decal",
                                                        "refl",     "map_Ks",   "map_Ns", "map_Pr", "map_Pm"};
    for (const std::string_view unsupported : kUnsupported) {
      if (key == unsupported) notes_.add(fmt::format("MTL '{}' is not supported, left out", key));
    }
    if (key.substr(0, 4) != "map_" && key != "norm") return;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
      if (word == "-s" || word == "-o" || word == "-t" || word == "-mm") {
        notes_.add(fmt::format("MTL texture option '{}' is not supported, left out", word));
      }
    }
  }

  const std::string& path_;
  NoteCounter& notes_;
  ObjScan result_;
  int line_ = 0;
  std::int64_t vertices_ = 0, texture_vertices_ = 0, normals_ = 0, faces_ = 0;
  std::set<std::string> used_materials_, defined_materials_;
};

}  // namespace

ObjScan scan_obj(const std::string& path, NoteCounter& notes) { return ObjScanner(path, notes).run(); }

}  // namespace glowworm
