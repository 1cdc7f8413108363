#include "apps/view_panel.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>

#include "core/frame.h"
#include "density/engine.h"
#include "image/false_color.h"
#include "kernels/kernel_shape.h"
#include "session/camera_control.h"
#include "session/command_text.h"

namespace glowworm {

namespace {

constexpr float kDegree = kPi / 180;

/// Draws a list of names to choose from. Returns true if the choice changed.
bool choose(const char* label, const std::vector<std::string>& names, std::size_t& chosen) {
  bool changed = false;
  if (!ImGui::BeginCombo(label, chosen < names.size() ? names[chosen].c_str() : "")) return false;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (ImGui::Selectable(names[i].c_str(), i == chosen)) {
      chosen = i;
      changed = true;
    }
  ImGui::EndCombo();
  return changed;
}

template <typename Enumeration>
void choose_enumeration(const char* label, const std::vector<std::string>& names, Enumeration& value) {
  auto chosen = static_cast<std::size_t>(value);
  if (choose(label, names, chosen)) value = static_cast<Enumeration>(chosen);
}

/// A tooltip for the item before.
void hint(const char* text) {
  if (!ImGui::IsItemHovered()) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(ImGui::GetFontSize() * 22);
  ImGui::TextUnformatted(text);
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

/// The tone curve, or the name of the view that --ocio has put in its place.
void draw_tone(ViewModel& model) {
  if (model.options.color.view) {
    ImGui::TextUnformatted(model.options.color.view->name().c_str());
    hint("The view of --ocio");
    return;
  }
  bool filmic = model.tone == ToneCurve::filmic;
  if (ImGui::Checkbox("filmic tone curve", &filmic)) {
    model.tone = filmic ? ToneCurve::filmic : ToneCurve::srgb;
    model.picture_changed = true;
  }
  hint("Keep detail in highlights; without it, light above 1 is white");
}

void draw_picture(ViewModel& model) {
  ViewState& s = model.state;
  choose_enumeration("show", view_mode_names(), s.mode);
  hint("gather: the final picture; photons: the photon map itself; others: its data in false colours");
  choose_enumeration("light shown", light_part_names(), s.part);
  hint("All light, or a part of it: direct, indirect, caustics");
  static const std::vector<std::string> counts = {"1", "4", "16", "64", "100"};
  std::size_t chosen = std::find(counts.begin(), counts.end(), std::to_string(s.gather)) - counts.begin();
  if (choose("gather rays", counts, chosen)) s.gather = static_cast<std::uint32_t>(std::stoul(counts[chosen]));
  hint("Final gather rays of each pixel and frame: more are smoother and slower");
  std::vector<std::string> engines = engine_names();
  std::erase_if(engines, [](const std::string& name) { return engine_traits(name).for_tests; });
  engines.insert(engines.begin(), "auto");
  std::size_t engine = std::find(engines.begin(), engines.end(), s.engine) - engines.begin();
  if (choose("photon lookup", engines, engine)) s.engine = engines[engine];
  hint("Density engine, which looks up photons. All give the same picture; auto is the fastest");
  choose_enumeration("photon kernel", kernel_names(), s.kernel);
  hint("How the weight of a photon falls off with distance");
  static const std::vector<std::string> photons = {"10000", "50000", "200000", "500000", "2000000"};
  std::size_t photon_count = std::find(photons.begin(), photons.end(), std::to_string(s.photons)) - photons.begin();
  if (choose("photons", photons, photon_count)) s.photons = std::stoull(photons[photon_count]);
  hint("Photons in the map: more are sharper, and take longer where a light changes");
  ImGui::Checkbox("smooth noise", &s.filter);
  hint("Average pixels whose difference is noise, as renders do");
  ImGui::SameLine();
  ImGui::Checkbox("reuse frames", &s.reuse);
  hint("Reuse earlier frames where the same surface was visible");
  ImGui::Checkbox("secondary gather", &s.secondary_gather);
  hint("Sharper light in corners: gather again where the photons' radii are too large");
  ImGui::SameLine();
  draw_tone(model);
  if (ImGui::SliderFloat("exposure", &model.exposure, -8, 8, "%.1f stops")) model.picture_changed = true;
  hint("Brightness of the picture; +1 is twice as bright");
  if (ImGui::Button("auto exposure")) {
    model.expose = true;
    model.expose_now();
  }
  hint("Choose the exposure from the picture shown");
}

void draw_cameras(ViewModel& model) {
  for (const Camera& camera : model.scene->scene->cameras()) {
    const std::string name = camera.name.empty() ? "(unnamed)" : camera.name;
    if (ImGui::Selectable(fmt::format("{}##scene", name).c_str())) model.state.camera = camera;
  }
  for (std::size_t i = 0; i < model.saved_cameras.size(); ++i) {
    const auto& [name, camera] = model.saved_cameras[i];
    if (ImGui::Selectable(fmt::format("{}##saved{}", name, i).c_str())) model.state.camera = camera;
  }
  if (ImGui::Button("save this camera"))
    model.saved_cameras.emplace_back(fmt::format("saved {}", model.saved_cameras.size() + 1), model.state.camera);
}

/// Azimuth and elevation of lights with a direction; rotations of other lights.
bool draw_turning(ViewModel& model, const RigLight& light, LightEdit& edit) {
  if (length_squared(light.direction) > 0) {
    const Vec3 up = model.up();
    SunAngles angles = sun_angles(rotate(light.direction, edit.turn), up);
    float azimuth = angles.azimuth / kDegree, elevation = angles.elevation / kDegree;
    bool busy = ImGui::SliderFloat("azimuth", &azimuth, -180, 180, "%.1f deg");
    busy = ImGui::SliderFloat("elevation", &elevation, -89, 89, "%.1f deg") || busy;
    if (busy)
      edit.turn = rotation_between(light.direction, sun_direction({azimuth * kDegree, elevation * kDegree}, up));
    return busy;
  }
  if (light.kind == RigLightKind::point) return false;
  float degrees[3] = {edit.turn.x / kDegree, edit.turn.y / kDegree, edit.turn.z / kDegree};
  if (!ImGui::DragFloat3("turn", degrees, 0.5f, -180, 180, "%.1f deg")) return false;
  edit.turn = {degrees[0] * kDegree, degrees[1] * kDegree, degrees[2] * kDegree};
  return true;
}

bool draw_light(ViewModel& model, const RigLight& light, LightEdit& edit) {
  ImGui::Checkbox("on", &edit.on);
  bool busy = ImGui::SliderFloat("scale", &edit.scale, 0, 10, "%.2f", ImGuiSliderFlags_Logarithmic);
  edit.scale = std::max(edit.scale, 0.0f);
  if (light.has_place()) {
    const float step = 0.002f * model.scene->scene->radius();
    float move[3] = {edit.move.x, edit.move.y, edit.move.z};
    if (ImGui::DragFloat3("move", move, step, 0, 0, "%.3f m")) {
      edit.move = {move[0], move[1], move[2]};
      busy = true;
    }
  }
  busy = draw_turning(model, light, edit) || busy;
  if (ImGui::Button("as in the file")) edit = {};
  hint("Undo all changes of this light");
  return busy || ImGui::IsAnyItemActive();
}

bool draw_lights(ViewModel& model) {
  const std::vector<RigLight>& lights = model.scene->lights;
  model.state.lights.resize(lights.size());
  for (std::size_t i = 0; i < lights.size(); ++i)
    if (ImGui::Selectable(fmt::format("{}##light{}", lights[i].name, i).c_str(), model.light == static_cast<int>(i)))
      model.light = model.light == static_cast<int>(i) ? -1 : static_cast<int>(i);
  if (model.light < 0 || static_cast<std::size_t>(model.light) >= lights.size()) return false;
  const auto chosen = static_cast<std::size_t>(model.light);
  return draw_light(model, lights[chosen], model.state.lights[chosen]);
}

void plot(const ViewModel& model, const char* label, const char* unit, float FrameTimes::*value) {
  std::vector<float> values;
  for (const FrameTimes& t : model.times) values.push_back(t.*value);
  const float now = values.empty() ? 0 : values.back();
  ImGui::PlotLines(label, values.data(), static_cast<int>(values.size()), 0,
                   fmt::format("{:.1f} {}", now, unit).c_str(), 0, FLT_MAX, ImVec2(0, 34));
}

void draw_curves(const ViewModel& model) {
  plot(model, "frame", "ms", &FrameTimes::total);
  plot(model, "photons", "ms", &FrameTimes::photons);
  plot(model, "map", "ms", &FrameTimes::map);
  plot(model, "camera", "ms", &FrameTimes::camera);
  plot(model, "direct", "ms", &FrameTimes::direct);
  plot(model, "gather rays", "ms", &FrameTimes::gather);
  plot(model, "density", "ms", &FrameTimes::density);
  plot(model, "rays", "M/s", &FrameTimes::rays);
  plot(model, "photon lookups", "M/s", &FrameTimes::operations);
}

void draw_files(ViewModel& model) {
  ImGui::InputText("file", &model.save_path);
  if (ImGui::Button("save image (.exr .png)")) model.save(model.save_path);
  if (ImGui::Button("copy render command")) {
    std::vector<std::string> options = scene_options(model.options, model.scene->path);
    if (model.scene->length > 0) options.insert(options.end(), {"--at", fmt::format("{}", model.state.seconds)});
    ImGui::SetClipboardText(
        render_command_text(model.scene->path, *model.scene->scene, model.scene->lights, model.state, options).c_str());
  }
  hint("Copy the glowworm render command of this view to the clipboard");
}

/// The animation's time. Returns whether it is being moved.
bool draw_timeline(ViewModel& model) {
  ImGui::Checkbox("play", &model.plays);
  hint("Space bar");
  ImGui::SameLine();
  auto seconds = static_cast<float>(model.state.seconds);
  if (ImGui::SliderFloat("time", &seconds, 0, static_cast<float>(model.scene->length), "%.2f s")) {
    model.state.seconds = double{seconds};
    model.plays = false;
  }
  return ImGui::IsItemActive();
}

/// The colour scale of false-colour frames from left to right, with its numbers; logarithmic.
void draw_legend(const ViewFrame& frame) {
  constexpr int kSteps = 48;
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x, height = ImGui::GetTextLineHeight();
  for (int i = 0; i < kSteps; ++i) {
    const RGB color = tone_map(false_color((static_cast<float>(i) + 0.5f) / kSteps), ToneCurve::srgb, 0);
    ImGui::GetWindowDrawList()->AddRectFilled(
        ImVec2(corner.x + width * static_cast<float>(i) / kSteps, corner.y),
        ImVec2(corner.x + width * static_cast<float>(i + 1) / kSteps, corner.y + height),
        IM_COL32(to_byte(color.r), to_byte(color.g), to_byte(color.b), 255));
  }
  ImGui::Dummy(ImVec2(width, height));
  const std::string low = fmt::format("{:.3g}", frame.scale.low), high = fmt::format("{:.3g}", frame.scale.high);
  ImGui::TextUnformatted(low.c_str());
  ImGui::SameLine(width - ImGui::CalcTextSize(high.c_str()).x);
  ImGui::TextUnformatted(high.c_str());
  ImGui::TextWrapped("%s", frame.unit.c_str());
}

/// Lists the mouse and keyboard controls.
void draw_help() {
  static constexpr const char* kLines[] = {"drag: orbit",
                                           "Shift or middle button: pan",
                                           "right button: look around",
                                           "wheel: nearer, farther",
                                           "W A S D Q E: fly, Shift faster",
                                           "double-click: orbit around this place",
                                           "space: play the animation",
                                           "F1 or H: this help",
                                           "F12: screenshot"};
  for (const char* line : kLines) ImGui::BulletText("%s", line);
}

void draw_status(const ViewModel& model) {
  if (model.worker.loading()) ImGui::TextUnformatted("loading ...");
  if (model.shown) {
    const ViewFrame& f = model.shown->frame;
    ImGui::TextUnformatted(fmt::format("{}x{}  {} samples  {} rays  {}  {:.0f} fps", f.image.width, f.image.height,
                                       f.samples, f.effort.gather, f.engine, 1 / std::max(f.cost.seconds, 1e-6))
                               .c_str());
    if (!f.unit.empty()) draw_legend(f);
  }
  for (const std::string& message : model.messages) {
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(1, 0.45f, 0.4f, 1));
    ImGui::TextWrapped("%s", message.c_str());
    ImGui::PopStyleColor();
  }
}

}  // namespace

bool draw_panel(ViewModel& model, float window_width, float window_height) {
  const auto width = static_cast<float>(model.panel_width);
  ImGui::SetNextWindowPos(ImVec2(window_width - width, 0));
  ImGui::SetNextWindowSize(ImVec2(width, window_height));
  bool busy = false;
  ImGui::Begin("panel", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                   ImGuiWindowFlags_NoSavedSettings);
  draw_status(model);
  ImGui::SetNextItemOpen(model.help);
  model.help = ImGui::CollapsingHeader("help (F1)");
  if (model.help) draw_help();
  if (model.scene) {
    if (model.scene->length > 0) busy = draw_timeline(model);
    if (ImGui::CollapsingHeader("picture", ImGuiTreeNodeFlags_DefaultOpen)) draw_picture(model);
    if (ImGui::CollapsingHeader("lights", ImGuiTreeNodeFlags_DefaultOpen)) busy = draw_lights(model) || busy;
    if (ImGui::CollapsingHeader("cameras")) draw_cameras(model);
    if (ImGui::CollapsingHeader("file")) draw_files(model);
    if (ImGui::CollapsingHeader("frame times")) draw_curves(model);
  }
  ImGui::End();
  return busy;
}

}  // namespace glowworm
