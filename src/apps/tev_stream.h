// Shows the progress of a render in tev.
#pragma once
#include <memory>
#include <string>

#include "control/job.h"
#include "image/tev.h"

namespace glowworm {

/// Sends the unfinished image to tev. If the connection fails later, the render continues without it, after a warning.
class TevStream {
 public:
  /// @param address HOST:PORT; empty: nothing is sent. Throws Error if the connection is refused.
  explicit TevStream(const std::string& address);

  /// Sends the unfinished image, if there is one and it has changed since the last call.
  void show(const Job& job);

 private:
  std::unique_ptr<TevConnection> connection_;
  double shown_progress_ = 0;
};

}  // namespace glowworm
