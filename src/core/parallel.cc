#include "core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <atomic>
#include <exception>
#include <memory>

#include "core/disk_memory.h"
#include "core/error.h"

#ifdef GLOWWORM_THREAD_SANITIZER  // defined by the build
#include <sanitizer/tsan_interface.h>
#endif

namespace glowworm {

namespace {

// Debian's TBB is built without the thread sanitizer. The sanitizer therefore cannot see that a task starts after the
// call that makes it and ends before that call returns. This class tells it so.
class Ordering {
 public:
#ifdef GLOWWORM_THREAD_SANITIZER
  void release() { __tsan_release(this); }
  void acquire() { __tsan_acquire(this); }
#else
  void release() {}
  void acquire() {}
#endif
};

// Runs an action when the scope is left, also by an exception.
template <typename Action>
class AtEnd {
 public:
  explicit AtEnd(Action action) : action_(action) {}
  ~AtEnd() { action_(); }
  AtEnd(const AtEnd&) = delete;
  AtEnd& operator=(const AtEnd&) = delete;

 private:
  Action action_;
};

// The interrupt that work of this thread checks, or null.
thread_local const Interrupt* cancellation = nullptr;

void throw_if_cancelled(const Interrupt* flag) {
  if (flag && flag->requested()) throw Cancelled();
}

// Runs a task under the interrupt of the thread that started it, and marks its start and end for the sanitizer.
template <typename Task>
void run_ordered(Ordering& start, Ordering& end, const Interrupt* flag, const Task& task) {
  start.acquire();
  const AtEnd released([&] { end.release(); });
  throw_if_cancelled(flag);
  // A thread that waits for its own loop may run a piece of another loop meanwhile.
  const AtEnd restored([own = cancellation] { cancellation = own; });
  cancellation = flag;
  task();
  check_disk_memory();
}

// The first exception of a loop. TBB would allocate memory to transport it, and would abort if there is none.
class FirstFailure {
 public:
  template <typename Task>
  void watch(const Task& task) noexcept {
    try {
      task();
    } catch (...) {
      if (!taken_.test_and_set()) failure_ = std::current_exception();
      context_.cancel_group_execution();
    }
  }
  tbb::task_group_context& context() { return context_; }
  /// Call it when all pieces have ended.
  void rethrow() {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  // Pieces must run with the floating-point settings of the thread that starts the loop. Without this flag they would
  // use the settings of the thread that first used TBB; Embree does so with denormal numbers switched off.
  tbb::task_group_context context_{tbb::task_group_context::bound,
                                   tbb::task_group_context::default_traits | tbb::task_group_context::fp_settings};
  std::atomic_flag taken_ = ATOMIC_FLAG_INIT;
  std::exception_ptr failure_;
};

std::unique_ptr<tbb::global_control> control;
int limit = 0;
}  // namespace

CancellationScope::CancellationScope(const Interrupt& interrupt) : outer_(cancellation) { cancellation = &interrupt; }
CancellationScope::~CancellationScope() { cancellation = outer_; }

void check_cancelled() { throw_if_cancelled(cancellation); }

void set_thread_count(int threads) {
  control.reset();
  limit = threads > 0 ? threads : tbb::info::default_concurrency();
  control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  static_cast<std::size_t>(limit));
}

void end_threads() noexcept {
  tbb::task_scheduler_handle handle(tbb::attach{});
  tbb::finalize(handle, std::nothrow);
}

int thread_count() { return limit > 0 ? limit : tbb::info::default_concurrency(); }

void parallel_for(std::size_t begin, std::size_t end, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) {
  if (begin >= end) return;
  grain = std::max<std::size_t>(grain, 1);
  const std::size_t pieces = (end - begin + grain - 1) / grain;
  if (pieces == 1 || thread_count() == 1) {
    for (std::size_t first = begin; first < end; first += grain) {
      throw_if_cancelled(cancellation);
      body(first, std::min(first + grain, end));
      check_disk_memory();
    }
    return;
  }
  Ordering started, ended;
  const Interrupt* const flag = cancellation;
  started.release();
  const AtEnd acquired([&] { ended.acquire(); });
  FirstFailure failure;
  tbb::parallel_for(
      std::size_t{0}, pieces,
      [&](std::size_t piece) {
        const std::size_t first = begin + piece * grain;
        failure.watch([&] { run_ordered(started, ended, flag, [&] { body(first, std::min(first + grain, end)); }); });
      },
      tbb::simple_partitioner(), failure.context());
  failure.rethrow();
}

void parallel_invoke(const std::function<void()>& a, const std::function<void()>& b) {
  if (thread_count() == 1) {
    a();
    b();
    return;
  }
  Ordering started, ended;
  const Interrupt* const flag = cancellation;
  started.release();
  const AtEnd acquired([&] { ended.acquire(); });
  FirstFailure failure;
  tbb::parallel_invoke([&] { failure.watch([&] { run_ordered(started, ended, flag, a); }); },
                       [&] { failure.watch([&] { run_ordered(started, ended, flag, b); }); }, failure.context());
  failure.rethrow();
}

}  // namespace glowworm
