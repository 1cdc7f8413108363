// The ranks of an MPI job. The program loads this module only in such jobs, so it runs where MPI is not installed.
#define OMPI_SKIP_MPICXX 1
#include <mpi.h>

#include <chrono>
#include <cstdlib>
#include <mutex>
#include <thread>
#include <utility>

#include "dist/ranks.h"

namespace glowworm {

namespace {

using Clock = std::chrono::steady_clock;

/// Interval of polling for messages. MPI's blocking calls would occupy a whole core.
constexpr std::chrono::microseconds kPause{200};

class MpiRanks final : public Ranks {
 public:
  MpiRanks() {
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
  }
  ~MpiRanks() override {
    const std::lock_guard lock(mutex_);
    MPI_Finalize();
  }

  int rank() const override { return rank_; }
  int count() const override { return count_; }

  bool send(int to, std::vector<std::byte> bytes, double seconds) override {
    MPI_Request request;
    {
      const std::lock_guard lock(mutex_);
      MPI_Isend(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, to, 0, MPI_COMM_WORLD, &request);
    }
    const Clock::time_point end = after(seconds);
    while (true) {
      int done = 0;
      {
        const std::lock_guard lock(mutex_);
        MPI_Test(&request, &done, MPI_STATUS_IGNORE);
        if (!done && Clock::now() > end) {
          // The library may still read the bytes.
          lost_.push_back(std::move(bytes));
          MPI_Request_free(&request);
          return false;
        }
      }
      if (done) return true;
      std::this_thread::sleep_for(kPause);
    }
  }

  std::optional<Message> receive(double seconds) override {
    const Clock::time_point end = after(seconds);
    while (true) {
      {
        const std::lock_guard lock(mutex_);
        int there = 0;
        MPI_Status status;
        MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &there, &status);
        if (there) {
          int size = 0;
          MPI_Get_count(&status, MPI_BYTE, &size);
          Message message{status.MPI_SOURCE, std::vector<std::byte>(static_cast<std::size_t>(size))};
          MPI_Recv(message.bytes.data(), size, MPI_BYTE, status.MPI_SOURCE, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
          return message;
        }
      }
      if (Clock::now() > end) return std::nullopt;
      std::this_thread::sleep_for(kPause);
    }
  }

  void abort(int status) override {
    MPI_Abort(MPI_COMM_WORLD, status);
    std::_Exit(status);
  }

 private:
  static Clock::time_point after(double seconds) {
    return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  }

  int rank_ = 0, count_ = 1;
  std::mutex mutex_;
  std::vector<std::vector<std::byte>> lost_;  // messages that no rank takes
};

}  // namespace

}  // namespace glowworm

extern "C" __attribute__((visibility("default"))) glowworm::Ranks* glowworm_join_ranks() {
  return new glowworm::MpiRanks();
}
