// The typed parameters of a pbrt directive: "type name" followed by values.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/vec.h"
#include "import/pbrt/diagnostics.h"

namespace glowworm {

enum class PbrtType : std::uint8_t {
  boolean,
  integer,
  real,
  point2,
  vector2,
  point3,
  vector3,
  normal,
  string,
  rgb,
  xyz,
  blackbody,
  spectrum,
  texture,
};

/// The type of that name in pbrt-v4, or one of pbrt-v3's names for it ("point", "color", "normal3", ...).
std::optional<PbrtType> pbrt_type(std::string_view name);
const char* name_of(PbrtType type);

/// One parameter. Booleans are numbers 0 and 1; a spectrum is either numbers (wavelength in nm, value, ...) or one
/// string (a name or a file).
struct PbrtParameter {
  PbrtType type = PbrtType::real;
  std::string name;
  PbrtPlace place;
  std::vector<double> numbers;
  std::vector<std::string> strings;
  mutable bool used = false;  ///< was asked for: the rest is named in the notes
};

/// The parameters of a directive. Every lookup checks type and count of what it finds, records an error with its place
/// where they don't fit, and then gives the default.
class PbrtParameters {
 public:
  PbrtParameters() = default;
  explicit PbrtParameters(PbrtPlace place, PbrtDiagnostics* diagnostics) : place_(place), diagnostics_(diagnostics) {}

  void add(PbrtParameter parameter);
  /// Adds those of `defaults` (of an Attribute directive) whose names are not given here.
  void add_defaults(const PbrtParameters& defaults);
  /// Place of the directive.
  const PbrtPlace& place() const { return place_; }
  PbrtDiagnostics& diagnostics() const { return *diagnostics_; }
  const std::vector<PbrtParameter>& all() const { return parameters_; }

  /// The parameter of that name, marked as used, or null.
  const PbrtParameter* find(std::string_view name) const;
  bool has(std::string_view name) const { return find(name) != nullptr; }

  float real(std::string_view name, float otherwise) const;
  int integer(std::string_view name, int otherwise) const;
  bool boolean(std::string_view name, bool otherwise) const;
  std::string string(std::string_view name, const std::string& otherwise) const;
  Vec3 point3(std::string_view name, Vec3 otherwise) const;
  /// All numbers of a parameter of one of the numeric types; empty where it is not given.
  std::span<const double> numbers(std::string_view name, PbrtType type) const;
  std::span<const std::string> strings(std::string_view name) const;

  /// Records an error at a parameter.
  void error(const PbrtParameter& parameter, const std::string& message, const std::string& remedy) const;
  /// Marks all as used, where what they belong to is left out as a whole.
  void use_all() const;
  /// Notes every parameter that nothing asked for.
  void note_unused(const std::string& owner) const;

 private:
  const PbrtParameter* find_number(std::string_view name, std::size_t count) const;

  PbrtPlace place_;
  PbrtDiagnostics* diagnostics_ = nullptr;
  std::vector<PbrtParameter> parameters_;
};

}  // namespace glowworm
