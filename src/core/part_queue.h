// Parts of a result that threads make in any order, joined in the order of the parts.
#pragma once
#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace glowworm {

/// Hands out the numbers of parts in order, whichever thread asks, and joins the parts in that order as they come, so
/// that few wait and their memory is used again while it is in the caches.
/// @tparam Part what a part is made in; what it held before is still in it when it is borrowed
template <typename Part>
class PartQueue {
 public:
  /// @param join called for each part in order, by one thread at a time
  PartQueue(std::size_t parts, std::function<void(const Part&)> join) : waiting_(parts), join_(std::move(join)) {}

  /// The number of the next part: each once.
  std::size_t take() { return next_to_take_.fetch_add(1); }

  /// Memory that has been used before where possible.
  std::unique_ptr<Part> borrow() {
    const std::scoped_lock lock(mutex_);
    if (spare_.empty()) return std::make_unique<Part>();
    std::unique_ptr<Part> memory = std::move(spare_.back());
    spare_.pop_back();
    return memory;
  }

  /// Gives part `number`, made in memory that was borrowed.
  void put(std::size_t number, std::unique_ptr<Part> part) {
    const std::scoped_lock lock(mutex_);
    waiting_[number] = std::move(part);
    for (; next_to_join_ < waiting_.size() && waiting_[next_to_join_]; ++next_to_join_) {
      join_(*waiting_[next_to_join_]);
      spare_.push_back(std::move(waiting_[next_to_join_]));
    }
  }

 private:
  std::atomic<std::size_t> next_to_take_{0};
  std::mutex mutex_;
  std::vector<std::unique_ptr<Part>> waiting_;
  std::size_t next_to_join_ = 0;
  std::vector<std::unique_ptr<Part>> spare_;
  std::function<void(const Part&)> join_;
};

}  // namespace glowworm
