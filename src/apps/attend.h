// Waiting for a job at the terminal.
#pragma once
#include <exception>
#include <functional>
#include <vector>

#include "apps/progress_bar.h"
#include "control/job.h"

namespace glowworm {

/// Work that repeats while a job runs: at least `interval_s` apart, and for at most a twentieth of the time.
struct RepeatedWork {
  double interval_s = 1;
  std::function<void()> work;
  double next_s = interval_s;  ///< when it is due, by the job's time
};

/// The part of longer work that a job is.
struct WorkPart {
  double before = 0, share = 1;  ///< of the whole, in [0, 1]: what is done before the job, and what the job does
};

/// Waits for the job, shows progress, does the repeated work, and cancels the job after a Ctrl-C. Returns the job's
/// exception, or null.
std::exception_ptr attend(Job& job, bool quiet, std::vector<RepeatedWork> repeated, WorkPart part = {});

/// Does the same without repeated work, and throws the job's exception.
void finish_job(Job& job, bool quiet);
/// Does the same for a part of longer work. @param bar of all the work @param before, share of which the job is a part
void finish_job(Job& job, ProgressBar& bar, double before, double share);

}  // namespace glowworm
