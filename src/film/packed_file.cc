#include "film/packed_file.h"

#include <zstd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <memory>
#include <new>

#include "core/content_hash.h"
#include "core/parallel.h"

namespace glowworm {

namespace {

/// Bytes of a block before compression.
constexpr std::size_t kBlockBytes = std::size_t{1} << 20;
/// Bytes of the largest numbers.
constexpr std::size_t kNumber = 16;

struct BlockHeader {
  std::uint32_t size = 0, packed_size = 0;
  std::uint64_t hash = 0;  // of the packed bytes
};

/// Bytes i, i + 16, i + 32, ... together. The rest that is no whole number stays at the end.
void sort_bytes(std::span<const std::byte> from, std::byte* to) {
  const std::size_t numbers = from.size() / kNumber, whole = numbers * kNumber;
  for (std::size_t place = 0; place < kNumber; ++place)
    for (std::size_t i = 0; i < numbers; ++i) to[place * numbers + i] = from[i * kNumber + place];
  std::copy(from.begin() + static_cast<std::ptrdiff_t>(whole), from.end(), to + whole);
}

void unsort_bytes(std::span<const std::byte> from, std::byte* to) {
  const std::size_t numbers = from.size() / kNumber, whole = numbers * kNumber;
  for (std::size_t place = 0; place < kNumber; ++place)
    for (std::size_t i = 0; i < numbers; ++i) to[i * kNumber + place] = from[place * numbers + i];
  std::copy(from.begin() + static_cast<std::ptrdiff_t>(whole), from.end(), to + whole);
}

/// What a thread needs for a block. It stays with the thread, because making it takes long.
struct Workshop {
  Workshop() {
    if (!packer || !unpacker) throw std::bad_alloc();
  }

  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> packer{ZSTD_createCCtx(), ZSTD_freeCCtx};
  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> unpacker{ZSTD_createDCtx(), ZSTD_freeDCtx};
  std::vector<std::byte> sorted = std::vector<std::byte>(kBlockBytes);
  std::vector<std::byte> packed = std::vector<std::byte>(ZSTD_compressBound(kBlockBytes));
};

Workshop& workshop() {
  thread_local Workshop own;
  return own;
}

/// Blocks that wait for compression, or for the reader: few, so that they stay in the cache.
std::size_t blocks_at_once() { return 2 * static_cast<std::size_t>(thread_count()); }

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
  const std::size_t most = kBlockBytes * blocks_at_once();
  while (!bytes.empty()) {
    if (waiting_.size() >= most) flush();
    const std::size_t taken = std::min(bytes.size(), most - waiting_.size());
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(taken));
    bytes = bytes.subspan(taken);
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
    Workshop& own = workshop();
    sort_bytes(raw, own.sorted.data());
    // Slower levels hardly compress sums of samples further.
    const std::size_t bytes =
        ZSTD_compressCCtx(own.packer.get(), own.packed.data(), own.packed.size(), own.sorted.data(), size, 1);
    if (ZSTD_isError(bytes)) throw Error(std::string("a block cannot be compressed: ") + ZSTD_getErrorName(bytes));
    packed[i].assign(own.packed.begin(), own.packed.begin() + static_cast<std::ptrdiff_t>(bytes));
    headers[i] = {static_cast<std::uint32_t>(size), static_cast<std::uint32_t>(bytes), hash_of(packed[i])};
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
  while (!ended_ && headers.size() < blocks_at_once()) {
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
    Workshop& own = workshop();
    const std::size_t size = headers[i].size;
    const std::span<std::byte> raw(ready_.data() + first[i], size);
    if (hash_of(packed[i]) != headers[i].hash ||
        ZSTD_decompressDCtx(own.unpacker.get(), own.sorted.data(), size, packed[i].data(), packed[i].size()) != size)
      good = false;
    else
      unsort_bytes(std::span(own.sorted).first(size), raw.data());
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
