// The ranks of an MPI job. The program loads this module only in such jobs, so it runs where MPI is not installed.
#define OMPI_SKIP_MPICXX 1
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "share/ranks.h"
#include "share/running_clock.h"

namespace glowworm {

namespace {

/// Interval of polling for messages. MPI's blocking calls would occupy a whole core.
constexpr std::chrono::microseconds kPause{200};

class MpiRanks final : public Ranks {
 public:
  MpiRanks() {
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
    char host[kNameBytes] = {};
    int length = 0;
    MPI_Get_processor_name(host, &length);
    if (rank_ == 0) hosts_.resize(static_cast<std::size_t>(count_) * kNameBytes);
    MPI_Gather(host, kNameBytes, MPI_CHAR, hosts_.data(), kNameBytes, MPI_CHAR, 0, MPI_COMM_WORLD);
  }
  ~MpiRanks() override {
    const std::lock_guard lock(mutex_);
    MPI_Finalize();
  }

  int rank() const override { return rank_; }
  int count() const override { return count_; }
  std::string host(int rank) const override {
    return rank_ == 0 ? hosts_.data() + static_cast<std::size_t>(rank) * kNameBytes : "";
  }

  bool send(int to, std::vector<std::byte> bytes, double seconds) override {
    MPI_Request request;
    {
      const std::lock_guard lock(mutex_);
      MPI_Isend(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, to, 0, MPI_COMM_WORLD, &request);
    }
    RunningClock clock;
    while (true) {
      int done = 0;
      {
        const std::lock_guard lock(mutex_);
        MPI_Test(&request, &done, MPI_STATUS_IGNORE);
        if (!done && clock.seconds() > seconds) {
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
    RunningClock clock;
    while (true) {
      {
        const std::lock_guard lock(mutex_);
        take_up();
        if (std::optional<Message> message = next_whole()) return message;
      }
      if (clock.seconds() > seconds) return std::nullopt;
      std::this_thread::sleep_for(kPause);
    }
  }

  void abort(int status) override {
    MPI_Abort(MPI_COMM_WORLD, status);
    std::_Exit(status);
  }

 private:
  /// A message that is arriving. Its rank may stop at any byte of it, so nothing waits for the rest.
  struct Arriving {
    MPI_Request request;
    Message message;
  };

  /// Begins to receive messages that were sent. The others wait at their ranks, so that they take no memory here.
  void take_up() {
    while (arriving_.size() < kMostArriving) {
      int there = 0, size = 0;
      MPI_Message found;
      MPI_Status status;
      MPI_Improbe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &there, &found, &status);
      if (!there) return;
      MPI_Get_count(&status, MPI_BYTE, &size);
      Arriving& arriving = arriving_.emplace_back();
      arriving.message = {status.MPI_SOURCE, std::vector<std::byte>(static_cast<std::size_t>(size))};
      MPI_Imrecv(arriving.message.bytes.data(), size, MPI_BYTE, &found, &arriving.request);
    }
  }

  /// The first message that is there and has no message of the same rank before it.
  std::optional<Message> next_whole() {
    for (auto at = arriving_.begin(); at != arriving_.end(); ++at) {
      const auto before =
          std::find_if(arriving_.begin(), at, [&](const Arriving& a) { return a.message.from == at->message.from; });
      if (before != at) continue;
      int done = 0;
      MPI_Test(&at->request, &done, MPI_STATUS_IGNORE);
      if (!done) continue;
      Message message = std::move(at->message);
      arriving_.erase(at);
      return message;
    }
    return std::nullopt;
  }

  static constexpr std::size_t kMostArriving = 16;
  static constexpr int kNameBytes = MPI_MAX_PROCESSOR_NAME;

  int rank_ = 0, count_ = 1;
  std::vector<char> hosts_;  // of all ranks, kNameBytes each
  std::mutex mutex_;
  std::vector<std::vector<std::byte>> lost_;  // messages that no rank takes
  std::list<Arriving> arriving_;              // in the order of sending
};

}  // namespace

}  // namespace glowworm

extern "C" __attribute__((visibility("default"))) glowworm::Ranks* glowworm_join_ranks() {
  return new glowworm::MpiRanks();
}
