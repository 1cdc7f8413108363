// Compression by zlib, as EXR and PNG files have it.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace glowworm {

/// The bytes as a zlib stream (RFC 1950). Throws Error where memory is short.
std::vector<std::byte> deflate_bytes(std::span<const std::byte> bytes);

}  // namespace glowworm
