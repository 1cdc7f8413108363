// Materials of pbrt scenes.
#pragma once
#include <functional>
#include <string>

#include "import/pbrt/context.h"
#include "scene/material.h"

namespace glowworm {

/// Index in the scene's material table of a named material, which may be defined later.
using PbrtMaterialByName = std::function<std::uint32_t(const std::string& name, const PbrtPlace& place)>;

/// The material of a Material or MakeNamedMaterial directive. Kinds that are not supported are noted and replaced by a
/// diffuse one of like colour. Of pbrt-v3 the kinds are read whose names or parameters' names alone differ.
/// @param kind "diffuse", "conductor", ...; @param by_name finds the two materials of a mix
Material make_material(PbrtContext& context, const std::string& kind, const PbrtParameters& parameters,
                       const PbrtMaterialByName& by_name);

/// True where a kind stands for a surface that is not there ("interface", "none" or nothing).
bool is_interface_material(const std::string& kind);

}  // namespace glowworm
