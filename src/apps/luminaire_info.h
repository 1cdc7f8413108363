// What 'glowworm info' says of a photometric file.
#pragma once
#include <string>

namespace glowworm {

struct LuminaireInfoOptions {
  std::string path, lamps, output, command_line;  ///< output: a PNG file of the polar curve, or empty
  bool as_json = false;
};

/// Prints the key figures of a luminaire, and draws its polar curve if asked to. Throws Error if a file cannot be read
/// or written.
void print_luminaire(const LuminaireInfoOptions& options);

}  // namespace glowworm
