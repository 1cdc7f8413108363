// Photometric files of luminaires: IES LM-63 and EULUMDAT.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace glowworm {

/// Whether a file's ending says that it is photometric: .ies or .ldt, in any case.
bool is_photometric_file(const std::string& path);

/// One of the sets of lamps that a luminaire may have.
struct LampSet {
  std::string name;  ///< the type of its lamps
  float flux = 0;    ///< of all lamps, lm; 0: unknown
  float power = 0;   ///< of all lamps with their gear, W; 0: unknown
};

/// What a photometric file says.
struct PhotometricFile {
  IntensityTable table;       ///< cd
  LuminousOpening opening;    ///< in the axes of the table
  std::string name;           ///< of the luminaire, by its maker; may be empty
  std::vector<LampSet> sets;  ///< one at least
  std::size_t set = 0;        ///< the one that the table is of
};

/// Parses an IES LM-63 file of 1986 to 2019: type A, B or C, with TILT=NONE, TILT=INCLUDE or TILT=FILE beside it. The
/// table is in candela, with the file's factors applied; the factors of tilt stand beside it.
/// Throws Error with file and line for what is not one; also where numbers are missing or left over.
/// @param path for messages and for the file of TILT=FILE
PhotometricFile parse_lm63(std::string_view text, const std::string& path);

/// Parses a EULUMDAT file (.ldt); the table is in candela for the flux of one of its sets of lamps. The opening is a
/// box of the greatest of its four heights, or a cylinder where the width is 0; its length lies across the plane C0.
/// Throws Error as parse_lm63() does.
/// @param lamps a set by its name or number, from 1; empty: the first
PhotometricFile parse_eulumdat(std::string_view text, const std::string& path, const std::string& lamps = "");

/// Reads either, by the file's ending. Throws Error as the parsers do, or where the file cannot be read.
PhotometricFile read_photometric_file(const std::string& path, const std::string& lamps = "");

/// A white light with the intensities of a photometric file, in W sr^-1 by 179 lm/W; it aims along -y, with x to its
/// right. Throws Error as read_photometric_file() does.
Light read_luminaire(const std::string& path, const std::string& lamps = "");

/// Mirrors a luminaire's intensities in the plane of its right side and its aim, for a transform that mirrors it.
void mirror_luminaire(Light& light);

/// Whether a text of --light adds a luminaire: FILE@..., with the ending of a photometric file.
bool is_luminaire_text(const std::string& text);

/// A luminaire of the command line.
struct LuminaireText {
  std::string path, lamps;
  Vec3d place, aim{0, -1, 0};  ///< m, in the axes of the text, but for an aim that is not given
  bool aimed = false;
  double turn = 0;   ///< degrees
  float factor = 1;  ///< on its light
  bool point = false;
};
/// Parses FILE@X,Y,Z[,DX,DY,DZ[,TURN]][,CHANGE...]: a luminaire at a place that aims along D (down where none is
/// given), turned by TURN around that. A change is scale=F or maintenance=F, factors on its light, lamps=NAME or
/// =NUMBER, one of its sets of lamps, or opening=off, for a point. Throws Error for other texts.
LuminaireText parse_luminaire_text(const std::string& text);

/// Reads the luminaire of such a text. Throws Error as parse_luminaire_text() and read_luminaire() do.
///
/// A luminaire of type C hangs with C0 along x, and is tilted from there to its aim by the shortest way, so that
/// nothing jumps as it leaves straight down. One of type A or B stands level, with its right side across the vertical;
/// aimed straight down or up, that is along x.
/// @param z_up   the text's axes have z up; the light has y up
/// @param origin with y up, is subtracted from the place (SceneDescription::origin)
Light luminaire_of_text(const std::string& text, bool z_up = false, Vec3 origin = {0, 0, 0});

}  // namespace glowworm
