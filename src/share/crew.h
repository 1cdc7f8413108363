// One render by several processes: rank 0 hands out tasks and collects their light in its film; the others compute.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "film/film.h"
#include "points/gather_points.h"
#include "settings/render_key.h"
#include "share/ranks.h"
#include "share/running_clock.h"

namespace glowworm {

/// Seconds without an answer after which rank 0 warns of a rank.
constexpr double kLateAfter = 60;

/// Chooses the fastest instruction sets, of kernels and of rays, that all ranks have, so that bits do not depend on
/// who computes what. To be called by all ranks before the first Tracer is made. Returns what was chosen, for a
/// message. Rank 0 chooses without ranks that do not answer; they are told when they come.
/// @param late_after seconds without an answer
std::string agree_on_instruction_sets(Ranks& ranks, double late_after = kLateAfter);

/// Tells rank 0 why this rank cannot take part. The others go on without it, or rank 0 ends them all.
void report_failure(Ranks& ranks, const std::string& message);

/// Sends rank 0 the message that this rank has done its frames of a sequence.
void report_end(Ranks& ranks);
/// Waits until all other ranks have ended or failed; returns the failures, which name their ranks.
/// @param cancelled ends the wait
std::vector<std::string> wait_for_ends(Ranks& ranks, const std::function<bool()>& cancelled);

/// Rank 0's side.
class Crew {
 public:
  /// Callbacks of Crew::serve(). Only the serving thread calls them, but for `put`, which several threads may call.
  struct Work {
    std::function<std::optional<CameraTask>()> take;  ///< the next task, if there is one now
    /// Takes the film of a task, for unpack_film().
    std::function<void(const CameraTask&, std::span<const std::byte>)> put;
    std::function<void(const CameraTask&)> give_back;  ///< takes a task back whose rank does not compute it
    std::function<bool()> ended;                       ///< true: serve() returns
  };

  /// @param late_after seconds without an answer after which a rank that has tasks, or has not begun, is late
  explicit Crew(std::shared_ptr<Ranks> ranks, double late_after = kLateAfter)
      : ranks_(std::move(ranks)), late_after_(late_after) {}

  int count() const { return ranks_->count(); }
  /// Checks that all ranks have the same render. Throws Error that names the difference. Late ranks are checked when
  /// they come.
  void check(const RenderKey& key);
  /// Gives tasks to the other ranks and takes their results until work.ended().
  void serve(const Work& work);
  /// Tells all ranks to end after the task under way. Waits up to `seconds` for each to take the message.
  void stop(double seconds);
  /// Stops all ranks and waits for them, up to `seconds`; not for late ones. Warns of those that do not answer. Returns
  /// whether all have answered.
  bool dismiss(double seconds);
  /// Ranks that have failed, with their errors.
  const std::vector<std::string>& failures() const { return failures_; }

 private:
  /// Notes that a rank has answered; `put` has had its result.
  void take_message(const Message& message, const Work& work);
  void check_key(int rank, const std::string& text) const;
  void take_tasks_back(int rank, const Work& work);
  void warn_of_late();

  std::shared_ptr<Ranks> ranks_;
  RenderKey key_;
  std::set<int> gone_;                            // failed or dismissed
  std::vector<int> waiting_;                      // once for each task that a rank wants
  std::map<int, std::vector<CameraTask>> tasks_;  // that the ranks have
  std::vector<std::string> failures_;
  double late_after_;
  RunningClock clock_;
  double looked_ = 0;            // when warn_of_late() last looked, seconds
  std::map<int, double> heard_;  // when a rank last answered, or got its first task, seconds
  std::set<int> late_;
  std::set<int> stopped_;  // that have been told to end
};

/// Adds the film of a task from its message. Throws Error if it is not whole.
/// @param film without samples, of the task's pixels
void unpack_film(std::span<const std::byte> bytes, const CameraTask& task, Film& film);

/// The side of all other ranks.
class RankWorker {
 public:
  explicit RankWorker(std::shared_ptr<Ranks> ranks) : ranks_(std::move(ranks)) {}

  /// Tells rank 0 which render this is, for Crew::check().
  void introduce(const RenderKey& key);
  /// Computes films of tasks until rank 0 sends no more, or `ended`. Rank 0 is told what `begin` and `compute` throw.
  void work(const std::function<void()>& begin, const std::function<Film(const CameraTask&)>& compute,
            const std::function<bool()>& ended);

 private:
  std::shared_ptr<Ranks> ranks_;
};

}  // namespace glowworm
