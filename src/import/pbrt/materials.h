// Materials of pbrt scenes.
#pragma once
#include <functional>
#include <string>

#include "import/pbrt/context.h"
#include "scene/material.h"

namespace glowworm {

/// Looks up the index of a named material, which may be defined later, in the scene's material table.
using PbrtMaterialByName = std::function<std::uint32_t(const std::string& name, const PbrtPlace& place)>;

/// The material of a Material or MakeNamedMaterial directive. Unsupported kinds are noted and replaced by a diffuse
/// material of similar colour. Materials of pbrt-v3 are supported if they differ only in names.
/// @param kind "diffuse", "conductor", ...
/// @param by_name looks up the two materials of a mix
Material make_material(PbrtContext& context, const std::string& kind, const PbrtParameters& parameters,
                       const PbrtMaterialByName& by_name);

}  // namespace glowworm
