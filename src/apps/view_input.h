// Mouse and keyboard input in the picture.
#pragma once
#include "apps/view_model.h"

namespace glowworm {

/// Position of the picture in the window, in window units.
struct PictureArea {
  float x = 0, y = 0, width = 0, height = 0;
  bool contains(Vec2 p) const { return p.x >= x && p.y >= y && p.x < x + width && p.y < y + height; }
};

/// Translates mouse and keyboard input into changes of the model's state.
class ViewInput {
 public:
  /// Call it once per drawing of the window. Returns whether the user is interacting.
  bool handle(ViewModel& model, const PictureArea& area);
  /// Draws the handles of the selected light.
  void draw_gizmo(const ViewModel& model, const PictureArea& area) const;

 private:
  Vec2 film(const ViewModel& model, const PictureArea& area, Vec2 pointer) const;
  bool drag_light(ViewModel& model, const PictureArea& area, Vec2 pointer);
  bool move_by_mouse(ViewModel& model, const PictureArea& area, Vec2 pointer);
  bool move_by_keys(ViewModel& model) const;

  bool dragging_ = false;  // a drag that began in the picture
  Vec2 last_{0, 0};        // position of the pointer when the drag was last processed
  int axis_ = -1;          // axis of the light that is being dragged
  float grabbed_ = 0;      // position on the axis where the drag began
};

}  // namespace glowworm
