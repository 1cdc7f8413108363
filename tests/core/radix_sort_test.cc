#include "core/radix_sort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "core/parallel.h"
#include "core/random.h"

namespace glowworm {
namespace {

template <typename Key>
std::vector<KeyedIndex<Key>> random_pairs(std::size_t n, Key mask) {
  std::vector<KeyedIndex<Key>> pairs(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint64_t bits = static_cast<std::uint64_t>(hash32(2 * i)) << 32 | hash32(2 * i + 1);
    pairs[i] = {static_cast<Key>(static_cast<Key>(bits) & mask), i};
  }
  return pairs;
}

template <typename Key>
void expect_sorted_as_std_does(std::size_t n, Key mask, int bits) {
  std::vector<KeyedIndex<Key>> pairs = random_pairs<Key>(n, mask), expected = pairs;
  const Key compared = bits == 8 * sizeof(Key) ? static_cast<Key>(~Key{0}) : static_cast<Key>((Key{1} << bits) - 1);
  std::stable_sort(expected.begin(), expected.end(),
                   [&](const auto& a, const auto& b) { return (a.key & compared) < (b.key & compared); });
  radix_sort(pairs, bits);
  EXPECT_EQ(pairs, expected) << n << " pairs, mask " << mask << ", " << bits << " bits";
}

TEST(RadixSort, SortsStablyByTheGivenBits) {
  for (const std::size_t n : {0, 1, 2, 3, 1000, 100003}) {
    for (const int bits : {0, 1, 9, 11, 12, 27, 32}) expect_sorted_as_std_does<std::uint32_t>(n, 0xffffffffu, bits);
    for (const int bits : {0, 30, 33, 63, 64}) expect_sorted_as_std_does<std::uint64_t>(n, ~std::uint64_t{0}, bits);
  }
}

TEST(RadixSort, SkipsDigitsInWhichAllKeysAgree) {
  for (const std::uint64_t mask : {0x0ull, 0x1ull, 0xff00000000000000ull, 0x00ff00000000ff00ull, 0x8000000000000001ull})
    expect_sorted_as_std_does<std::uint64_t>(5000, mask, 64);
}

TEST(RadixSort, DoesNotDependOnThreads) {
  std::vector<std::vector<KeyedIndex<std::uint32_t>>> results;
  for (const int threads : {1, 2, 5}) {
    set_thread_count(threads);
    results.push_back(random_pairs<std::uint32_t>(200000, 0xfffu));
    radix_sort(results.back(), 12);
  }
  set_thread_count(0);
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

}  // namespace
}  // namespace glowworm
