// The materials of a pbrt scene by index and name.
#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "import/pbrt/context.h"
#include "import/pbrt/materials.h"
#include "import/pbrt/media.h"

namespace glowworm {

/// The scene's materials. Index 0 is pbrt's default: diffuse with a reflectance of 0.5. Names may be used before they
/// are defined.
class PbrtMaterialTable {
 public:
  explicit PbrtMaterialTable(PbrtContext& context);

  /// Adds a material without a name.
  std::uint32_t add(const std::string& kind, const PbrtParameters& parameters);
  /// Defines a named material. If the name is already defined, adds a note; later uses get the new material.
  void define(const std::string& name, const std::string& kind, const PbrtParameters& parameters);
  /// Gives a named material its present definition again; null if it has none.
  std::function<void()> restorer(const std::string& name);
  /// Index of a named material, even if it is defined later.
  std::uint32_t by_name(const std::string& name, const PbrtPlace& place);
  /// A copy of a material as a shape has it; the same index if alpha is 1, no medium is named and cameras see it.
  std::uint32_t on_shape(std::uint32_t material, const FloatInput& alpha, const PbrtMediumSides& media, bool unseen);
  /// Returns false only if texture coordinates do not affect the material.
  bool may_be_textured(std::uint32_t material) const;
  /// Call it after the last directive. Reports undefined names and mixes that contain themselves as errors. Removes
  /// triangles of "interface" materials that part no media.
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
    PbrtMediumSides media;
    bool unseen = false;
  };
  std::uint32_t next_index();
  void check_mixes();
  void remove_absent();

  PbrtContext& context_;
  Reservation held_;
  std::map<std::string, Name, std::less<>> names_;
  std::vector<bool> known_;  // for each material: false until it is defined
  std::vector<Variant> variants_;
};

}  // namespace glowworm
