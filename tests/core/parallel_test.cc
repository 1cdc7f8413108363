#include "core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <limits>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace glowworm {
namespace {

class Parallel : public ::testing::TestWithParam<int> {
 protected:
  void SetUp() override { set_thread_count(GetParam()); }
  void TearDown() override { set_thread_count(0); }
};

TEST_P(Parallel, ReportsItsThreads) { EXPECT_EQ(thread_count(), GetParam()); }

TEST_P(Parallel, VisitsEveryIndexOnce) {
  std::vector<int> visits(1003, 0);
  parallel_for(3, 1003, 7, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) ++visits[i];
  });
  for (std::size_t i = 0; i < visits.size(); ++i) EXPECT_EQ(visits[i], i >= 3 ? 1 : 0) << i;
}

TEST_P(Parallel, PiecesDependOnlyOnTheGrain) {
  std::mutex mutex;
  std::set<std::pair<std::size_t, std::size_t>> pieces;
  parallel_for(10, 35, 10, [&](std::size_t first, std::size_t last) {
    const std::lock_guard lock(mutex);
    pieces.insert({first, last});
  });
  EXPECT_EQ(pieces, (std::set<std::pair<std::size_t, std::size_t>>{{10, 20}, {20, 30}, {30, 35}}));
}

TEST_P(Parallel, EmptyRangesDoNothing) {
  std::atomic<int> calls = 0;
  parallel_for(5, 5, 1, [&](std::size_t, std::size_t) { ++calls; });
  parallel_for(5, 3, 1, [&](std::size_t, std::size_t) { ++calls; });
  EXPECT_EQ(calls, 0);
  parallel_for(0, 3, 0, [&](std::size_t, std::size_t) { ++calls; });
  EXPECT_EQ(calls, 3);
}

TEST_P(Parallel, RethrowsTheExceptionOfAPiece) {
  EXPECT_THROW(parallel_for(0, 100, 1,
                            [](std::size_t first, std::size_t) {
                              if (first == 42) throw std::runtime_error("piece");
                            }),
               std::runtime_error);
}

TEST_P(Parallel, Nests) {
  std::atomic<int> sum = 0;
  parallel_for(0, 10, 1, [&](std::size_t, std::size_t) {
    parallel_for(0, 10, 3, [&](std::size_t first, std::size_t last) { sum += static_cast<int>(last - first); });
  });
  EXPECT_EQ(sum, 100);
}

TEST_P(Parallel, InvokeRunsBoth) {
  std::atomic<int> a = 0, b = 0;
  parallel_invoke([&] { a = 1; }, [&] { b = 2; });
  EXPECT_EQ(a + b, 3);
}

/// Threads are gone after end_threads(), and later work has threads again.
TEST(EndThreads, LeavesTheThreadsOfTheCallerOnly) {
  const auto threads = [] {
    const std::filesystem::directory_iterator all("/proc/self/task");
    return std::distance(begin(all), end(all));
  };
  end_threads();
  const auto before = threads();
  set_thread_count(5);
  for (int round = 0; round < 20; ++round) {
    std::atomic<int> sum = 0;
    parallel_for(0, 1000, 1, [&](std::size_t first, std::size_t) { sum += static_cast<int>(first); });
    EXPECT_EQ(sum, 499500);
    EXPECT_GT(threads(), before);
    end_threads();
    // The system lists a thread for a moment after it has been joined.
    const auto start = std::chrono::steady_clock::now();
    while (threads() > before && std::chrono::steady_clock::now() - start < std::chrono::seconds(10))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(threads(), before);
  }
  set_thread_count(0);
}

#if defined(__x86_64__)
/// Where the thread that first uses TBB has denormal numbers switched off, later loops of the same thread have not.
TEST_P(Parallel, PiecesHaveTheFloatingPointSettingsOfTheCaller) {
  std::atomic<int> lost = 0;
  std::thread([&] {
    volatile float denormal = std::numeric_limits<float>::denorm_min();
    const auto look = [&] { lost += !(denormal * 1.0f > 0); };
    const unsigned int saved = _mm_getcsr();
    _mm_setcsr(saved | 0x8040);  // flush to zero, and denormals are zero
    parallel_for(0, 100, 1, [](std::size_t, std::size_t) {});
    _mm_setcsr(saved);
    parallel_for(0, 100, 1, [&](std::size_t, std::size_t) { look(); });
    parallel_invoke(look, look);
  }).join();
  EXPECT_EQ(lost, 0);
}
#endif

INSTANTIATE_TEST_SUITE_P(Threads, Parallel, ::testing::Values(1, 2, 5));

}  // namespace
}  // namespace glowworm
