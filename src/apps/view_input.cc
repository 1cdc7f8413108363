#include "apps/view_input.h"

#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "session/camera_control.h"
#include "session/script.h"

namespace glowworm {

namespace {

constexpr float kHandleReach = 8;        // pixels
constexpr float kTurnPerPixel = 0.006f;  // radians
/// Time to fly across the scene's radius, seconds.
constexpr float kCrossing = 4;

/// The light's position, including its edit.
Vec3 light_position(const ViewModel& model) {
  const auto i = static_cast<std::size_t>(model.light);
  return model.scene->lights[i].center + model.state.lights[i].move;
}

bool has_gizmo(const ViewModel& model) {
  return model.scene && model.light >= 0 && static_cast<std::size_t>(model.light) < model.state.lights.size() &&
         model.scene->lights[static_cast<std::size_t>(model.light)].has_place();
}

}  // namespace

Vec2 ViewInput::film(const ViewModel& model, const PictureArea& area, Vec2 pointer) const {
  return {(pointer.x - area.x) / area.width * static_cast<float>(model.state.width),
          (pointer.y - area.y) / area.height * static_cast<float>(model.state.height)};
}

bool ViewInput::handle(ViewModel& model, const PictureArea& area) {
  if (!model.scene || area.width < 1 || area.height < 1) return false;
  const ImGuiIO& io = ImGui::GetIO();
  const Vec2 pointer{io.MousePos.x, io.MousePos.y};
  const bool over = !io.WantCaptureMouse && area.contains(pointer);
  bool busy = false;
  bool any_down = false;
  for (int button = 0; button < 3; ++button) {
    if (over && ImGui::IsMouseClicked(button)) {
      dragging_ = true;
      last_ = pointer;  // ImGui's MouseDelta includes movement before the button was pressed
    }
    any_down = any_down || ImGui::IsMouseDown(button);
  }
  if (!any_down) {
    dragging_ = false;
    axis_ = -1;
  }
  if (over && ImGui::IsMouseDoubleClicked(0) && model.shown) {
    focus_on(model.shown->frame, {(pointer.x - area.x) / area.width, (pointer.y - area.y) / area.height}, model.state);
    dragging_ = false;
  }
  if (dragging_) busy = drag_light(model, area, pointer) || move_by_mouse(model, area, pointer);
  if (over && io.MouseWheel != 0) {
    const float nearer = 1 - std::pow(0.9f, io.MouseWheel);
    model.state.camera = fly(model.state.camera, {0, 0, model.state.pivot_distance * nearer});
    model.state.pivot_distance *= 1 - nearer;
    busy = true;
  }
  if (!io.WantCaptureKeyboard) busy = move_by_keys(model) || busy;
  return busy;
}

bool ViewInput::drag_light(ViewModel& model, const PictureArea& area, Vec2 pointer) {
  if (!has_gizmo(model)) return false;
  const Vec2 at = film(model, area, pointer);
  ViewState& s = model.state;
  const Gizmo gizmo = make_gizmo(s.camera, light_position(model), s.width, s.height);
  if (ImGui::IsMouseClicked(0)) {
    const float reach = kHandleReach * static_cast<float>(s.width) / area.width;
    axis_ = picked_axis(gizmo, s.camera, at, s.width, s.height, reach);
    if (axis_ >= 0) grabbed_ = axis_position(gizmo, axis_, s.camera, at, s.width, s.height, 0);
  }
  if (axis_ < 0) return false;
  const float now = axis_position(gizmo, axis_, s.camera, at, s.width, s.height, grabbed_);
  s.lights[static_cast<std::size_t>(model.light)].move += axis_direction(axis_) * (now - grabbed_);
  return true;
}

bool ViewInput::move_by_mouse(ViewModel& model, const PictureArea& area, Vec2 pointer) {
  const ImGuiIO& io = ImGui::GetIO();
  ViewState& s = model.state;
  const Vec2 delta{pointer.x - last_.x, pointer.y - last_.y};
  if (!std::isfinite(delta.x) || !std::isfinite(delta.y) || (delta.x == 0 && delta.y == 0)) return true;
  last_ = pointer;
  const Vec3 up = model.up();
  if (ImGui::IsMouseDown(2) || (ImGui::IsMouseDown(0) && io.KeyShift)) {
    // The point at the pivot stays under the pointer.
    const Vec2 now = film(model, area, pointer);
    const Vec2 before = film(model, area, {pointer.x - delta.x, pointer.y - delta.y});
    const Vec3 by = unproject(s.camera, before, s.width, s.height, s.pivot_distance) -
                    unproject(s.camera, now, s.width, s.height, s.pivot_distance);
    s.camera.to_world.translation += by;
  } else if (ImGui::IsMouseDown(1)) {
    s.camera = look(s.camera, up, -delta.x * kTurnPerPixel, -delta.y * kTurnPerPixel);
  } else {
    s.camera = orbit(s.camera, s.pivot_distance, up, -delta.x * kTurnPerPixel, -delta.y * kTurnPerPixel);
  }
  return true;
}

bool ViewInput::move_by_keys(ViewModel& model) const {
  Vec3 way{0, 0, 0};
  const auto add = [&](int key, Vec3 direction) {
    if (ImGui::IsKeyDown(key)) way += direction;
  };
  add(GLFW_KEY_D, {1, 0, 0});
  add(GLFW_KEY_A, {-1, 0, 0});
  add(GLFW_KEY_E, {0, 1, 0});
  add(GLFW_KEY_Q, {0, -1, 0});
  add(GLFW_KEY_W, {0, 0, 1});
  add(GLFW_KEY_S, {0, 0, -1});
  if (length_squared(way) == 0) return false;
  const ImGuiIO& io = ImGui::GetIO();
  const float haste = io.KeyShift ? 4.0f : 1.0f;
  const float seconds = std::min(io.DeltaTime, 0.1f);
  model.state.camera = fly(model.state.camera, way * (model.scene->scene->radius() / kCrossing * seconds * haste));
  return true;
}

void ViewInput::draw_gizmo(const ViewModel& model, const PictureArea& area) const {
  if (!has_gizmo(model)) return;
  const ViewState& s = model.state;
  const Gizmo gizmo = make_gizmo(s.camera, light_position(model), s.width, s.height);
  const Projection from = project(s.camera, gizmo.origin, s.width, s.height);
  if (!(from.depth > 0)) return;
  ImDrawList* draw = ImGui::GetBackgroundDrawList();
  const auto place = [&](Vec2 film) {
    return ImVec2(area.x + film.x / static_cast<float>(s.width) * area.width,
                  area.y + film.y / static_cast<float>(s.height) * area.height);
  };
  static constexpr ImU32 colors[3] = {IM_COL32(235, 80, 70, 255), IM_COL32(90, 205, 90, 255),
                                      IM_COL32(80, 130, 250, 255)};
  for (int axis = 0; axis < 3; ++axis) {
    const Projection to = project(s.camera, gizmo.origin + axis_direction(axis) * gizmo.length, s.width, s.height);
    if (!(to.depth > 0)) continue;
    draw->AddLine(place(from.film), place(to.film), colors[axis], axis == axis_ ? 4.0f : 2.5f);
    draw->AddCircleFilled(place(to.film), 5, colors[axis]);
  }
}

}  // namespace glowworm
