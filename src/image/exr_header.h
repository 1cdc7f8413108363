// Checks the header of an OpenEXR file before OpenEXR reads it.
#pragma once
#include <string>

namespace glowworm {

/// Throws Error if an attribute in the file's headers claims more bytes than the file has, or if the headers do not
/// end: OpenEXR allocates memory for an attribute, up to 2 GB, before it reads it. Also if a header lacks what a
/// picture needs, or a row without compression is shorter or longer than its pixels: OpenEXR would return memory of
/// earlier use as pixels. Format: "OpenEXR File Layout", openexr.com/en/latest/OpenEXRFileLayout.html.
/// @param path a regular file that begins like an OpenEXR file
void check_exr_header(const std::string& path);

}  // namespace glowworm
