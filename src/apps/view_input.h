// Mouse and keys in the picture.
#pragma once
#include "apps/view_model.h"

namespace glowworm {

/// Where the picture is in the window, in window units.
struct PictureArea {
  float x = 0, y = 0, width = 0, height = 0;
  bool contains(Vec2 p) const { return p.x >= x && p.y >= y && p.x < x + width && p.y < y + height; }
};

/// Turns what ImGui knows of mouse and keyboard into changes of the model's state.
class ViewInput {
 public:
  /// Called once for each drawing of the window; returns whether a person is at it.
  bool handle(ViewModel& model, const PictureArea& area);
  /// Draws the handles of the selected light.
  void draw_gizmo(const ViewModel& model, const PictureArea& area) const;

 private:
  Vec2 film(const ViewModel& model, const PictureArea& area, Vec2 pointer) const;
  bool drag_light(ViewModel& model, const PictureArea& area, Vec2 pointer);
  bool move_by_mouse(ViewModel& model, const PictureArea& area, Vec2 pointer);
  bool move_by_keys(ViewModel& model) const;

  bool dragging_ = false;  // a drag that began in the picture
  Vec2 last_{0, 0};        // where the pointer was when the drag was followed last
  int axis_ = -1;          // of the light that is dragged
  float grabbed_ = 0;      // where on the axis it was taken
};

}  // namespace glowworm
