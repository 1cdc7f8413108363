#include "film/checkpoint.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>

#include "core/archive.h"
#include "core/atomic_file.h"
#include "core/content_hash.h"
#include "core/disk_memory.h"
#include "core/error.h"
#include "core/input_file.h"

namespace glowworm {

namespace {

constexpr char kCheckpointMagic[8] = {'G', 'L', 'O', 'W', 'C', 'P', '0', '9'};

/// Writes values (core/archive.h) and their fingerprint.
class Writer {
 public:
  static constexpr bool kReads = false;
  explicit Writer(const std::string& path) : file_(path) { file_.write(kCheckpointMagic, sizeof kCheckpointMagic); }
  void bytes(const void* data, std::size_t size) {
    file_.write(data, size);
    fingerprint_.add_bytes(data, size);
    check_disk_memory();
  }
  std::size_t count(std::uint64_t size, std::size_t) {
    bytes(&size, sizeof size);
    return size;
  }
  void commit() {
    const std::uint64_t sum = fingerprint_.value();
    file_.write(&sum, sizeof sum);
    file_.commit();
  }

 private:
  AtomicFile file_;
  ContentHash fingerprint_;
};

/// Reads the output of Writer. Throws InvalidArchive for files that are too short or of another kind.
class Reader {
 public:
  static constexpr bool kReads = true;
  Reader(std::ifstream& file, std::uint64_t size) : file_(file), left_(size) {
    char magic[sizeof kCheckpointMagic];
    bytes(magic, sizeof magic);
    if (std::memcmp(magic, kCheckpointMagic, sizeof magic) != 0) fail_transfer("it is of another kind");
    fingerprint_ = ContentHash();
  }
  void bytes(void* to, std::uint64_t size) {
    if (size > left_ || !file_.read(static_cast<char*>(to), static_cast<std::streamsize>(size)))
      fail_transfer("it ends too early");
    left_ -= size;
    fingerprint_.add_bytes(to, size);
    check_disk_memory();
  }
  std::size_t count(std::size_t, std::size_t bytes_each) {
    std::uint64_t size = 0;
    bytes(&size, sizeof size);
    if (size > left_ / bytes_each) fail_transfer("it holds less than it says");
    return size;
  }
  void finish() {
    const std::uint64_t expected = fingerprint_.value();
    std::uint64_t sum = 0;
    bytes(&sum, sizeof sum);
    if (sum != expected || left_ > 0) fail_transfer("it is damaged");
  }

 private:
  std::ifstream& file_;
  std::uint64_t left_;
  ContentHash fingerprint_;
};

template <typename Archive>
void transfer_key(Archive& archive, Checkpoint& c) {
  transfer_all(archive, c.key, c.passes);
}

template <typename Archive>
void transfer(Archive& archive, Checkpoint& c) {
  transfer_key(archive, c);
  transfer_all(archive, c.film, c.round, c.photon_variance, c.first_row, c.end_row, c.above);
}

}  // namespace

void write_checkpoint(const std::string& path, const Checkpoint& checkpoint) {
  Writer writer(path);
  transfer(writer, const_cast<Checkpoint&>(checkpoint));  // a writer does not change it
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
  try {
    Reader reader(file, size);
    Checkpoint out;
    transfer(reader, out);
    reader.finish();
    return out;
  } catch (const InvalidArchive&) {
    throw Error({path}, "this is not a whole checkpoint of this program",
                "Remove the file, or leave --resume out, to start again.");
  }
}

std::optional<Checkpoint> read_key_of_checkpoint(const std::string& path) try {
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path, error);
  if (error) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  Reader reader(file, size);
  Checkpoint out;
  transfer_key(reader, out);
  return out;
} catch (const InvalidArchive&) {
  return std::nullopt;
}

}  // namespace glowworm
