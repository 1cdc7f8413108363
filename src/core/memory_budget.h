// The memory that a render, or the loading of a scene, may hold, reserved by name.
#pragma once
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "core/error.h"

namespace glowworm {

/// Thrown where a budget has no room.
class MemoryError : public Error {
 public:
  using Error::Error;
};

/// Keeps account of reserved bytes against a limit. Thread-safe.
class MemoryBudget {
 public:
  /// @param limit_bytes what may be reserved at once; 0 means without limit
  /// @param remedy what the person can do where that is not enough
  explicit MemoryBudget(std::uint64_t limit_bytes = 0,
                        std::string remedy = "Give a larger --memory, or a smaller image.")
      : limit_(limit_bytes), remedy_(std::move(remedy)) {}

  /// Reserves bytes under a name; throws MemoryError, naming every holder, where that would pass the limit.
  void reserve(const std::string& name, std::uint64_t bytes);
  void release(const std::string& name, std::uint64_t bytes);

  std::uint64_t limit() const { return limit_; }
  /// Bytes that may still be reserved; the largest number there is, where there is no limit.
  std::uint64_t available() const;
  std::uint64_t peak() const;
  /// Peak bytes by name.
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

  /// Reserves so many bytes more; throws MemoryError as MemoryBudget::reserve does.
  void grow(std::uint64_t bytes) {
    budget_.reserve(name_, bytes);
    bytes_ += bytes;
  }
  /// Grows to `bytes` where it is smaller.
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
/// Peak resident memory of this process since restart_peak_resident(), else since its start, in bytes (getrusage).
std::uint64_t peak_resident_bytes();
/// Lets the peak begin anew at what is resident now; without effect where the system cannot (Linux can).
void restart_peak_resident();
/// From now on memory that is freed goes back to the system at once, which costs some time.
void keep_heap_small();
/// Gives what is free in the heap back to the system.
void return_free_memory();
/// Memory of the machine in bytes.
std::uint64_t physical_memory_bytes();

}  // namespace glowworm
