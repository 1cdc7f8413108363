#include "import/pbrt/parser.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "core/lines.h"
#include "core/parallel.h"
#include "core/text.h"
#include "import/pbrt/file.h"
#include "import/pbrt/tokens.h"

namespace glowworm {

namespace {

/// The arguments of a directive, in this order.
struct Signature {
  std::string_view name;
  int strings = 0;           ///< quoted strings
  int optional_strings = 0;  ///< optional quoted strings after those
  int numbers = 0;           ///< numbers, in brackets or not
  int words = 0;             ///< bare words
  bool parameters = false;   ///< a list of parameters
};

constexpr Signature kGrammar[] = {
    {"Accelerator", 1, 0, 0, 0, true},
    {"ActiveTransform", 0, 0, 0, 1, false},
    {"AreaLightSource", 1, 0, 0, 0, true},
    {"Attribute", 1, 0, 0, 0, true},
    {"AttributeBegin"},
    {"AttributeEnd"},
    {"Camera", 1, 0, 0, 0, true},
    {"ColorSpace", 1},
    {"ConcatTransform", 0, 0, 16},
    {"CoordSysTransform", 1},
    {"CoordinateSystem", 1},
    {"Film", 1, 0, 0, 0, true},
    {"Identity"},
    {"Import", 1},
    {"Include", 1},
    {"Integrator", 1, 0, 0, 0, true},
    {"LightSource", 1, 0, 0, 0, true},
    {"LookAt", 0, 0, 9},
    {"MakeNamedMaterial", 1, 0, 0, 0, true},
    {"MakeNamedMedium", 1, 0, 0, 0, true},
    {"Material", 1, 0, 0, 0, true},
    {"MediumInterface", 1, 1},
    {"NamedMaterial", 1},
    {"ObjectBegin", 1},
    {"ObjectEnd"},
    {"ObjectInstance", 1},
    {"Option", 0, 0, 0, 0, true},
    {"PixelFilter", 1, 0, 0, 0, true},
    {"Renderer", 1, 0, 0, 0, true},
    {"ReverseOrientation"},
    {"Rotate", 0, 0, 4},
    {"Sampler", 1, 0, 0, 0, true},
    {"Scale", 0, 0, 3},
    {"Shape", 1, 0, 0, 0, true},
    {"SurfaceIntegrator", 1, 0, 0, 0, true},
    {"Texture", 3, 0, 0, 0, true},
    {"Transform", 0, 0, 16},
    {"TransformBegin"},
    {"TransformEnd"},
    {"TransformTimes", 0, 0, 2},
    {"Translate", 0, 0, 3},
    {"VolumeIntegrator", 1, 0, 0, 0, true},
    {"WorldBegin"},
    {"WorldEnd"},
};

const Signature* find_signature(std::string_view name) {
  for (const Signature& signature : kGrammar) {
    if (signature.name == name) return &signature;
  }
  return nullptr;
}

/// The remedy for an unknown directive: suggests one that differs only in case.
std::string spelling_remedy(std::string_view name) {
  for (const Signature& signature : kGrammar) {
    if (lower(signature.name) == lower(name)) return fmt::format("Write it as {}.", signature.name);
  }
  return "Check the spelling; directives are named as in pbrt-v4, like Shape, Material or LightSource.";
}

/// Thrown inside the parser after an error is recorded, to skip the directive.
struct GiveUp {};

constexpr std::size_t kMaxIncludeDepth = 64;
constexpr std::size_t kMaxIncludes = 16384;
constexpr std::size_t kMaxParameters = 1000;  // per directive; keeps the search for duplicates cheap

class Parser {
 public:
  Parser(const std::string& main_file, PbrtDiagnostics& diagnostics, MemoryBudget& budget, const PbrtSink& sink)
      : main_file_(main_file), diagnostics_(diagnostics), budget_(budget), sink_(sink) {}

  void parse(std::string_view text, const std::string& path);

 private:
  void directive(PbrtTokenizer& tokens, const std::string& path);
  void include(const PbrtDirective& directive, const std::string& path);
  void read_numbers(PbrtTokenizer& tokens, const Signature& signature, PbrtDirective& directive);
  /// @param memory of all numbers
  void read_parameters(PbrtTokenizer& tokens, PbrtDirective& directive, Reservation& memory);
  /// @param held memory of the directive's other parameters, bytes
  PbrtParameter read_parameter(PbrtTokenizer& tokens, std::size_t held, Reservation& memory);
  void read_value(const PbrtToken& token, PbrtParameter& parameter);
  void check_values(const PbrtParameter& parameter);
  [[noreturn]] void fail(const PbrtPlace& place, const std::string& message, const std::string& remedy) {
    diagnostics_.error(place, message, remedy);
    throw GiveUp();
  }

  const std::string main_file_;
  PbrtDiagnostics& diagnostics_;
  MemoryBudget& budget_;
  const PbrtSink& sink_;
  std::vector<std::string> open_files_;  // canonical paths, the main file first
  std::size_t includes_ = 0;
};

std::string canonical(const std::string& path) {
  std::error_code error;
  const std::filesystem::path resolved = std::filesystem::weakly_canonical(path, error);
  return error ? path : resolved.string();
}

void Parser::parse(std::string_view text, const std::string& path) {
  open_files_.push_back(canonical(path));
  PbrtTokenizer tokens(text, diagnostics_.add_file(path), diagnostics_);
  while (!diagnostics_.full() && tokens.peek().kind != PbrtTokenKind::end) {
    try {
      directive(tokens, path);
    } catch (const GiveUp&) {
      // Continue at the next word that begins a directive.
      while (tokens.peek().kind != PbrtTokenKind::end &&
             !(tokens.peek().kind == PbrtTokenKind::word && find_signature(tokens.peek().text))) {
        tokens.next();
      }
    }
  }
  open_files_.pop_back();
}

void Parser::directive(PbrtTokenizer& tokens, const std::string& path) {
  const PbrtToken name = tokens.next();
  if (name.kind != PbrtTokenKind::word) {
    fail(name.place, "unexpected " + in_quotes(name.text) + ", expected a directive",
         "A directive is a word such as Shape, followed by its type and parameters.");
  }
  const Signature* signature = find_signature(name.text);
  if (!signature) fail(name.place, "unknown directive " + in_quotes(name.text), spelling_remedy(name.text));

  Reservation memory(budget_, "parameters", 0);
  PbrtDirective directive;
  directive.name = signature->name;
  directive.place = name.place;
  directive.parameters = PbrtParameters(name.place, &diagnostics_);
  for (int i = 0; i < signature->strings + signature->optional_strings; ++i) {
    if (tokens.peek().kind != PbrtTokenKind::string) {
      if (i >= signature->strings) break;
      fail(tokens.peek().place, fmt::format("expected a string in double quotes after {}", signature->name),
           "Write for example: Material \"diffuse\".");
    }
    directive.strings.push_back(unescape(tokens.next()));
  }
  for (int i = 0; i < signature->words; ++i) {
    if (tokens.peek().kind != PbrtTokenKind::word) {
      fail(tokens.peek().place, fmt::format("expected a word after {}", signature->name),
           "Write ActiveTransform StartTime, EndTime or All.");
    }
    directive.strings.emplace_back(tokens.next().text);
  }
  if (signature->numbers > 0) read_numbers(tokens, *signature, directive);
  if (signature->parameters) read_parameters(tokens, directive, memory);
  if (signature->name == "Include" || signature->name == "Import") {
    include(directive, path);
  } else if (!diagnostics_.full()) {
    sink_(directive);
  }
}

void Parser::include(const PbrtDirective& directive, const std::string& path) {
  check_cancelled();  // files of comments alone give no directives
  const std::string& name = directive.strings[0];
  const std::string file = resolve_pbrt_path(name, main_file_, path);
  if (std::find(open_files_.begin(), open_files_.end(), canonical(file)) != open_files_.end()) {
    fail(directive.place, in_quotes(name) + " includes itself", "Remove the circular Include.");
  }
  if (open_files_.size() > kMaxIncludeDepth) {
    fail(directive.place, fmt::format("files are included more than {} deep", kMaxIncludeDepth),
         "Include fewer levels.");
  }
  if (++includes_ > kMaxIncludes) {
    fail(directive.place, fmt::format("more than {} included files", kMaxIncludes), "Merge some of them.");
  }
  std::string text;
  Reservation held(budget_, "scene files", 0);
  try {
    text = read_pbrt_file(file, held);
  } catch (const Error& error) {
    diagnostics_.error(directive.place, fmt::format("cannot include {}: {}", in_quotes(name), error.what()), "");
    return;
  }
  const bool isolated = directive.name == "Import";
  PbrtDirective bracket;
  bracket.place = directive.place;
  bracket.parameters = PbrtParameters(directive.place, &diagnostics_);
  bracket.name = "AttributeBegin";
  if (isolated) sink_(bracket);
  parse(text, file);
  bracket.name = "AttributeEnd";
  if (isolated) sink_(bracket);
}

void Parser::read_numbers(PbrtTokenizer& tokens, const Signature& signature, PbrtDirective& directive) {
  const bool bracketed = tokens.peek().kind == PbrtTokenKind::left_bracket;
  if (bracketed) tokens.next();
  for (int i = 0; i < signature.numbers; ++i) {
    if (tokens.peek().kind != PbrtTokenKind::number) {
      fail(tokens.peek().place, fmt::format("{} needs {} numbers, found {}", signature.name, signature.numbers, i),
           "Add what is missing.");
    }
    directive.numbers.push_back(tokens.next().number);
  }
  if (!bracketed) return;
  const PbrtToken& end = tokens.peek();
  if (end.kind != PbrtTokenKind::right_bracket) {
    fail(end.place, fmt::format("expected ] after the {} numbers of {}", signature.numbers, signature.name),
         "Close the list, or remove surplus numbers.");
  }
  tokens.next();
}

void Parser::read_parameters(PbrtTokenizer& tokens, PbrtDirective& directive, Reservation& memory) {
  std::size_t held = 0;
  while (tokens.peek().kind == PbrtTokenKind::string) {
    PbrtParameter parameter = read_parameter(tokens, held, memory);
    held += parameter.numbers.capacity() * sizeof(double);
    check_values(parameter);
    if (directive.parameters.all().size() >= kMaxParameters) {
      fail(parameter.place, fmt::format("more than {} parameters", kMaxParameters), "The file may be damaged.");
    }
    for (const PbrtParameter& other : directive.parameters.all()) {
      if (other.name == parameter.name && other.type == parameter.type) {
        fail(parameter.place, fmt::format("parameter {} is given twice", in_quotes(parameter.name)),
             "Remove one of the two.");
      }
    }
    directive.parameters.add(std::move(parameter));
  }
}

PbrtParameter Parser::read_parameter(PbrtTokenizer& tokens, std::size_t held, Reservation& memory) {
  const PbrtToken declaration = tokens.next();
  PbrtParameter parameter;
  parameter.place = declaration.place;
  const std::string text = unescape(declaration);
  std::string_view rest = text;
  const std::string_view type = take_word(rest);
  parameter.name = take_word(rest);
  if (parameter.name.empty()) {
    fail(declaration.place, in_quotes(text) + " is not a parameter: expected a type and a name",
         "Write for example \"float radius\" 2.");
  }
  const auto known = pbrt_type(type);
  if (!known) {
    fail(declaration.place, fmt::format("unknown type {} of parameter {}", in_quotes(type), in_quotes(parameter.name)),
         "Types are bool, integer, float, point2, point3, vector2, vector3, normal, string, rgb, blackbody, spectrum "
         "and texture.");
  }
  parameter.type = *known;
  if (tokens.peek().kind != PbrtTokenKind::left_bracket) {
    const PbrtToken value = tokens.next();
    if (value.kind == PbrtTokenKind::end) {
      fail(value.place, fmt::format("the file ends where the value of {} is expected", in_quotes(parameter.name)),
           "The file may be cut off.");
    }
    read_value(value, parameter);
    return parameter;
  }
  const PbrtToken open = tokens.next();
  while (tokens.peek().kind != PbrtTokenKind::right_bracket) {
    if (tokens.peek().kind == PbrtTokenKind::end || find_signature(tokens.peek().text)) {
      // A string may look like a directive, but a bare word may not stand in a list.
      if (tokens.peek().kind != PbrtTokenKind::string) {
        fail(open.place, fmt::format("the list of values of {} has no end", in_quotes(parameter.name)),
             "Close it with ].");
      }
    }
    read_value(tokens.next(), parameter);
    memory.cover(held + parameter.numbers.capacity() * sizeof(double));
  }
  tokens.next();
  return parameter;
}

void Parser::read_value(const PbrtToken& token, PbrtParameter& parameter) {
  const bool wants_string = parameter.type == PbrtType::string || parameter.type == PbrtType::texture;
  if (parameter.type == PbrtType::boolean) {
    if (token.kind != PbrtTokenKind::number && (token.text == "true" || token.text == "false")) {
      parameter.numbers.push_back(token.text == "true");
      return;
    }
  } else if (token.kind == PbrtTokenKind::string && (wants_string || parameter.type == PbrtType::spectrum)) {
    parameter.strings.push_back(unescape(token));
    return;
  } else if (token.kind == PbrtTokenKind::number && !wants_string) {
    parameter.numbers.push_back(token.number);
    return;
  }
  fail(token.place,
       fmt::format("{} is not a value of type {} for parameter {}", in_quotes(token.text), name_of(parameter.type),
                   in_quotes(parameter.name)),
       parameter.type == PbrtType::boolean ? "Write true or false." : "Give a value of that type.");
}

void Parser::check_values(const PbrtParameter& parameter) {
  if (!parameter.numbers.empty() && !parameter.strings.empty()) {
    fail(parameter.place, fmt::format("parameter {} mixes numbers and strings", in_quotes(parameter.name)),
         "Give only one of them.");
  }
  const std::size_t count = parameter.numbers.size() + parameter.strings.size();
  const bool color = parameter.type == PbrtType::rgb || parameter.type == PbrtType::xyz;
  if (color && (count == 0 || count % 3 != 0)) {
    fail(parameter.place, fmt::format("parameter {} has {} values, expected 3", in_quotes(parameter.name), count),
         "A colour has three values.");
  }
  if (parameter.type == PbrtType::spectrum &&
      (count == 0 || (parameter.strings.empty() && count % 2 != 0) || parameter.strings.size() > 1)) {
    fail(parameter.place,
         fmt::format("spectrum {} should be pairs of wavelength and value, or one name or file",
                     in_quotes(parameter.name)),
         "Write for example \"spectrum L\" [ 400 1 700 2 ].");
  }
}

}  // namespace

void parse_pbrt_text(std::string_view text, const std::string& path, PbrtDiagnostics& diagnostics, MemoryBudget& budget,
                     const PbrtSink& sink) {
  Parser(path, diagnostics, budget, sink).parse(text, path);
}

bool is_pbrt_v3(std::string_view text) {
  PbrtDiagnostics unused;
  PbrtTokenizer tokens(text, nullptr, unused);
  for (PbrtToken token = tokens.next(); token.kind != PbrtTokenKind::end; token = tokens.next()) {
    if (token.kind == PbrtTokenKind::word && token.text == "WorldEnd") return true;
  }
  return false;
}

}  // namespace glowworm
