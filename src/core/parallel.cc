#include "core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <memory>

namespace glowworm {

namespace {
std::unique_ptr<tbb::global_control> control;
int limit = 0;
}  // namespace

void set_thread_count(int threads) {
  control.reset();
  limit = threads > 0 ? threads : tbb::info::default_concurrency();
  control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  static_cast<std::size_t>(limit));
}

int thread_count() { return limit > 0 ? limit : tbb::info::default_concurrency(); }

void parallel_for(std::size_t begin, std::size_t end, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) {
  if (begin >= end) return;
  grain = std::max<std::size_t>(grain, 1);
  const std::size_t pieces = (end - begin + grain - 1) / grain;
  if (pieces == 1 || thread_count() == 1) {
    for (std::size_t first = begin; first < end; first += grain) body(first, std::min(first + grain, end));
    return;
  }
  tbb::parallel_for(
      std::size_t{0}, pieces,
      [&](std::size_t piece) {
        const std::size_t first = begin + piece * grain;
        body(first, std::min(first + grain, end));
      },
      tbb::simple_partitioner());
}

void parallel_invoke(const std::function<void()>& a, const std::function<void()>& b) {
  if (thread_count() == 1) {
    a();
    b();
    return;
  }
  tbb::parallel_invoke(a, b);
}

}  // namespace glowworm
