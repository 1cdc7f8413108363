// Modifiers of Radiance's scene files: materials, and what changes them.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/memory_budget.h"
#include "import/notes.h"
#include "import/rad/placement.h"
#include "import/rad/words.h"
#include "scene/scene.h"
#include "scene/sky_model.h"

namespace glowworm {

/// The cone of a spotlight's material.
struct RadSpot {
  float cosine = 1;  ///< of the angle between its axis and its side
  Vec3 direction;    ///< in world space, unit
};

/// What a modifier makes of a surface.
struct RadModifier {
  bool is_pattern = false;         ///< a pattern or a texture: `below` has the material
  std::uint32_t below = kNone;     ///< the modifier of this one
  std::uint32_t material = kNone;  ///< kNone: rays pass, there is no surface
  std::uint32_t emission = kNone;
  RGB radiance{0.0f};           ///< of a light, W sr^-1 m^-2
  std::optional<RadSpot> spot;  ///< of a spotlight: its surfaces become lights without size
  bool turns = false;           ///< other directions of the placement make another material of it
  std::optional<SkyModel> sky;  ///< of the pattern that gensky and gendaylit write
};

/// The modifiers of a scene. A name means its last definition.
///
/// Models, by the Radiance reference manual and its normal.c and glass.c: plastic, metal and trans keep their shares of
/// diffuse and specular light. Ward's roughness is the alpha of GGX, which gives lobes the same peak, though GGX has
/// longer tails. Specular light of smooth ones grows towards grazing angles as Schlick has it, in place of Radiance's
/// estimate; rough plastic does not grow in either. Glass is a pane of the given transmissivity.
class RadMaterials {
 public:
  /// @param read_file the text of a file that a line names
  using FileReader = std::function<const std::string&(const std::string& name, const FilePlace& place)>;
  RadMaterials(SceneDescription& description, NoteCounter& notes, MemoryBudget& budget, FileReader read_file)
      : description_(description), notes_(notes), read_file_(std::move(read_file)), held_(budget, "materials", 0) {}

  /// Takes a modifier. Returns false, and does nothing, for another type. Throws Error with file and line for missing
  /// or wrong arguments, and for a name that is not defined.
  bool define(const RadPrimitive& p, const RadPlacement& placement);
  /// What a modifier makes of surfaces, below its patterns. Throws Error if the name is not defined.
  /// @param name "void" has no surface
  RadModifier on_surface(const std::string& name, const FilePlace& place) const;
  /// What names mean.
  using Names = std::unordered_map<std::string, std::uint32_t>;
  /// At this place of the files.
  const Names& names() const { return by_name_; }
  void set_names(const Names& names) { by_name_ = names; }

  /// What a part of the files takes from what stands before it, and what it leaves.
  struct Trace {
    Names needed;   ///< kNone: not defined
    Names defined;  ///< at its end
    void add(const Trace& part);
  };
  /// Records in a trace from here on; null: nowhere. Returns the trace before.
  Trace* trace_to(Trace* trace) { return std::exchange(trace_, trace); }
  /// Whether a part with this trace means the same here.
  bool fits(const Trace& trace) const;
  /// Defines what a part of the files does. Returns false, and does nothing, if that is another in each place.
  bool define_as(const Trace& trace);
  /// The sky among the patterns of a modifier.
  std::optional<SkyModel> sky_of(const std::string& name, const FilePlace& place) const;

 private:
  std::uint32_t find(const std::string& name) const;
  std::uint32_t index_of(const std::string& name, const FilePlace& place) const;
  void set_name(const std::string& name, std::uint32_t index);
  RadModifier make(const RadPrimitive& p, const RadPlacement& placement);
  RadModifier made_of(const RadPrimitive& p, Material material);
  RadModifier glowing(const RadPrimitive& p);
  RadModifier mixed(const RadPrimitive& p);
  Material material_of(const RadPrimitive& p);
  Material dielectric(const RadPrimitive& p);
  Material measured(const RadPrimitive& p, const RadPlacement& placement);
  std::uint32_t medium_of(RGB transmissivity, const std::string& name);
  std::uint32_t add_material(Material material);

  SceneDescription& description_;
  NoteCounter& notes_;
  FileReader read_file_;
  Reservation held_;
  std::vector<RadModifier> modifiers_;
  Names by_name_;
  Trace* trace_ = nullptr;
  std::unordered_map<std::string, std::uint32_t> by_text_;  ///< equal definitions, as of a file placed many times
};

}  // namespace glowworm
