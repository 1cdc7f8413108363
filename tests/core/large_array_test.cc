#include "core/large_array.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <new>

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

TEST(LargeArray, ThrowsWhereThereIsNoMemory) {
  EXPECT_THROW(allocate_large(std::numeric_limits<std::size_t>::max() - 5), std::bad_alloc);
  EXPECT_THROW(allocate_large(std::numeric_limits<std::size_t>::max() / 2), std::bad_alloc);
}

}  // namespace
}  // namespace glowworm
