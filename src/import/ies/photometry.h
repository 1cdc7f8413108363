// What people ask of a photometric file: flux, peak, symmetry, and the polar curve.
#pragma once
#include <string>
#include <utility>
#include <vector>

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
  std::string symmetry;     ///< "around the axis", "to both planes", ...
  std::string opening;      ///< "disc, 0.5 m"
};
Photometry photometry_of(const PhotometricFile& file);

/// The curves of the planes C0 to C180 and C90 to C270 over a grid of angles and candela, with labels: 0 degrees points
/// down. Write it as PNG with ToneCurve::srgb.
Image polar_curve(const PhotometricFile& file, const std::string& title);

}  // namespace glowworm
