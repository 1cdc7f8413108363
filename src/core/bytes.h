// Numbers and arrays as bytes, for messages and files between processes of one program.
#pragma once
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/error.h"

namespace glowworm {

/// Appends values to a block of bytes.
class ByteWriter {
 public:
  template <typename T>
  void put(const T& value) {
    put_array(std::span(&value, 1));
  }
  template <typename T>
  void put_array(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (values.empty()) return;
    const std::size_t at = bytes_.size();
    bytes_.resize(at + values.size_bytes());
    std::memcpy(bytes_.data() + at, values.data(), values.size_bytes());
  }
  template <typename T>
  void put_array(const std::vector<T>& values) {
    put_array(std::span<const T>(values));
  }
  void put_text(std::string_view text) { put_array(std::span(text)); }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

/// Takes the values of a ByteWriter in the same order.
class ByteReader {
 public:
  /// @param bytes must outlive the reader @param source where they come from, for errors
  ByteReader(std::span<const std::byte> bytes, std::string source) : bytes_(bytes), source_(std::move(source)) {}

  /// Throws Error, as all below, if too few bytes are left.
  template <typename T>
  T take() {
    T value{};
    take_to(std::span(&value, 1));
    return value;
  }
  template <typename T>
  void take_to(std::span<T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    check(values.size(), sizeof(T));
    if (!values.empty()) std::memcpy(values.data(), bytes_.data(), values.size_bytes());
    bytes_ = bytes_.subspan(values.size_bytes());
  }
  template <typename T>
  void take_array(std::vector<T>& values, std::size_t count) {
    check(count, sizeof(T));
    values.resize(count);
    take_to(std::span(values));
  }
  /// All bytes that are left, as text.
  std::string rest() {
    std::string text(left(), '\0');
    take_to(std::span(text));
    return text;
  }
  std::size_t left() const { return bytes_.size(); }

 private:
  void check(std::size_t count, std::size_t size) const {
    if (count > left() / size) throw Error(source_ + " is too short");
  }

  std::span<const std::byte> bytes_;
  std::string source_;
};

}  // namespace glowworm
