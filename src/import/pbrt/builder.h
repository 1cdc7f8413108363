// What pbrt directives mean: a state of transforms and attributes, and the scene that grows from it.
#pragma once
#include <memory>

#include "import/pbrt/context.h"
#include "import/pbrt/parser.h"

namespace glowworm {

/// Takes directives in order and fills in a scene. Mistakes go to the context's diagnostics.
class PbrtBuilder {
 public:
  explicit PbrtBuilder(PbrtContext& context);
  ~PbrtBuilder();
  PbrtBuilder(const PbrtBuilder&) = delete;
  PbrtBuilder& operator=(const PbrtBuilder&) = delete;

  void take(PbrtDirective& directive);
  /// To be called after the last directive: checks what can only be checked then.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace glowworm
