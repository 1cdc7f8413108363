// Photometric files of luminaires: IES LM-63 and EULUMDAT.
#pragma once
#include <string>
#include <string_view>

#include "scene/scene.h"

namespace glowworm {

/// Whether a file's ending is that of a photometric file: .ies or .ldt, in any case.
bool is_photometric_file(const std::string& path);

/// Parses an IES LM-63 file of 1986 to 2019: type A, B or C, with TILT=NONE, TILT=INCLUDE or TILT=FILE beside it. The
/// table is in candela, with the file's factors applied; the factors of tilt stand beside it.
/// Throws Error with file and line for what is not one; also where numbers are missing or left over.
/// @param path for messages and for the file of TILT=FILE
IntensityTable parse_lm63(std::string_view text, const std::string& path);

/// Parses a EULUMDAT file (.ldt); the table is in candela for the flux of the file's first set of lamps.
/// Throws Error as parse_lm63() does.
IntensityTable parse_eulumdat(std::string_view text, const std::string& path);

/// A white light with the intensities of a photometric file, in W sr^-1 by 179 lm/W; it aims along -y, with x to its
/// right. Throws Error as the parsers do, or where the file cannot be read.
Light read_luminaire(const std::string& path);

/// Whether a text of --light adds a luminaire: FILE@..., with the ending of a photometric file.
bool is_luminaire_text(const std::string& text);

/// Reads FILE@X,Y,Z[,DX,DY,DZ[,TURN]]: a luminaire at a place (m) that aims along D (down where none is given), turned
/// by TURN degrees around that. Throws Error for other texts, and as read_luminaire() does.
/// @param z_up   the text's axes have z up; the light has y up
/// @param origin with y up, is subtracted from the place (SceneDescription::origin)
Light luminaire_of_text(const std::string& text, bool z_up = false, Vec3 origin = {0, 0, 0});

}  // namespace glowworm
