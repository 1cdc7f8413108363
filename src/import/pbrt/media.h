// Participating media of pbrt scenes.
#pragma once
#include <map>
#include <string>

#include "import/pbrt/context.h"

namespace glowworm {

/// What MediumInterface names: indices of media, kNone for vacuum; kUnnamed where both sides are the same.
struct PbrtMediumSides {
  std::uint32_t inside = kUnnamed, outside = kUnnamed;
};

/// The media of a scene by name. They may be named before they are defined.
class PbrtMediumTable {
 public:
  explicit PbrtMediumTable(PbrtContext& context) : context_(context) {}

  /// Defines a medium. If the name is already defined, adds a note; later uses get the new one.
  void define(const std::string& name, const PbrtParameters& parameters, const TransformDouble& to_world);
  /// The sides that MediumInterface gives. @param outside the same as inside, if the directive has one name
  PbrtMediumSides sides(const std::string& inside, const std::string& outside, const PbrtPlace& place);
  /// Index of a medium by its name, or kNone for vacuum, whose name is empty.
  std::uint32_t by_name(const std::string& name, const PbrtPlace& place);
  /// Call it after the last directive. Reports names that are not defined as errors.
  void finish();

 private:
  struct Name {
    std::uint32_t index = 0;
    bool defined = false;
    PbrtPlace first_use;
  };
  std::uint32_t next_index();

  PbrtContext& context_;
  std::map<std::string, Name, std::less<>> names_;
};

/// The medium of a MakeNamedMedium directive. Reports errors in it to the context's diagnostics.
/// @param to_world the current transform
Medium make_medium(PbrtContext& context, const PbrtParameters& parameters, const TransformDouble& to_world);

}  // namespace glowworm
