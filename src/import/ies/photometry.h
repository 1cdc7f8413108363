// Key figures of a photometric file, and its polar curve.
#pragma once
#include <string>

#include "image/image.h"
#include "import/ies/luminaire.h"

namespace glowworm {

/// Key figures of a luminaire.
struct Photometry {
  double flux = 0;          ///< lm
  double down = 0;          ///< share of the flux below the level of the luminaire, where it aims down
  double efficacy = 0;      ///< lm/W; 0: the power is unknown
  double candela = 0;       ///< the greatest intensity
  double c = 0, gamma = 0;  ///< its direction, degrees, as type C has them
  std::string symmetry;     ///< "around the axis", "to the plane C0-C180", ..., "none"
  std::string opening;      ///< its shape and sizes; "point" without any
};
Photometry photometry_of(const PhotometricFile& file);

/// The curves of the planes C0 to C180 and C90 to C270 over a grid of angles and candela, with labels: 0 degrees points
/// down. Write it as PNG with ToneCurve::srgb.
Image polar_curve(const PhotometricFile& file, const std::string& title);

}  // namespace glowworm
