#include "apps/attend.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "apps/interrupt.h"
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

/// A part of longer work, whose progress is shown.
struct ShownPart {
  ProgressBar& bar;
  double before, share;
};

std::exception_ptr attend_part(Job& job, std::vector<RepeatedWork> repeated, const ShownPart& part) {
  bool warned = false;
  // Signals are seen at the next look.
  const auto interval_s = [&job] { return job.seconds() < 2 ? 0.005 : 0.05; };
  for (; !job.done(); job.wait_for(interval_s())) {
    if (caught_interrupt()) job.cancel();
    if (!warned && is_late(job)) {
      part.bar.finish();
      warn(
          "--time has run out, but not every pixel has a sample: the render continues until each has one, or "
          "until Ctrl-C. Give fewer --photons, fewer --gather or a smaller --size");
      warned = true;
    }
    for (RepeatedWork& work : repeated) run_if_due(job, work);
    part.bar.update(part.before + part.share * job.progress(), caught_interrupt() ? "stopping" : work_of(job));
  }
  part.bar.finish();
  try {
    job.wait();
  } catch (...) {
    return std::current_exception();
  }
  return nullptr;
}

}  // namespace

std::exception_ptr attend(Job& job, bool quiet, std::vector<RepeatedWork> repeated, WorkPart part) {
  ProgressBar bar(!quiet);
  return attend_part(job, std::move(repeated), {bar, part.before, part.share});
}

void finish_job(Job& job, bool quiet) {
  ProgressBar bar(!quiet);
  finish_job(job, bar, 0, 1);
}

void finish_job(Job& job, ProgressBar& bar, double before, double share) {
  if (const std::exception_ptr failure = attend_part(job, {}, {bar, before, share})) std::rethrow_exception(failure);
}

}  // namespace glowworm
