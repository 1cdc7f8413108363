// What lobes the surfaces of a material may have.
#pragma once
#include <cstdint>

#include "scene/surface.h"

namespace glowworm {

/// Whether some point of a surface of this material may have one of the lobes. Textures count as if they had any value.
/// Interfaces count as nothing.
/// @param point of such a surface; its material is not used
bool may_have_lobes(const Scene& scene, const SurfacePoint& point, std::uint32_t material, Lobes wanted);
/// Whether some surface of the scene may have one of the lobes.
/// @param panes whether those of panes count (Scene::is_pane)
bool may_have_lobes(const Scene& scene, Lobes wanted, bool panes = true);

/// Whether the scene has lights without size, and surfaces that may bend their light to other places: mirrors, glass,
/// panes, coats. No ray from a viewer meets such a light through them; only photons bring it.
/// @param panes whether what panes reflect counts. Shadow rays pass panes, so it is all that they bend.
bool bends_delta_lights(const Scene& scene, bool panes = true);

}  // namespace glowworm
