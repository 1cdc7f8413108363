#include "import/pbrt/materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "import/pbrt/textures.h"
#include "import/texture_nodes.h"

namespace glowworm {

namespace {

/// Converts pbrt's roughness to a GGX alpha: the square root in pbrt-v4, a fitted polynomial in pbrt-v3
/// (TrowbridgeReitzDistribution::RoughnessToAlpha of each).
float remapped_roughness(float roughness, bool v3) {
  if (!v3) return std::sqrt(std::max(roughness, 0.0f));
  const float x = std::log(std::max(roughness, 1e-3f));
  return 1.62142f + 0.819955f * x + 0.1734f * x * x + 0.0171201f * x * x * x + 0.000640711f * x * x * x * x;
}

/// Mean of a float texture over the unit square.
float mean_of(const std::vector<TextureNode>& textures, const FloatInput& input) {
  constexpr int kSide = 16;
  float sum = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) sum += evaluate(textures, input, {(x + 0.5f) / kSide, (y + 0.5f) / kSide});
  }
  return sum / (kSide * kSide);
}

class MaterialBuilder {
 public:
  MaterialBuilder(PbrtContext& context, const PbrtParameters& parameters, const PbrtMaterialByName& by_name)
      : context_(context), parameters_(parameters), by_name_(by_name) {}

  Material build(const std::string& kind) {
    if (!build_known(kind)) build_replacement(kind);
    common();
    return material_;
  }

 private:
  using Recipe = void (MaterialBuilder::*)();
  struct Entry {
    std::string_view kind;
    Recipe recipe;
  };

  bool build_known(const std::string& kind) {
    static constexpr std::array kRecipes = {
        Entry{"diffuse", &MaterialBuilder::diffuse},
        Entry{"coateddiffuse", &MaterialBuilder::coated_diffuse},
        Entry{"conductor", &MaterialBuilder::conductor},
        Entry{"coatedconductor", &MaterialBuilder::coated_conductor},
        Entry{"dielectric", &MaterialBuilder::dielectric},
        Entry{"thindielectric", &MaterialBuilder::thin_dielectric},
        Entry{"diffusetransmission", &MaterialBuilder::diffuse_transmission},
        Entry{"mix", &MaterialBuilder::mix},
        Entry{"metallicroughness", &MaterialBuilder::metallic_roughness},
        // pbrt-v3
        Entry{"matte", &MaterialBuilder::matte},
        Entry{"glass", &MaterialBuilder::glass},
        Entry{"metal", &MaterialBuilder::metal},
        Entry{"mirror", &MaterialBuilder::mirror},
        Entry{"plastic", &MaterialBuilder::plastic},
        Entry{"uber", &MaterialBuilder::uber},
        Entry{"substrate", &MaterialBuilder::substrate},
        Entry{"translucent", &MaterialBuilder::translucent},
    };
    for (const Entry& entry : kRecipes) {
      if (entry.kind != kind) continue;
      (this->*entry.recipe)();
      return true;
    }
    if (!kind.empty() && kind != "interface" && kind != "none") return false;
    material_.kind = MaterialKind::interface;
    return true;
  }

  void build_replacement(const std::string& kind) {
    static constexpr std::array<std::string_view, 8> kKnown = {"subsurface", "hair",         "measured",   "disney",
                                                               "fourier",    "kdsubsurface", "principled", "merl"};
    if (std::find(kKnown.begin(), kKnown.end(), kind) == kKnown.end()) {
      parameters_.error(fmt::format("unknown material {}", in_quotes(kind)),
                        "Supported: diffuse, coateddiffuse, conductor, coatedconductor, dielectric, "
                        "thindielectric, diffusetransmission, mix, metallicroughness and interface.");
      return;
    }
    for (const char* name : {"reflectance", "color", "Kd"}) {
      if (parameters_.has(name)) material_.reflectance = color_input(context_, parameters_, name, RGB(0.5f));
    }
    parameters_.use_all();
    parameters_.note(fmt::format("not supported, replaced by a diffuse one: material {}", in_quotes(kind)));
  }

  void diffuse() {
    material_.reflectance = color_input(context_, parameters_, "reflectance", RGB(0.5f));
    // Standard deviation of pbrt-v3's Oren-Nayar model.
    const FloatInput sigma = float_input(context_, parameters_, "sigma", 0);
    if (sigma.texture != kNone || sigma.value != 0) {
      parameters_.note("not supported, read as 0: sigma of a diffuse material");
    }
  }

  /// Reads NAMEroughness and its u and v variants into two inputs.
  void roughness(const std::string& prefix, float otherwise, FloatInput& u, FloatInput& v) {
    const bool remap = parameters_.boolean("remaproughness", true);
    const FloatInput both = float_input(context_, parameters_, prefix + "roughness", otherwise);
    u = parameters_.has(prefix + "uroughness") ? float_input(context_, parameters_, prefix + "uroughness", 0) : both;
    v = parameters_.has(prefix + "vroughness") ? float_input(context_, parameters_, prefix + "vroughness", 0) : both;
    if (!remap) return;
    for (FloatInput* input : {&u, &v}) {
      if (input->texture != kNone) {
        input->value = mean_of(context_.scene.textures, *input);
        input->texture = kNone;
        parameters_.note("its mean is used: a roughness texture with \"remaproughness\" true");
      }
      input->value = remapped(input->value);
    }
  }

  /// In pbrt-v3, a roughness of 0 also stays smooth.
  float remapped(float roughness) const { return roughness == 0 ? 0 : remapped_roughness(roughness, context_.v3); }

  void ignore(std::initializer_list<const char*> names) {
    for (const char* name : names) static_cast<void>(parameters_.find(name));
  }

  void coat(const char* thickness) {
    material_.coat_thickness = std::max(parameters_.real(thickness, 0.01f), 0.0f);
    const int depth = std::clamp(parameters_.integer("maxdepth", 10), 1, 500);
    material_.coat_bounces = static_cast<std::uint8_t>((depth + 1) / 2);
    ignore({"nsamples", "g"});
    if (!parameters_.has("albedo")) return;
    const ColorInput albedo = color_input(context_, parameters_, "albedo", RGB(0.0f));
    if (!is_black(albedo.value)) {
      parameters_.note("not supported, read as absorbing: albedo of a coat");
    }
  }

  void coated_diffuse() {
    material_.kind = MaterialKind::coated_diffuse;
    material_.reflectance = color_input(context_, parameters_, "reflectance", RGB(0.5f));
    material_.ior = read_index_of_refraction(context_, parameters_, "eta", 1.5f);
    roughness("", 0, material_.roughness_u, material_.roughness_v);
    coat("thickness");
  }

  void conductor_base(const std::string& prefix) {
    if (parameters_.has("reflectance")) {
      if (parameters_.has(prefix + "eta") || parameters_.has(prefix + "k")) {
        parameters_.error("a conductor with both reflectance and eta or k", "Give only one of them.");
      }
      material_.reflectance = color_input(context_, parameters_, "reflectance", RGB(0.5f));
      material_.use_reflectance = material_.reflectance.texture != kNone;
      const ConductorIndex index = conductor_from_reflectance(material_.reflectance.value);
      material_.eta = index.eta;
      material_.k = index.k;
      return;
    }
    const ConductorIndex index = read_conductor(context_, parameters_, prefix);
    material_.eta = index.eta;
    material_.k = index.k;
  }

  void conductor() {
    material_.kind = MaterialKind::conductor;
    conductor_base("");
    roughness("", 0, material_.roughness_u, material_.roughness_v);
  }

  void coated_conductor() {
    material_.kind = MaterialKind::coated_conductor;
    conductor_base("conductor.");
    roughness("conductor.", 0, material_.roughness_u, material_.roughness_v);
    FloatInput other;
    roughness("interface.", 0, material_.coat_roughness, other);
    if (other.value != material_.coat_roughness.value) {
      parameters_.note("not supported, read as isotropic: roughness of a coat");
    }
    material_.ior = read_index_of_refraction(context_, parameters_, "interface.eta", 1.5f);
    coat("thickness");
  }

  void dielectric() {
    material_.kind = MaterialKind::dielectric;
    tint("reflectance", "transmittance");
    material_.ior = read_index_of_refraction(context_, parameters_, "eta", 1.5f);
    roughness("", 0, material_.roughness_u, material_.roughness_v);
  }

  void tint(const char* reflected, const char* transmitted) {
    material_.reflectance = color_input(context_, parameters_, reflected, RGB(1.0f));
    material_.transmittance = color_input(context_, parameters_, transmitted, RGB(1.0f));
  }

  void thin_dielectric() {
    material_.kind = MaterialKind::thin_dielectric;
    tint("reflectance", "transmittance");
    material_.ior = read_index_of_refraction(context_, parameters_, "eta", 1.5f);
  }

  void diffuse_transmission() {
    const float scale = parameters_.real("scale", 1);
    material_.reflectance = color_input(context_, parameters_, "reflectance", RGB(0.25f));
    material_.transmittance = color_input(context_, parameters_, "transmittance", RGB(0.25f));
    material_.reflectance.value *= scale;
    material_.transmittance.value *= scale;
  }

  /// pbrt-v4 has a list of names. pbrt-v3 has two parameters; the first one has the weight `amount`.
  void mix() {
    std::vector<std::string> names;
    for (const std::string& name : parameters_.strings("materials")) names.push_back(name);
    if (parameters_.has("namedmaterial1")) {
      names = {parameters_.string("namedmaterial2", ""), parameters_.string("namedmaterial1", "")};
    }
    if (names.size() != 2) {
      parameters_.error("a mix needs the names of two materials", "Give \"string materials\" [ \"one\" \"other\" ].");
      return;
    }
    material_.kind = MaterialKind::mix;
    material_.mix_a = by_name_(names[0], parameters_.place());
    material_.mix_b = by_name_(names[1], parameters_.place());
    material_.mix_amount = mean_input("amount", 0.5f);
  }

  /// A number, or the mean of a colour. A texture may be of floats or, as in pbrt-v3, of colours.
  FloatInput mean_input(const char* name, float otherwise) {
    const PbrtParameter* parameter = parameters_.find(name);
    const bool is_color = parameter && (parameter->type == PbrtType::rgb || parameter->type == PbrtType::spectrum);
    const bool is_color_texture = names_texture_in(context_.spectrum_textures, parameter) &&
                                  (context_.v3 || !names_texture_in(context_.float_textures, parameter));
    if (!is_color && !is_color_texture) return float_input(context_, parameters_, name, otherwise);
    const ColorInput color = color_input(context_, parameters_, name, RGB(otherwise));
    return {mean(color.value), color.texture};
  }

  /// glTF's metallic-roughness model, a material of Glowworm that pbrt does not have. As in glTF, roughness is the
  /// square root of GGX's alpha. It refracts unless it is thin.
  void metallic_roughness() {
    material_.kind = MaterialKind::metallic_roughness;
    material_.reflectance = color_input(context_, parameters_, "reflectance", RGB(0.5f));
    material_.metallic = float_input(context_, parameters_, "metallic", 0);
    material_.roughness_u = material_.roughness_v = squared("roughness");
    material_.ior = read_index_of_refraction(context_, parameters_, "eta", 1.5f);
    material_.specular = float_input(context_, parameters_, "specular", 1);
    material_.specular_color = color_input(context_, parameters_, "specularcolor", RGB(1.0f));
    material_.transmission = float_input(context_, parameters_, "transmission", 0);
    material_.thin = parameters_.boolean("thin", false);
    material_.clearcoat = float_input(context_, parameters_, "clearcoat", 0);
    material_.coat_roughness = squared("clearcoatroughness");
    material_.sheen = color_input(context_, parameters_, "sheen", RGB(0.0f));
    material_.sheen_roughness = float_input(context_, parameters_, "sheenroughness", 0.5f);
    material_.anisotropy = float_input(context_, parameters_, "anisotropy", 0);
    material_.anisotropy_rotation = parameters_.real("anisotropyrotation", 0) * kPi / 180;
  }

  FloatInput squared(const char* name) {
    FloatInput input = float_input(context_, parameters_, name, 0);
    input.value *= input.value;
    if (input.texture != kNone) input.texture = add_product_node(context_.scene.textures, input.texture, input.texture);
    return input;
  }

  // Materials of pbrt-v3.

  void matte() {
    diffuse();
    material_.reflectance = color_input(context_, parameters_, "Kd", RGB(0.5f));
  }

  void glass() {
    material_.kind = MaterialKind::dielectric;
    tint("Kr", "Kt");
    material_.ior = read_index_of_refraction(context_, parameters_, parameters_.has("index") ? "index" : "eta", 1.5f);
    roughness("", 0, material_.roughness_u, material_.roughness_v);
  }

  void metal() {
    material_.kind = MaterialKind::conductor;
    conductor_base("");
    roughness("", 0.01f, material_.roughness_u, material_.roughness_v);
  }

  void mirror() {
    material_.kind = MaterialKind::conductor;
    material_.use_reflectance = true;
    material_.reflectance = color_input(context_, parameters_, "Kr", RGB(0.9f));
  }

  void coated(float diffuse_otherwise) {
    material_.kind = MaterialKind::coated_diffuse;
    material_.reflectance = color_input(context_, parameters_, "Kd", RGB(diffuse_otherwise));
    material_.ior = read_index_of_refraction(context_, parameters_, parameters_.has("eta") ? "eta" : "index", 1.5f);
    roughness("", 0.1f, material_.roughness_u, material_.roughness_v);
    ignore({"Ks", "index"});
    parameters_.note("taken as coateddiffuse: a plastic, uber or substrate material of pbrt-v3");
  }

  void plastic() { coated(0.25f); }
  void substrate() { coated(0.5f); }

  void uber() {
    coated(0.25f);
    material_.alpha = mean_input("opacity", 1);
    for (const char* name : {"Kr", "Kt"}) {
      const ColorInput color = color_input(context_, parameters_, name, RGB(0.0f));
      if (color.texture == kNone && is_black(color.value)) continue;
      parameters_.note("not supported, read as 0: Kr and Kt of an uber material");
    }
  }

  void translucent() {
    material_.reflectance = color_input(context_, parameters_, "Kd", RGB(0.25f));
    const float reflect = mean(color_or(context_, parameters_, "reflect", PbrtColorUse::reflectance, RGB(0.5f)));
    const float transmit = mean(color_or(context_, parameters_, "transmit", PbrtColorUse::reflectance, RGB(0.5f)));
    material_.transmittance = material_.reflectance;
    material_.reflectance.value *= reflect;
    material_.transmittance.value *= transmit;
    ignore({"Ks", "roughness", "remaproughness"});
    parameters_.note("taken as diffusetransmission: a translucent material of pbrt-v3");
  }

  void common() {
    const std::string normal_map = parameters_.string("normalmap", "");
    if (!normal_map.empty()) {
      TextureOptions data;
      data.encoding = TextureEncoding::linear;
      material_.normal_map.texture = add_image_texture(context_, parameters_, normal_map, data, StandIn::flat_normal);
    }
    const char* bump = parameters_.has("displacement") ? "displacement" : "bumpmap";
    if (parameters_.has(bump)) {
      material_.bump = float_input(context_, parameters_, bump, 0);
      if (material_.bump.texture == kNone) material_.bump.value = 0;
    }
    ignore({"type"});
  }

  PbrtContext& context_;
  const PbrtParameters& parameters_;
  const PbrtMaterialByName& by_name_;
  Material material_;
};

}  // namespace

Material make_material(PbrtContext& context, const std::string& kind, const PbrtParameters& parameters,
                       const PbrtMaterialByName& by_name) {
  Material material = MaterialBuilder(context, parameters, by_name).build(kind);
  parameters.note_unused(fmt::format("material {}", in_quotes(kind)));
  return material;
}

}  // namespace glowworm
