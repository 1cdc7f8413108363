// Paths that take their steps together.
#pragma once
#include <cstddef>
#include <vector>

#include "trace/tracer.h"

namespace glowworm {

/// Paths under way, whose rays are traced at once. `Path` is a PathState with what its policy needs. A queue keeps its
/// memory.
template <typename Path>
class PathQueue {
 public:
  std::vector<Path> paths;
  std::vector<Path> branches;  ///< paths that join the others before the next step

  bool empty() const { return paths.empty() && branches.empty(); }
  void clear() {
    paths.clear();
    branches.clear();
  }

  /// Traces all paths to their next hits, then calls advance(Path&, Hit&) for one after the other, in their order.
  /// Keeps those for which that returns true. Returns the number of rays.
  template <typename Advance>
  std::size_t step(const Tracer& tracer, const Advance& advance) {
    paths.insert(paths.end(), branches.begin(), branches.end());
    branches.clear();
    rays_.clear();
    for (const Path& path : paths) rays_.push_back(path.ray);
    hits_.resize(rays_.size());
    tracer.intersect(rays_, hits_, RayOrder::incoherent);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < hits_.size(); ++i)
      if (advance(paths[i], hits_[i])) {
        if (kept != i) paths[kept] = paths[i];
        ++kept;
      }
    paths.erase(paths.begin() + static_cast<std::ptrdiff_t>(kept), paths.end());
    return hits_.size();
  }

 private:
  std::vector<Ray> rays_;
  std::vector<Hit> hits_;
};

}  // namespace glowworm
