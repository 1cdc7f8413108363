// The parts of the atrium: one side of it in its own coordinates, and what runs around all four.
#pragma once
#include <cstdint>

#include "builtin/mesh_builder.h"
#include "builtin/ornaments.h"

namespace glowworm::atrium {

// The plan, in metres. The court is surrounded by galleries of two storeys; every line that runs around it is a
// rectangle |x| = d + kExcess, |z| = d, named by d.
inline constexpr float kExcess = 7.5f;        ///< half length less half width
inline constexpr float kColumnLine = 3.9f;    ///< centres of the columns
inline constexpr float kCourtFace = 3.65f;    ///< the arcades' wall towards the court
inline constexpr float kGalleryFace = 4.15f;  ///< and towards the gallery
inline constexpr float kWallFace = 7.5f;      ///< inner face of the outer walls
inline constexpr float kOutside = 8.1f;       ///< their outer face
inline constexpr float kEave = 3.2f;          ///< edge of the roof

// Heights.
inline constexpr float kCourtFloor = -0.3f;
inline constexpr float kLowerSpring = 3.2f;  ///< springing of the lower arches
inline constexpr float kLowerTop = 4.95f;    ///< top of the wall above them
inline constexpr float kVaultSpring = 3.3f, kVaultRise = 1.25f;
inline constexpr float kUpperFloor = 5.05f;
inline constexpr float kPedestal = 0.95f;  ///< height of the upper columns' pedestals, above the floor
inline constexpr float kUpperSpring = 8.1f;
inline constexpr float kUpperTop = 9.55f;
inline constexpr float kCeiling = 9.45f;
inline constexpr float kEaveTop = 10.0f, kRidge = 11.5f;

/// How finely the atrium is cut.
struct Detail {
  Fineness column, baluster, urn;
  int arch_segments;    ///< of a half circle
  int vault_cells;      ///< along each side of a quarter of a vault
  int curtain_cells;    ///< per fold
  int tile_segments;    ///< around a roof tile
  int sphere_segments;  ///< around a shrub
  int tile_cuts;        ///< floor tiles along the side of one of the coarse atrium's
  bool ornaments;       ///< beads along the arches and the cornices
};

/// Materials by use.
struct Materials {
  std::uint32_t stone, plaster, vault, floor_light, floor_dark, court_light, court_dark, roof, wood, terracotta, leaves,
      water, curtain[4];
};

/// One side, in coordinates in which it lies at +z and runs along x.
struct Side {
  float half_length;  ///< from its middle to the centres of its corner piers
  float line;         ///< z of its columns
  int bays;
  float bay() const { return 2 * half_length / static_cast<float>(bays); }
  float column_x(int k) const { return -half_length + bay() * static_cast<float>(k); }
  /// From d of the plan to z here.
  float z(float d) const { return line + (d - kColumnLine); }
};

/// Columns, arches and the wall above them, for the lower or the upper storey.
void add_arcade(MeshBuilder& mesh, const Side& side, const Materials& materials, const Detail& detail, bool upper);
/// Pedestals and balustrade between the upper columns.
void add_balustrade(MeshBuilder& mesh, const Side& side, const Materials& materials, const Detail& detail);
/// Vaults, ribs, pilasters and doors of the lower gallery.
void add_lower_gallery(MeshBuilder& mesh, const Side& side, const Materials& materials, const Detail& detail);
/// Ceiling beams, pilasters and doors of the upper gallery.
void add_upper_gallery(MeshBuilder& mesh, const Side& side, const Materials& materials);
void add_roof_tiles(MeshBuilder& mesh, const Side& side, const Materials& materials, const Detail& detail);

/// A groined vault over the rectangle around (center.x, center.z), seen from below, springing at center.y.
void add_vault(MeshBuilder& mesh, Vec3 center, float half_x, float half_z, float rise, int cells);

/// Floors in two stones: the ring between two lines of the plan, and a whole rectangle.
/// @param size about the side of a tile, metres
void add_floor_ring(MeshBuilder& mesh, float inner, float outer, float y, float size, std::uint32_t light,
                    std::uint32_t dark);
void add_floor(MeshBuilder& mesh, float half_x, float half_z, float y, float size, std::uint32_t light,
               std::uint32_t dark);

/// Walls, slabs, mouldings, steps and the roof's plane: all that is swept around the court.
void add_shell(MeshBuilder& mesh, const Materials& materials);

}  // namespace glowworm::atrium
