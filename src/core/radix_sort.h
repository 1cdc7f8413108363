// Sorting of keyed indices, in parallel and stably: the same order for any number of threads.
#pragma once
#include <cstdint>
#include <vector>

namespace glowworm {

/// A sort key and the index of what it belongs to.
template <typename Key>
struct KeyedIndex {
  Key key;
  std::uint32_t index;
  friend bool operator==(const KeyedIndex&, const KeyedIndex&) = default;
};

/// Sorts by the low `bits` bits of the keys, ascending; equal keys keep their order. A least-significant-digit radix
/// sort with digits of up to 11 bits that looks at no digit in which all keys agree. Takes as much memory again as the
/// pairs, on all threads.
/// @param bits 0 to 32
void radix_sort(std::vector<KeyedIndex<std::uint32_t>>& pairs, int bits);
/// @param bits 0 to 64
void radix_sort(std::vector<KeyedIndex<std::uint64_t>>& pairs, int bits);

}  // namespace glowworm
