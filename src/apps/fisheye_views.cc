#include "apps/fisheye_views.h"

#include "core/input_file.h"
#include "core/memory_budget.h"
#include "settings/settings.h"

namespace glowworm {

std::vector<RadianceView> read_fisheyes(const std::string& path) {
  MemoryBudget budget(default_memory_bytes());
  Reservation held(budget, "the file of views", 0);
  const std::string text = read_input_file(path, held);
  std::vector<RadianceView> views = parse_radiance_views(text, path);
  for (RadianceView& view : views) {
    view.kind = CameraKind::fisheye;
    view.horizontal = view.vertical = 180;
  }
  return views;
}

}  // namespace glowworm
