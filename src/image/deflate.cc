#include "image/deflate.h"

#include <zlib.h>

#include "core/error.h"

namespace glowworm {

namespace {
// What OpenEXR compresses with: twice as fast as zlib's own 6, and hardly larger.
constexpr int kLevel = 4;
}  // namespace

std::vector<std::byte> deflate_bytes(std::span<const std::byte> bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<std::byte> packed(size);
  const int status = compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                               reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()), kLevel);
  if (status != Z_OK) throw Error("a picture cannot be compressed: memory is short", "Render a smaller picture.");
  packed.resize(size);
  return packed;
}

}  // namespace glowworm
