// libFuzzer's entry; see scripts/fuzz.
#include <cstddef>
#include <cstdint>

#include "fuzz/parse_once.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  glowworm::fuzz::parse_mesh(bytes);
  glowworm::fuzz::parse_spectrum(bytes);
  return 0;
}
