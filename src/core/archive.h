// Values in bytes between processes. A reader takes any bytes: counts are checked against the bytes that are there,
// flags and enumerators against their ranges.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/rgb.h"
#include "core/vec.h"

namespace glowworm {

/// Thrown where bytes are not what they should hold.
class InvalidArchive : public Error {
 public:
  using Error::Error;
};

[[noreturn]] inline void fail_transfer(const char* what) { throw InvalidArchive(what); }
/// Throws InvalidArchive unless values that were read are possible.
inline void require(bool possible) {
  if (!possible) fail_transfer("it holds impossible values");
}

/// Whether values of a type are copied bit by bit: any bits are valid, and none are padding.
template <typename T>
inline constexpr bool kPlain = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;
template <typename T, std::size_t count>
inline constexpr bool kPlain<std::array<T, count>> = kPlain<T>;
template <>
inline constexpr bool kPlain<Vec2> = sizeof(Vec2) == 8;
template <>
inline constexpr bool kPlain<Vec3> = sizeof(Vec3) == 12;
template <>
inline constexpr bool kPlain<RGB> = sizeof(RGB) == 12;
template <>
inline constexpr bool kPlain<std::byte> = true;

class ArchiveWriter {
 public:
  static constexpr bool kReads = false;
  /// Takes the bytes, piece by piece.
  using Sink = std::function<void(const void*, std::size_t)>;

  explicit ArchiveWriter(Sink write) : write_(std::move(write)) {}

  void bytes(const void* data, std::size_t size) { write_(data, size); }
  /// Number of elements, of at least `size` bytes each.
  std::size_t count(std::size_t size, std::size_t) {
    const std::uint64_t value = size;
    bytes(&value, sizeof value);
    return size;
  }

 private:
  Sink write_;
};

class ArchiveReader {
 public:
  static constexpr bool kReads = true;
  /// Fills the memory with the next bytes; false: it cannot.
  using Source = std::function<bool(void*, std::size_t)>;

  /// @param size bytes of the source
  ArchiveReader(Source read, std::uint64_t size) : read_(std::move(read)), left_(size) {}
  /// @param all must outlive the reader
  explicit ArchiveReader(std::span<const std::byte> all)
      : ArchiveReader(
            [at = all.data()](void* data, std::size_t size) mutable {
              std::memcpy(data, std::exchange(at, at + size), size);
              return true;
            },
            all.size()) {}

  void bytes(void* data, std::size_t size) {
    if (size > left_ || (size > 0 && !read_(data, size))) fail_transfer("it ends too early");
    left_ -= size;
  }
  std::size_t count(std::size_t, std::size_t bytes_each) {
    std::uint64_t value = 0;
    bytes(&value, sizeof value);
    if (value > left_ / bytes_each) fail_transfer("it holds less than it says");
    return static_cast<std::size_t>(value);
  }
  bool at_end() const { return left_ == 0; }

 private:
  Source read_;
  std::uint64_t left_;
};

// Each transfer() lists the members of a structure, for both reading and writing: a function, or a member of a class.

template <typename Archive, typename T>
requires requires(Archive& archive, T& value) { value.transfer(archive); }
void transfer(Archive& archive, T& value) { value.transfer(archive); }

template <typename Archive, typename T>
requires kPlain<T>
void transfer(Archive& archive, T& value) { archive.bytes(&value, sizeof value); }

template <typename Archive>
void transfer(Archive& archive, bool& value) {
  auto byte = static_cast<std::uint8_t>(value);
  archive.bytes(&byte, 1);
  if (byte > 1) fail_transfer("a flag is neither 0 nor 1");
  value = byte == 1;
}

template <typename Archive, typename Enum>
void transfer_enum(Archive& archive, Enum& value, Enum last) {
  auto byte = static_cast<std::uint8_t>(value);
  archive.bytes(&byte, 1);
  if (byte > static_cast<std::uint8_t>(last)) fail_transfer("it holds an unknown kind");
  value = static_cast<Enum>(byte);
}

template <typename Archive>
void transfer(Archive& archive, std::string& text) {
  text.resize(archive.count(text.size(), 1));
  archive.bytes(text.data(), text.size());
}

template <typename Archive>
void transfer(Archive& archive, std::optional<float>& value) {
  bool given = value.has_value();
  transfer(archive, given);
  if (!given) return;
  if (!value) value.emplace();
  transfer(archive, *value);
}

template <typename Archive, typename T, typename Allocator>
void transfer(Archive& archive, std::vector<T, Allocator>& values) {
  if constexpr (kPlain<T>) {
    // By pieces of 1 MB, because the array may lie on disk (core/disk_memory.h).
    constexpr std::size_t kPiece = (std::size_t{1} << 20) / sizeof(T);
    const std::size_t count = archive.count(values.size(), sizeof(T));
    if (Archive::kReads) {
      values.clear();
      values.reserve(count);
    }
    for (std::size_t at = 0; at < count; at += kPiece) {
      const std::size_t end = std::min(at + kPiece, count);
      if (Archive::kReads) values.resize(end);
      archive.bytes(values.data() + at, (end - at) * sizeof(T));
    }
  } else {
    // An element in memory takes about ten times its minimum size in the encoding.
    const std::size_t count = archive.count(values.size(), 8);
    if constexpr (Archive::kReads) values.clear();
    for (std::size_t i = 0; i < count; ++i) {
      if constexpr (Archive::kReads) values.emplace_back();
      transfer(archive, values[i]);
    }
  }
}

template <typename Archive, typename... Members>
void transfer_all(Archive& archive, Members&... members) {
  (transfer(archive, members), ...);
}

/// The values as bytes.
template <typename... Values>
std::vector<std::byte> archived(const Values&... values) {
  std::vector<std::byte> out;
  ArchiveWriter writer([&out](const void* data, std::size_t size) {
    const std::size_t before = out.size();
    out.resize(before + size);
    if (size > 0) std::memcpy(out.data() + before, data, size);
  });
  transfer_all(writer, const_cast<Values&>(values)...);  // a writer does not change them
  return out;
}

/// Reads values that are all of the bytes. Throws InvalidArchive if archived() cannot have made them.
template <typename... Values>
void unarchive(std::span<const std::byte> bytes, Values&... values) {
  ArchiveReader reader(bytes);
  transfer_all(reader, values...);
  if (!reader.at_end()) fail_transfer("it does not end where it should");
}
/// The same for one value.
template <typename T>
T unarchived(std::span<const std::byte> bytes) {
  T value{};
  unarchive(bytes, value);
  return value;
}

}  // namespace glowworm
