#include "import/pbrt/textures.h"

#include <fmt/format.h>

#include "core/lines.h"
#include "core/text.h"
#include "import/texture_nodes.h"

namespace glowworm {

namespace {

std::uint32_t as_node(PbrtContext& context, const PbrtTexture& texture) {
  if (texture.node != kNone && texture.value == RGB(1.0f)) return texture.node;
  TextureNode constant;
  constant.value = texture.value;
  const std::uint32_t factor = add_node(context.scene.textures, constant);
  return texture.node == kNone ? factor : add_product_node(context.scene.textures, texture.node, factor);
}

/// A parameter of a texture: a number, a colour or another texture.
PbrtTexture operand(PbrtContext& context, const PbrtParameters& parameters, std::string_view name, bool is_float,
                    float otherwise) {
  if (is_float) {
    const FloatInput input = float_input(context, parameters, name, otherwise);
    return {RGB(input.value), input.texture};
  }
  const ColorInput input = color_input(context, parameters, name, RGB(otherwise), PbrtColorUse::unbounded);
  return {input.value, input.texture};
}

class TextureBuilder {
 public:
  TextureBuilder(PbrtContext& context, const PbrtParameters& parameters, bool is_float)
      : context_(context), parameters_(parameters), is_float_(is_float) {}

  PbrtTexture build(const std::string& kind) {
    if (kind == "constant") return operand(context_, parameters_, "value", is_float_, 1);
    if (kind == "scale") return scale();
    if (kind == "mix") return mix();
    if (kind == "imagemap") return image_map();
    if (kind == "checkerboard") return checkerboard();
    parameters_.use_all();
    parameters_.note(fmt::format("not supported, replaced by mid-grey: texture {}", in_quotes(kind)));
    return {RGB(0.5f), kNone};
  }

 private:
  /// pbrt-v4 calls the operands "tex" and "scale", pbrt-v3 "tex1" and "tex2".
  PbrtTexture scale() {
    const bool old_names = parameters_.has("tex1") || parameters_.has("tex2");
    const PbrtTexture a = operand(context_, parameters_, old_names ? "tex1" : "tex", is_float_, 1);
    // The "scale" of a texture of colours is a texture of floats.
    const bool float_factor = !old_names && names_texture_in(context_.float_textures, parameters_.find("scale"));
    const PbrtTexture b = operand(context_, parameters_, old_names ? "tex2" : "scale", is_float_ || float_factor, 1);
    if (a.node == kNone || b.node == kNone) {
      return {a.value * b.value, a.node == kNone ? b.node : a.node};
    }
    const std::uint32_t a_node = as_node(context_, a), b_node = as_node(context_, b);
    return {RGB(1.0f), add_product_node(context_.scene.textures, a_node, b_node)};
  }

  PbrtTexture mix() {
    const PbrtTexture a = operand(context_, parameters_, "tex1", is_float_, 0);
    const PbrtTexture b = operand(context_, parameters_, "tex2", is_float_, 1);
    const PbrtTexture amount = operand(context_, parameters_, "amount", true, 0.5f);
    if (a.node == kNone && b.node == kNone && amount.node == kNone) return {lerp(a.value, b.value, amount.value.r)};
    TextureNode node;
    node.kind = TextureKind::mix;
    node.child_a = as_node(context_, a);
    node.child_b = as_node(context_, b);
    node.child_amount = as_node(context_, amount);
    return {RGB(1.0f), add_node(context_.scene.textures, node)};
  }

  PbrtTexture checkerboard() {
    if (parameters_.integer("dimension", 2) != 2) {
      parameters_.note("not supported, read as two-dimensional: 3D checkerboard");
    }
    TextureNode node;
    node.kind = TextureKind::checkerboard;
    node.child_a = as_node(context_, operand(context_, parameters_, "tex1", is_float_, 1));
    node.child_b = as_node(context_, operand(context_, parameters_, "tex2", is_float_, 0));
    set_mapping(node);
    static_cast<void>(parameters_.string("aamode", ""));
    return {RGB(1.0f), add_node(context_.scene.textures, node)};
  }

  PbrtTexture image_map() {
    const std::string file = parameters_.string("filename", "");
    if (file.empty()) {
      parameters_.error("an imagemap without a file name", "Give \"string filename\".");
      return {};
    }
    const std::uint32_t id = add_image_texture(context_, parameters_, file, image_options(file),
                                               is_float_ ? StandIn::one : StandIn::magenta);
    TextureNode& node = context_.scene.textures[id];
    node.value = RGB(parameters_.real("scale", 1));
    node.invert = parameters_.boolean("invert", false);
    // pbrt-v3 reads no alpha.
    node.from_alpha = is_float_ && !context_.v3 && node.image->has_alpha();
    set_mapping(node);
    return {RGB(1.0f), id};
  }

  TextureOptions image_options(const std::string& file) {
    TextureOptions options = default_image_options(file);
    // "bilinear", "trilinear" and "ewa" differ only in how they blur distant texels; many samples have the same effect.
    if (parameters_.string("filter", "bilinear") == "point") options.filter = TextureFilter::nearest;
    static_cast<void>(parameters_.find("maxanisotropy"));
    static_cast<void>(parameters_.find("trilinear"));
    options.wrap_u = options.wrap_v = wrap();
    const std::string encoding = parameters_.string("encoding", parameters_.boolean("gamma", true) ? "sRGB" : "linear");
    constexpr std::string_view kGamma = "gamma ";
    if (encoding == "linear") {
      options.encoding = TextureEncoding::linear;
    } else if (encoding.starts_with(kGamma)) {
      options.encoding = TextureEncoding::power;
      double exponent = 0;
      std::string_view number = std::string_view(encoding).substr(kGamma.size());
      options.exponent = take_number(number, exponent) ? static_cast<float>(exponent) : 0;
      if (!(options.exponent > 0 && options.exponent < 100)) bad_value("encoding", encoding);
    } else if (encoding != "sRGB") {
      bad_value("encoding", encoding);
    }
    return options;
  }

  TextureWrap wrap() {
    const std::string name = parameters_.string("wrap", "repeat");
    if (name == "repeat") return TextureWrap::repeat;
    if (name == "black") return TextureWrap::black;
    if (name != "clamp") bad_value("wrap", name);
    return TextureWrap::clamp;
  }

  void bad_value(const char* parameter, const std::string& value) {
    parameters_.error(fmt::format("{} {}", parameter, in_quotes(value)),
                      "wrap is repeat, clamp or black; encoding is sRGB, linear or \"gamma 2.2\".");
  }

  void set_mapping(TextureNode& node) {
    const std::string mapping = parameters_.string("mapping", "uv");
    if (mapping != "uv") {
      parameters_.use_all();
      parameters_.note(fmt::format("not supported, mapped by uv: texture mapping {}", in_quotes(mapping)));
      return;
    }
    node.uv_scale = {parameters_.real("uscale", 1), parameters_.real("vscale", 1)};
    node.uv_offset = {parameters_.real("udelta", 0), parameters_.real("vdelta", 0)};
  }

  PbrtContext& context_;
  const PbrtParameters& parameters_;
  bool is_float_;
};

/// Reports an error if a new texture is nested so deeply that lookups could hang, and makes it a constant.
void check_nesting(PbrtContext& context, const std::string& name, const PbrtParameters& parameters,
                   PbrtTexture& texture) {
  measure_textures(context.scene.textures, context.texture_costs);
  if (texture.node == kNone) return;
  const TextureCost cost = context.texture_costs[texture.node];
  if (cost.is_allowed()) return;
  parameters.error(
      fmt::format("texture {} is nested too deeply: {} levels, {} nodes", in_quotes(name), cost.levels, cost.nodes),
      "Combine its parts into an image.");
  texture.node = kNone;
}

/// The texture that a parameter names. If there is none, reports an error and returns null.
const PbrtTexture* find_texture(PbrtContext& context, const PbrtParameters& parameters, const PbrtParameter& parameter,
                                bool is_float) {
  if (parameter.strings.size() != 1) {
    parameters.error(parameter,
                     fmt::format("parameter {} should be the name of one texture", in_quotes(parameter.name)),
                     "Write \"texture name\" \"texture's name\".");
    return nullptr;
  }
  const std::string& name = parameter.strings[0];
  const auto& table = is_float ? context.float_textures : context.spectrum_textures;
  const auto found = table.find(name);
  if (found != table.end()) return &found->second;
  const auto& other = is_float ? context.spectrum_textures : context.float_textures;
  const char* kind = is_float ? "float" : "spectrum";
  parameters.error(parameter, fmt::format("there is no {} texture {}", kind, in_quotes(name)),
                   other.contains(name) ? fmt::format("It is of the other type: define it as \"{}\".", kind)
                                        : "Define it by a Texture directive before its use.");
  return nullptr;
}

}  // namespace

bool names_texture_in(const PbrtTextures& table, const PbrtParameter* parameter) {
  return parameter && parameter->type == PbrtType::texture && parameter->strings.size() == 1 &&
         table.contains(parameter->strings[0]);
}

TextureOptions default_image_options(const std::string& file) {
  TextureOptions options;
  const std::string extension = lower_ending(file);
  const bool floats = extension == ".exr" || extension == ".hdr";
  options.encoding = floats ? TextureEncoding::linear : TextureEncoding::srgb;
  return options;
}

std::uint32_t add_image_texture(PbrtContext& context, const PbrtParameters& parameters, const std::string& file,
                                const TextureOptions& options, StandIn stand_in) {
  return add_image_node(context.scene.textures,
                        context.load_image(context.resolve(file, parameters.place()), options, stand_in));
}

void define_texture(PbrtContext& context, const std::string& name, const std::string& value_type,
                    const std::string& kind, const PbrtParameters& parameters) {
  const bool is_float = value_type == "float";
  if (!is_float && value_type != "spectrum" && value_type != "color") {
    parameters.error(fmt::format("a texture of type {}", in_quotes(value_type)), "Expected float or spectrum.");
    return;
  }
  PbrtTexture texture = TextureBuilder(context, parameters, is_float).build(kind);
  check_nesting(context, name, parameters, texture);
  auto& table = is_float ? context.float_textures : context.spectrum_textures;
  if (!table.insert_or_assign(name, texture).second) {
    parameters.note(fmt::format("defined again, later uses take the new one: texture {}", in_quotes(name)));
  }
}

ColorInput color_input(PbrtContext& context, const PbrtParameters& parameters, std::string_view name, RGB otherwise,
                       PbrtColorUse use) {
  ColorInput input{otherwise};
  const PbrtParameter* parameter = parameters.find(name);
  if (!parameter) return input;
  if (parameter->type == PbrtType::texture) {
    if (const PbrtTexture* texture = find_texture(context, parameters, *parameter, false)) {
      input.value = texture->value;
      input.texture = texture->node;
    }
    return input;
  }
  input.value = read_color(context, parameters, *parameter, use).value_or(otherwise);
  return input;
}

FloatInput float_input(PbrtContext& context, const PbrtParameters& parameters, std::string_view name, float otherwise) {
  FloatInput input;
  input.value = otherwise;
  const PbrtParameter* parameter = parameters.find(name);
  if (!parameter) return input;
  if (parameter->type == PbrtType::texture) {
    if (const PbrtTexture* texture = find_texture(context, parameters, *parameter, true)) {
      input.value = mean(texture->value);
      input.texture = texture->node;
    }
    return input;
  }
  input.value = parameters.real(name, otherwise);
  return input;
}

}  // namespace glowworm
