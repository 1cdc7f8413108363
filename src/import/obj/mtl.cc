#include "import/obj/mtl.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "core/parallel.h"
#include "core/text.h"
#include "import/obj/lines.h"

namespace glowworm {

namespace {

class MtlParser {
 public:
  explicit MtlParser(NoteCounter& notes) : notes_(notes) {}

  std::vector<PhongMaterial> run(std::string_view text) {
    LineReader lines(text);
    while (lines.next()) {
      if (lines.number() % 1024 == 0) check_cancelled();
      std::string_view rest = lines.line();
      const std::string_view key = next_word(rest);
      if (key == "newmtl") {
        materials_.emplace_back().name = trimmed(rest);
        has_emission_ = false;
      } else if (!key.empty() && !materials_.empty()) {  // lines before the first material are ignored
        visit(key, rest, materials_.back());
      }
    }
    return std::move(materials_);
  }

 private:
  void visit(std::string_view key, std::string_view rest, PhongMaterial& m) {
    const std::string known = lower(key);
    if (known == "kd") {
      color(key, rest, m.diffuse);
    } else if (known == "ks") {
      color(key, rest, m.specular);
    } else if (known == "ke") {
      color(key, rest, m.emissive);
      has_emission_ = true;
    } else if (known == "tf") {
      color(key, rest, m.filter);
    } else if (known == "ns") {
      number(key, rest, m.exponent);
    } else if (known == "ni") {
      number(key, rest, m.ior);
    } else if (known == "d") {
      std::string_view after = rest;
      number(key, next_word(after) == "-halo" ? after : rest, m.opacity);
    } else if (known == "tr") {
      float transparency = 1 - m.opacity;
      number(key, rest, transparency);
      m.opacity = 1 - transparency;
    } else if (known == "illum") {
      float model = static_cast<float>(m.model);
      number(key, rest, model);
      m.model = model >= 0 && model <= 10 ? static_cast<int>(model) : -1;
    } else if (known == "pr") {
      number(key, rest, m.roughness.emplace(1.0f));
    } else if (known == "pm") {
      number(key, rest, m.metallic.emplace(0.0f));
    } else if (known == "pc" || known == "pcr" || known == "ps" || known == "aniso" || known == "anisor") {
      float amount = 0;
      number(key, rest, amount);
      if (amount != 0) not_supported(key);
    } else {
      visit_map(key, known, rest, m);
    }
  }

  void visit_map(std::string_view key, std::string_view known, std::string_view rest, PhongMaterial& m) {
    static constexpr std::string_view kUnsupported[] = {"map_bump", "bump",   "disp",    "map_disp", "decal",
                                                        "refl",     "map_ks", "map_ns",  "map_pr",   "map_pm",
                                                        "map_tr",   "map_pc", "map_pcr", "map_ps"};
    if (known == "map_kd") {
      texture(rest, m.diffuse_map);
    } else if (known == "map_d") {
      texture(rest, m.opacity_map);
    } else if (known == "map_ke" || known == "map_emissive") {
      texture(rest, m.emissive_map);
      if (!has_emission_) m.emissive = RGB(1.0f);
    } else if (known == "norm" || known == "map_kn") {
      texture(rest, m.normal_map);
    } else if (std::find(std::begin(kUnsupported), std::end(kUnsupported), known) != std::end(kUnsupported)) {
      not_supported(key);
    }
  }

  void not_supported(std::string_view key) { notes_.add(fmt::format("MTL '{}' is not supported, left out", key)); }

  /// Parses a number. If it is invalid, keeps the old value and adds a note.
  void number(std::string_view key, std::string_view rest, float& value) {
    const auto found = number_of(next_word(rest));
    if (found) {
      value = *found;
    } else {
      notes_.add(fmt::format("MTL '{}' without a number, left out", key));
    }
  }

  /// A single number sets all three channels.
  void color(std::string_view key, std::string_view rest, RGB& value) {
    const auto r = number_of(next_word(rest));
    if (!r) return notes_.add(fmt::format("MTL '{}' without a number, left out", key));
    const auto g = number_of(next_word(rest)), b = number_of(next_word(rest));
    value = {*r, g.value_or(*r), b.value_or(g.value_or(*r))};
  }

  void texture(std::string_view rest, PhongTexture& out) {
    out = {};
    for (std::string_view after = rest; !after.empty(); rest = after) {
      const std::string_view option = next_word(after);
      if (option.size() < 2 || option.front() != '-') break;
      if (option == "-o" || option == "-s" || option == "-t" || option == "-mm") {
        notes_.add(fmt::format("MTL texture option '{}' is not supported, left out", option));
        skip_numbers(after, option == "-mm" ? 2 : 3);
      } else {
        const std::string_view value = next_word(after);
        if (option == "-imfchan") notes_.add("MTL texture option '-imfchan' is not supported, left out");
        if (option == "-clamp" && value == "on") out.wrap_u = out.wrap_v = TextureWrap::clamp;
      }
    }
    out.name = trimmed(rest);
  }

  static void skip_numbers(std::string_view& rest, int most) {
    for (std::string_view after = rest; most > 0 && number_of(next_word(after)); --most) rest = after;
  }

  NoteCounter& notes_;
  std::vector<PhongMaterial> materials_;
  bool has_emission_ = false;  ///< the last material has a Ke
};

}  // namespace

std::vector<PhongMaterial> parse_mtl(std::string_view text, NoteCounter& notes) { return MtlParser(notes).run(text); }

}  // namespace glowworm
