#include "import/obj/mtl.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/parallel.h"
#include "core/text.h"
#include "import/obj/lines.h"

namespace glowworm {

namespace {

/// Options of textures, and how many values at most follow each.
struct TextureOption {
  std::string_view name;
  int values;
};
constexpr TextureOption kTextureOptions[] = {{"-s", 3},      {"-o", 3},      {"-t", 3},       {"-mm", 2},
                                             {"-clamp", 1},  {"-blendu", 1}, {"-blendv", 1},  {"-boost", 1},
                                             {"-texres", 1}, {"-bm", 1},     {"-imfchan", 1}, {"-cc", 1}};

const TextureOption* option_of(std::string_view word) {
  const auto found = std::find_if(std::begin(kTextureOptions), std::end(kTextureOptions),
                                  [&](const TextureOption& option) { return option.name == word; });
  return found == std::end(kTextureOptions) ? nullptr : found;
}

/// Whether a word is a value of an option: a number, a switch, or the letter of a channel.
bool is_value(const TextureOption& option, std::string_view word) {
  return number_of(word) || word == "on" || word == "off" || (option.name == "-imfchan" && word.size() == 1);
}

class MtlParser {
 public:
  explicit MtlParser(NoteCounter& notes) : notes_(notes) {}

  std::vector<PhongMaterial> run(std::string_view text) {
    LineReader lines(text);
    while (lines.next()) {
      if (lines.number() % 1024 == 0) check_cancelled();
      std::string_view rest = lines.line();
      const std::string_view key = take_word(rest);
      if (key == "newmtl") {
        finish();
        materials_.emplace_back().name = name_of(rest);
      } else if (!key.empty() && !materials_.empty()) {  // lines before the first material are ignored
        visit(key, rest, materials_.back());
      }
    }
    finish();
    return std::move(materials_);
  }

 private:
  /// What a material says, beside the values themselves.
  struct Given {
    bool diffuse = false, emission = false;
    std::optional<float> dissolve, transparency;
  };

  /// Resolves what depends on several lines of the last material, which come in any order.
  void finish() {
    const Given given = std::exchange(given_, {});
    if (materials_.empty()) return;
    PhongMaterial& m = materials_.back();
    if (!given.diffuse && !m.diffuse_map.name.empty()) m.diffuse = RGB(1.0f);
    if (!given.emission && !m.emissive_map.name.empty()) m.emissive = RGB(1.0f);
    if (given.dissolve) {
      m.opacity = *given.dissolve;
    } else if (given.transparency) {
      // Nobody writes a material that cannot be seen: some programs write 1 for opaque. Glass is clear in any case.
      const bool opaque = *given.transparency >= 1 && !is_glass_model(m.model);
      if (opaque) notes_.add("MTL 'Tr' of 1 without 'd': taken as opaque");
      m.opacity = opaque ? 1 : 1 - *given.transparency;
    }
  }

  /// Whether an illumination model lets light through.
  static bool is_glass_model(int model) { return model == 4 || model == 6 || model == 7 || model == 9; }

  void visit(std::string_view key, std::string_view rest, PhongMaterial& m) {
    static const std::map<std::string_view, RGB PhongMaterial::*> kColors = {{"kd", &PhongMaterial::diffuse},
                                                                             {"ks", &PhongMaterial::specular},
                                                                             {"ke", &PhongMaterial::emissive},
                                                                             {"tf", &PhongMaterial::filter}};
    const std::string known = lower(key);
    given_.diffuse |= known == "kd";
    given_.emission |= known == "ke";
    if (const auto found = kColors.find(known); found != kColors.end()) {
      color(key, rest, m.*found->second);
    } else if (known == "ns") {
      number(key, rest, m.exponent);
    } else if (known == "ni") {
      number(key, rest, m.ior);
    } else if (known == "d") {
      std::string_view after = rest;
      number(key, take_word(after) == "-halo" ? after : rest, given_.dissolve.emplace(1.0f));
    } else if (known == "tr") {
      number(key, rest, given_.transparency.emplace(0.0f));
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
    } else if (known == "norm" || known == "map_kn") {
      texture(rest, m.normal_map);
    } else if (std::find(std::begin(kUnsupported), std::end(kUnsupported), known) != std::end(kUnsupported)) {
      not_supported(key);
    }
  }

  void not_supported(std::string_view key) { notes_.add(fmt::format("MTL '{}' is not supported, left out", key)); }

  /// Parses a number. If it is invalid, keeps the old value and adds a note.
  void number(std::string_view key, std::string_view rest, float& value) {
    const auto found = float_of(take_word(rest));
    if (found) {
      value = *found;
    } else {
      notes_.add(fmt::format("MTL '{}' without a number, left out", key));
    }
  }

  /// A single number sets all three channels.
  void color(std::string_view key, std::string_view rest, RGB& value) {
    const auto r = float_of(take_word(rest));
    if (!r) return notes_.add(fmt::format("MTL '{}' without a number, left out", key));
    const auto g = float_of(take_word(rest)), b = float_of(take_word(rest));
    value = {*r, g.value_or(*r), b.value_or(g.value_or(*r))};
  }

  /// Reads a texture: options, its name, and options again. The name may hold blanks, and need no quotes then.
  void texture(std::string_view rest, PhongTexture& out) {
    out = {};
    take_options(rest, out);
    rest = trimmed(rest);
    if (rest.starts_with('"')) {
      out.name = next_name(rest);
    } else {
      std::string_view behind = rest;
      while (!behind.empty() && !begins_with_option(behind)) take_word(behind);
      out.name = trimmed(rest.substr(0, rest.size() - behind.size()));
      rest = behind;
    }
    take_options(rest, out);
  }

  static bool begins_with_option(std::string_view text) {
    const TextureOption* option = option_of(take_word(text));
    return option && is_value(*option, take_word(text));
  }

  void take_options(std::string_view& rest, PhongTexture& out) {
    for (std::string_view after = rest; const TextureOption* option = option_of(take_word(after)); rest = after)
      take_values(*option, after, out);
  }

  /// Reads the values behind an option.
  void take_values(const TextureOption& option, std::string_view& rest, PhongTexture& out) {
    std::string_view words[3];
    int count = 0;
    for (std::string_view after = rest; count < option.values && is_value(option, words[count] = take_word(after));
         ++count)
      rest = after;
    const auto number = [&](int i, float otherwise) {
      const float found = i < count ? float_of(words[i]).value_or(otherwise) : otherwise;
      return std::isfinite(found) ? found : otherwise;
    };
    if (option.name == "-s") {
      out.scale = {number(0, 1), number(1, number(0, 1))};
    } else if (option.name == "-o") {
      out.offset = {number(0, 0), number(1, 0)};
    } else if (option.name == "-mm") {
      out.base = number(0, 0);
      out.gain = number(1, 1);
    } else if (option.name == "-clamp") {
      if (count == 1 && words[0] == "on") out.wrap_u = out.wrap_v = TextureWrap::clamp;
    } else if (option.name == "-t" || option.name == "-imfchan") {
      notes_.add(fmt::format("MTL texture option '{}' is not supported, left out", option.name));
    }
  }

  NoteCounter& notes_;
  std::vector<PhongMaterial> materials_;
  Given given_;  ///< by the last material
};

}  // namespace

std::vector<PhongMaterial> parse_mtl(std::string_view text, NoteCounter& notes) { return MtlParser(notes).run(text); }

}  // namespace glowworm
