// Processes of one render on several machines, which pass messages.
#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace glowworm {

/// A message between ranks.
struct Message {
  int from = 0;
  std::vector<std::byte> bytes;
};

/// Processes started together by an MPI launcher, with the numbers 0 to count() - 1. Every function may be called by
/// any thread. Waiting threads sleep.
class Ranks {
 public:
  virtual ~Ranks() = default;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  virtual int rank() const = 0;
  virtual int count() const = 0;
  /// Name of a rank's machine, for messages. Only rank 0 knows it.
  virtual std::string host(int rank) const = 0;

  /// Sends bytes, and waits until they are on their way. Returns false if the other rank has taken none after
  /// `seconds`, and is probably lost. Messages between two ranks arrive in the order of sending.
  virtual bool send(int to, std::vector<std::byte> bytes, double seconds) = 0;
  /// The next message for this rank; nothing if none arrives within `seconds`.
  virtual std::optional<Message> receive(double seconds) = 0;
  /// Ends the process, and with it all ranks, without waiting for those that are lost.
  [[noreturn]] virtual void abort(int status) = 0;

 protected:
  Ranks() = default;
};

/// Number of processes of the MPI job, from OMPI_COMM_WORLD_SIZE or PMI_SIZE in the environment; 1 without a launcher.
int launched_count();

/// Number of them on this machine, by OMPI_COMM_WORLD_LOCAL_SIZE or MPI_LOCALNRANKS; 1 if it is unknown.
int launched_here();

/// The ranks of this process. Loads the MPI library. Throws Error, which says what to install, if it cannot be loaded.
/// Ends the process with an error if other ranks have not joined after ten minutes. The ranks end with the object,
/// which waits for all of them.
std::unique_ptr<Ranks> join_ranks();

/// Function of the module that MPI is used by; it stands beside the program.
inline constexpr const char* kJoinFunction = "glowworm_join_ranks";
using JoinFunction = Ranks*();

}  // namespace glowworm
