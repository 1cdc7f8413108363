#include "import/window/bsdf_xml.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/lines.h"
#include "core/parallel.h"
#include "core/text.h"
#include "import/window/tensor_tree.h"

namespace glowworm {

namespace {

constexpr std::size_t kMostPatches = 1024;
constexpr double kMostValue = 1e9;  // sr^-1; of a mirror of patches, one over their size
constexpr const char* kRemedy = "Give a file of BSDF data as WINDOW or genBSDF write it.";
/// The basis that trees are averaged over: 145 patches.
constexpr const char* kBasisOfTrees = "lbnl/klems full";

/// Reads the elements of an XML text one by one.
class XmlElements {
 public:
  XmlElements(std::string_view text, const std::string& path) : text_(without_byte_order_mark(text)), path_(path) {}

  /// The names of the elements around the place, the innermost last, and the text of the innermost in front of it.
  const std::vector<std::string_view>& open() const { return open_; }
  std::string_view text() const { return trimmed(inner_); }
  /// The line where that text begins.
  int text_line() const {
    const std::size_t blanks = std::min(inner_.find_first_not_of(" \t\r\n"), inner_.size());
    return inner_line_ +
           static_cast<int>(std::count(inner_.begin(), inner_.begin() + static_cast<std::ptrdiff_t>(blanks), '\n'));
  }
  /// Goes on to the next beginning or end of an element. Returns false at the end of the text.
  enum class Event { begin, end, none };
  Event next() {
    if (closing_) {
      open_.pop_back();
      closing_ = false;
    }
    if (self_closing_) {
      self_closing_ = false;
      closing_ = true;
      return Event::end;
    }
    for (;;) {
      const std::size_t tag = text_.find('<', at_);
      if (tag == std::string_view::npos) {
        if (!open_.empty()) fail(fmt::format("element <{}> is not closed", open_.back()));
        return Event::none;
      }
      inner_ = text_.substr(at_, tag - at_);
      inner_line_ = line_;
      move_to(tag);
      if (skipped("<!--", "-->") || skipped("<?", "?>") || skipped("<!", ">")) continue;
      return take_tag();
    }
  }
  [[noreturn]] void fail(const std::string& message) const { fail_at(line_, message); }
  [[noreturn]] void fail_at(int line, const std::string& message) const {
    throw Error({path_, line}, message, kRemedy);
  }

 private:
  void move_to(std::size_t place) {
    line_ += static_cast<int>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(at_),
                                         text_.begin() + static_cast<std::ptrdiff_t>(place), '\n'));
    at_ = place;
  }
  bool skipped(std::string_view begin, std::string_view end) {
    if (!text_.substr(at_).starts_with(begin)) return false;
    const std::size_t found = text_.find(end, at_ + begin.size());
    if (found == std::string_view::npos) fail(fmt::format("'{}' is not closed", begin));
    move_to(found + end.size());
    return true;
  }
  Event take_tag() {
    const std::size_t end = text_.find('>', at_);
    if (end == std::string_view::npos) fail("a tag is not closed");
    std::string_view tag = text_.substr(at_ + 1, end - at_ - 1);
    const bool closes = tag.starts_with('/');
    self_closing_ = tag.ends_with('/');
    tag = tag.substr(closes, tag.find_first_of(" \t\r\n/", closes) - closes);
    if (tag.empty()) fail("a tag has no name");
    if (closes) {
      if (open_.empty() || open_.back() != tag) fail(fmt::format("</{}> closes no element", tag));
      move_to(end + 1);
      self_closing_ = false;
      closing_ = true;
      return Event::end;
    }
    move_to(end + 1);
    constexpr std::size_t kMostLevels = 64;
    if (open_.size() > kMostLevels) fail("elements are nested too deeply");
    open_.push_back(tag);
    inner_ = {};
    return Event::begin;
  }

  std::string_view text_;
  const std::string& path_;
  std::size_t at_ = 0;
  int line_ = 1, inner_line_ = 1;
  std::vector<std::string_view> open_;
  std::string_view inner_;
  bool closing_ = false, self_closing_ = false;
};

using Rings = std::vector<PatchBasis::Ring>;

std::size_t patches_of(const Rings& rings) {
  std::size_t sum = 0;
  for (const PatchBasis::Ring& ring : rings) sum += static_cast<std::size_t>(ring.patches);
  return sum;
}

std::map<std::string, Rings> known_bases() {
  return {{"lbnl/klems full", {{5, 1}, {15, 8}, {25, 16}, {35, 20}, {45, 24}, {55, 24}, {65, 24}, {75, 16}, {90, 12}}},
          {"lbnl/klems half", {{6.5, 1}, {19.5, 8}, {32.5, 12}, {46.5, 16}, {61.5, 20}, {76.5, 12}, {90, 4}}},
          {"lbnl/klems quarter", {{9, 1}, {27, 8}, {46, 12}, {66, 12}, {90, 8}}}};
}

class BsdfXmlReader {
 public:
  BsdfXmlReader(std::string_view text, const std::string& path) : xml_(text, path), bases_(known_bases()) {}

  std::shared_ptr<const MeasuredBsdf> run(std::vector<std::string>& notes) {
    for (XmlElements::Event event = xml_.next(); event != XmlElements::Event::none; event = xml_.next())
      event == XmlElements::Event::begin ? begin() : end();
    if (!basis_) xml_.fail("the file has no matrix of visible light");
    auto out = std::make_shared<const MeasuredBsdf>(PatchBasis(bases_.at(*basis_)), std::move(values_));
    if (rank_ > 0)
      notes.push_back(fmt::format("its trees are averaged over the {} patches of the Klems basis",
                                  PatchBasis(bases_.at(*basis_)).size()));
    constexpr double kNotable = 0.01;
    const MeasuredBsdf::Corrections& c = out->corrections();
    if (c.asymmetry > kNotable)
      notes.push_back(
          fmt::format("its matrices are not reciprocal by {:.1f}% of the light: the mean of both directions "
                      "counts",
                      100 * c.asymmetry));
    if (c.scale < 1 - kNotable)
      notes.push_back(
          fmt::format("its matrices give {:.1f}% more light than they get, and are scaled", 100 / c.scale - 100));
    return out;
  }

 private:
  void begin() {
    const std::string_view name = xml_.open().back();
    if (xml_.open().size() == 1 && name != "WindowElement") xml_.fail("the file is not a <WindowElement>");
    if (name == "AngleBasis") {
      rings_.clear();
      basis_name_.clear();
    }
    if (name == "AngleBasisBlock") ring_ = {};
    if (name == "WavelengthDataBlock") block_ = {};
    if (name == "WavelengthData") wavelength_ = "Visible";
  }

  void end() {
    const std::string_view name = xml_.open().back(), text = xml_.text();
    if (name == "IncidentDataStructure") set_order(text);
    if (name == "AngleBasisName") basis_name_ = lower(text);
    if (name == "nPhis") ring_.patches = static_cast<int>(number(text, 1, kMostPatches));
    if (name == "UpperTheta") ring_.upper = number(text, 0, 90);
    if (name == "AngleBasisBlock") rings_.push_back(ring_);
    if (name == "AngleBasis") add_basis();
    if (name == "Wavelength") wavelength_ = text;
    if (name == "WavelengthDataDirection") block_.direction = lower(text);
    if (name == "ColumnAngleBasis") block_.columns = lower(text);
    if (name == "RowAngleBasis") block_.rows = lower(text);
    if (name == "ScatteringData") {
      block_.data = text;
      block_.line = xml_.text_line();
    }
    if (name == "WavelengthDataBlock" && lower(wavelength_) == "visible") add_block();
  }

  void set_order(std::string_view text) {
    const std::string order = lower(text);
    if (order == "tensortree3" || order == "tensortree4") {
      rank_ = order.back() - '0';
      return;
    }
    by_rows_ = order == "rows";
    if (!by_rows_ && order != "columns") xml_.fail(fmt::format("unknown IncidentDataStructure '{}'", text));
  }

  double number(std::string_view text, double least, double most) const {
    double value = 0;
    std::string_view rest = text;
    if (!take_number(rest, value) || !rest.empty() || !(value >= least && value <= most))
      xml_.fail(fmt::format("'{}' is not a number from {:g} to {:g}", text, least, most));
    return value;
  }

  void add_basis() {
    if (rings_.empty() || bases_.contains(basis_name_)) return;
    double before = 0;
    for (const PatchBasis::Ring& ring : rings_) {
      if (!(ring.upper > before)) xml_.fail("the rings of the basis do not follow one another");
      if (ring.patches > 1 && ring.patches % 2 == 1)
        xml_.fail(fmt::format("rings of {} patches are not supported: their number must be even", ring.patches));
      before = ring.upper;
    }
    if (before != 90) xml_.fail("the basis does not end at 90 degrees");
    if (rings_.size() > 255 || patches_of(rings_) > kMostPatches) xml_.fail("the basis has too many patches");
    bases_[basis_name_] = rings_;
  }

  /// A matrix as the file has it.
  struct Block {
    std::string direction, columns, rows;
    std::string_view data;
    int line = 0;
  };

  void add_block() {
    if (rank_ > 0) block_.columns = block_.rows = kBasisOfTrees;
    const auto known = bases_.find(block_.columns);
    if (known == bases_.end()) xml_.fail(fmt::format("unknown basis '{}'", block_.columns));
    if (block_.rows != block_.columns) xml_.fail("light that comes and light that goes have different bases");
    if (basis_ && *basis_ != block_.columns) xml_.fail("the matrices have different bases");
    basis_ = block_.columns;
    const PatchBasis basis(known->second);
    const std::size_t n = basis.size();
    const std::vector<float> data = rank_ > 0 ? matrix_of_tree(tree(), basis) : matrix(n * n);
    // The front here is WINDOW's back. A matrix has the way of the light that comes, which is opposite to where it is.
    const bool reflects = block_.direction.starts_with("reflection");
    const bool from_front = block_.direction.ends_with(" back");
    if (!reflects && !block_.direction.starts_with("transmission"))
      xml_.fail(fmt::format("unknown WavelengthDataDirection '{}'", block_.direction));
    std::vector<float>& out = reflects     ? from_front ? values_.front : values_.back
                              : from_front ? values_.backwards
                                           : values_.onwards;
    out.assign(n * n, 0);
    for (std::size_t o = 0; o < n; ++o)
      for (std::size_t i = 0; i < n; ++i) {
        const float value = by_rows_ ? data[i * n + o] : data[o * n + i];
        const std::size_t from = basis.opposite(i);
        // Transmission is by the patches in front and behind.
        (!reflects && from_front ? out[from * n + o] : out[o * n + from]) = value;
      }
  }

  TensorTree tree() const {
    try {
      return TensorTree(block_.data, rank_, kMostValue);
    } catch (const Error& error) {
      xml_.fail_at(block_.line, error.what());
    }
  }

  std::vector<float> matrix(std::size_t count) const {
    std::vector<float> out;
    out.reserve(count);
    std::string_view rest = block_.data;
    constexpr std::string_view kBetween = " \t\r\n,";
    for (rest = rest.substr(std::min(rest.find_first_not_of(kBetween), rest.size())); !rest.empty();
         rest = rest.substr(std::min(rest.find_first_not_of(kBetween), rest.size()))) {
      double value = 0;
      const std::string_view word = rest.substr(0, rest.find_first_of(kBetween));
      if (!take_number(rest, value) || !(std::abs(value) <= kMostValue))
        xml_.fail_at(
            block_.line + static_cast<int>(std::count(block_.data.begin(), word.begin(), '\n')),
            fmt::format("the matrix '{}' holds '{}', which is no number", block_.direction, word.substr(0, 40)));
      out.push_back(std::max(static_cast<float>(value), 0.0f));
      if (out.size() > count) break;
    }
    if (out.size() != count)
      xml_.fail(fmt::format("the matrix '{}' has {} numbers, but its basis needs {}", block_.direction,
                            out.size() > count ? "more" : std::to_string(out.size()), count));
    return out;
  }

  XmlElements xml_;
  std::map<std::string, Rings> bases_;
  Rings rings_;
  PatchBasis::Ring ring_;
  std::string basis_name_;
  std::string_view wavelength_ = "Visible";
  bool by_rows_ = false;
  int rank_ = 0;  // of tensor trees; 0: matrices
  Block block_;
  std::optional<std::string> basis_;
  MeasuredBsdf::Values values_;
};

}  // namespace

std::uint64_t bsdf_bytes(std::string_view text) {
  // A number of two letters becomes eight floats: values and sums of two sides, reflected and passed.
  // Trees, which may be short, become matrices of 145 patches.
  constexpr std::uint64_t kOfTrees = 145 * 145 * 10 * sizeof(float);
  return text.size() * 8 * sizeof(float) / 2 + kOfTrees;
}

std::shared_ptr<const MeasuredBsdf> parse_bsdf_xml(std::string_view text, const std::string& path,
                                                   std::vector<std::string>& notes) {
  return BsdfXmlReader(text, path).run(notes);
}

}  // namespace glowworm
