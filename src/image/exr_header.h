// What an OpenEXR file says about itself, before OpenEXR believes it.
#pragma once
#include <string>

namespace glowworm {

/// Throws Error where an attribute of the file's headers claims more bytes than the file has, or the headers do not
/// end: OpenEXR takes memory for an attribute, up to 2 GB, before it reads it.
/// Format: "OpenEXR File Layout", openexr.com/en/latest/OpenEXRFileLayout.html.
/// @param path a regular file that begins as OpenEXR files do
void check_exr_header(const std::string& path);

}  // namespace glowworm
