// Work of several processes that pass messages: rank 0 hands out tasks and takes their results; the others compute.
// What a task is, such as pixels of a picture or a frame of a sequence, is up to those who share the work.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/shared_work.h"
#include "settings/render_key.h"
#include "share/ranks.h"
#include "share/running_clock.h"

namespace glowworm {

/// Seconds without an answer after which rank 0 warns of a rank.
constexpr double kLateAfter = 60;
/// A rank that works says so at this interval, in seconds, and is not late meanwhile.
constexpr double kAliveInterval = 10;

/// Chooses the fastest instruction sets, of kernels and of rays, that all ranks have, so that bits do not depend on
/// who computes what. To be called by all ranks before the first Tracer is made. Returns what was chosen, for a
/// message. Rank 0 chooses without ranks that do not answer; they are told when they come.
/// @param late_after seconds without an answer
std::string agree_on_instruction_sets(Ranks& ranks, double late_after = kLateAfter);

/// Tells rank 0 why this rank cannot take part. The others go on without it, or rank 0 ends them all. Rank 0 takes no
/// other message of this rank then.
void report_failure(Ranks& ranks, const std::string& message);

/// A task, or its result.
using TaskBytes = std::vector<std::byte>;

/// Rank 0's side.
class Crew : public SharedWork {
 public:
  /// Callbacks of serve(). Only the serving thread calls them, but for `put`, which several threads may call.
  struct Work {
    std::function<std::optional<TaskBytes>()> take;  ///< the next task, if there is one
    std::function<void(const TaskBytes& task, std::span<const std::byte> result)> put;  ///< may come twice for a task
    std::function<void(const TaskBytes& task)> give_back;  ///< takes a task back whose rank is lost, or late
    std::function<bool()> ended;                           ///< true: serve() returns
  };

  /// @param late_after seconds without an answer after which a rank that has tasks, or has not begun, is late
  explicit Crew(std::shared_ptr<Ranks> ranks, double late_after = kLateAfter)
      : ranks_(std::move(ranks)), late_after_(late_after) {}

  int count() const { return ranks_->count(); }
  /// Checks that all ranks have the same render. Throws Error that names the difference. Late ranks are checked when
  /// they come.
  void check(const RenderKey& key);
  /// Gives tasks to the other ranks and takes their results until work.ended(). Tasks of ranks that fail or are late go
  /// to others.
  void serve(const Work& work);
  /// Serves the other ranks in a thread of its own, while this one computes tasks, too, until work.ended(). All
  /// callbacks but `compute` may be called by several threads at once.
  /// @param compute takes and computes a task; returns false if there is none now
  void share(const Work& work, const std::function<bool()>& compute);
  /// Shares pieces with the other ranks, which call RankWorker::divide(). They take none: `take` is rank 0's alone.
  /// Rank 0 makes the first. To be called once. If it is interrupted, it takes pieces first that are there and next in
  /// order. Throws InvalidArchive, too, if `take` does: no piece is made again. What ranks other than 0 throw is among
  /// failures(), and others make their pieces.
  void divide(const std::string& name, std::size_t count, const Make& make, const Take& take) override;
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
  void look_for_late(const Work& work);

  std::shared_ptr<Ranks> ranks_;
  RenderKey key_;
  std::set<int> gone_;                           // failed or dismissed
  std::vector<int> waiting_;                     // once for each task that a rank wants
  std::map<int, std::vector<TaskBytes>> tasks_;  // that the ranks have
  std::vector<std::string> failures_;
  double late_after_;
  RunningClock clock_;
  double looked_ = 0;            // when look_for_late() last looked, seconds
  std::map<int, double> heard_;  // when a rank last answered, or got its first task, seconds
  std::set<int> begun_;          // that have asked for work
  std::set<int> late_;
  std::set<int> stopped_;  // that have been told to end
};

/// The side of all other ranks. While it works, rank 0 hears that it is not lost.
class RankWorker : public SharedWork {
 public:
  /// @param alive_interval seconds between the messages that say so
  explicit RankWorker(std::shared_ptr<Ranks> ranks, double alive_interval = kAliveInterval)
      : ranks_(std::move(ranks)), alive_interval_(alive_interval) {}

  /// Tells rank 0 which render this is, for Crew::check().
  void introduce(const RenderKey& key);
  /// Computes tasks until rank 0 sends no more, or `ended`. Throws what `begin` and `compute` throw; rank 0 has been
  /// told then, and needs no report_failure().
  /// @param at_once tasks that this rank has: one that it computes, and those that wait, to hide the time of messages
  void work(const std::function<void()>& begin, const std::function<TaskBytes(const TaskBytes&)>& compute,
            const std::function<bool()>& ended, int at_once);
  /// Makes pieces of Crew::divide() until rank 0 ends the crew, in the order of its messages. Takes none. Throws what
  /// work() throws; Cancelled only from `make`.
  void divide(const std::string& name, std::size_t count, const Make& make, const Take& take) override;

 private:
  void do_tasks(const std::function<TaskBytes(const TaskBytes&)>& compute, const std::function<bool()>& ended,
                int at_once);

  std::shared_ptr<Ranks> ranks_;
  double alive_interval_;
};

}  // namespace glowworm
