#include "import/rad/materials.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "core/content_hash.h"
#include "import/material_text.h"
#include "import/mesh_tools.h"
#include "import/window/bsdf_xml.h"

namespace glowworm {

namespace {

/// What becomes of a type.
enum class Treatment { pattern, alias, light, mixture, clear, measured, surface };

struct RadType {
  std::string_view name;
  Treatment treatment;
  std::size_t least_numbers = 0, most_numbers = std::numeric_limits<std::size_t>::max();
  std::string_view stand_in = {};  ///< what takes its place, for the note
};

constexpr RadType kTypes[] = {
    {"alias", Treatment::alias},
    {"plastic", Treatment::surface, 5, 5},
    {"metal", Treatment::surface, 5, 5},
    {"trans", Treatment::surface, 7, 7},
    {"plastic2", Treatment::surface, 6, 6},
    {"metal2", Treatment::surface, 6, 6},
    {"trans2", Treatment::surface, 8, 8},
    {"glass", Treatment::surface, 3, 4},
    {"dielectric", Treatment::surface, 5, 5},
    {"interface", Treatment::surface, 8, 8},
    {"mirror", Treatment::surface, 3, 3},
    {"light", Treatment::light, 3, 3},
    {"glow", Treatment::light, 4, 4},
    {"spotlight", Treatment::light, 7, 7},
    {"illum", Treatment::light, 3, 3},
    {"mixfunc", Treatment::mixture},
    {"mixdata", Treatment::mixture},
    {"mixpict", Treatment::mixture},
    {"mixtext", Treatment::mixture},
    {"texfunc", Treatment::pattern},
    {"texdata", Treatment::pattern},
    {"colorfunc", Treatment::pattern},
    {"brightfunc", Treatment::pattern},
    {"colordata", Treatment::pattern},
    {"brightdata", Treatment::pattern},
    {"colorpict", Treatment::pattern},
    {"colortext", Treatment::pattern},
    {"brighttext", Treatment::pattern},
    {"spectrum", Treatment::pattern},
    {"specfile", Treatment::pattern},
    {"specfunc", Treatment::pattern},
    {"specdata", Treatment::pattern},
    {"specpict", Treatment::pattern},
    {"plasfunc", Treatment::surface, 4, 1000, "diffuse in its colour"},
    {"plasdata", Treatment::surface, 4, 1000, "diffuse in its colour"},
    {"metfunc", Treatment::surface, 4, 1000, "diffuse in its colour"},
    {"metdata", Treatment::surface, 4, 1000, "diffuse in its colour"},
    {"ashik2", Treatment::surface, 8, 8, "diffuse in its colour"},
    {"WGMDfunc", Treatment::surface, 0, 1000, "diffuse with a reflectance of 0.5"},
    {"transfunc", Treatment::surface, 6, 1000, "diffuse reflection and transmission"},
    {"transdata", Treatment::surface, 6, 1000, "diffuse reflection and transmission"},
    {"BRTDfunc", Treatment::surface, 9, 1000, "diffuse reflection and transmission"},
    {"BSDF", Treatment::measured, 0, 9},
    {"aBSDF", Treatment::measured, 0, 9},
    {"prism1", Treatment::clear, 0, 1000, "clear: light passes straight"},
    {"prism2", Treatment::clear, 0, 1000, "clear: light passes straight"},
    {"mist", Treatment::clear, 0, 1000, "clear: light passes straight"},
    {"antimatter", Treatment::clear, 0, 1000, "clear: light passes straight"},
};

const RadType* type_of(const std::string& name) {
  const auto* const found =
      std::find_if(std::begin(kTypes), std::end(kTypes), [&](const RadType& type) { return type.name == name; });
  return found == std::end(kTypes) ? nullptr : found;
}

RGB color(const RadPrimitive& p, std::size_t first = 0) {
  const auto at = [&](std::size_t i) { return static_cast<float>(p.numbers[first + i]); };
  return {at(0), at(1), at(2)};
}

float share(double value) { return static_cast<float>(std::clamp(value, 0.0, 1.0)); }

/// Gives a metallic_roughness material a specular lobe whose reflectance is `level` times `tint` in all directions.
void set_level(Material& m, float level, RGB tint) {
  constexpr float kWhole = 25;  // times the 4% of an index of 1.5: all
  m.ior = 1.5f;
  m.specular.value = level;
  m.specular_color.value = tint * kWhole;
}

/// The specular lobe of plastic and trans.
void set_specular(Material& m, float level, float roughness) {
  constexpr float kFresnel = 0.018f;  // normal.c: smooth surfaces that reflect less have no Fresnel term
  set_level(m, level, RGB(1.0f));
  if (roughness > 1e-3f || level < kFresnel) return;
  m.specular_color.value *= level;
  m.specular.value = 1;
}

Material plain(RGB reflectance, RGB transmittance = RGB(0.0f)) {
  Material m;
  m.kind = MaterialKind::diffuse;
  m.reflectance.value = clamp(reflectance, 0, 1);
  m.transmittance.value = clamp(transmittance, 0, 1);
  return m;
}

Material glossy(RGB reflectance, float roughness) {
  Material m;
  m.kind = MaterialKind::metallic_roughness;
  m.reflectance.value = clamp(reflectance, 0, 1);
  m.roughness_u.value = m.roughness_v.value = roughness;
  return m;
}

Material plastic(RGB reflectance, float specular, float roughness) {
  if (specular == 0) return plain(reflectance);
  Material m = glossy(reflectance, roughness);
  set_specular(m, specular, roughness);
  return m;
}

Material metal(RGB reflectance, float specular, float roughness) {
  if (specular == 0) return plain(reflectance);
  Material m = glossy(reflectance, roughness);
  m.metallic.value = specular;
  m.specular.value = 0;
  return m;
}

Material trans(RGB reflectance, float specular, float roughness, float passes, float straight) {
  if (specular == 0 && (passes == 0 || straight == 0)) return plain(reflectance * (1 - passes), reflectance * passes);
  Material m = glossy(reflectance, roughness);
  set_specular(m, specular, roughness);
  m.thin = true;
  m.transmission.value = passes * straight;
  m.transmittance.value = m.reflectance.value;
  const float scattered = 1 - passes * straight;
  m.diffuse_transmission.value = scattered > 0 ? share(passes * (1 - straight) / scattered) : 0;
  return m;
}

/// The sky of a brightfunc that gensky or gendaylit writes, by skybright.cal and perezlum.cal. The horizon is sharp,
/// where these blend sky and ground over some degrees.
std::optional<SkyModel> sky_pattern(const RadPrimitive& p, const RadPlacement& placement) {
  if (p.type != "brightfunc" || p.words.size() != 2) return std::nullopt;
  const std::string file = p.words[1].substr(p.words[1].find_last_of('/') + 1);
  const auto number = [&](std::size_t i) { return static_cast<float>(p.numbers[i]); };
  SkyModel sky;
  sky.c = 0, sky.offset = 0;
  const auto set_sun = [&](std::size_t first) {
    const Vec3 sun = narrow(placement.to_world.vector({p.numbers[first], p.numbers[first + 1], p.numbers[first + 2]}));
    if (!(length(sun) > 0)) throw Error(p.place, "the sun of the sky has no direction");
    sky.sun = y_up_from_z_up(normalize(sun));
  };
  if (file == "perezlum.cal" && p.numbers.size() == 10) {
    sky.zenith = number(0), sky.ground = number(1);
    sky.a = number(2), sky.b = std::min(number(3), 0.0f), sky.c = number(4), sky.d = number(5), sky.e = number(6);
    set_sun(7);
    return sky;
  }
  if (file != "skybright.cal" || (p.numbers.size() != 3 && p.numbers.size() != 7)) return std::nullopt;
  const double kind = p.numbers[0];
  sky.zenith = number(1), sky.ground = number(2);
  if (kind == 1 && p.numbers.size() == 7) {  // clear
    if (!(number(3) > 0)) throw Error(p.place, "the clear sky has no factor above 0");
    constexpr float kBase = 0.91f;
    sky.a = -1, sky.b = -0.32f, sky.c = 10 / kBase, sky.d = -3, sky.e = 0.45f / kBase;
    sky.zenith *= kBase / number(3);
    set_sun(4);
    return sky;
  }
  if (kind == 2) {  // overcast
    sky.linear = 2;
    sky.zenith /= 3;
    return sky;
  }
  return kind == 3 ? std::optional(sky) : std::nullopt;
}

}  // namespace

void RadMaterials::Trace::add(const Trace& part) {
  for (const auto& [name, index] : part.needed)
    if (!defined.contains(name)) needed.emplace(name, index);
  for (const auto& [name, index] : part.defined) defined[name] = index;
}

bool RadMaterials::fits(const Trace& trace) const {
  return std::all_of(trace.needed.begin(), trace.needed.end(), [&](const auto& needed) {
    const auto found = by_name_.find(needed.first);
    return needed.second == (found == by_name_.end() ? kNone : found->second);
  });
}

bool RadMaterials::define_as(const Trace& trace) {
  for (const auto& [name, index] : trace.defined)
    if (const RadModifier& m = modifiers_[index]; m.turns || m.spot || m.sky) return false;
  for (const auto& [name, index] : trace.defined) set_name(name, index);
  return true;
}

std::uint32_t RadMaterials::find(const std::string& name) const {
  const auto found = by_name_.find(name);
  const std::uint32_t index = found == by_name_.end() ? kNone : found->second;
  if (trace_ && !trace_->defined.contains(name)) trace_->needed.emplace(name, index);
  return index;
}

std::uint32_t RadMaterials::index_of(const std::string& name, const FilePlace& place) const {
  if (name == "void") return kNone;
  const std::uint32_t found = find(name);
  if (found == kNone)
    throw Error(place, fmt::format("modifier '{}' is not defined before this line", name),
                "Put its definition in front, or include the file that has it by !xform.");
  return found;
}

RadModifier RadMaterials::on_surface(const std::string& name, const FilePlace& place) const {
  std::uint32_t at = index_of(name, place);
  while (at != kNone && modifiers_[at].is_pattern) at = modifiers_[at].below;
  return at == kNone ? RadModifier() : modifiers_[at];
}

std::optional<SkyModel> RadMaterials::sky_of(const std::string& name, const FilePlace& place) const {
  for (std::uint32_t at = index_of(name, place); at != kNone; at = modifiers_[at].below)
    if (modifiers_[at].sky) return modifiers_[at].sky;
  return std::nullopt;
}

void RadMaterials::set_name(const std::string& name, std::uint32_t index) {
  by_name_[name] = index;
  if (trace_) trace_->defined[name] = index;
}

bool RadMaterials::define(const RadPrimitive& p, const RadPlacement& placement) {
  const RadType* const type = type_of(p.type);
  if (!type) return false;
  if (p.type == "alias") {
    const std::uint32_t same = index_of(p.alias_of, p.place);
    if (p.modifier != "inherit") index_of(p.modifier, p.place);
    if (same == kNone) throw Error(p.place, fmt::format("alias '{}' stands for void", p.name));
    set_name(p.name, same);
    return true;
  }
  if (p.numbers.size() < type->least_numbers || p.numbers.size() > type->most_numbers)
    throw Error(p.place, fmt::format("{} '{}' has {} numbers", p.type, p.name, p.numbers.size()),
                type->least_numbers == type->most_numbers
                    ? fmt::format("Expected: {}.", type->least_numbers)
                    : fmt::format("Expected: {} to {}.", type->least_numbers, type->most_numbers));
  const std::uint32_t below = index_of(p.modifier, p.place);
  const TransformDouble& m = placement.to_world;
  const bool turns =
      type->treatment == Treatment::measured || p.type == "spotlight" || sky_pattern(p, placement).has_value();
  const std::string turned =
      turns ? fmt::format(" {} {} {} {} {} {} {} {} {}", m.x.x, m.x.y, m.x.z, m.y.x, m.y.y, m.y.z, m.z.x, m.z.y, m.z.z)
            : "";
  std::string parts;  // what its words mean here
  if (type->treatment == Treatment::mixture || p.type == "illum")
    for (const std::string& word : p.words)
      if (const std::uint32_t known = find(word); known != kNone) parts += fmt::format(" {}", known);
  if (type->treatment == Treatment::measured) parts += " " + p.place.file;  // its file is looked for beside that
  const std::string text = fmt::format("{} {} {}\n{}\n{}{}{}", below, p.type, p.name, fmt::join(p.words, "\n"),
                                       fmt::join(p.numbers, " "), turned, parts);
  const auto next = static_cast<std::uint32_t>(modifiers_.size());
  const auto [known, fresh] = by_text_.try_emplace(text, next);
  if (fresh) {
    held_.grow(material_bytes() + 4 * text.size() + sizeof(RadModifier));
    RadModifier made = make(p, placement);
    made.below = below;
    modifiers_.push_back(std::move(made));
  }
  set_name(p.name, known->second);
  return true;
}

RadModifier RadMaterials::make(const RadPrimitive& p, const RadPlacement& placement) {
  const RadType& type = *type_of(p.type);
  RadModifier out;
  switch (type.treatment) {
    case Treatment::pattern:
      out.is_pattern = true;
      out.sky = sky_pattern(p, placement);
      if (!out.sky) notes_.add(fmt::format("{} '{}' is not read: it changes nothing", p.type, p.name));
      return out;
    case Treatment::light:
      out = glowing(p);
      if (p.type == "spotlight") {
        const Vec3 along = narrow(placement.to_world.vector({p.numbers[4], p.numbers[5], p.numbers[6]}));
        if (!(length(along) > 0)) throw Error(p.place, fmt::format("spotlight '{}' has no direction", p.name));
        const double half = std::clamp(p.numbers[3] / 2, 0.0, 180.0) * M_PI / 180;
        out.spot = RadSpot{static_cast<float>(std::cos(half)), normalize(along)};
      }
      return out;
    case Treatment::mixture:
      return mixed(p);
    case Treatment::measured:
      out = made_of(p, measured(p, placement));
      out.turns = true;
      return out;
    case Treatment::clear:
    case Treatment::surface:
    case Treatment::alias:
      break;
  }
  if (!type.stand_in.empty())
    notes_.add(fmt::format("material '{}' of type {} is not supported: {}", p.name, p.type, type.stand_in));
  return type.treatment == Treatment::clear ? out : made_of(p, material_of(p));
}

RadModifier RadMaterials::made_of(const RadPrimitive& p, Material material) {
  RadModifier out;
  material.name = p.name;
  out.material = add_material(std::move(material));
  return out;
}

std::uint32_t RadMaterials::add_material(Material material) {
  description_.materials.push_back(std::move(material));
  return static_cast<std::uint32_t>(description_.materials.size() - 1);
}

RadModifier RadMaterials::glowing(const RadPrimitive& p) {
  if (p.type == "illum") {
    notes_.add(
        fmt::format("illum '{}': its surfaces are what it stands for; the light comes from what is behind", p.name));
    return p.words.empty() ? RadModifier() : on_surface(p.words[0], p.place);
  }
  RadModifier out = made_of(p, plain(RGB(0.0f)));
  out.radiance = color(p);
  if (is_black(out.radiance) || p.type == "spotlight") return out;
  Emission emission;
  emission.name = p.name;
  emission.radiance.value = out.radiance;
  out.emission = static_cast<std::uint32_t>(description_.emissions.size());
  description_.emissions.push_back(std::move(emission));
  return out;
}

RadModifier RadMaterials::mixed(const RadPrimitive& p) {
  if (p.words.size() < 2) throw Error(p.place, fmt::format("{} '{}' lacks the names of two modifiers", p.type, p.name));
  float amount = 0.5f;
  const std::string_view function = p.type == "mixfunc" && p.words.size() > 2 ? std::string_view(p.words[2]) : "";
  if (const std::optional<double> given = rad_number(function))
    amount = share(*given);
  else
    notes_.add(fmt::format("{} '{}': its function is not read, and both parts count half", p.type, p.name));
  const RadModifier front = on_surface(p.words[0], p.place), back = on_surface(p.words[1], p.place);
  if (front.material == kNone && back.material == kNone) return {};
  if (front.material == kNone || back.material == kNone) {
    // A part without a surface lets rays pass.
    Material one = description_.materials[front.material == kNone ? back.material : front.material];
    one.alpha.value *= front.material == kNone ? 1 - amount : amount;
    RadModifier out = made_of(p, std::move(one));
    out.turns = front.turns || back.turns;
    return out;
  }
  if (front.emission != kNone || back.emission != kNone)
    notes_.add(fmt::format("{} '{}' mixes a light, which gives no light", p.type, p.name));
  Material m;
  m.kind = MaterialKind::mix;
  m.mix_a = back.material, m.mix_b = front.material;
  m.mix_amount.value = amount;
  RadModifier out = made_of(p, std::move(m));
  out.turns = front.turns || back.turns;
  return out;
}

Material RadMaterials::material_of(const RadPrimitive& p) {
  const std::string& type = p.type;
  const auto at = [&](std::size_t i) { return share(p.numbers[i]); };
  if (type == "plastic") return plastic(color(p), at(3), at(4));
  if (type == "metal") return metal(color(p), at(3), at(4));
  if (type == "trans") return trans(color(p), at(3), at(4), at(5), at(6));
  if (type == "plastic2" || type == "metal2" || type == "trans2") {
    if (at(4) != at(5))
      notes_.add(fmt::format("{} '{}': roughness is the same in all directions, the mean of both", type, p.name));
    const float mean = std::sqrt(at(4) * at(5));
    if (type == "plastic2") return plastic(color(p), at(3), mean);
    if (type == "metal2") return metal(color(p), at(3), mean);
    return trans(color(p), at(3), mean, at(6), at(7));
  }
  if (type == "glass" || type == "dielectric" || type == "interface") return dielectric(p);
  if (type == "mirror") {
    const RGB tint = clamp(color(p), 0, 1);
    const float level = max_component(tint);
    Material m = glossy(RGB(0.0f), 0);
    set_level(m, level, level > 0 ? tint / level : tint);
    return m;
  }
  if (type == "transfunc" || type == "transdata") return trans(color(p), 0, 0, at(4), 0);
  if (type == "BRTDfunc") return plain(color(p), color(p, 6));
  return p.numbers.size() < 4 ? plain(RGB(0.5f)) : plain(color(p));
}

Material RadMaterials::dielectric(const RadPrimitive& p) {
  Material m;
  m.reflectance.value = m.transmittance.value = RGB(1.0f);
  const auto index = [&](std::size_t i) {
    const double n = p.numbers[i];
    if (n < 1e-3 || n > 1e3) throw Error(p.place, fmt::format("{} '{}' has an index of {:g}", p.type, p.name, n));
    return n;
  };
  if (p.type == "glass") {
    m.kind = MaterialKind::thin_dielectric;
    m.transmittance.value = clamp(color(p), 0, 1);
    m.ior = static_cast<float>(p.numbers.size() > 3 ? index(3) : 1.52);
    return m;
  }
  m.kind = MaterialKind::dielectric;
  const std::uint32_t inside = medium_of(color(p), p.name);
  if (p.type == "dielectric") {
    m.ior = static_cast<float>(index(3));
    if (p.numbers[4] != 0) notes_.add(fmt::format("dielectric '{}': all colours have one index", p.name));
    if (inside != kNone) m.inside = inside;
    return m;
  }
  const std::uint32_t outside = medium_of(color(p, 4), p.name);
  m.ior = static_cast<float>(index(3) / index(7));
  if (inside != kNone || outside != kNone) m.inside = inside, m.outside = outside;
  return m;
}

Material RadMaterials::measured(const RadPrimitive& p, const RadPlacement& placement) {
  const std::size_t first = p.type == "BSDF" ? 1 : 0;
  if (p.words.size() < first + 4) throw Error(p.place, fmt::format("{} '{}' lacks words", p.type, p.name));
  if (first == 1 && rad_number(p.words[0]) != 0.0)
    notes_.add(fmt::format("BSDF '{}' has no thickness here: it stands for no other geometry", p.name));
  if (std::any_of(p.numbers.begin(), p.numbers.end(), [](double x) { return x != 0; }))
    notes_.add(fmt::format("{} '{}': its additional diffuse colours are left out", p.type, p.name));
  const std::string& file = p.words[first];
  std::vector<std::string> notes;
  const std::string& text = read_file_(file, p.place);
  held_.grow(bsdf_bytes(text));
  Material m = measured_material(text, file, notes);
  for (const std::string& note : notes) notes_.add(note);
  Vec3d up{0, 0, 1}, given;
  bool known = true;
  for (int i = 0; i < 3; ++i) {
    const std::optional<double> number = rad_number(p.words[first + 1 + static_cast<std::size_t>(i)]);
    known = known && number;
    given[i] = number.value_or(0);
  }
  if (known && length(given) > 0)
    up = given;
  else
    notes_.add(fmt::format("{} '{}': its up vector is not read, and z is up", p.type, p.name));
  m.measured_up = y_up_from_z_up(narrow(placement.to_world.vector(up)));
  return m;
}

std::uint32_t RadMaterials::medium_of(RGB transmissivity, const std::string& name) {
  Medium medium;
  medium.name = name;
  // Less than a millionth passes a metre.
  for (int i = 0; i < 3; ++i) medium.sigma_a[i] = -std::log(std::clamp(transmissivity[i], 1e-6f, 1.0f));
  if (is_black(medium.sigma_a)) return kNone;
  description_.media.push_back(std::move(medium));
  return static_cast<std::uint32_t>(description_.media.size() - 1);
}

}  // namespace glowworm
