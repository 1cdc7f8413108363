// Long runs of numbers in files and messages, compressed in blocks (Zstandard).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/atomic_file.h"

namespace glowworm {

/// Eight characters that tell the kind of a file.
using FileKind = std::array<char, 8>;

/// Writes the kind of a file and a text, with a hash.
void write_header(AtomicFile& file, const FileKind& kind, const std::string& text);

/// Reads the text of write_header(); nothing if the file is of another kind or damaged.
/// @param size of the file, bytes
std::optional<std::string> read_header(std::ifstream& file, const FileKind& kind, std::uint64_t size);

/// Cuts bytes into blocks, sorts each by the place of a byte in its number of 128 bits, which makes runs of equal bytes
/// of numbers of like size, and writes it compressed with a hash.
class PackedWriter {
 public:
  /// Takes the output, piece by piece.
  using Sink = std::function<void(std::span<const std::byte>)>;

  explicit PackedWriter(Sink sink) : sink_(std::move(sink)) {}
  explicit PackedWriter(AtomicFile& file);
  /// Appends bytes, whatever they are cut into. Throws what the sink throws: DiskError where a file cannot be written.
  void write(std::span<const std::byte> bytes);
  /// Writes the rest. To be called once, at the end.
  void finish();

 private:
  void flush();

  Sink sink_;
  std::vector<std::byte> waiting_;
};

/// Reads the output of PackedWriter.
class PackedReader {
 public:
  /// Fills the bytes with the next ones; returns false if there are no more.
  using Source = std::function<bool(std::span<std::byte>)>;

  explicit PackedReader(Source source) : source_(std::move(source)) {}
  explicit PackedReader(std::ifstream& file);
  /// Fills the bytes with the next ones. Returns false if the source ends before, or is not what was written.
  bool read(std::span<std::byte> bytes);
  /// Whether all has been read and nothing follows.
  bool at_end();

 private:
  bool fill();

  Source source_;
  std::vector<std::byte> ready_;
  std::size_t taken_ = 0;
  bool ended_ = false;  // the mark of the end has been read
};

}  // namespace glowworm
