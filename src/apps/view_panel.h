// The panel beside the picture.
#pragma once
#include "apps/view_model.h"

namespace glowworm {

/// Draws the panel at the right of the window with ImGui; changes the model as it is used. Returns whether a person is
/// at one of its controls that changes the picture.
bool draw_panel(ViewModel& model, float window_width, float window_height);

}  // namespace glowworm
