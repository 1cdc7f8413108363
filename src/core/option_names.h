// How messages call options.
#pragma once
#include <string>

namespace glowworm {

/// Whether messages call options as the command line does: --memory. If not, they call them as the library does, in
/// RenderOptions::more and in the keywords of Python: memory. Set it once, at the start of a program.
void name_options_with_dashes(bool with_dashes);

/// A message that names options with dashes, as it is told. Errors and the log use it.
std::string with_option_names(const std::string& message);

}  // namespace glowworm
