#include "core/disk_memory.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <thread>

#include "core/error.h"
#include "core/large_array.h"
#include "core/memory_budget.h"
#include "support/sanitizers.h"

namespace glowworm {
namespace {

TEST(DiskMemory, HoldsMoreThanTheProcessDoes) {
  constexpr std::size_t kCount = std::size_t{16} << 20, kLimit = std::size_t{8} << 20;
  // AddressSanitizer keeps a byte for each eight that are used, and some kernels count those that it has only read.
  constexpr std::size_t kMost = kLimit + (kAddressSanitizer ? kCount * sizeof(std::uint32_t) / 8 : 0);
  const DiskMemory memory(kLimit);
  LargeArray<std::uint32_t> array;
  {
    const DiskMemory::Scope scope(&memory);
    array = LargeArray<std::uint32_t>(kCount);
  }
  const std::uint64_t before = resident_bytes();
  for (std::size_t i = 0; i < kCount; ++i) array[i] = static_cast<std::uint32_t>(i * 7);
  for (int i = 0; i < 1000 && resident_bytes() > before + kMost; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_LE(resident_bytes(), before + kMost);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < kCount; ++i) wrong += array[i] != static_cast<std::uint32_t>(i * 7);
  EXPECT_EQ(wrong, 0u);
}

TEST(DiskMemory, TakesLargeArraysOfItsScopeAlone) {
  const DiskMemory memory(std::uint64_t{1} << 20);
  void* const outside = allocate_on_disk(std::size_t{2} << 20);
  EXPECT_EQ(outside, nullptr);
  const DiskMemory::Scope scope(&memory);
  EXPECT_EQ(allocate_on_disk(1000), nullptr);
  void* const inside = allocate_on_disk(std::size_t{2} << 20);
  ASSERT_NE(inside, nullptr);
  EXPECT_TRUE(free_on_disk(inside));
  EXPECT_FALSE(free_on_disk(inside));
  EXPECT_THROW(allocate_on_disk(std::size_t{1} << 55), Error);
}

}  // namespace
}  // namespace glowworm
