#include "film/checkpoint.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

#include "core/atomic_file.h"
#include "core/content_hash.h"
#include "core/error.h"
#include "core/input_file.h"

namespace glowworm {

namespace {

constexpr char kCheckpointMagic[8] = {'G', 'L', 'O', 'W', 'C', 'P', '0', '9'};

/// Writes bytes and computes their fingerprint.
class Writer {
 public:
  explicit Writer(const std::string& path) : file_(path) { file_.write(kCheckpointMagic, sizeof kCheckpointMagic); }
  void put(const void* data, std::size_t size) {
    file_.write(data, size);
    fingerprint_.add_bytes(data, size);
  }
  void put_count(std::uint64_t count) { put(&count, sizeof count); }
  void commit() {
    const std::uint64_t sum = fingerprint_.value();
    file_.write(&sum, sizeof sum);
    file_.commit();
  }

 private:
  AtomicFile file_;
  ContentHash fingerprint_;
};

/// Reads the output of Writer; detects files that are too short or of another kind.
class Reader {
 public:
  explicit Reader(std::ifstream& file, std::uint64_t size) : file_(file), left_(size) {}
  bool take(void* to, std::uint64_t size) {
    if (size > left_) return false;
    left_ -= size;
    if (!file_.read(static_cast<char*>(to), static_cast<std::streamsize>(size))) return false;
    fingerprint_.add_bytes(to, size);
    return true;
  }
  bool take_magic() {
    char magic[sizeof kCheckpointMagic];
    const bool good = take(magic, sizeof magic) && std::memcmp(magic, kCheckpointMagic, sizeof magic) == 0;
    fingerprint_ = ContentHash();
    return good;
  }
  /// Reads a number of items of that size; false if the file cannot hold them.
  bool take_count(std::uint64_t& count, std::uint64_t item) {
    return take(&count, sizeof count) && count <= left_ / item;
  }
  bool ends_with_fingerprint() {
    const std::uint64_t expected = fingerprint_.value();
    std::uint64_t sum = 0;
    return take(&sum, sizeof sum) && sum == expected && left_ == 0;
  }

 private:
  std::ifstream& file_;
  std::uint64_t left_;
  ContentHash fingerprint_;
};

bool parse_begin(Reader& reader, Checkpoint& out) {
  std::uint64_t key_size = 0;
  if (!reader.take_magic() || !reader.take_count(key_size, 1)) return false;
  out.key.resize(key_size);
  return reader.take(out.key.data(), key_size) && reader.take(&out.passes, sizeof out.passes);
}

bool parse(Reader& reader, Checkpoint& out) {
  if (!parse_begin(reader, out)) return false;
  for (auto* numbers : {&out.film, &out.round}) {
    std::uint64_t size = 0;
    if (!reader.take_count(size, sizeof(std::uint32_t))) return false;
    numbers->resize(size);
    if (!reader.take(numbers->data(), size * sizeof(std::uint32_t))) return false;
  }
  if (!reader.take(&out.photon_variance, sizeof out.photon_variance)) return false;
  std::uint64_t above = 0;
  if (!reader.take(&out.first_row, sizeof out.first_row) || !reader.take(&out.end_row, sizeof out.end_row))
    return false;
  if (!reader.take_count(above, sizeof(RGB))) return false;
  out.above.resize(above);
  return reader.take(out.above.data(), above * sizeof(RGB)) && reader.ends_with_fingerprint();
}

}  // namespace

void write_checkpoint(const std::string& path, const Checkpoint& checkpoint) {
  Writer writer(path);
  writer.put_count(checkpoint.key.size());
  writer.put(checkpoint.key.data(), checkpoint.key.size());
  writer.put(&checkpoint.passes, sizeof checkpoint.passes);
  for (const auto* numbers : {&checkpoint.film, &checkpoint.round}) {
    writer.put_count(numbers->size());
    writer.put(numbers->data(), numbers->size() * sizeof(std::uint32_t));
  }
  writer.put(&checkpoint.photon_variance, sizeof checkpoint.photon_variance);
  writer.put(&checkpoint.first_row, sizeof checkpoint.first_row);
  writer.put(&checkpoint.end_row, sizeof checkpoint.end_row);
  writer.put_count(checkpoint.above.size());
  writer.put(checkpoint.above.data(), checkpoint.above.size() * sizeof(RGB));
  writer.commit();
}

std::optional<Checkpoint> read_checkpoint(const std::string& path, DiskUse use, std::uint64_t memory) {
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path, error);
  if (error == std::errc::no_such_file_or_directory) return std::nullopt;
  check_input_file(path);
  std::ifstream file(path, std::ios::binary);
  if (error || !file)
    throw Error({path}, "the checkpoint cannot be read", "Give --resume a file that can be read and written.");
  // The film takes as much beside it.
  const std::unique_ptr<DiskMemory> disk = DiskMemory::for_arrays(use, 2 * size, memory);
  const DiskMemory::Scope scope(disk.get());
  Reader reader(file, size);
  Checkpoint out;
  if (!parse(reader, out))
    throw Error({path}, "this is not a whole checkpoint of this program",
                "Remove the file, or leave --resume out, to start again.");
  return out;
}

std::optional<Checkpoint> read_key_of_checkpoint(const std::string& path) {
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path, error);
  if (error) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  Reader reader(file, size);
  Checkpoint out;
  if (!parse_begin(reader, out)) return std::nullopt;
  return out;
}

}  // namespace glowworm
