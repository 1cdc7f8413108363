// The typed parameters of a pbrt directive: "type name" followed by values.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/transform_double.h"
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

/// The type with this name in pbrt-v4 or, with another name, in pbrt-v3 ("point", "color", "normal3", ...).
std::optional<PbrtType> pbrt_type(std::string_view name);
const char* name_of(PbrtType type);

/// One parameter. Booleans are numbers 0 and 1. A spectrum is either numbers (wavelength in nm, value, ...) or one
/// string (a name or a file).
struct PbrtParameter {
  PbrtType type = PbrtType::real;
  std::string name;
  PbrtPlace place;
  std::vector<double> numbers;
  std::vector<std::string> strings;
  mutable bool used = false;  ///< was looked up; others are noted as unused
};

/// The parameters of a directive. Every lookup checks the type and the number of values. If they are wrong, it reports
/// an error with its place and returns the default.
class PbrtParameters {
 public:
  PbrtParameters() = default;
  explicit PbrtParameters(PbrtPlace place, PbrtDiagnostics* diagnostics) : place_(place), diagnostics_(diagnostics) {}

  void add(PbrtParameter parameter);
  /// Adds parameters of `defaults` (of an Attribute directive) whose names are not given here.
  void add_defaults(const PbrtParameters& defaults);
  /// Place of the directive.
  const PbrtPlace& place() const { return place_; }
  PbrtDiagnostics& diagnostics() const { return *diagnostics_; }
  const std::vector<PbrtParameter>& all() const { return parameters_; }

  /// The parameter with this name, marked as used; null if it is not given.
  const PbrtParameter* find(std::string_view name) const;
  bool has(std::string_view name) const { return find(name) != nullptr; }

  float real(std::string_view name, float otherwise) const;
  int integer(std::string_view name, int otherwise) const;
  bool boolean(std::string_view name, bool otherwise) const;
  std::string string(std::string_view name, const std::string& otherwise) const;
  Vec3d point3(std::string_view name, Vec3d otherwise) const;
  /// All numbers of a parameter of a numeric type; empty if it is not given.
  std::span<const double> numbers(std::string_view name, PbrtType type) const;
  std::span<const std::string> strings(std::string_view name) const;

  /// Reports an error at a parameter, or at the directive.
  void error(const PbrtParameter& parameter, const std::string& message, const std::string& remedy) const;
  void error(const std::string& message, const std::string& remedy) const;
  /// Adds a note with the place of the directive.
  void note(const std::string& text) const { diagnostics_->note(place_, text); }
  /// Marks all parameters as used, if the directive is left out as a whole.
  void use_all() const;
  /// Adds a note for every unused parameter.
  void note_unused(const std::string& owner) const;

 private:
  const PbrtParameter* find_number(std::string_view name, std::size_t count) const;

  PbrtPlace place_;
  PbrtDiagnostics* diagnostics_ = nullptr;
  std::vector<PbrtParameter> parameters_;
};

}  // namespace glowworm
