// The memory that a render may hold, reserved by name.
#pragma once
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>

namespace glowworm {

/// Keeps account of reserved bytes against a limit. Thread-safe.
class MemoryBudget {
 public:
  /// @param limit_bytes what may be reserved at once; 0 means without limit
  explicit MemoryBudget(std::uint64_t limit_bytes = 0) : limit_(limit_bytes) {}

  /// Reserves bytes under a name; throws Error, naming every holder, where that would pass the limit.
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
