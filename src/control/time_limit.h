// The time that a render has.
#pragma once
#include <functional>

namespace glowworm {

/// Divides a time limit between samples and what follows them: the filter, layers and files. The time of these is
/// measured on a part of the picture now and then, because other programs may take a part of the machine. All times are
/// wall time in seconds.
class TimeLimit {
 public:
  /// @param limit_s 0: none @param spent_s of it, before the start of the clock @param clock seconds since the start
  TimeLimit(double limit_s, double spent_s, std::function<double()> clock);

  bool is_set() const { return limit_s_ > 0; }
  /// The whole time that the clock may run.
  double whole_s() const { return limit_s_ - spent_s_; }
  /// Time left for samples, below 0 when it is over; infinity without a limit.
  double left_s() const;
  /// Whether stopping now comes closer to the limit than stopping after work that takes `next_s`.
  bool is_up(double next_s) const { return next_s / 2 >= left_s(); }
  /// The most that a task may take, so that the limit is met: half of the time left, or a small share of the limit.
  double task_s() const;

  /// Time that is kept for what follows the last sample.
  double finish_s() const { return finish_s_; }
  /// Whether finish_s() should be measured again: so rarely that it takes little time in all, and with the first image.
  /// @param has_image every pixel has a sample
  bool wants_rehearsal(bool has_image) const;
  /// Measures finish_s() by work that does what follows the last sample for a share of the picture.
  void rehearse(bool has_image, double share, const std::function<void()>& work);

 private:
  double limit_s_, spent_s_;
  std::function<double()> clock_;
  double finish_s_ = 0, next_rehearsal_s_ = 0;
  bool had_image_ = false;
};

}  // namespace glowworm
