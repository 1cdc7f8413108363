// The report of a room: zones, plans, luminaires and how it was calculated, as one page that prints on A4.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "measure/measurement.h"
#include "measure/zones.h"
#include "trace/tracer.h"

namespace glowworm {

/// Key figures of a zone.
struct ZoneFigures {
  double mean = 0, least = 0, most = 0;  ///< lx
  double error = 0;        ///< of the mean over itself, at most; with a chance of 95% twice of it bounds it. Of sensors
                           ///< that found light; infinite: none did
  double cylindrical = 0;  ///< mean at the eyes, lx; level zones
  double ugr = 0;          ///< the greatest at the eyes in four directions; 0: no lamp is in view
  Vec3 ugr_eye, ugr_view;  ///< where, in the tables' coordinates

  double uniformity() const { return mean > 0 ? least / mean : 0; }
};

/// @param measured at the sensors of all zones (add_zone())
ZoneFigures zone_figures(const Zone& zone, const Measurement& measured, const Tracer& tracer);

/// A row of the schedule of luminaires.
struct LuminaireRow {
  std::string file, name, opening;
  std::vector<std::string> places;  ///< one for each
  double flux = 0, power = 0;       ///< of each, lm and W; 0: unknown
};
/// The luminaires that texts add (luminaire_of_text()), those of one file, lamps and factor together. Names show
/// factors other than 1; the flux contains them.
std::vector<LuminaireRow> luminaire_rows(const std::vector<std::string>& texts);

/// A plan of a rectangle as SVG: illuminance as tints and isolines, values at sensors where there is room, and outlines
/// of lamps above it.
std::string zone_plan(const Zone& zone, const Measurement& measured, const Scene& scene);

/// What the page says beside zones and plans.
struct ReportTexts {
  std::string title, command_line;
  std::vector<std::pair<std::string, std::string>> settings;  ///< names and values
  std::vector<std::string> notes;
};

/// The whole page, well-formed as XML, too; it loads nothing.
std::string room_report(const std::vector<Zone>& zones, const Measurement& measured,
                        const std::vector<LuminaireRow>& luminaires, const Tracer& tracer, const ReportTexts& texts);

}  // namespace glowworm
