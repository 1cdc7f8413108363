// The grammar of pbrt scene files: from tokens to directives. PbrtBuilder interprets the directives.
#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/memory_budget.h"
#include "import/pbrt/diagnostics.h"
#include "import/pbrt/parameters.h"

namespace glowworm {

/// One directive of a file. Included files are already expanded: "Include" never appears, and an imported file is
/// enclosed in AttributeBegin and AttributeEnd, so that its settings do not affect other files.
struct PbrtDirective {
  std::string_view name;  ///< as in the grammar's table
  PbrtPlace place;
  std::vector<double> numbers;       ///< of transforms
  std::vector<std::string> strings;  ///< names and types, as many as the directive takes
  PbrtParameters parameters;
};

using PbrtSink = std::function<void(PbrtDirective&)>;

/// Parses the text of a scene file and all files it includes, and passes the directives to `sink` in order. Errors are
/// recorded, and reading continues at the next directive until diagnostics.full(). Files may be included 64 levels deep
/// and 16,384 times in total; a file that includes itself is an error.
/// @param budget limits the memory of open files and of lists of numbers. Throws MemoryError.
/// @param path base of relative paths, and name for messages
void parse_pbrt_text(std::string_view text, const std::string& path, PbrtDiagnostics& diagnostics, MemoryBudget& budget,
                     const PbrtSink& sink);

/// Whether a scene's main file is for pbrt-v3: it contains WorldEnd, which pbrt-v4 does not have.
bool is_pbrt_v3(std::string_view text);

}  // namespace glowworm
