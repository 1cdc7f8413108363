// Parts of a result that threads make in any order and that are joined by index.
#pragma once
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "core/parallel.h"

namespace glowworm {

/// Calls make(number, part) for all numbers below `count` on all threads, and join(part) in the order of the numbers as
/// parts arrive, by one thread at a time. Few parts wait, and their memory is reused while it is in the caches: `make`
/// gets parts with their old content.
template <typename Part, typename Make, typename Join>
void make_parts(std::size_t count, const Make& make, const Join& join) {
  std::vector<std::unique_ptr<Part>> waiting(count), spare;
  std::atomic<std::size_t> next_to_make = 0;
  std::size_t next_to_join = 0;
  std::mutex mutex;
  parallel_for(0, count, 1, [&](std::size_t, std::size_t) {
    const std::size_t number = next_to_make++;
    std::unique_ptr<Part> part;
    {
      const std::scoped_lock lock(mutex);
      if (!spare.empty()) {
        part = std::move(spare.back());
        spare.pop_back();
      }
    }
    if (!part) part = std::make_unique<Part>();
    make(number, *part);
    const std::scoped_lock lock(mutex);
    waiting[number] = std::move(part);
    for (; next_to_join < count && waiting[next_to_join]; ++next_to_join) {
      join(std::as_const(*waiting[next_to_join]));
      spare.push_back(std::move(waiting[next_to_join]));
    }
  });
}

}  // namespace glowworm
