#include "core/large_array.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <new>

#include "core/spare_memory.h"

namespace glowworm {
namespace {

TEST(LargeArray, HoldsWhatIsWritten) {
  for (const std::size_t n : {std::size_t{0}, std::size_t{1}, std::size_t{1000}, std::size_t{3} << 20}) {
    LargeArray<std::uint32_t> array(n);
    ASSERT_EQ(array.size(), n);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(array.data()) % 64, 0u);
    for (std::size_t i = 0; i < n; ++i) array[i] = static_cast<std::uint32_t>(i * 7);
    const LargeArray<std::uint32_t> moved = std::move(array);
    for (std::size_t i = 0; i < n; i += 997) ASSERT_EQ(moved[i], static_cast<std::uint32_t>(i * 7));
  }
}

/// A block that is freed serves the next array of about its size, and no other.
TEST(FreedMemory, ServesTheNextArrayOfItsSize) {
  constexpr std::size_t kBytes = std::size_t{8} << 20;
  const FreedMemoryKeeper keeper(3 * kBytes);
  void* const first = allocate_large(kBytes);
  free_large(first);
  void* const smaller = allocate_large(kBytes / 4);
  EXPECT_NE(smaller, first);
  void* const second = allocate_large(kBytes - 1000);
  EXPECT_EQ(second, first);
  void* const third = allocate_large(kBytes);
  EXPECT_NE(third, first);
  for (void* memory : {smaller, second, third}) free_large(memory);
}

/// No more is kept than was asked for: the block that waits the longest goes first.
TEST(FreedMemory, IsKeptUpToItsLimit) {
  constexpr std::size_t kBytes = std::size_t{8} << 20, kOthers = std::size_t{12} << 20;
  const FreedMemoryKeeper keeper(kOthers + kBytes / 2);
  free_large(allocate_large(kBytes));
  void* const other = allocate_large(kOthers);
  free_large(other);
  void* const again = allocate_large(kOthers);
  EXPECT_EQ(again, other);
  free_large(again);
}

TEST(LargeArray, ThrowsWithoutMemory) {
  EXPECT_THROW(allocate_large(std::numeric_limits<std::size_t>::max() - 5), std::bad_alloc);
  EXPECT_THROW(allocate_large(std::numeric_limits<std::size_t>::max() / 2), std::bad_alloc);
}

}  // namespace
}  // namespace glowworm
