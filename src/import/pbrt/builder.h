// The meaning of pbrt directives: a state of transforms and attributes, and the scene built from it.
#pragma once
#include <memory>

#include "import/pbrt/context.h"
#include "import/pbrt/parser.h"

namespace glowworm {

/// Processes directives in order and builds a scene. Reports errors to the context's diagnostics.
class PbrtBuilder {
 public:
  explicit PbrtBuilder(PbrtContext& context);
  ~PbrtBuilder();
  PbrtBuilder(const PbrtBuilder&) = delete;
  PbrtBuilder& operator=(const PbrtBuilder&) = delete;

  void take(PbrtDirective& directive);
  /// Call it after the last directive. Makes the checks that need the complete file.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace glowworm
