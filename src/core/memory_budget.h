// The memory budget of rendering, or of loading a scene, reserved by name.
#pragma once
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "core/error.h"

namespace glowworm {

/// Thrown if a reservation exceeds the budget.
class MemoryError : public Error {
 public:
  explicit MemoryError(const std::string& message, const std::string& remedy = "")
      : Error(message, remedy, ErrorCode::memory) {}
};

/// Tracks reserved bytes against a limit. Thread-safe.
class MemoryBudget {
 public:
  /// @param limit_bytes total bytes that may be reserved at once; 0: unlimited
  /// @param remedy advice for the user if the limit is exceeded
  explicit MemoryBudget(std::uint64_t limit_bytes = 0,
                        std::string remedy = "Give a larger --memory, a smaller image or fewer --threads.")
      : limit_(limit_bytes), remedy_(std::move(remedy)) {}

  /// Reserves bytes under a name. If that exceeds the limit, throws MemoryError, which lists all holders.
  void reserve(const std::string& name, std::uint64_t bytes);
  void release(const std::string& name, std::uint64_t bytes);

  std::uint64_t limit() const { return limit_; }
  /// Bytes that may still be reserved; the maximum of the type if there is no limit.
  std::uint64_t available() const;
  std::uint64_t peak() const;
  /// Peak bytes for each name.
  std::map<std::string, std::uint64_t> peaks() const;

 private:
  std::uint64_t limit_;
  std::string remedy_;
  mutable std::mutex mutex_;
  std::uint64_t used_ = 0, peak_ = 0;
  std::map<std::string, std::uint64_t> held_, peaks_;
};

/// A reservation that ends with its scope.
class Reservation {
 public:
  Reservation(MemoryBudget& budget, std::string name, std::uint64_t bytes)
      : budget_(budget), name_(std::move(name)), bytes_(bytes) {
    budget_.reserve(name_, bytes_);
  }
  ~Reservation() { budget_.release(name_, bytes_); }
  Reservation(const Reservation&) = delete;
  Reservation& operator=(const Reservation&) = delete;

  /// Reserves more bytes. Throws MemoryError as MemoryBudget::reserve() does.
  void grow(std::uint64_t bytes) {
    budget_.reserve(name_, bytes);
    bytes_ += bytes;
  }
  /// Grows to `bytes` if it is smaller.
  void cover(std::uint64_t bytes) {
    if (bytes > bytes_) grow(bytes - bytes_);
  }

 private:
  MemoryBudget& budget_;
  std::string name_;
  std::uint64_t bytes_;
};

/// Resident memory of this process now, in bytes.
std::uint64_t resident_bytes();
/// Peak resident memory of this process since restart_peak_resident() or its start, in bytes (proc(5)).
std::uint64_t peak_resident_bytes();
/// Resets the peak to the present resident memory, if the system can (Linux).
void restart_peak_resident();
/// Makes freed memory return to the system at once, from now on, if the budget in bytes is small. This costs some time,
/// so with an ample budget it stays in the heap for what comes next.
void keep_heap_small(std::uint64_t budget);
/// Returns free memory of the heap to the system.
void return_free_memory();
/// Physical memory of the machine in bytes.
std::uint64_t physical_memory_bytes();

}  // namespace glowworm
