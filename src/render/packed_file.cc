#include "render/packed_file.h"

#include <zstd.h>

#include <algorithm>
#include <atomic>
#include <cstring>

#include "core/content_hash.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

/// Bytes of a block before compression, and blocks that are compressed at once.
constexpr std::size_t kBlockBytes = std::size_t{1} << 20, kBlocksAtOnce = 32;
/// Bytes of the largest numbers.
constexpr std::size_t kNumber = 16;
/// Slower levels hardly compress sums of samples further.
constexpr int kLevel = 1;

struct BlockHeader {
  std::uint32_t size = 0, packed_size = 0;
  std::uint64_t hash = 0;  // of the bytes before compression
};

/// Bytes i, i + 16, i + 32, ... together. The rest that is no whole number stays at the end.
void sort_bytes(std::span<const std::byte> from, std::byte* to) {
  const std::size_t numbers = from.size() / kNumber;
  for (std::size_t i = 0; i < kNumber; ++i)
    for (std::size_t j = 0; j < numbers; ++j) to[i * numbers + j] = from[j * kNumber + i];
  std::copy(from.begin() + static_cast<std::ptrdiff_t>(numbers * kNumber), from.end(), to + numbers * kNumber);
}

void unsort_bytes(std::span<const std::byte> from, std::byte* to) {
  const std::size_t numbers = from.size() / kNumber;
  for (std::size_t i = 0; i < kNumber; ++i)
    for (std::size_t j = 0; j < numbers; ++j) to[j * kNumber + i] = from[i * numbers + j];
  std::copy(from.begin() + static_cast<std::ptrdiff_t>(numbers * kNumber), from.end(), to + numbers * kNumber);
}

std::uint64_t hash_of(std::span<const std::byte> bytes) {
  ContentHash hash;
  hash.add_bytes(bytes.data(), bytes.size());
  return hash.value();
}

}  // namespace

void write_header(AtomicFile& file, const FileKind& kind, const std::string& text) {
  const std::uint64_t length = text.size(), hash = hash_of(std::as_bytes(std::span(text)));
  file.write(kind.data(), kind.size());
  file.write(&length, sizeof length);
  file.write(&hash, sizeof hash);
  file.write(text);
}

std::optional<std::string> read_header(std::ifstream& file, const FileKind& kind, std::uint64_t size) {
  FileKind own{};
  std::uint64_t length = 0, hash = 0;
  const auto take = [&](void* to, std::uint64_t bytes) {
    return static_cast<bool>(file.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes)));
  };
  if (!take(own.data(), own.size()) || own != kind) return std::nullopt;
  if (!take(&length, sizeof length) || !take(&hash, sizeof hash) || length > size) return std::nullopt;
  std::string text(length, '\0');
  if (!take(text.data(), length) || hash_of(std::as_bytes(std::span(text))) != hash) return std::nullopt;
  return text;
}

PackedWriter::PackedWriter(AtomicFile& file)
    : sink_([&file](std::span<const std::byte> bytes) { file.write(bytes.data(), bytes.size()); }) {}

void PackedWriter::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t taken = std::min(bytes.size(), kBlockBytes * kBlocksAtOnce - waiting_.size());
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(taken));
    bytes = bytes.subspan(taken);
    if (waiting_.size() == kBlockBytes * kBlocksAtOnce) flush();
  }
}

void PackedWriter::finish() {
  flush();
  const BlockHeader end;
  sink_(std::as_bytes(std::span(&end, 1)));
}

void PackedWriter::flush() {
  const std::size_t blocks = (waiting_.size() + kBlockBytes - 1) / kBlockBytes;
  std::vector<BlockHeader> headers(blocks);
  std::vector<std::vector<std::byte>> packed(blocks);
  parallel_for(0, blocks, 1, [&](std::size_t i, std::size_t) {
    const std::size_t size = std::min(kBlockBytes, waiting_.size() - i * kBlockBytes);
    const std::span<const std::byte> raw(waiting_.data() + i * kBlockBytes, size);
    std::vector<std::byte> sorted(size);
    sort_bytes(raw, sorted.data());
    packed[i].resize(ZSTD_compressBound(size));
    const std::size_t bytes = ZSTD_compress(packed[i].data(), packed[i].size(), sorted.data(), size, kLevel);
    if (ZSTD_isError(bytes)) throw Error(std::string("a block cannot be compressed: ") + ZSTD_getErrorName(bytes));
    packed[i].resize(bytes);
    headers[i] = {static_cast<std::uint32_t>(size), static_cast<std::uint32_t>(bytes), hash_of(raw)};
  });
  for (std::size_t i = 0; i < blocks; ++i) {
    sink_(std::as_bytes(std::span(&headers[i], 1)));
    sink_(packed[i]);
  }
  waiting_.clear();
}

PackedReader::PackedReader(std::ifstream& file)
    : source_([&file](std::span<std::byte> bytes) {
        return static_cast<bool>(
            file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())));
      }) {}

bool PackedReader::fill() {
  std::vector<BlockHeader> headers;
  std::vector<std::vector<std::byte>> packed;
  while (!ended_ && headers.size() < kBlocksAtOnce) {
    BlockHeader header;
    if (!source_(std::as_writable_bytes(std::span(&header, 1)))) return false;
    ended_ = header.size == 0 && header.packed_size == 0 && header.hash == 0;
    if (ended_) break;
    if (header.size > kBlockBytes || header.packed_size > ZSTD_compressBound(kBlockBytes)) return false;
    packed.emplace_back(header.packed_size);
    if (!source_(packed.back())) return false;
    headers.push_back(header);
  }
  std::vector<std::size_t> first(headers.size() + 1);
  for (std::size_t i = 0; i < headers.size(); ++i) first[i + 1] = first[i] + headers[i].size;
  ready_.resize(first.back());
  taken_ = 0;
  std::atomic<bool> good = !headers.empty();
  parallel_for(0, headers.size(), 1, [&](std::size_t i, std::size_t) {
    std::vector<std::byte> sorted(headers[i].size);
    const std::size_t size = ZSTD_decompress(sorted.data(), sorted.size(), packed[i].data(), packed[i].size());
    if (size != sorted.size()) {
      good = false;
      return;
    }
    unsort_bytes(sorted, ready_.data() + first[i]);
    if (hash_of({ready_.data() + first[i], size}) != headers[i].hash) good = false;
  });
  return good;
}

bool PackedReader::read(std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    if (taken_ == ready_.size() && !fill()) return false;
    const std::size_t taken = std::min(bytes.size(), ready_.size() - taken_);
    std::memcpy(bytes.data(), ready_.data() + taken_, taken);
    taken_ += taken;
    bytes = bytes.subspan(taken);
  }
  return true;
}

bool PackedReader::at_end() {
  std::byte more;
  if (taken_ == ready_.size() && !ended_) fill();
  return taken_ == ready_.size() && ended_ && !source_(std::span(&more, 1));
}

}  // namespace glowworm
