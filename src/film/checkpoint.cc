#include "film/checkpoint.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <memory>

#include "core/archive.h"
#include "core/atomic_file.h"
#include "core/content_hash.h"
#include "core/error.h"
#include "core/input_file.h"

namespace glowworm {

namespace {

constexpr std::array<char, 8> kCheckpointMagic = {'G', 'L', 'O', 'W', 'C', 'P', '0', '9'};

/// The next bytes of a checkpoint's file, with their fingerprint.
ArchiveReader::Source source_of(std::ifstream& file, ContentHash& fingerprint) {
  return [&](void* to, std::size_t size) {
    if (!file.read(static_cast<char*>(to), static_cast<std::streamsize>(size))) return false;
    fingerprint.add_bytes(to, size);
    check_disk_memory();
    return true;
  };
}

void check_magic(ArchiveReader& reader) {
  std::array<char, 8> magic{};
  transfer(reader, magic);
  if (magic != kCheckpointMagic) fail_transfer("it is of another kind");
}

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
  AtomicFile file(path);
  ContentHash fingerprint;
  file.write(kCheckpointMagic.data(), kCheckpointMagic.size());
  ArchiveWriter writer([&](const void* data, std::size_t size) {
    file.write(data, size);
    fingerprint.add_bytes(data, size);
    check_disk_memory();
  });
  transfer(writer, const_cast<Checkpoint&>(checkpoint));  // a writer does not change it
  const std::uint64_t sum = fingerprint.value();
  file.write(&sum, sizeof sum);
  file.commit();
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
    ContentHash fingerprint;
    ArchiveReader reader(source_of(file, fingerprint), size);
    check_magic(reader);
    fingerprint = ContentHash();
    Checkpoint out;
    transfer(reader, out);
    const std::uint64_t expected = fingerprint.value();
    std::uint64_t sum = 0;
    transfer(reader, sum);
    if (sum != expected || !reader.at_end()) fail_transfer("it is damaged");
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
  ContentHash unused;
  ArchiveReader reader(source_of(file, unused), size);
  check_magic(reader);
  Checkpoint out;
  transfer_key(reader, out);
  return out;
} catch (const InvalidArchive&) {
  return std::nullopt;
}

}  // namespace glowworm
