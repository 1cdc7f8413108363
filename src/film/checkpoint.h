// Checkpoints: the film between two tasks. An interrupted render continues to the same bits.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/disk_memory.h"
#include "core/rgb.h"

namespace glowworm {

/// The state of a render after a whole number of tasks. It is complete, because all randomness belongs to the numbers
/// of pass, pixel and photon.
struct Checkpoint {
  std::string key;  ///< identifies scene, settings and version; a render continues only from its own checkpoint
  std::uint32_t passes = 0;          ///< complete passes in the film, which may hold a part of the next
  std::vector<std::uint32_t> film;   ///< Film::save()
  std::vector<std::uint32_t> round;  ///< of adaptive sampling (control/adaptive.h); empty: none is under way
  double photon_variance = 0;        ///< PictureInfo::photon_variance
  // Of renders that are made in bands of rows (bake/bands.h); all 0 and empty for others.
  std::uint32_t first_row = 0, end_row = 0;  ///< rows that the film is for
  std::vector<RGB> above = {};               ///< the light of all rows above these
};

/// Writes a checkpoint, whole or not at all. Throws Error if it cannot be written.
void write_checkpoint(const std::string& path, const Checkpoint& checkpoint);

/// Reads a checkpoint; nothing if there is no such file. Throws Error if the file is not a complete checkpoint.
/// @param use    whether its arrays may lie on disk, like the film's
/// @param memory bytes of the render
std::optional<Checkpoint> read_checkpoint(const std::string& path, DiskUse use = DiskUse::never,
                                          std::uint64_t memory = 0);

/// The key and the passes of a checkpoint, without its film; nothing if the file cannot be read.
std::optional<Checkpoint> read_key_of_checkpoint(const std::string& path);

}  // namespace glowworm
