// The panel beside the picture.
#pragma once
#include "apps/view_model.h"

namespace glowworm {

/// Draws the panel at the right of the window with ImGui, and changes the model when it is used. Returns whether the
/// user is operating a control that changes the picture.
bool draw_panel(ViewModel& model, float window_width, float window_height);

}  // namespace glowworm
