// The grammar of pbrt scene files: from tokens to directives. What directives mean is pbrt_builder's affair.
#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/memory_budget.h"
#include "import/pbrt/diagnostics.h"
#include "import/pbrt/parameters.h"

namespace glowworm {

/// One directive as it stands in the file. Included files have been entered: "Include" never appears, and an imported
/// file is put between an AttributeBegin and an AttributeEnd, since its settings stay its own.
struct PbrtDirective {
  std::string_view name;  ///< as in the grammar's table
  PbrtPlace place;
  std::vector<double> numbers;       ///< of transforms
  std::vector<std::string> strings;  ///< names and types, as many as the directive has
  PbrtParameters parameters;
};

using PbrtSink = std::function<void(PbrtDirective&)>;

/// Reads a scene file and all that it includes and gives the directives to `sink` in order. Mistakes are recorded and
/// reading goes on at the next directive; it stops when diagnostics.full(). Files may include others 64 deep and
/// 16,384 times in all; a file that includes itself is an error.
/// @param budget that the texts of files are reserved in while they are open
/// Throws Error where the main file itself cannot be read.
void parse_pbrt_file(const std::string& path, PbrtDiagnostics& diagnostics, MemoryBudget& budget, const PbrtSink& sink);

/// The same for a text. @param path what names in it are relative to and messages call it
void parse_pbrt_text(std::string_view text, const std::string& path, PbrtDiagnostics& diagnostics, MemoryBudget& budget,
                     const PbrtSink& sink);

/// True where a scene's main file is for pbrt-v3: there is a WorldEnd, which pbrt-v4 does away with.
bool is_pbrt_v3(std::string_view text);

}  // namespace glowworm
