// A queue of parts that threads make in any order and that are joined by index.
#pragma once
#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace glowworm {

/// Hands out part numbers in increasing order to any thread, and joins finished parts in that order as they arrive. Few
/// parts wait, so their memory is reused while it is in the caches.
/// @tparam Part holds the content of a part; a borrowed one still holds its old content
template <typename Part>
class PartQueue {
 public:
  /// @param join called for each part in index order, by one thread at a time
  PartQueue(std::size_t parts, std::function<void(const Part&)> join) : waiting_(parts), join_(std::move(join)) {}

  /// The number of the next part. Each number is handed out once.
  std::size_t take() { return next_to_take_.fetch_add(1); }

  /// Returns memory for a part, reused if possible.
  std::unique_ptr<Part> borrow() {
    const std::scoped_lock lock(mutex_);
    if (spare_.empty()) return std::make_unique<Part>();
    std::unique_ptr<Part> memory = std::move(spare_.back());
    spare_.pop_back();
    return memory;
  }

  /// Delivers part `number`, in memory from borrow().
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
