// Zones of a room: rectangles and surfaces with sensors, and eyes above working planes.
#pragma once
#include <cstddef>
#include <string>

#include "measure/sensors.h"

namespace glowworm {

/// Sensors around the vertical at each eye, whose mean is the cylindrical illuminance (to 3% for one source, less for
/// several); every second one is a direction of view for glare.
inline constexpr std::size_t kEyeDirections = 8;

/// A zone and its place among the sensors of all zones.
struct Zone {
  std::string name;
  std::size_t first = 0, count = 0;     ///< its sensors
  int columns = 0, rows = 0;            ///< of a rectangle's sensors, row by row; 0: a surface
  Vec3 corner, across, along;           ///< rectangle: where its first cell begins, and its edges, m
  std::size_t first_eye = 0, eyes = 0;  ///< sensors of its eyes: kEyeDirections for each; level rectangles have eyes

  bool is_level() const { return eyes > 0; }
};

/// Adds the sensors of a zone. A text is NAME=X,Y,Z,X,Y,Z[,SPACING], two opposite corners of a rectangle across an
/// axis, in the coordinates and axes of the user's file, or NAME=OBJECT[,SPACING], the front of an object's surface.
/// Level rectangles face up, others the side from which the first corner is at the left. Without a spacing it is that
/// of EN 12464-1: 0.2 m times 5 to the power of log10 of the longer side. Eyes are 1.2 m above the floor, which is the
/// lowest surface facing up within 1.5 m below the middle; without one, the zone itself counts as the floor.
/// Throws Error for other texts and for more than `most` sensors.
/// @param eyes whether level rectangles have any
Zone add_zone(const std::string& text, const Tracer& tracer, Sensors& sensors, std::size_t most, bool eyes = true);

}  // namespace glowworm
