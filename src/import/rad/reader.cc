#include "import/rad/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <list>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/input_file.h"
#include "core/offset_origin.h"
#include "core/parallel.h"
#include "import/instance_keeper.h"
#include "import/mesh_tools.h"
#include "import/rad/materials.h"
#include "import/rad/placement.h"
#include "import/rad/surfaces.h"
#include "import/rad/words.h"
#include "import/texture_cache.h"

namespace glowworm {

namespace {

/// Copies that commands may ask for: far more than real scenes have, and few enough to end.
constexpr std::size_t kMostCopies = 10'000'000;
constexpr std::size_t kMostLevels = 32;  ///< of files that include files

constexpr TransformDouble kUp{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {}};  ///< z up to y up

/// The part of the sky that a source covers.
struct RadSkyPart {
  RGB color{0.0f};
  std::optional<SkyModel> model;
};

class RadReader {
 public:
  RadReader(const RadFileReader& read_file, NoteCounter& notes, MemoryBudget& budget, CoordinateOrigin& origin)
      : read_file_(read_file),
        notes_(notes),
        origin_(origin),
        materials_(description_, notes, budget,
                   [this](const std::string& name, const FilePlace& place) -> const std::string& {
                     return text_of(name, place).text;
                   }),
        triangles_(budget, "triangles", 0),
        keeper_(description_.geometry, origin, triangles_) {}

  SceneDescription run(std::string_view text, const std::string& file) {
    files_.push_back(file);
    description_.z_up = true;
    read(text, {file, 1}, {});
    add_sky();
    return std::move(description_);
  }

 private:
  void read(std::string_view text, const FilePlace& place, const RadPlacement& placement) {
    RadWords words(text, place);
    for (RadWords::Item item = words.next(); item != RadWords::Item::none; item = words.next()) {
      if (++items_ % 1024 == 0) check_cancelled();
      if (item == RadWords::Item::command) {
        const FilePlace of_command = words.place();
        const std::string command = words.command();
        const Stages stages = rad_pipeline(command, of_command);
        run_command(stages, stages.size(), command, of_command, placement);
      } else {
        visit(words.primitive(), placement);
      }
    }
  }

  using Stages = std::vector<std::vector<std::string>>;

  /// Evaluates the last of the first `count` stages of a pipeline, and those in front of it for each copy that it
  /// makes.
  void run_command(const Stages& stages, std::size_t count, const std::string& command, const FilePlace& place,
                   const RadPlacement& placement) {
    const std::string& name = stages[count - 1].front();
    const std::vector<std::string> words(stages[count - 1].begin() + 1, stages[count - 1].end());
    if (name == "xform") {
      for_each_rad_copy(
          words, place, [&](const std::string& file) { return text_of(file, place).text; }, [&] { count_copy(place); },
          [&](const RadPlacement& copy, const std::vector<std::string>& files) {
            if (!files.empty()) return include(files, place, placement * copy);
            if (count == 1) throw Error(place, "xform names no file", "Write: !xform -t 1 0 0 part.rad");
            run_command(stages, count - 1, command, place, placement * copy);
          });
    } else if (name == "cat" && count == 1) {
      include(words, place, placement);
    } else if (name == "genbox" && count == 1) {
      read(rad_box(words, place), place, placement);
    } else {
      throw Error(place,
                  fmt::format("the command '!{}' is not supported: only xform, genbox and cat are evaluated", command),
                  "Run it yourself, and keep its output in a .rad file that takes its place.");
    }
  }

  struct TextFile {
    std::string name, text;
  };
  const TextFile& text_of(const std::string& name, const FilePlace& place) {
    const auto [found, fresh] = texts_.try_emplace({files_.back(), name});
    if (fresh) {
      try {
        found->second.name = name;
        found->second.text = read_file_(found->second.name, files_.back());
      } catch (const MemoryError&) {
        throw;
      } catch (const Error& error) {
        throw Error(place, error.what());
      }
    }
    return found->second;
  }

  void include(const std::vector<std::string>& names, const FilePlace& place, const RadPlacement& placement) {
    if (leaves_for_each_copy(true)) return;
    for (const std::string& name : names) {
      const TextFile& file = text_of(name, place);
      count_copy(place);
      if (std::find(files_.begin(), files_.end(), file.name) != files_.end())
        throw Error(place, fmt::format("'{}' includes itself", name), "Remove one of the !xform lines.");
      if (files_.size() > kMostLevels) throw Error(place, "files include one another too deeply");
      files_.push_back(file.name);
      const Surfaces around = std::exchange(surfaces_, Surfaces::all);
      place_file(file, placement);
      surfaces_ = around;
      files_.pop_back();
    }
  }

  /// What is read of a file: all of it, the surfaces that its copies share, or the rest, which each copy has for
  /// itself.
  enum class Surfaces { all, shared, own };

  /// What copies of a file must have in common to share surfaces, beside what names mean.
  struct FileUse {
    std::string name, modifier;
    bool inverted;
    auto operator<=>(const FileUse&) const = default;
  };
  /// Copies that share surfaces.
  struct SharedUse {
    RadMaterials::Trace trace;
    bool has_own = false;  ///< whether each has more, once that is known
  };

  /// Copies of this file to which names mean the same; null if there were none.
  SharedUse* known_use(std::list<SharedUse>& uses) const {
    constexpr int kTried = 16;  // the latest
    int tried = 0;
    for (auto use = uses.rbegin(); use != uses.rend() && tried < kTried; ++use, ++tried)
      if (materials_.fits(use->trace)) return &*use;
    return nullptr;
  }

  /// Reads a file, or places what it shares with other copies as an instance.
  void place_file(const TextFile& file, const RadPlacement& placement) {
    const FilePlace start{file.name, 1};
    std::list<SharedUse>& uses = uses_[{file.name, placement.modifier, placement.inverted}];
    SharedUse* use = known_use(uses);
    const bool is_first = !use;
    if (is_first) use = &uses.emplace_back();
    RadMaterials::Trace* const around = materials_.trace_to(is_first ? &use->trace : nullptr);
    const auto shared_mesh = [&] {
      surfaces_ = Surfaces::shared;
      has_own_ = false;
      const RadMaterials::Names names = materials_.names();
      CoordinateOrigin origin;
      Geometry mesh = read_near(origin, [&] {
        shared_ = {{}, &origin};
        read(file.text, start, {{}, placement.inverted, "", placement.modifier});
        return std::move(shared_.mesh);
      });
      use->has_own = has_own_;
      materials_.set_names(names);
      return SharedMesh{std::move(mesh), Vec3d(origin.origin())};
    };
    std::string name = placement.prefix.substr(0, placement.prefix.rfind('.'));
    if (name.empty()) name = std::filesystem::path(file.name).stem().string();
    const bool is_kept = keeper_.keep(use, kUp * placement.to_world, name, shared_mesh) != kNone;
    surfaces_ = is_kept ? Surfaces::own : Surfaces::all;
    if (!is_kept || use->has_own || !materials_.define_as(use->trace)) read(file.text, start, placement);
    materials_.trace_to(around);
    if (around) around->add(use->trace);
  }

  /// Whether a surface or statement is left out now. @param own whether each copy has it for itself
  bool leaves_for_each_copy(bool own) {
    has_own_ = has_own_ || own;
    return surfaces_ != Surfaces::all && own == (surfaces_ == Surfaces::shared);
  }

  void visit(const RadPrimitive& p, const RadPlacement& placement) {
    if (materials_.define(p, placement)) return;
    if (is_rad_surface(p.type)) return add_surface(p, placement);
    if (p.type == "source") return leaves_for_each_copy(true) ? void() : add_source(p, placement);
    if (p.type == "instance" || p.type == "mesh")
      throw Error(p.place, fmt::format("{} '{}' needs a compiled file, which is not read", p.type, p.name),
                  p.type == "mesh" ? "Turn the .obj file that it was made of into .rad by obj2rad."
                                   : "Place the .rad files that its octree was made of by !xform.");
    throw Error(p.place, fmt::format("'{}' is not a type of Radiance", p.type),
                "Check that the primitive before it has as many arguments as it says.");
  }

  const std::string& modifier_of(const RadPrimitive& p, const RadPlacement& placement) const {
    return placement.modifier.empty() ? p.modifier : placement.modifier;
  }

  void add_surface(const RadPrimitive& p, const RadPlacement& placement) {
    const RadModifier modifier = materials_.on_surface(modifier_of(p, placement), p.place);
    const bool is_own =
        modifier.material == kNone || modifier.emission != kNone || modifier.spot.has_value() || modifier.turns;
    if (leaves_for_each_copy(is_own)) return;
    if (modifier.material == kNone) return notes_.add("surface without a material, which is not seen, left out");
    const bool is_shared = surfaces_ == Surfaces::shared;
    Geometry mesh = rad_surface(p, is_shared ? placement.to_world : kUp * placement.to_world, placement.inverted,
                                is_shared ? *shared_.origin : origin_, notes_);
    if (is_shared) return append_counted(shared_.mesh, mesh, p.place.file, modifier.material, kNone, notes_);
    triangles_.grow(scene_bytes(mesh));
    const std::string name = placement.prefix + p.name;
    if (modifier.spot) add_spot(*modifier.spot, modifier.radiance, mesh, name);
    description_.geometry.begin_object(name);
    append_counted(description_.geometry, mesh, p.place.file, modifier.material, modifier.emission, notes_);
  }

  /// The place along an axis through a point from which the axis leads away from all of the surface.
  static Vec3 before_surface(const Geometry& mesh, Vec3 point, Vec3 along) {
    float front = 0;
    double rounding = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vec3 corner = mesh.positions[a], e1 = mesh.positions[b] - corner, e2 = mesh.positions[c] - corner;
      if (length(cross(e1, e2)) > 0) rounding = std::max(rounding, rounding_offset(corner, e1, e2));
      for (const std::uint32_t vertex : {a, b, c}) front = std::max(front, dot(mesh.positions[vertex] - point, along));
    }
    // The light's own coordinates are rounded, too.
    return point + along * (front + static_cast<float>(2 * rounding) + position_rounding(point));
  }

  /// A spotlight without size has the intensity of its surface along the axis. It hangs just before that surface, which
  /// would shade it.
  void add_spot(const RadSpot& spot, RGB radiance, const Geometry& mesh, const std::string& name) {
    const Vec3 along = y_up_from_z_up(spot.direction);
    Vec3 middle{0, 0, 0};
    float area = 0, across = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      const float part = mesh.area(t);
      area += part;
      across += std::max(0.0f, dot(mesh.scaled_normal(t), along) / 2);
      middle += (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) * (part / 3);
    }
    if (!(area > 0) || !(across > 0)) return notes_.add(fmt::format("spotlight '{}' faces away from its axis", name));
    notes_.add(fmt::format("spotlight '{}' is a light without size", name));
    Light light;
    light.name = name;
    light.kind = LightKind::spot;
    light.position = before_surface(mesh, middle / area, along);
    light.direction = along;
    light.intensity = radiance * across;
    light.cos_inner = light.cos_outer = spot.cosine;
    triangles_.grow(sizeof(Light) + light.name.size());
    description_.lights.push_back(light);
  }

  /// Counts a copy, an included file or a step of an array.
  void count_copy(const FilePlace& place) {
    if (++copies_ > kMostCopies) throw Error(place, fmt::format("the file asks for more than {} copies", kMostCopies));
    if (copies_ % 1024 == 0) check_cancelled();
  }

  void add_source(const RadPrimitive& p, const RadPlacement& placement) {
    if (p.numbers.size() != 4)
      throw Error(p.place, fmt::format("source '{}' has {} numbers", p.name, p.numbers.size()),
                  "Expected: a direction and an angle.");
    const Vec3 given = narrow(placement.to_world.vector({p.numbers[0], p.numbers[1], p.numbers[2]}));
    const double angle = p.numbers[3];
    if (!(length(given) > 0) || !(angle > 0) || angle > 360)
      throw Error(p.place, fmt::format("source '{}' has no direction, or no angle up to 360 degrees", p.name));
    const Vec3 towards = normalize(y_up_from_z_up(given));
    const std::string& name = modifier_of(p, placement);
    const RadModifier modifier = materials_.on_surface(name, p.place);
    if (is_black(modifier.radiance)) return;
    if (angle >= 180) return add_sky_part(p, {modifier.radiance, materials_.sky_of(name, p.place)}, towards);
    if (angle > 2) notes_.add(fmt::format("source '{}' of {:g} degrees is a light without size", p.name, angle));
    Light sun;
    sun.name = placement.prefix + p.name;
    sun.kind = LightKind::directional;
    sun.direction = -towards;
    const double sine = std::sin(angle / 2 * M_PI / 180);
    sun.intensity = modifier.radiance * static_cast<float>(M_PI * sine * sine);
    triangles_.grow(sizeof(Light) + sun.name.size());
    description_.lights.push_back(sun);
  }

  void add_sky_part(const RadPrimitive& p, const RadSkyPart& part, Vec3 towards) {
    const bool whole = p.numbers[3] >= 360;
    if (!whole && std::abs(towards.y) < 0.999f)
      throw Error(p.place, fmt::format("source '{}' is half of the sky, but neither upwards nor downwards", p.name),
                  "Give it the direction 0 0 1 or 0 0 -1, or 360 degrees.");
    for (const bool up : {true, false}) {
      if (!whole && up != (towards.y > 0)) continue;
      std::optional<RadSkyPart>& known = up ? sky_ : ground_;
      if (known) notes_.add(fmt::format("source '{}' takes the place of the sky or ground before", p.name));
      known = part;
    }
  }

  /// Makes the environment of the parts that sources cover.
  void add_sky() {
    if (!sky_ && !ground_) return;
    const RGB color = sky_ ? sky_->color : ground_->color;
    SkyModel model;
    model.c = model.offset = 0;
    if (sky_ && sky_->model) model = *sky_->model;
    if (!sky_) model.zenith = 0;
    model.ground = 0;
    if (ground_) {
      // The environment has one colour, so the ground keeps its luminance.
      const float level = ground_->model ? ground_->model->ground : 1;
      model.ground = level * luminance(ground_->color) / luminance(color);
      if (!is_black(ground_->color / luminance(ground_->color) - color / luminance(color)))
        notes_.add("the ground has the colour of the sky, and its own luminance");
    }
    if (!(luminance(color) > 0) || !std::isfinite(horizontal_irradiance(model)) || !std::isfinite(model.ground))
      throw Error({files_.front()}, "the radiance of the sky is negative or not finite");
    description_.environment = sky_environment(model);
    description_.environment->name = "sky";
    description_.environment->scale = color;
  }

  const RadFileReader& read_file_;
  NoteCounter& notes_;
  CoordinateOrigin& origin_;
  SceneDescription description_;
  RadMaterials materials_;
  Reservation triangles_;
  InstanceKeeper keeper_;
  std::map<FileUse, std::list<SharedUse>> uses_;
  Surfaces surfaces_ = Surfaces::all;
  struct {
    Geometry mesh;
    CoordinateOrigin* origin = nullptr;
  } shared_;                                                       ///< what copies share
  bool has_own_ = false;                                           ///< whether something was met that they do not
  std::map<std::pair<std::string, std::string>, TextFile> texts_;  ///< by the file that names it, and its name there
  std::vector<std::string> files_;  ///< the scene's, and those included around this place
  std::optional<RadSkyPart> sky_, ground_;
  std::size_t items_ = 0, copies_ = 0;
};

}  // namespace

SceneDescription parse_rad(std::string_view text, const std::string& file, const RadFileReader& read_file,
                           NoteCounter& notes, MemoryBudget& budget, CoordinateOrigin& origin) {
  return RadReader(read_file, notes, budget, origin).run(text, file);
}

SceneDescription load_rad(const std::string& path, const ImportOptions& options, CoordinateOrigin& origin) {
  NoteCounter notes;
  Reservation held(*options.budget, "scene files", 0);
  const std::filesystem::path scene(path);
  const RadFileReader read_file = [&](std::string& name, const std::string& named_by) {
    // xform reads a file in the folder of its own; oconv names files from where it is started.
    const std::string near = find_texture_file(std::filesystem::path(named_by).parent_path().string(), name);
    std::error_code error;
    const bool found = std::filesystem::exists(near, error);
    name = found ? near : find_texture_file(scene.parent_path().string(), name);
    return read_input_file(name, held);
  };
  SceneDescription description =
      parse_rad(read_input_file(path, held), path, read_file, notes, *options.budget, origin);
  description.name = scene.stem().string();
  if (description.geometry.triangles.empty())
    throw Error({path}, "has no surfaces", "Give the file that has them, or that places them by !xform.");
  notes.write_to(description.notes);
  return description;
}

}  // namespace glowworm
