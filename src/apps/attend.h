// Waiting for a job at the terminal.
#pragma once
#include <exception>
#include <functional>
#include <vector>

#include "control/job.h"

namespace glowworm {

/// Work that repeats while a job runs: at least `interval_s` apart, and for at most a twentieth of the time.
struct RepeatedWork {
  double interval_s = 1;
  std::function<void()> work;
  double next_s = interval_s;  ///< when it is due, by the job's time
};

/// Waits for the job, shows progress, does the repeated work, and cancels the job after a Ctrl-C. Returns the job's
/// exception, or null.
/// @param before, share the part of all work that the job is, for the progress
std::exception_ptr attend(Job& job, bool quiet, std::vector<RepeatedWork> repeated, double before = 0,
                          double share = 1);

/// Does the same without repeated work, and throws the job's exception.
void finish_job(Job& job, bool quiet, double before = 0, double share = 1);

}  // namespace glowworm
