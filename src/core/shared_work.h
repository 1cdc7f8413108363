// Work that several processes divide among themselves.
#pragma once
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace glowworm {

/// Processes that do the same work. Each makes some pieces of it and takes the other pieces from the others; of ranks
/// (share/crew.h), one takes all of them.
class SharedWork {
 public:
  using Make = std::function<std::vector<std::byte>(std::size_t piece)>;
  using Take = std::function<void(std::size_t piece, std::span<const std::byte> bytes)>;

  virtual ~SharedWork() = default;
  SharedWork(const SharedWork&) = delete;
  SharedWork& operator=(const SharedWork&) = delete;

  /// Calls `take` for the pieces 0 to count - 1 in this order, unless another process takes them all. Its bytes come
  /// from `make`, here or in another process: `make` is called in any order, for pieces that no other process makes or
  /// has made. The calling thread runs both. Waits for pieces that others make. Throws Cancelled within an interrupted
  /// CancellationScope, and what `make` and `take` throw. Each class says what it does else, and whether a piece is
  /// made again whose bytes `take` refuses by InvalidArchive (core/archive.h) before they have any effect.
  /// @param name of the work: the same for all processes, and of letters, digits and hyphens
  virtual void divide(const std::string& name, std::size_t count, const Make& make, const Take& take) = 0;

 protected:
  SharedWork() = default;
};

}  // namespace glowworm
