// Batches in structure-of-arrays form.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>

#include "core/large_array.h"

namespace glowworm {

/// Element i of the result is element order[i] of `from`.
template <class T>
LargeVector<std::remove_const_t<T>> permuted(std::span<T> from, std::span<const std::uint32_t> order) {
  LargeVector<std::remove_const_t<T>> to(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) to[i] = from[order[i]];
  return to;
}

/// Base of a batch `Own`, whose arrays have one length: index i of each belongs to element i. Own::arrays(batch)
/// returns references to them in a tuple. An array that stays empty comes last.
template <class Own>
struct Batch {
  std::size_t size() const { return std::get<0>(Own::arrays(own())).size(); }
  /// Calls work(array of each batch...) for each of the arrays.
  template <std::size_t first = 0, class Work, class... Batches>
  static void for_arrays(const Work& work, Batches&... batches) {
    if constexpr (first < kArrays<Own>) {
      work(std::get<first>(Own::arrays(batches))...);
      for_arrays<first + 1>(work, batches...);
    }
  }
  void reserve(std::size_t n) {
    for_arrays([n](auto& array) { array.reserve(n); }, own());
  }
  void resize(std::size_t n) {
    for_arrays([n](auto& array) { array.resize(n); }, own());
  }
  /// Removes all elements but keeps their memory.
  void clear() { resize(0); }
  /// Appends an element: one value for each of the first arrays.
  template <class... Values>
  void add(const Values&... values) {
    add_from<0>(values...);
  }
  void append(const Own& other) {
    for_arrays([](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); }, own(), other);
  }
  /// Overwrites element `to` with element `from`.
  void move(std::size_t from, std::size_t to) {
    if (from != to) for_arrays([from, to](auto& array) { array[to] = array[from]; }, own());
  }
  /// Element i of the result is element order[i] of this batch.
  Own permuted(std::span<const std::uint32_t> order) const {
    Own out;
    for_arrays([&](auto& to, const auto& from) { to = glowworm::permuted(std::span(from), order); }, out, own());
    return out;
  }

 private:
  template <class Any>
  static constexpr std::size_t kArrays = std::tuple_size_v<decltype(Any::arrays(std::declval<Any&>()))>;

  Own& own() { return static_cast<Own&>(*this); }
  const Own& own() const { return static_cast<const Own&>(*this); }
  template <std::size_t place, class Value, class... Values>
  void add_from(const Value& value, const Values&... values) {
    std::get<place>(Own::arrays(own())).push_back(value);
    if constexpr (sizeof...(values) > 0) add_from<place + 1>(values...);
  }
};

/// Bytes of an element of a batch, in all of its arrays.
template <class Any>
std::size_t bytes_each() {
  Any none;
  std::size_t bytes = 0;
  Any::for_arrays([&bytes](auto& array) { bytes += sizeof(array[0]); }, none);
  return bytes;
}

}  // namespace glowworm
