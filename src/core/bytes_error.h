// Bytes that are damaged or forged.
#pragma once
#include "core/error.h"

namespace glowworm {

/// Thrown if bytes are not those that the program writes. SharedWork::Take throws it before it has any effect; the
/// piece is then made again.
class BytesError : public Error {
 public:
  using Error::Error;
};

/// Throws BytesError unless values that were read are possible.
inline void require(bool possible) {
  if (!possible) throw BytesError("the bytes hold impossible values");
}

/// Runs `read`, which takes values out of a ByteReader (core/bytes.h), and throws BytesError in place of Error.
template <typename Read>
void read_bytes(const Read& read) {
  try {
    read();
  } catch (const Error& error) {
    throw BytesError(error.what());
  }
}

}  // namespace glowworm
