#include "control/time_limit.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace glowworm {

namespace {

/// Most that a task may take, as a share of the limit, and the time from which on smaller tasks gain nothing.
constexpr double kTaskShare = 0.03, kLeastTaskShare = 0.005;

}  // namespace

TimeLimit::TimeLimit(double limit_s, double spent_s, std::function<double()> clock)
    : limit_s_(limit_s), spent_s_(spent_s), clock_(std::move(clock)) {}

double TimeLimit::left_s() const {
  return is_set() ? whole_s() - clock_() - finish_s_ : std::numeric_limits<double>::infinity();
}

double TimeLimit::task_s() const {
  const double left = left_s();
  // A first image that comes too late gains nothing by small tasks.
  if (is_set() && left <= 0) return kTaskShare * limit_s_;
  return is_set() ? std::clamp(0.5 * left, kLeastTaskShare * limit_s_, kTaskShare * limit_s_) : left;
}

bool TimeLimit::wants_rehearsal(bool has_image) const {
  return is_set() && (clock_() >= next_rehearsal_s_ || has_image > had_image_);
}

void TimeLimit::rehearse(bool has_image, double share, const std::function<void()>& work) {
  const double start = clock_();
  work();
  const double end = clock_();
  // Rises at once and falls slowly: a short rehearsal may have had more of the machine than the whole will have.
  const double measured = (end - start) / share;
  finish_s_ = std::max(measured, 0.5 * (finish_s_ + measured));
  // Rehearsals take at most a fiftieth of the time.
  next_rehearsal_s_ = end + (end - start) / 0.02;
  had_image_ = has_image;
}

}  // namespace glowworm
