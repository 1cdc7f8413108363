// A render shown in tev while it goes on.
#pragma once
#include <memory>
#include <string>

#include "image/tev.h"
#include "render/job.h"

namespace glowworm {

/// Sends the image so far to a tev. Where tev goes away, the render goes on without it, after a warning.
class TevStream {
 public:
  /// @param address HOST:PORT; empty: nothing is ever sent. Throws Error where nothing answers there.
  explicit TevStream(const std::string& address);

  /// Sends the image so far, if there is something of it, and it is not what was sent last.
  void show(const Job& job);

 private:
  std::unique_ptr<TevConnection> connection_;
  double shown_progress_ = 0;
};

}  // namespace glowworm
