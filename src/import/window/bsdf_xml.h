// Scattering data of windows, as LBNL's WINDOW, genBSDF and the CGDB write them (XML).
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bsdf/measured.h"

namespace glowworm {

/// Memory that the matrices of a text take at most, bytes.
std::uint64_t bsdf_bytes(std::string_view text);

/// Reads matrices of the visible light over patches of directions: the Klems bases (full, half, quarter), or another of
/// the file's own; or tensor trees, as their means over the full basis. The front of the surface is WINDOW's back, the
/// side of the room, as in Radiance. What is missing scatters nothing. Throws Error with file and line for what is no
/// such file.
/// @param notes gets what was changed: trees, and matrices that are not reciprocal, or give more light than they get
std::shared_ptr<const MeasuredBsdf> parse_bsdf_xml(std::string_view text, const std::string& path,
                                                   std::vector<std::string>& notes);

}  // namespace glowworm
