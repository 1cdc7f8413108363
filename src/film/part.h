// Parts of a render: the film of a share of its samples in a file, and parts put together.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "film/film.h"
#include "film/picture_info.h"
#include "points/gather_points.h"
#include "settings/render_key.h"

namespace glowworm {

/// The header of a part's file.
struct Part {
  RenderKey key;                    ///< of the whole render
  std::vector<SampleRange> ranges;  ///< samples of every pixel in the film, in order and apart; a render that was
                                    ///< stopped may have fewer
  PictureInfo picture;              ///< of the whole render: its settings have the samples of all parts

  /// Samples of a pixel in the ranges.
  std::uint32_t sample_count() const;
};

/// Writes a part, whole or not at all. Throws Error if it cannot be written.
void write_part(const std::string& path, const Part& part, const Film& film);

/// Reads all but the film. Throws Error if the file is not the beginning of a part.
Part read_part(const std::string& path);

/// A film without samples for a part.
Film film_for(const Part& part);
/// Bytes of such a film, and of what add_part() and write_part() need beside it.
std::uint64_t merge_bytes(const Part& part);

/// Adds the film of a part to the film, in little memory: the same bits in any order of parts (except ids beyond the
/// kMaxIdsOfPixel of a pixel). Throws Error if the file is not a whole part, with the film in no useful state.
/// @param part read_part(path)
void add_part(const std::string& path, const Part& part, Film& film);

/// The samples of a film as bytes, as a part's file holds them: from a few samples of a pixel on they are smaller than
/// the samples.
std::vector<std::byte> packed_film(const Film& film);
/// Adds the samples of a packed_film() to a film of the same pixels. Throws Error if they are not whole, or if the film
/// does not hold those of `task` then and no others.
void unpack_film(std::span<const std::byte> bytes, const CameraTask& task, Film& film);

/// A part and its file.
struct PartFile {
  std::string path;
  Part part;
};

/// The part that all parts make together, with the layers of all of them. Throws Error that names the files if two
/// parts are of different renders, or have a sample in common.
/// @param mixed take parts that other instruction sets have computed
Part united(const std::vector<PartFile>& parts, bool mixed);

}  // namespace glowworm
