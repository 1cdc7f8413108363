#include "import/pbrt/builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "import/instance_keeper.h"
#include "import/mesh_tools.h"
#include "import/pbrt/camera.h"
#include "import/pbrt/lights.h"
#include "import/pbrt/material_table.h"
#include "import/pbrt/media.h"
#include "import/pbrt/motion.h"
#include "import/pbrt/placement.h"
#include "import/pbrt/shapes.h"
#include "import/pbrt/textures.h"
#include "import/pbrt/transforms.h"

namespace glowworm {

namespace {

constexpr std::size_t kMaxNesting = 10000;
constexpr int kDeepestObject = 1000;

/// What ObjectBegin defines.
struct PbrtObject {
  struct Part {
    const PbrtObject* object;
    std::string name;
    TransformDouble to_outer;
  };
  std::vector<PbrtShape> shapes, lamps;  ///< lamps emit light
  std::vector<Part> parts;               ///< objects that it places
  int depth = 0;                         ///< of the objects in it

  bool is_empty() const { return shapes.empty() && lamps.empty() && parts.empty(); }
};

/// Parameters set by Attribute directives, newest first. It is a linked list, so that states saved by AttributeBegin
/// share it.
struct Defaults {
  std::string target;  ///< "shape", "light", ...
  PbrtParameters parameters;
  std::shared_ptr<const Defaults> before;
  int length = 1;  ///< length of the list
};
constexpr int kMaxDefaults = 256;

/// Whether `parameters` contains all names of `others`.
bool hides(const PbrtParameters& parameters, const PbrtParameters& others) {
  return std::all_of(others.all().begin(), others.all().end(), [&](const PbrtParameter& other) {
    return std::any_of(parameters.all().begin(), parameters.all().end(),
                       [&](const PbrtParameter& own) { return own.name == other.name; });
  });
}

/// The state that AttributeBegin saves.
struct Attributes {
  PbrtTransforms transforms;
  bool reverse = false;
  std::uint32_t material = 0;
  bool textured_material = false;
  PbrtMediumSides media;
  std::uint32_t outside_medium = kNone;  ///< of cameras
  std::shared_ptr<PbrtAreaLight> light;
  std::shared_ptr<const Defaults> defaults;  ///< null: none
  PbrtColorSpace color_space = PbrtColorSpace::srgb;
  bool start_active = true, end_active = true;  ///< whether transforms apply to the ends of the motion
};

struct Saved {
  Attributes attributes;
  std::size_t redefinitions = 0;  ///< number of State::redefinitions before the block
  std::string_view opened_by;
  PbrtPlace place;
};

}  // namespace

struct PbrtBuilder::State {
  explicit State(PbrtContext& context_)
      : context(context_),
        materials(context_),
        media(context_),
        object_meshes(*context_.budget, "object meshes", 0),
        triangles(*context_.budget, "triangles", 0),
        keeper(context_.scene.geometry, context_.origin, triangles) {}

  PbrtContext& context;
  PbrtMaterialTable materials;
  PbrtMediumTable media;
  Attributes now;
  std::vector<Saved> stack;
  std::vector<std::function<void()>> redefinitions;  ///< of names within open blocks: restore the older value
  std::size_t ignored_nesting = 0;
  std::map<std::string, PbrtTransforms, std::less<>> coordinate_systems;
  std::map<std::string, PbrtObject, std::less<>> objects;
  PbrtObject* open_object = nullptr;
  PbrtObject repeated;  ///< takes what a second definition of a name holds
  std::optional<PbrtDirective> film;
  float exposure_seconds = 1;
  Shutter shutter{0, 1};                 ///< of the first camera
  double first_time = 0, last_time = 1;  ///< of the motion, s
  PbrtTransforms camera_to_world;        ///< of the first camera
  double camera_first_time = 0, camera_last_time = 1;
  std::optional<PbrtPlace> moving;  ///< the first directive that moves anything but the camera
  double moving_from = 0, moving_until = 0;
  std::optional<PbrtPlace> moving_camera;
  bool has_world_content = false;
  Reservation object_meshes, triangles;
  InstanceKeeper keeper;

  using Action = void (State::*)(PbrtDirective&);
  static Action action_of(std::string_view name);

  PbrtDiagnostics& diagnostics() { return context.diagnostics; }
  void note(const PbrtDirective& d, const std::string& text) { diagnostics().note(d.place, text); }
  void error(const PbrtDirective& d, const std::string& message, const std::string& remedy) {
    diagnostics().error(d.place, message, remedy);
  }
  /// The transform at a directive, at the moment that is shown.
  TransformDouble transform_at(const PbrtDirective& d) {
    if (now.transforms.moves()) {
      moving_from = moving ? std::min(moving_from, first_time) : first_time;
      moving_until = moving ? std::max(moving_until, last_time) : last_time;
      if (!moving) moving = d.place;
    }
    return transform_between(now.transforms, first_time, last_time, context.seconds, d.place);
  }
  TransformDouble transform_between(const PbrtTransforms& ends, double first, double last, double seconds,
                                    const PbrtPlace& place) {
    const double share = seconds <= first ? 0 : seconds >= last ? 1 : (seconds - first) / (last - first);
    const std::optional<TransformDouble> out = between(ends, share);
    if (!out)
      diagnostics().error(place, "the transform at the start or the end of the motion cannot be inverted",
                          "A scale of 0? Between them, scale and rotation are interpolated.");
    return out.value_or(ends.start);
  }
  void add_motion();
  void add_defaults(const char* target, PbrtDirective& d) {
    for (const Defaults* set = now.defaults.get(); set; set = set->before.get()) {
      if (set->target == target) d.parameters.add_defaults(set->parameters);
    }
  }

  void ignore(PbrtDirective&) {}
  void attribute(PbrtDirective& d) {
    auto set = std::make_shared<Defaults>(Defaults{d.strings[0], d.parameters, now.defaults});
    while (set->before && set->before->target == set->target && hides(set->parameters, set->before->parameters)) {
      set->before = set->before->before;
    }
    if (set->before) set->length = set->before->length + 1;
    if (set->length > kMaxDefaults) {
      return error(d, fmt::format("more than {} Attribute directives are in force", kMaxDefaults),
                   "Merge some of them.");
    }
    now.defaults = std::move(set);
  }
  void begin(PbrtDirective& d) {
    if (stack.size() < kMaxNesting) {
      stack.push_back({now, redefinitions.size(), d.name, d.place});
    } else if (ignored_nesting++ == 0) {
      error(d, fmt::format("{} is nested more than {} deep", d.name, kMaxNesting), "Close open blocks.");
    }
  }
  void end(PbrtDirective& d);
  /// Call it before a name gets a new value. In pbrt-v3, the older one is back after the block.
  /// @param restore sets the older value; null if there is none
  void redefine(std::function<void()> restore) {
    if (context.v3 && !stack.empty() && restore) redefinitions.push_back(std::move(restore));
  }
  void color_space(PbrtDirective& d);
  void transform(PbrtDirective& d);
  void active_transform(PbrtDirective& d);
  void transform_times(PbrtDirective& d);
  void coordinate_system(PbrtDirective& d) { coordinate_systems[d.strings[0]] = now.transforms; }
  void coordinate_system_transform(PbrtDirective& d);
  void reverse_orientation(PbrtDirective&) { now.reverse = !now.reverse; }
  void camera(PbrtDirective& d);
  void set_film(PbrtDirective& d) { film = d; }
  void render_setting(PbrtDirective& d) {
    note_render_settings(d.name, d.strings[0], d.parameters, context.scene.film);
  }
  void world_begin(PbrtDirective& d);
  void make_named_medium(PbrtDirective& d);
  void medium_interface(PbrtDirective& d);
  void texture(PbrtDirective& d);
  void material(PbrtDirective& d);
  void make_named_material(PbrtDirective& d);
  void named_material(PbrtDirective& d);
  void light_source(PbrtDirective& d);
  void area_light_source(PbrtDirective& d);
  void shape(PbrtDirective& d);
  void place(const PbrtShape& shape, const TransformDouble& to_world);
  void object_begin(PbrtDirective& d);
  void object_instance(PbrtDirective& d);
  void place_object(const PbrtObject& object, const std::string& name, const TransformDouble& to_world);
};

PbrtBuilder::State::Action PbrtBuilder::State::action_of(std::string_view name) {
  struct Entry {
    std::string_view name;
    Action action;
  };
  static constexpr std::array kActions = {
      Entry{"Shape", &State::shape},
      Entry{"AttributeBegin", &State::begin},
      Entry{"AttributeEnd", &State::end},
      Entry{"TransformBegin", &State::begin},
      Entry{"TransformEnd", &State::end},
      Entry{"ObjectBegin", &State::object_begin},
      Entry{"ObjectEnd", &State::end},
      Entry{"ObjectInstance", &State::object_instance},
      Entry{"Attribute", &State::attribute},
      Entry{"Identity", &State::transform},
      Entry{"Transform", &State::transform},
      Entry{"ConcatTransform", &State::transform},
      Entry{"Translate", &State::transform},
      Entry{"Scale", &State::transform},
      Entry{"Rotate", &State::transform},
      Entry{"LookAt", &State::transform},
      Entry{"ActiveTransform", &State::active_transform},
      Entry{"TransformTimes", &State::transform_times},
      Entry{"CoordinateSystem", &State::coordinate_system},
      Entry{"CoordSysTransform", &State::coordinate_system_transform},
      Entry{"ReverseOrientation", &State::reverse_orientation},
      Entry{"ColorSpace", &State::color_space},
      Entry{"Camera", &State::camera},
      Entry{"Film", &State::set_film},
      Entry{"Sampler", &State::render_setting},
      Entry{"Integrator", &State::render_setting},
      Entry{"PixelFilter", &State::render_setting},
      Entry{"WorldBegin", &State::world_begin},
      Entry{"MakeNamedMedium", &State::make_named_medium},
      Entry{"MediumInterface", &State::medium_interface},
      Entry{"Texture", &State::texture},
      Entry{"Material", &State::material},
      Entry{"MakeNamedMaterial", &State::make_named_material},
      Entry{"NamedMaterial", &State::named_material},
      Entry{"LightSource", &State::light_source},
      Entry{"AreaLightSource", &State::area_light_source},
  };
  for (const Entry& entry : kActions) {
    if (entry.name == name) return entry.action;
  }
  // Directives that control rendering (Accelerator, Option, ...) are ignored.
  return &State::ignore;
}

void PbrtBuilder::State::end(PbrtDirective& d) {
  if (ignored_nesting > 0) {
    --ignored_nesting;
    return;
  }
  const std::string_view stem = d.name.substr(0, d.name.size() - 3);  // without "End"
  if (stack.empty() || !stack.back().opened_by.starts_with(stem)) {
    const std::string open =
        stack.empty() ? "no block is open"
                      : fmt::format("{} at {} is open", stack.back().opened_by, to_string(stack.back().place));
    error(d, fmt::format("{} without its {}Begin: {}", d.name, stem, open),
          "Remove it, or close the open block first.");
    return;
  }
  Attributes& saved = stack.back().attributes;
  if (stem == "Transform") {
    now.transforms = saved.transforms;
    now.start_active = saved.start_active;
    now.end_active = saved.end_active;
  } else {
    now = std::move(saved);
    for (; redefinitions.size() > stack.back().redefinitions; redefinitions.pop_back()) redefinitions.back()();
  }
  if (stem == "Object") open_object = nullptr;
  stack.pop_back();
}

void PbrtBuilder::State::color_space(PbrtDirective& d) {
  const std::string& name = d.strings[0];
  if (name == "srgb") {
    now.color_space = PbrtColorSpace::srgb;
  } else if (name == "rec2020") {
    now.color_space = PbrtColorSpace::rec2020;
  } else if (name == "dci-p3") {
    now.color_space = PbrtColorSpace::dci_p3;
  } else if (name == "aces2065-1") {
    now.color_space = PbrtColorSpace::aces2065_1;
  } else {
    error(d, fmt::format("unknown colour space {}", in_quotes(name)),
          "Supported: srgb, rec2020, dci-p3 and aces2065-1.");
  }
}

void PbrtBuilder::State::transform(PbrtDirective& d) {
  PbrtTransforms& both = now.transforms;
  const bool moved = both.moves();
  for (const bool at_start : {true, false}) {
    if (!(at_start ? now.start_active : now.end_active)) continue;
    // One transform, and one message, where both ends are the same.
    if (!at_start && now.start_active && !moved) {
      both.end = both.start;
      return;
    }
    TransformDouble& current = at_start ? both.start : both.end;
    const auto changed = apply_transform(d, current);
    if (!changed) return;
    current = *changed;
  }
}

void PbrtBuilder::State::active_transform(PbrtDirective& d) {
  const std::string& word = d.strings[0];
  if (word != "StartTime" && word != "EndTime" && word != "All") {
    error(d, fmt::format("ActiveTransform {}", in_quotes(word)), "Expected StartTime, EndTime or All.");
    return;
  }
  now.start_active = word != "EndTime";
  now.end_active = word != "StartTime";
}

void PbrtBuilder::State::transform_times(PbrtDirective& d) {
  if (!(d.numbers[0] <= d.numbers[1])) return error(d, "TransformTimes end before they start", "Swap them.");
  first_time = d.numbers[0];
  last_time = d.numbers[1];
}

void PbrtBuilder::State::coordinate_system_transform(PbrtDirective& d) {
  const auto found = coordinate_systems.find(d.strings[0]);
  if (found != coordinate_systems.end()) {
    now.transforms = found->second;
  } else {
    error(d, fmt::format("no coordinate system {}", in_quotes(d.strings[0])), "Define it by CoordinateSystem.");
  }
}

void PbrtBuilder::State::camera(PbrtDirective& d) {
  if (!is_invertible(now.transforms.start) || !is_invertible(now.transforms.end)) {
    error(d, "the transform of the camera cannot be inverted", "A scale of 0, or points of LookAt that coincide?");
    return;
  }
  const PbrtTransforms to_world{inverse(now.transforms.start), inverse(now.transforms.end)};
  coordinate_systems["camera"] = to_world;
  const TransformDouble shown = transform_between(to_world, first_time, last_time, context.seconds, d.place);
  Camera camera = make_camera(d.strings[0], d.parameters, shown.relative_to(context.origin.origin()));
  if (context.scene.cameras.empty()) {
    context.scene.ambient_medium = now.outside_medium;
    camera_to_world = to_world;
    camera_first_time = first_time;
    camera_last_time = last_time;
    shutter = shutter_of(d.parameters);
    if (to_world.moves()) moving_camera = d.place;
  }
  if (!context.scene.cameras.empty()) camera.name += fmt::format("{}", context.scene.cameras.size() + 1);
  // Pictures of pbrt-v3 do not depend on the shutter.
  exposure_seconds = context.v3 ? 1.0f : exposure_time(d.parameters);
  context.scene.cameras.push_back(camera);
}

void PbrtBuilder::State::world_begin(PbrtDirective& d) {
  if (has_world_content) {
    error(d, "WorldBegin comes after shapes or lights", "Move them after it: only the camera comes before.");
  }
  now.transforms = PbrtTransforms();
  now.start_active = now.end_active = true;
  coordinate_systems["world"] = now.transforms;
}

void PbrtBuilder::State::make_named_medium(PbrtDirective& d) {
  add_defaults("medium", d);
  media.define(d.strings[0], d.parameters, transform_at(d));
  d.parameters.note_unused(fmt::format("medium {}", in_quotes(d.strings[0])));
}

void PbrtBuilder::State::medium_interface(PbrtDirective& d) {
  const std::string& inside = d.strings.front();
  const std::string& outside = d.strings.back();
  now.media = media.sides(inside, outside, d.place);
  now.outside_medium = media.by_name(outside, d.place);
}

void PbrtBuilder::State::texture(PbrtDirective& d) {
  add_defaults("texture", d);
  auto& table = d.strings[1] == "float" ? context.float_textures : context.spectrum_textures;
  if (const auto older = table.find(d.strings[0]); older != table.end()) {
    redefine([&table, name = older->first, value = older->second] { table[name] = value; });
  }
  define_texture(context, d.strings[0], d.strings[1], d.strings[2], d.parameters);
  d.parameters.note_unused(fmt::format("texture {}", in_quotes(d.strings[2])));
}

void PbrtBuilder::State::material(PbrtDirective& d) {
  add_defaults("material", d);
  now.material = materials.add(d.strings[0], d.parameters);
  now.textured_material = materials.may_be_textured(now.material);
}

void PbrtBuilder::State::make_named_material(PbrtDirective& d) {
  add_defaults("material", d);
  const std::string kind = d.parameters.string("type", "");
  if (kind.empty()) {
    error(d, fmt::format("the material {} has no type", in_quotes(d.strings[0])), "Give \"string type\".");
    return;
  }
  redefine(materials.restorer(d.strings[0]));
  materials.define(d.strings[0], kind, d.parameters);
}

void PbrtBuilder::State::named_material(PbrtDirective& d) {
  now.material = materials.by_name(d.strings[0], d.place);
  now.textured_material = materials.may_be_textured(now.material);
}

void PbrtBuilder::State::light_source(PbrtDirective& d) {
  has_world_content = true;
  add_defaults("light", d);
  if (const TransformDouble to_world = transform_at(d); is_invertible(to_world)) {
    add_light(context, d.strings[0], d.parameters, to_world);
  } else {
    error(d, "the transform of the light cannot be inverted", "A scale of 0?");
  }
}

void PbrtBuilder::State::area_light_source(PbrtDirective& d) {
  add_defaults("light", d);
  now.light = std::make_shared<PbrtAreaLight>(make_area_light(context, d.strings[0], d.parameters));
}

void PbrtBuilder::State::shape(PbrtDirective& d) {
  has_world_content = true;
  add_defaults("shape", d);
  PbrtShape shape;
  shape.to_outer = transform_at(d);
  shape.reverse = now.reverse;
  shape.place = d.place;
  shape.kind = d.strings[0];
  shape.name = d.parameters.string("name", "");
  const FloatInput alpha = float_input(context, d.parameters, "alpha", 1);
  shape.material = materials.on_shape(now.material, alpha, now.media, !d.parameters.boolean("seenbycameras", true));
  shape.textured =
      now.textured_material || alpha.texture != kNone || (now.light && now.light->emission.radiance.texture != kNone);
  shape.light = now.light;
  if (shape.light && alpha.texture == kNone && alpha.value == 0) {
    note(d, "not supported, left out with its light: area light of a shape with an alpha of 0");
  }
  auto mesh = make_shape(context, shape.kind, d.parameters, shape.light != nullptr);
  d.parameters.note_unused(fmt::format("shape {}", in_quotes(shape.kind)));
  if (!mesh) return;
  shape.mesh = std::move(*mesh);
  if (open_object) {
    // An object without triangles would cost time at each place, and no memory that bounds it.
    if (shape.mesh.geometry.triangles.empty()) return;
    object_meshes.grow(sizeof shape + mesh_bytes(shape.mesh.geometry));
    (shape.light ? open_object->lamps : open_object->shapes).push_back(std::move(shape));
  } else {
    place(shape, TransformDouble());
  }
}

void PbrtBuilder::State::place(const PbrtShape& shape, const TransformDouble& to_world) {
  triangles.grow(scene_bytes(shape.mesh.geometry));
  try {
    place_shape(context, shape, to_world);
  } catch (const Error& error) {
    diagnostics().error(shape.place, error.what(), "");
  }
}

void PbrtBuilder::State::object_begin(PbrtDirective& d) {
  if (open_object) {
    error(d, "ObjectBegin inside of an object", "Close the object before with ObjectEnd.");
    return;
  }
  begin(d);
  const auto [entry, is_new] = objects.try_emplace(d.strings[0]);
  if (!is_new) {
    error(d, fmt::format("the object {} is defined twice", in_quotes(d.strings[0])), "Give one of them another name.");
    repeated = {};
  }
  open_object = is_new ? &entry->second : &repeated;
}

void PbrtBuilder::State::object_instance(PbrtDirective& d) {
  has_world_content = true;
  const auto found = objects.find(d.strings[0]);
  if (found == objects.end()) {
    error(d, fmt::format("no object {}", in_quotes(d.strings[0])), "Define it first by ObjectBegin.");
    return;
  }
  const PbrtObject& object = found->second;
  if (!open_object) return place_object(object, d.strings[0], transform_at(d));
  if (&object == open_object) {
    error(d, fmt::format("the object {} contains itself", in_quotes(d.strings[0])), "Remove the ObjectInstance.");
  } else if (object.depth == kDeepestObject) {
    error(d, fmt::format("objects are nested more than {} deep", kDeepestObject), "Place the inner ones themselves.");
  } else if (!object.is_empty()) {
    open_object->depth = std::max(open_object->depth, object.depth + 1);
    object_meshes.grow(sizeof(PbrtObject::Part) + d.strings[0].size());
    open_object->parts.push_back({&object, d.strings[0], transform_at(d)});
  }
}

/// Adds an object: its shapes as an instance where that saves memory, its lamps, and the objects in it.
void PbrtBuilder::State::place_object(const PbrtObject& object, const std::string& name,
                                      const TransformDouble& to_world) {
  check_cancelled();
  if (diagnostics().full()) return;
  // Errors of shapes are found with the first place.
  const bool kept =
      diagnostics().error_count() == 0 &&
      keeper.keep(&object, to_world, fmt::format("{} {}", name, context.scene.geometry.instances.size() + 1),
                  [&] { return shared_mesh(object.shapes); }) != kNone;
  for (const auto* shapes : {&object.shapes, &object.lamps})
    for (const PbrtShape& shape : *shapes)
      if (!kept || shapes == &object.lamps) place(shape, to_world);
  for (const PbrtObject::Part& part : object.parts) place_object(*part.object, part.name, to_world * part.to_outer);
}

/// Tells the motion what moves, and adds the cameras of its moments.
void PbrtBuilder::State::add_motion() {
  const std::optional<PbrtPlace>& first = moving_camera ? moving_camera : moving;
  SceneMotion* const motion = context.motion;
  context.moves = first.has_value();
  if (!first) return;
  if (motion) {
    if (!motion->shutter && shutter.close > shutter.open) motion->shutter = shutter;
    motion->length = std::max(moving ? moving_until : 0, moving_camera ? camera_last_time : 0);
    motion->cover_length();
    const auto phase = [&](FrameMoment m) { return std::clamp(motion->seconds(m), moving_from, moving_until); };
    const std::vector<FrameMoment> moments = motion->moments();
    motion->anything_else_moves = moving && std::any_of(moments.begin(), moments.end(), [&](FrameMoment m) {
                                    return phase(m) != phase(moments.front());
                                  });
  }
  if (context.seconds == 0 && (!motion || (motion->is_still && motion->slice_count() == 0)))
    diagnostics().note(*first, "motion: the first moment is shown; --at shows another, --shutter its blur");
  if (!motion || !moving_camera || context.scene.cameras.empty()) return;
  if (motion->is_still && motion->slice_count() == 0) return;
  for (const FrameMoment moment : motion->moments()) {
    Camera camera = context.scene.cameras.front();
    const TransformDouble to_world = transform_between(camera_to_world, camera_first_time, camera_last_time,
                                                       motion->seconds(moment), *moving_camera);
    place_camera(camera, to_world.relative_to(context.origin.origin()));
    camera.name = moment.camera();
    context.scene.cameras.push_back(std::move(camera));
  }
}

PbrtBuilder::PbrtBuilder(PbrtContext& context) : state_(std::make_unique<State>(context)) {}
PbrtBuilder::~PbrtBuilder() = default;

void PbrtBuilder::take(PbrtDirective& directive) try {
  state_->context.color_space = state_->now.color_space;
  (state_.get()->*State::action_of(directive.name))(directive);
} catch (const MemoryError& error) {
  const PbrtPlace& at = directive.place;
  throw Error({at.file ? *at.file : "", at.line, at.column}, error.what(), "", ErrorCode::memory);
}

void PbrtBuilder::finish() {
  State& state = *state_;
  if (!state.stack.empty()) {
    const Saved& open = state.stack.back();
    state.diagnostics().error(open.place, fmt::format("{} is never closed", open.opened_by),
                              "The file may be cut off; close it with the matching End.");
  }
  if (state.film) {
    FilmRequest& film = state.context.scene.film;
    const std::uint32_t samples = film.samples;
    film = make_film(state.film->strings[0], state.film->parameters, state.exposure_seconds);
    film.samples = samples;
  }
  state.add_motion();
  state.media.finish();
  state.materials.finish();
  state.context.scene.geometry.number_instances();
}

}  // namespace glowworm
