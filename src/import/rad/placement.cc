#include "import/rad/placement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include "core/lines.h"
#include "import/rad/words.h"

namespace glowworm {

namespace {

using Words = std::vector<std::string>;

/// Levels of -a and -f within one command.
constexpr int kMostNested = 8;

TransformDouble turn_about(int axis, double degrees) {
  const double c = std::cos(degrees * M_PI / 180), s = std::sin(degrees * M_PI / 180);
  if (axis == 0) return {{1, 0, 0}, {0, c, s}, {0, -s, c}, {}};
  if (axis == 1) return {{c, 0, -s}, {0, 1, 0}, {s, 0, c}, {}};
  return {{c, s, 0}, {-s, c, 0}, {0, 0, 1}, {}};
}

TransformDouble power(TransformDouble base, std::size_t exponent) {
  TransformDouble out;
  for (; exponent > 0; exponent /= 2, base = base * base)
    if (exponent % 2 == 1) out = base * out;
  return out;
}

/// Reads the arguments of one copy, without -a and -f.
class CopyReader {
 public:
  CopyReader(const Words& words, const FilePlace& place) : words_(words), place_(place) {}

  RadPlacement placement() {
    RadPlacement out;
    for (; at_ < words_.size(); ++at_) {
      const std::string& word = words_[at_];
      if (word == "-I")
        out.inverted = true;
      else if (word == "-n")
        out.prefix = argument() + ".";
      else if (word == "-m")
        out.modifier = argument();
      else if (word != "-c" && word != "-e")
        break;
    }
    TransformDouble part;
    std::size_t repeat = 1;
    for (; at_ < words_.size() && words_[at_].starts_with('-'); ++at_) {
      if (words_[at_] == "-i") {
        out.to_world = power(part, repeat) * out.to_world;
        part = {};
        repeat = count();
      } else {
        part = transform() * part;
      }
    }
    out.to_world = power(part, repeat) * out.to_world;
    const double size = out.to_world.determinant();
    if (!(std::abs(size) > 0) || !std::isfinite(size))
      throw Error(place_, "xform places things without size, or without end", "Check -s and -i.");
    return out;
  }
  Words files() const { return {words_.begin() + static_cast<std::ptrdiff_t>(at_), words_.end()}; }

 private:
  const std::string& argument() {
    if (at_ + 1 >= words_.size()) throw Error(place_, fmt::format("xform {} lacks its argument", words_[at_]));
    return words_[++at_];
  }
  double number() {
    const std::string& text = argument();
    return rad_number(text, "a number of xform", place_);
  }
  std::size_t count() { return rad_count(argument(), "a count of xform", place_); }
  TransformDouble transform() {
    const std::string word = words_[at_];
    const auto axis = static_cast<int>(std::string_view("xyz").find(word.back()));
    if (word == "-t") {
      Vec3d by;
      for (int i = 0; i < 3; ++i) by[i] = number();
      return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, by};
    }
    if (word == "-s") {
      const double s = number();
      return {{s, 0, 0}, {0, s, 0}, {0, 0, s}, {}};
    }
    if (word == "-rx" || word == "-ry" || word == "-rz") return turn_about(axis, number());
    if (word == "-mx" || word == "-my" || word == "-mz") {
      TransformDouble out;
      (axis == 0 ? out.x : axis == 1 ? out.y : out.z)[axis] = -1;
      return out;
    }
    throw Error(place_, fmt::format("xform has no option {}", word),
                "Known: -n -m -I, then -t -rx -ry -rz -s -mx -my -mz -i -a -f, then files.");
  }

  const Words& words_;
  const FilePlace& place_;
  std::size_t at_ = 0;
};

class Copies {
 public:
  Copies(const FilePlace& place, const std::function<std::string(const std::string&)>& read_file,
         const std::function<void()>& count, const std::function<void(const RadPlacement&, const Words&)>& visit)
      : place_(place), read_file_(read_file), count_(count), visit_(visit) {}

  void expand(const Words& words, int level) {
    count_();
    if (level > kMostNested) throw Error(place_, "xform nests its -a and -f too deeply");
    const auto found =
        std::find_if(words.begin(), words.end(), [](const std::string& w) { return w == "-a" || w == "-f"; });
    if (found == words.end()) {
      CopyReader reader(words, place_);
      const RadPlacement placement = reader.placement();
      return visit_(placement, reader.files());
    }
    if (found + 1 == words.end()) throw Error(place_, fmt::format("xform {} lacks its argument", *found));
    *found == "-a" ? expand_array(words, found, level) : expand_file(words, found, level);
  }

 private:
  void expand_array(const Words& words, Words::const_iterator found, int level) {
    const std::size_t copies = rad_count(found[1], "the count of an array", place_);
    Words one = words;
    const auto at = static_cast<std::size_t>(found - words.begin());
    one[at] = "-i";
    for (std::size_t i = 0; i < copies; ++i) {
      one[at + 1] = std::to_string(i);
      expand(one, level + 1);
    }
  }

  void expand_file(const Words& words, Words::const_iterator found, int level) {
    const std::string text = read_file_(found[1]);
    for (std::string_view rest = text; !rest.empty();) {
      const std::string_view line = take_line(rest);
      if (line.find_first_not_of(" \t") == std::string_view::npos || line.starts_with('#')) continue;
      Words given = rad_pipeline(std::string(line), place_).front();
      if (given.front() == "xform" || given.front() == "!xform") given.erase(given.begin());
      Words one(words.begin(), found);
      one.insert(one.end(), given.begin(), given.end());
      one.insert(one.end(), found + 2, words.end());
      expand(one, level + 1);
    }
  }

  const FilePlace& place_;
  const std::function<std::string(const std::string&)>& read_file_;
  const std::function<void()>& count_;
  const std::function<void(const RadPlacement&, const Words&)>& visit_;
};

/// Writes a box: its eight corners are numbered by bits, 1 for x, 2 for y and 4 for z.
class BoxWriter {
 public:
  BoxWriter(const std::string& material, const std::string& name, const double (&size)[3], double edge, bool inward)
      : material_(material), name_(name), size_(size), edge_(edge), inward_(inward) {}

  std::string plain() {
    for (int axis = 0; axis < 3; ++axis)
      for (const int far : {0, 1}) face(axis, far);
    return text_;
  }
  std::string beveled() {
    plain();
    for (int axis = 0; axis < 3; ++axis)
      for (int corner = 0; corner < 8; ++corner)
        if (!(corner >> axis & 1)) bevel(axis, corner);
    for (int corner = 0; corner < 8; ++corner) {
      std::vector<Vec3d> points;
      for (int axis = 0; axis < 3; ++axis) points.push_back(on_face(corner, axis));
      polygon(points, outward(corner, {1, 1, 1}));
    }
    return text_;
  }
  std::string rounded() {
    plain();
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d from = inner(corner);
      for (int axis = 0; axis < 3; ++axis) {
        if (corner >> axis & 1) continue;
        const Vec3d to = inner(corner | 1 << axis);
        fmt::format_to(std::back_inserter(text_), "{} cylinder {}.e\n0\n0\n7 {} {} {} {} {} {} {}\n", material_, name_,
                       from.x, from.y, from.z, to.x, to.y, to.z, edge_);
      }
      fmt::format_to(std::back_inserter(text_), "{} sphere {}.c\n0\n0\n4 {} {} {} {}\n", material_, name_, from.x,
                     from.y, from.z, edge_);
    }
    return text_;
  }

 private:
  double along(int axis, bool far, double inset) const { return far ? size_[axis] - inset : inset; }
  Vec3d inner(int corner) const {
    Vec3d out;
    for (int i = 0; i < 3; ++i) out[i] = along(i, corner >> i & 1, edge_);
    return out;
  }
  /// The corner of the face across an axis.
  Vec3d on_face(int corner, int axis) const {
    Vec3d out = inner(corner);
    out[axis] = along(axis, corner >> axis & 1, 0);
    return out;
  }
  static Vec3d outward(int corner, Vec3d weights) {
    for (int i = 0; i < 3; ++i)
      if (!(corner >> i & 1)) weights[i] = -weights[i];
    return weights;
  }
  void face(int axis, int far) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::vector<Vec3d> points;
    for (const int corner : {0, 1 << u, 1 << u | 1 << v, 1 << v}) points.push_back(on_face(corner | far << axis, axis));
    Vec3d normal;
    normal[axis] = far ? 1 : -1;
    polygon(points, normal);
  }
  /// The face between the two faces at the edge from a corner along an axis.
  void bevel(int axis, int corner) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3, end = corner | 1 << axis;
    Vec3d weights{1, 1, 1};
    weights[axis] = 0;
    polygon({on_face(corner, u), on_face(end, u), on_face(end, v), on_face(corner, v)}, outward(corner, weights));
  }
  /// @param normal about where it faces
  void polygon(std::vector<Vec3d> points, Vec3d normal) {
    const Vec3d by_order = cross(points[1] - points[0], points[2] - points[0]);
    if ((dot(by_order, normal) < 0) != inward_) std::reverse(points.begin(), points.end());
    fmt::format_to(std::back_inserter(text_), "{} polygon {}.f\n0\n0\n{}", material_, name_, 3 * points.size());
    for (const Vec3d& p : points) fmt::format_to(std::back_inserter(text_), " {} {} {}", p.x, p.y, p.z);
    text_ += '\n';
  }

  const std::string &material_, &name_;
  const double (&size_)[3];
  double edge_;
  bool inward_;
  std::string text_;
};

}  // namespace

RadPlacement operator*(const RadPlacement& outer, const RadPlacement& inner) {
  return {outer.to_world * inner.to_world, outer.inverted != inner.inverted, outer.prefix + inner.prefix,
          outer.modifier.empty() ? inner.modifier : outer.modifier};
}

void for_each_rad_copy(const Words& words, const FilePlace& place,
                       const std::function<std::string(const std::string& name)>& read_file,
                       const std::function<void()>& count,
                       const std::function<void(const RadPlacement&, const Words&)>& visit) {
  Copies(place, read_file, count, visit).expand(words, 0);
}

std::string rad_box(const Words& words, const FilePlace& place) {
  constexpr const char* kForm = "Write: genbox material name xsize ysize zsize [-i] [-b bevel | -r round].";
  if (words.size() < 5) throw Error(place, "genbox lacks arguments", kForm);
  double size[3], edge = 0;
  for (std::size_t i = 0; i < 3; ++i) size[i] = rad_number(words[2 + i], "a size of genbox", place);
  bool inward = false, round = false;
  for (std::size_t i = 5; i < words.size(); ++i) {
    const bool sized = words[i] == "-r" || words[i] == "-b";
    if (words[i] == "-i") {
      inward = true;
    } else if (sized && i + 1 < words.size()) {
      round = words[i] == "-r";
      edge = rad_number(words[++i], "a size of genbox", place);
    } else {
      throw Error(place, fmt::format("genbox has no option {}", words[i]), kForm);
    }
  }
  const double least = *std::min_element(size, size + 3);
  if (!(least > 0) || edge < 0 || 2 * edge > least)
    throw Error(place, "genbox needs sizes above 0 and edges of at most half of them", kForm);
  for (const std::string& name : {words[0], words[1]})
    if (name.find_first_of(" \t\n\"'#!") != std::string::npos)
      throw Error(place, fmt::format("'{}' is no name that genbox can write", name));
  BoxWriter writer(words[0], words[1], size, edge, inward);
  return edge == 0 ? writer.plain() : round ? writer.rounded() : writer.beveled();
}

}  // namespace glowworm
