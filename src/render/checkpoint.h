// Checkpoints: the film between two tasks, so that a render that was cut off goes on to the same bits.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace glowworm {

/// The state of a render after a whole number of tasks. Nothing else need be kept: all randomness belongs to the
/// numbers of pass, pixel and photon.
struct Checkpoint {
  std::string key;                  ///< names scene, settings and version; a render goes on only from its own
  std::uint32_t passes = 0;         ///< whole passes in the film, which may hold a part of the next
  std::vector<std::uint32_t> film;  ///< Film::save()
};

/// Writes a checkpoint, whole or not at all. Throws Error where it cannot be written.
void write_checkpoint(const std::string& path, const Checkpoint& checkpoint);

/// Reads a checkpoint; nothing where there is no such file. Throws Error where the file is not a whole checkpoint.
std::optional<Checkpoint> read_checkpoint(const std::string& path);

}  // namespace glowworm
