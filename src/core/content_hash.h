// A fast 64-bit hash that tells whether two contents are equal. It is not cryptographic.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>

namespace glowworm {

/// Hashes data in the order in which it is added.
class ContentHash {
 public:
  void add_bytes(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (; size >= sizeof(std::uint64_t); size -= sizeof(std::uint64_t), bytes += sizeof(std::uint64_t)) {
      std::uint64_t word;
      std::memcpy(&word, bytes, sizeof word);
      mix(word);
    }
    std::uint64_t rest = 0;
    if (size > 0) {
      std::memcpy(&rest, bytes, size);
      mix(rest);
    }
  }
  /// Adds a number, or a structure without padding.
  template <typename T>
  void add(const T& value) {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    add_bytes(&value, sizeof value);
  }
  void add(std::string_view text) {
    add(text.size());
    add_bytes(text.data(), text.size());
  }
  /// Adds an array of numbers, or of structures without padding.
  template <typename T>
  void add_array(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
    add(values.size());
    add_bytes(values.data(), values.size_bytes());
  }
  std::uint64_t value() const { return state_; }

 private:
  /// Multiplies to 128 bits and mixes both halves, as in wyhash (Wang Yi).
  void mix(std::uint64_t word) {
    __extension__ using Product = unsigned __int128;
    const Product product = static_cast<Product>(state_ ^ word) * 0x9e3779b97f4a7c15u;
    state_ = (static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64)) + 0xa0761d6478bd642fu;
  }

  std::uint64_t state_ = 0x243f6a8885a308d3u;
};

}  // namespace glowworm
