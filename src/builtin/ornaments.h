// Turned and moulded parts for the built-in scenes.
#pragma once
#include <span>
#include <vector>

#include "builtin/mesh_builder.h"

namespace glowworm {

/// An outline for MeshBuilder::lathe(), drawn upwards. Lengths in metres.
class Outline {
 public:
  /// @param subdivision segments of every curved piece
  explicit Outline(int subdivision) : subdivision_(subdivision) {}

  Outline& start(float radius, float y);
  /// A straight piece with a crease at its beginning and end.
  Outline& line_to(float radius, float y);
  /// A half round that bulges outwards (a torus), or inwards (a scotia, flattened by half), up by `height`.
  Outline& torus(float height) { return half_round(height, height / 2); }
  Outline& scotia(float height) { return half_round(height, -height / 4); }
  /// A smooth curve from the last point to (radius, y) that is vertical at both ends.
  Outline& swell_to(float radius, float y);
  /// The shaft of a column up to (radius, y), with a slight swelling in its middle (entasis).
  Outline& shaft_to(float radius, float y);

  std::span<const MeshBuilder::ProfilePoint> points() const { return points_; }

 private:
  Outline& half_round(float height, float bulge);
  void crease() { points_.back().crease = true; }
  int subdivision_;
  std::vector<MeshBuilder::ProfilePoint> points_;
};

/// Subdivision of round parts.
struct Fineness {
  int around;  ///< segments of a full turn of a large round part
  int along;   ///< segments of a curved piece of an outline
};

/// A column on a square plinth, from y = 0 to y = height, with the shaft's lower radius given and without faces on the
/// ground. Its square abacus on top is 2.5 radii wide.
void add_column(MeshBuilder& mesh, float height, float radius, Fineness fineness);
/// A baluster from y = 0 to y = height.
void add_baluster(MeshBuilder& mesh, float height, Fineness fineness);
/// An urn with an open mouth, or a round planter, from y = 0.
void add_urn(MeshBuilder& mesh, float height, Fineness fineness);

/// Sweeps an outline around a rectangle with mitred corners: a point (radius, y) becomes the rectangle |x| = radius +
/// excess, |z| = radius. The outside is on the same side as in MeshBuilder::lathe().
void sweep_rectangle(MeshBuilder& mesh, std::span<const MeshBuilder::ProfilePoint> profile, float excess);

/// A hanging curtain in the plane z = 0, between x = -width/2 and width/2, from y = 0 up to `height`: a closed sheet
/// 1 cm thick with folds.
void add_curtain(MeshBuilder& mesh, float width, float height, int folds, int cells_per_fold, float phase);

}  // namespace glowworm
