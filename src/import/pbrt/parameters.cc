#include "import/pbrt/parameters.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

namespace glowworm {

namespace {

struct TypeName {
  std::string_view name;
  PbrtType type;
};

// The first name of each type is pbrt-v4's.
constexpr std::array kTypeNames = {
    TypeName{"bool", PbrtType::boolean},      TypeName{"integer", PbrtType::integer},
    TypeName{"float", PbrtType::real},        TypeName{"point2", PbrtType::point2},
    TypeName{"vector2", PbrtType::vector2},   TypeName{"point3", PbrtType::point3},
    TypeName{"vector3", PbrtType::vector3},   TypeName{"normal", PbrtType::normal},
    TypeName{"string", PbrtType::string},     TypeName{"rgb", PbrtType::rgb},
    TypeName{"xyz", PbrtType::xyz},           TypeName{"blackbody", PbrtType::blackbody},
    TypeName{"spectrum", PbrtType::spectrum}, TypeName{"texture", PbrtType::texture},
    TypeName{"point", PbrtType::point3},      TypeName{"vector", PbrtType::vector3},
    TypeName{"normal3", PbrtType::normal},    TypeName{"color", PbrtType::rgb},
};

bool is_numeric(PbrtType type) {
  return type != PbrtType::string && type != PbrtType::texture && type != PbrtType::spectrum;
}

/// Number of numbers in one value of a type.
std::size_t group_size(PbrtType type) {
  switch (type) {
    case PbrtType::point2:
    case PbrtType::vector2:
      return 2;
    case PbrtType::point3:
    case PbrtType::vector3:
    case PbrtType::normal:
    case PbrtType::rgb:
    case PbrtType::xyz:
      return 3;
    default:
      return 1;
  }
}

}  // namespace

std::optional<PbrtType> pbrt_type(std::string_view name) {
  for (const TypeName& entry : kTypeNames) {
    if (entry.name == name) return entry.type;
  }
  return std::nullopt;
}

const char* name_of(PbrtType type) {
  for (const TypeName& entry : kTypeNames) {
    if (entry.type == type) return entry.name.data();
  }
  return "?";
}

void PbrtParameters::add(PbrtParameter parameter) { parameters_.push_back(std::move(parameter)); }

void PbrtParameters::add_defaults(const PbrtParameters& defaults) {
  const std::size_t own = parameters_.size();
  for (const PbrtParameter& extra : defaults.parameters_) {
    bool given = false;
    for (std::size_t i = 0; i < own; ++i) given = given || parameters_[i].name == extra.name;
    if (given) continue;
    parameters_.push_back(extra);
    parameters_.back().used = true;  // it was not written for this directive, so it may not fit
  }
}

const PbrtParameter* PbrtParameters::find(std::string_view name) const {
  for (const PbrtParameter& parameter : parameters_) {
    if (parameter.name != name) continue;
    parameter.used = true;
    return &parameter;
  }
  return nullptr;
}

void PbrtParameters::error(const PbrtParameter& parameter, const std::string& message,
                           const std::string& remedy) const {
  diagnostics_->error(parameter.place, message, remedy);
}

void PbrtParameters::error(const std::string& message, const std::string& remedy) const {
  diagnostics_->error(place_, message, remedy);
}

const PbrtParameter* PbrtParameters::find_number(std::string_view name, std::size_t count) const {
  const PbrtParameter* found = find(name);
  if (!found) return nullptr;
  if (!is_numeric(found->type)) {
    error(*found, fmt::format("parameter {} is of type {}, expected a number", in_quotes(name), name_of(found->type)),
          "Give it as a number.");
    return nullptr;
  }
  if (found->numbers.size() != count) {
    error(*found, fmt::format("parameter {} has {} values, expected {}", in_quotes(name), found->numbers.size(), count),
          "Give as many values as expected.");
    return nullptr;
  }
  return found;
}

float PbrtParameters::real(std::string_view name, float otherwise) const {
  const PbrtParameter* found = find_number(name, 1);
  if (!found) return otherwise;
  const auto value = static_cast<float>(found->numbers[0]);
  if (std::isfinite(value)) return value;
  error(*found, fmt::format("parameter {} is too large", in_quotes(name)), "Give a number within single precision.");
  return otherwise;
}

int PbrtParameters::integer(std::string_view name, int otherwise) const {
  const PbrtParameter* found = find_number(name, 1);
  if (!found) return otherwise;
  const double value = found->numbers[0];
  if (value == std::floor(value) && std::fabs(value) <= 2147483647.0) return static_cast<int>(value);
  error(*found, fmt::format("parameter {} is not an integer", in_quotes(name)), "Give a whole number.");
  return otherwise;
}

bool PbrtParameters::boolean(std::string_view name, bool otherwise) const {
  const PbrtParameter* found = find_number(name, 1);
  return found ? found->numbers[0] != 0 : otherwise;
}

std::string PbrtParameters::string(std::string_view name, const std::string& otherwise) const {
  const PbrtParameter* found = find(name);
  if (!found) return otherwise;
  if (found->strings.size() == 1) return found->strings[0];
  error(*found, fmt::format("parameter {} should be one string", in_quotes(name)),
        "Write it as \"string name\" \"value\".");
  return otherwise;
}

Vec3d PbrtParameters::point3(std::string_view name, Vec3d otherwise) const {
  const PbrtParameter* found = find_number(name, 3);
  if (!found) return otherwise;
  const Vec3d value{found->numbers[0], found->numbers[1], found->numbers[2]};
  if (is_finite(narrow(value))) return value;
  error(*found, fmt::format("parameter {} is too large", in_quotes(name)), "Give numbers within single precision.");
  return otherwise;
}

std::span<const double> PbrtParameters::numbers(std::string_view name, PbrtType type) const {
  const PbrtParameter* found = find(name);
  if (!found) return {};
  if (!is_numeric(found->type)) {
    error(*found,
          fmt::format("parameter {} is of type {}, expected {}", in_quotes(name), name_of(found->type), name_of(type)),
          "Give it as numbers.");
    return {};
  }
  if (found->numbers.size() % group_size(type) != 0) {
    error(*found,
          fmt::format("parameter {} has {} values, which is not a multiple of {}", in_quotes(name),
                      found->numbers.size(), group_size(type)),
          "Add or remove values.");
    return {};
  }
  return found->numbers;
}

std::span<const std::string> PbrtParameters::strings(std::string_view name) const {
  const PbrtParameter* found = find(name);
  if (!found) return {};
  if (found->type == PbrtType::string) return found->strings;
  error(*found, fmt::format("parameter {} is of type {}, expected string", in_quotes(name), name_of(found->type)),
        "Give it as strings.");
  return {};
}

void PbrtParameters::use_all() const {
  for (const PbrtParameter& parameter : parameters_) parameter.used = true;
}

void PbrtParameters::note_unused(const std::string& owner) const {
  for (const PbrtParameter& parameter : parameters_) {
    if (parameter.used) continue;
    diagnostics_->note(parameter.place, fmt::format("not used: parameter {} of {}", in_quotes(parameter.name), owner));
  }
}

}  // namespace glowworm
