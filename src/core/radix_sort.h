// Stable parallel sorting of keyed indices: the same order for any number of threads.
#pragma once
#include <cstdint>
#include <vector>

namespace glowworm {

/// A sort key and the index of its item.
template <typename Key>
struct KeyedIndex {
  Key key;
  std::uint32_t index;
  friend bool operator==(const KeyedIndex&, const KeyedIndex&) = default;
};

/// Sorts by the low `bits` bits of the keys, ascending and stably. This is a parallel least-significant-digit radix
/// sort with digits of up to 11 bits; it skips digits in which all keys agree. It needs as much additional memory as
/// the pairs.
/// @param bits 0 to 32
void radix_sort(std::vector<KeyedIndex<std::uint32_t>>& pairs, int bits);
/// @param bits 0 to 64
void radix_sort(std::vector<KeyedIndex<std::uint64_t>>& pairs, int bits);

}  // namespace glowworm
