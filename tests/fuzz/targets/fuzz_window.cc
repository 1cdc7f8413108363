// libFuzzer's entry; see scripts/fuzz.
#include <cstddef>
#include <cstdint>

#include "fuzz/parse_once.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  glowworm::fuzz::parse_window({reinterpret_cast<const char*>(data), size});
  return 0;
}
