#include "apps/attend.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "apps/interrupt.h"
#include "apps/progress_bar.h"
#include "core/log.h"

namespace glowworm {

namespace {

void run_if_due(const Job& job, RepeatedWork& repeated) {
  const double start = job.seconds();
  if (start < repeated.next_s) return;
  repeated.work();
  const double end = job.seconds();
  repeated.next_s = end + std::max(repeated.interval_s, 20 * (end - start));
}

/// The current step of the job, for the progress bar.
std::string work_of(const Job& job) {
  if (job.step() == Job::Step::photons) return "tracing photons";
  if (job.step() == Job::Step::map) return "building photon map";
  if (job.step() == Job::Step::waiting) return "waiting for photons of other processes";
  if (job.step() == Job::Step::rounds) return "sampling noisy pixels";
  return fmt::format("pass {}", std::min(job.passes() + 1, job.settings().sample_range().count()));
}

/// Whether the first image comes too late for the time limit.
bool is_late(const Job& job) {
  constexpr double kTolerance = 1.1;
  const double limit = job.settings().time_limit_s;
  return limit > 0 && job.passes() == 0 && job.seconds() > kTolerance * limit;
}

}  // namespace

std::exception_ptr attend(Job& job, bool quiet, std::vector<RepeatedWork> repeated, double before, double share) {
  ProgressBar bar(!quiet);
  bool warned = false;
  // Signals are seen at the next look.
  const auto interval_s = [&job] { return job.seconds() < 2 ? 0.005 : 0.05; };
  for (; !job.done(); job.wait_for(interval_s())) {
    if (caught_interrupt()) job.cancel();
    if (!warned && is_late(job)) {
      bar.finish();
      warn(
          "--time has run out, but not every pixel has a sample: the render continues until each has one, or "
          "until Ctrl-C. Give fewer --photons, fewer --gather or a smaller --size");
      warned = true;
    }
    for (RepeatedWork& work : repeated) run_if_due(job, work);
    bar.update(before + share * job.progress(), caught_interrupt() ? "stopping" : work_of(job));
  }
  bar.finish();
  try {
    job.wait();
  } catch (...) {
    return std::current_exception();
  }
  return nullptr;
}

void finish_job(Job& job, bool quiet, double before, double share) {
  if (const std::exception_ptr failure = attend(job, quiet, {}, before, share)) std::rethrow_exception(failure);
}

}  // namespace glowworm
