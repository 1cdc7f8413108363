// Transform directives.
#pragma once
#include <optional>

#include "core/transform_double.h"
#include "import/pbrt/parser.h"

namespace glowworm {

/// The transform after an Identity, Transform, ConcatTransform, Translate, Scale, Rotate or LookAt directive. Empty
/// after an error, which is recorded.
std::optional<TransformDouble> apply_transform(const PbrtDirective& directive, const TransformDouble& current);

/// Whether a transform is finite and has an inverse.
bool is_invertible(const TransformDouble& transform);

}  // namespace glowworm
