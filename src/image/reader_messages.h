// What the program glowworm-reader and its parent tell each other.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "image/image_file.h"

namespace glowworm {

/// A message of the parent, with a file descriptor. After each but `close`, the program sends the number of bytes of
/// its answer, 32 bits, and the answer.
struct ReaderRequest {
  enum class Kind : std::uint8_t {
    open,   ///< open the picture in the descriptor
    rows,   ///< write rows of the open picture to the descriptor, memory that all requests share
    close,  ///< close the picture
  };
  Kind kind = Kind::close;
  SampleType type = SampleType::single;  ///< rows: of samples
  char plugin[16] = {};                  ///< open: ImageFormat::plugin
  std::int32_t first = 0, last = 0;      ///< rows: first and past the last
  std::uint64_t bytes = 0;               ///< rows: of all samples
  std::uint64_t memory_bytes = 0;        ///< that it may take beside what the program takes
  std::uint32_t cpu_seconds = 0;
};

/// The answer to a request.
struct ReaderAnswer {
  bool done = false;    ///< opened, or all rows read
  std::string message;  ///< of the reader
  // open:
  ImageFileHeader header;
  std::int32_t depth = 0, tile_height = 0;
  bool unpacks_whole = false;
};

std::string encode_answer(const ReaderAnswer& answer);

/// Decodes an answer. Any bytes give an answer whose enumerators are known and which has a name for each channel, or
/// throw InvalidArchive (core/archive.h). Sizes may have any value.
ReaderAnswer decode_answer(std::string_view bytes);

}  // namespace glowworm
