// Checks an OpenEXR file before OpenEXR reads it.
#pragma once
#include <string>

namespace glowworm {

/// Throws Error if an attribute in the file's headers claims more bytes than the file has, or if the headers do not
/// end: OpenEXR allocates memory for an attribute, up to 2 GB, before it reads it. Also if an attribute has not the
/// size of its type, a channel is of unknown type, or the first picture of the file lacks what OpenEXR needs, is deep,
/// or has channels of fewer pixels.
/// Format: "OpenEXR File Layout", openexr.com/en/latest/OpenEXRFileLayout.html.
/// @param path a regular file that begins like an OpenEXR file
void check_exr_header(const std::string& path);

/// Does what check_exr_header() does. Also throws Error if a block of pixels is missing or empty, or if one without
/// compression or with that of ZIP, ZIPS or RLE does not hold as many bytes as its pixels need: OpenEXR 3.1 would
/// return memory of earlier use as the rest. Checks the first picture of the file, at its largest size. Unpacks each
/// block once, in memory of its size.
void check_exr_blocks(const std::string& path);

}  // namespace glowworm
