#include "apps/view_options.h"
#include "core/error.h"
namespace glowworm {
int run_window_view(const ViewOptions&, const Script&) { throw Error("no window yet"); }
}  // namespace glowworm
