// The materials of a pbrt scene by index and name.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "import/pbrt/context.h"
#include "import/pbrt/materials.h"

namespace glowworm {

/// Fills in the scene's materials; index 0 is pbrt's default, diffuse with a reflectance of 0.5. A name may be used
/// before it is defined.
class PbrtMaterialTable {
 public:
  explicit PbrtMaterialTable(PbrtContext& context);

  /// Adds a material without a name.
  std::uint32_t add(const std::string& kind, const PbrtParameters& parameters);
  /// Defines a name. One that is defined already is noted, and what comes later takes the new material.
  void define(const std::string& name, const std::string& kind, const PbrtParameters& parameters);
  /// Index of a named material, known or yet to come.
  std::uint32_t by_name(const std::string& name, const PbrtPlace& place);
  /// A material like another with a shape's alpha; the same index where alpha is 1.
  std::uint32_t with_alpha(std::uint32_t material, const FloatInput& alpha);
  /// False where texture coordinates surely don't matter to the material.
  bool may_be_textured(std::uint32_t material) const;
  /// After the last directive: names that were never defined are errors, as are mixes that hold themselves; triangles
  /// of materials that are not there ("interface") are taken out.
  void finish();

 private:
  struct Name {
    std::uint32_t index = 0;
    bool defined = false;
    PbrtPlace first_use;
  };
  struct Variant {
    std::uint32_t base = 0, index = 0;
    FloatInput alpha;
  };
  std::uint32_t next_index();
  void check_mixes();
  void remove_absent();

  PbrtContext& context_;
  std::map<std::string, Name, std::less<>> names_;
  std::vector<bool> known_;  // one a material: false until it is defined
  std::vector<Variant> variants_;
};

}  // namespace glowworm
